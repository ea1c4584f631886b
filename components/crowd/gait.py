"""The phase of the walk and the direction of the body, integrated from the velocity.

A cycle takes as long as `crowdcosim.gait` says, so that the feet of `crowdcosim.avatar` stand still on the floor.

Not in the paper cited there: the speed is smoothed over 0.3 s, since people do not change their step within a tenth of
a second.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdcosim.gait import AT_REST, phase_rate

Array = NDArray[np.float64]

SMOOTHING = 0.3
"""time constant of the speed that the steps follow [s]"""


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
