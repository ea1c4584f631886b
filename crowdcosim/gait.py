"""How people step: stride, cycle and support of a walk, from speed and stature.

With nu = v / h, where h = 0.530 H is the height of the hip above the floor: a cycle (two steps) covers the stride
L = 1.346 sqrt(nu) h and takes T = L / v = 1.346 / sqrt(nu), and each foot stands for 0.752 T - 0.143 s of it
(Boulic, Magnenat-Thalmann and Thalmann 1990, "A global human walking model with real-time kinematic personification";
h from Winter's body segments).

Not in the paper: a cycle takes at most 1.8 s, because in a jam the steps get short rather than slow (Jelic,
Appert-Rolland, Lemercier and Pettre 2012, "Properties of pedestrians walking in line. II. Stepping behavior"); whoever
is almost at rest stands.
"""

from __future__ import annotations

import math

from numba import njit

HIP = 0.530
"""height of the hip over stature"""
STRIDE = 1.346
"""stride over hip height at nu = 1 / s"""
LONGEST_CYCLE = 1.8
"""[s]"""
AT_REST = 0.05
"""slower people stand: no step, no turn [m/s]"""


@njit(cache=True, nogil=True, error_model="numpy")
def cycle_time(speed: float, stature: float) -> float:
    """Time [s] that two steps take at `speed` [m/s]; `stature` is the body height [m]."""
    nu = speed / (HIP * stature)
    if nu < (STRIDE / LONGEST_CYCLE) ** 2:
        return LONGEST_CYCLE
    return STRIDE / math.sqrt(nu)


@njit(cache=True, nogil=True, error_model="numpy")
def phase_rate(speed: float, stature: float) -> float:
    """Cycles per second of somebody who walks at `speed` [m/s]; `stature` is the body height [m]."""
    if speed < AT_REST:
        return 0.0
    return 1.0 / cycle_time(speed, stature)


@njit(cache=True, nogil=True, error_model="numpy")
def duty(cycle: float) -> float:
    """Share of a cycle of `cycle` [s] for which a foot stands; above one half, both stand at times."""
    return 0.752 - 0.143 / cycle
