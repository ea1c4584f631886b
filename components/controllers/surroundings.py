"""Whom a controller must not touch: people and other robots as discs, seen across the seam of a periodic world."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.ego import Ego
from crowdcosim.messages import Crowd, RobotState

Array = NDArray[np.float64]


class Discs(NamedTuple):
    """N moving discs in the frame `map`, people first; arrays are read-only."""

    position: Array
    """(N, 2) centres [m]"""
    velocity: Array
    """(N, 2) velocities [m/s]"""
    radius: Array
    """(N,) radii [m]"""
    people: int
    """how many of them are people: only these pass the seam"""


def discs_of(crowd: Crowd, robots: Sequence[RobotState], own: str) -> Discs:
    """All people and, of `robots`, those not named `own`."""
    people = len(crowd.radius)
    others = [robot for robot in robots if robot.name != own]
    if not others:
        return Discs(crowd.position, crowd.velocity, crowd.radius, people)
    return Discs(
        frozen(np.concatenate([crowd.position, [robot.position for robot in others]])),
        frozen(np.concatenate([crowd.velocity, [robot.velocity for robot in others]])),
        frozen(np.concatenate([crowd.radius, [robot.radius for robot in others]])),
        people,
    )


def frozen(array: Array) -> Array:
    """A read-only copy. Messages hold read-only arrays, and numba compiles once more for a writable one."""
    copy = np.array(array, np.float64, order="C")
    copy.flags.writeable = False
    return copy


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_image(difference: float, period: float) -> float:
    """The shortest of a coordinate difference and its copies `period` apart [m]; period 0 for an axis without seam."""
    if period > 0.0:
        return float(difference - np.rint(difference / period) * period)
    return difference


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_on_segment(ax: float, ay: float, bx: float, by: float) -> tuple[float, float]:
    """The point nearest to the origin on the segment from (ax, ay) to (bx, by) [m]."""
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    t = min(1.0, max(0.0, -(ax * dx + ay * dy) / square)) if square > 0.0 else 0.0
    return ax + t * dx, ay + t * dy


@njit(cache=True, nogil=True, error_model="numpy")
def walls_near(ego: Ego, walls: Array, reach: float) -> Array:
    """(K, 2, 2) both ends of those of (W, 2, 2) walls that are within `reach`, relative to the robot's position [m]."""
    near, count = np.empty_like(walls), 0
    for i in range(len(walls)):
        ax, ay = walls[i, 0, 0] - ego.x, walls[i, 0, 1] - ego.y
        bx, by = walls[i, 1, 0] - ego.x, walls[i, 1, 1] - ego.y
        x, y = nearest_on_segment(ax, ay, bx, by)
        if math.hypot(x, y) <= reach:
            near[count, 0], near[count, 1] = (ax, ay), (bx, by)
            count += 1
    return near[:count]
