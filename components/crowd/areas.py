"""Places with a name, in which people start, stop and arrive."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from crowdcosim.world import World


@dataclass(frozen=True, kw_only=True)
class Area:
    """A rectangle along the axes."""

    x: tuple[float, float]
    """from, to [m]"""
    y: tuple[float, float]
    """from, to [m]"""

    def __post_init__(self) -> None:
        for name in ("x", "y"):
            low, high = getattr(self, name)
            if not (math.isfinite(low) and math.isfinite(high) and low <= high):
                raise ValueError(f"{name} is {[low, high]}, expected two numbers in ascending order")

    @property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 2) lower left and upper right corner [m]."""
        return np.array([(self.x[0], self.y[0]), (self.x[1], self.y[1])])


def check_areas(areas: Mapping[str, Area], world: World) -> None:
    """Check that areas are in the world.

    Raises:
        ValueError: that names the first that is not.
    """
    for name, area in areas.items():
        low, high = area.bounds
        if (low < 0).any() or (high > world.size).any():
            raise ValueError(
                f"areas.{name} is x {list(area.x)}, y {list(area.y)}, expected within the world of "
                f"{world.size[0]:g} x {world.size[1]:g} m"
            )
