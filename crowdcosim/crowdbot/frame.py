"""The module's frame: its origin is midway between start and goal, x points from the goal back to the start."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from crowdcosim.messages import Goal


class Frame:
    """Turns places, vectors and directions of the map into the module's."""

    def __init__(self, goal: Goal, start: NDArray[np.float64]) -> None:
        """`start`: (2,) where the robot begins [m]."""
        way = goal.position - start
        ahead = goal.direction if goal.direction.any() else way / math.hypot(*way)
        self._origin = start + 0.5 * float(way @ ahead) * ahead
        self._turn = math.atan2(-ahead[1], -ahead[0])
        cos, sin = math.cos(self._turn), math.sin(self._turn)
        self._axes = np.array([[cos, -sin], [sin, cos]])

    def place(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) points [m]."""
        return self.vector(position - self._origin)

    def vector(self, vector: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) vectors."""
        return np.asarray(vector @ self._axes)

    def direction(self, heading: float) -> float:
        """A heading [rad] in degrees, above -180 and up to 180."""
        degrees = math.remainder(math.degrees(heading - self._turn), 360.0)
        return 180.0 if degrees == -180.0 else degrees
