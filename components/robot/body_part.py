"""Which part of a walking person a robot touches, and how much of the body's inertia lies behind it.

Of the body's capsules (`crowdcosim.avatar`) whose axis comes down to the robot's height, the one that is, below that
height, nearest to the robot, an upright cylinder; if none does, the one that comes lowest. Taken from the pose at the
start of the step. Who touches whom is not decided here: that is for the discs of `Crowd`, which are wider than a body.
Reflected masses are those of Grzeskowiak et al., "Crowd against the machine", 2021, section "Collision assessment".
Not in the paper: the upper body's reflected mass. A free chain of the same four rigid bodies (Winter's segments, 73 kg,
1.74 m, hinged at ankle, knee and hip), hit at the middle of a segment, gives 3, 10, 24 and 54 kg: the last is used.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdcosim.avatar import CAPSULES, pose_one
from crowdcosim.body import BODY_PART
from crowdcosim.messages import Contacts, Crowd

REFLECTED_MASS = {
    Contacts.FEET: 4.0,
    Contacts.LOWER_LEGS: 13.0,
    Contacts.UPPER_LEGS: 24.0,
    Contacts.UPPER_BODY: 54.0,
}
"""body part -> reflected mass [kg]"""


class TouchedPart:
    """Finds the body parts that a robot of one height touches."""

    def __init__(self, height: float) -> None:
        """`height` of the robot [m]."""
        self._height = height
        _touched(1.0, 0.0, 0.0, 0.0, 0.0, 1.75, 0.0, height)  # Compile now, not at the first contact.

    def __call__(self, crowd: Crowd, index: int, way: NDArray[np.float64]) -> int:
        """The part (a constant of `Contacts`) of person number `index` in `crowd`, `way` (2,) from the robot [m]."""
        x, y = way.tolist()
        vx, vy = crowd.velocity[index].tolist()
        heading, stature, phase = crowd.heading[index], crowd.stature[index], crowd.gait_phase[index]
        return int(_touched(x, y, vx, vy, float(heading), float(stature), float(phase), self._height))


@njit(cache=True, nogil=True)
def _touched(
    x: float, y: float, vx: float, vy: float, heading: float, stature: float, gait_phase: float, height: float
) -> int:
    """The part of somebody at (x, y), seen from the middle of a robot of this `height` [m]."""
    capsules = np.empty((CAPSULES, 7))
    pose_one(x, y, vx, vy, heading, stature, gait_phase, capsules)
    nearest, lowest, touched, above = math.inf, math.inf, -1, -1
    for c in range(CAPSULES):
        distance = _distance(capsules[c], height)
        if distance < nearest:
            nearest, touched = distance, c
        bottom = min(capsules[c, 2], capsules[c, 5]) - capsules[c, 6]
        if bottom < lowest:
            lowest, above = bottom, c
    return BODY_PART[touched if touched >= 0 else above]


@njit(cache=True, nogil=True)
def _distance(capsule: NDArray[np.float64], height: float) -> float:
    """From the vertical through the origin to a capsule as far as its axis is below `height` [m], else infinite."""
    ax, ay, az, bx, by, bz, radius = capsule
    if az > bz:
        ax, ay, az, bx, by, bz = bx, by, bz, ax, ay, az
    if az > height:
        return math.inf
    share = (height - az) / (bz - az) if bz > height else 1.0
    dx, dy = share * (bx - ax), share * (by - ay)
    square = dx * dx + dy * dy
    where = min(max(-(ax * dx + ay * dy) / square, 0.0), 1.0) if square > 0.0 else 0.0
    return math.hypot(ax + where * dx, ay + where * dy) - radius
