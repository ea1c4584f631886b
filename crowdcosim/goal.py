"""Goals: a line to cross or a disc to enter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from crowdcosim.messages import Goal


def reached(goal: Goal, position: NDArray[np.float64]) -> bool:
    """True if a robot at `position` (2,) [m] has crossed the goal's line or is within its disc."""
    if goal.direction.any():
        return bool((position - goal.position) @ goal.direction >= 0.0)
    return bool(np.hypot(*(position - goal.position)) <= goal.tolerance)


def target(goal: Goal, position: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2,) the point to head for [m]: the disc's centre, or the nearest point of the goal's line.

    The nearest point moves with the robot, so that one that has dodged sideways goes on instead of coming back.
    """
    if goal.direction.any():
        return np.asarray(position + ((goal.position - position) @ goal.direction) * goal.direction)
    return np.asarray(goal.position)
