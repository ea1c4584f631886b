"""What people act upon at one instant: everybody's state, robots, walls, limits."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from components.crowd.walls import Walls

Array = NDArray[np.float64]

RANGE = 5.0
"""people notice others and robots up to this distance, centre to centre [m]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class Scene:
    """The old state, from which everybody computes before anybody moves."""

    position: Array
    """(N, 2) centres, within [0, period) along periodic axes [m]"""
    velocity: Array
    """(N, 2) velocities [m/s]"""
    preferred: Array
    """(N, 2) velocities that people would walk at if they were alone [m/s]"""
    radius: Array
    """(N,) radii of the bodies' discs [m]"""
    robots: Array
    """(M, 5) x, y, velocity in x and y, and radius of each robot that people see [m, m/s]"""
    pushed_by_robots: NDArray[np.bool_]
    """(N,) False for those who walk through robots"""
    walls: Walls
    """the walls and obstacles that stop people"""
    period: Array
    """(2,) period of each axis, 0 where the world does not wrap around [m]"""
    max_speed: Array
    """(N,) speeds that people do not want to exceed [m/s]"""
    max_acceleration: Array
    """(N,) as hard as people want to accelerate or brake at most [m/s2]"""
    stream: NDArray[np.uint64]
    """(N,) numbers that everybody's random choices of this step begin with"""
    dt: float
    """time step [s]"""


class Policy(Protocol):
    """How people react to what is around them."""

    def accelerate(self, scene: Scene, who: NDArray[np.int64] | None = None) -> Array:
        """(N, 2) accelerations that everybody wants, or at least those whose indices are in `who` [m/s2]."""
