"""The phase of the walk and the direction of the body, integrated from the velocity.

With nu = v / h, h = 0.530 H the height of the hip above the floor: stride L = 1.346 sqrt(nu) h, so that a cycle takes
L / v = 1.346 / sqrt(nu) (Boulic, Magnenat-Thalmann and Thalmann 1990, "A global human walking model with real-time
kinematic personification"; h from Winter's body segments).

Not in the paper: the speed is smoothed over 0.3 s, since people do not change their step within a tenth of a second; a
cycle takes at most 1.8 s, because in a jam the steps get short rather than slow (Jelic, Appert-Rolland, Lemercier and
Pettre 2012, "Properties of pedestrians walking in line. II. Stepping behavior"); whoever is almost at rest stands.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

HIP = 0.530
"""height of the hip over stature"""
STRIDE = 1.346
LONGEST_CYCLE = 1.8
"""[s]"""
SMOOTHING = 0.3
"""time constant of the speed that the steps follow [s]"""
AT_REST = 0.05
"""slower people stand: no step, no turn [m/s]"""


@njit(cache=True, nogil=True, error_model="numpy")
def phase_rate(speed: float, stature: float) -> float:
    """Cycles per second of somebody who walks at `speed` [m/s]; `stature` is the body height [m]."""
    if speed < AT_REST:
        return 0.0
    return max(math.sqrt(speed / (HIP * stature)) / STRIDE, 1.0 / LONGEST_CYCLE)


@njit(cache=True, nogil=True, error_model="numpy")
def walk(
    velocity: Array, heading: Array, pace: Array, phase: Array, stature: Array, dt: float
) -> tuple[Array, Array, Array]:
    """Headings [rad], paces [m/s] and phases [cycles], all (N,), one step later.

    Args:
        velocity: (N, 2) new velocities [m/s]
        heading: (N,) old headings, kept by those at rest [rad]
        pace: (N,) old smoothed speeds [m/s]
        phase: (N,) old phases, in [0, 1) [cycles]
        stature: (N,) body heights [m]
        dt: time step [s]
    """
    n = len(velocity)
    new_heading, new_pace, new_phase = np.empty(n), np.empty(n), np.empty(n)
    share = 1.0 - math.exp(-dt / SMOOTHING)
    for i in range(n):
        speed = math.hypot(velocity[i, 0], velocity[i, 1])
        new_heading[i] = heading[i] if speed < AT_REST else math.atan2(velocity[i, 1], velocity[i, 0])
        new_pace[i] = pace[i] + share * (speed - pace[i])
        cycles = phase[i] + phase_rate(new_pace[i], stature[i]) * dt
        new_phase[i] = cycles - math.floor(cycles)
    return new_heading, new_pace, new_phase
