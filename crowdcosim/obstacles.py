"""Solid things on the ground: boxes, discs and polygons, each with a height."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

HEIGHT = 2.5
"""of walls and obstacles that do not say it [m]"""
DISC_EDGES = 32
"""a disc is a regular polygon around it, which is nowhere farther out than 0.5% of the radius"""

Point = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Box:
    """A rectangle on the ground, such as a table or a square pillar."""

    shape: Literal["box"]
    centre: Point
    """(x, y) [m]"""
    size: Point
    """extent along its own axes [m]"""
    yaw: float = 0.0
    """of its first axis, counter-clockwise from x [rad]"""
    height: float = HEIGHT
    """[m]"""

    def __post_init__(self) -> None:
        if not min(self.size) > 0:
            raise ValueError(f"size is {list(self.size)}, expected two positive numbers")
        _check_height(self.height)

    @property
    def outline(self) -> NDArray[np.float64]:
        """(4, 2) corners, counter-clockwise [m]."""
        half = 0.5 * np.array(self.size)
        corners = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * half
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return np.asarray(corners @ np.array([(cos, sin), (-sin, cos)]) + self.centre)


@dataclass(frozen=True, kw_only=True)
class Disc:
    """A round pillar."""

    shape: Literal["disc"]
    centre: Point
    """(x, y) [m]"""
    radius: float
    """[m]"""
    height: float = HEIGHT
    """[m]"""

    def __post_init__(self) -> None:
        if not self.radius > 0:
            raise ValueError(f"radius is {self.radius}, expected a positive number")
        _check_height(self.height)

    @property
    def outline(self) -> NDArray[np.float64]:
        """(32, 2) corners of the regular polygon around the disc, counter-clockwise [m]."""
        angle = 2.0 * math.pi * (np.arange(DISC_EDGES) + 0.5) / DISC_EDGES
        radius = self.radius / math.cos(math.pi / DISC_EDGES)
        return np.column_stack([np.cos(angle), np.sin(angle)]) * radius + self.centre


@dataclass(frozen=True, kw_only=True)
class Polygon:
    """A polygon that does not cross itself, convex or not."""

    shape: Literal["polygon"]
    corners: tuple[Point, ...]
    """(x, y) of each, in either order round, the first not repeated [m]"""
    height: float = HEIGHT
    """[m]"""

    def __post_init__(self) -> None:
        if len(self.corners) < 3:
            raise ValueError(f"corners are {len(self.corners)}, expected at least 3")
        if not abs(_area(np.array(self.corners, np.float64))) > 0:
            raise ValueError("corners enclose no area, expected a polygon that does")
        if crossing := _crossing(self.corners):
            raise ValueError(
                f"the edges after corners[{crossing[0]}] and corners[{crossing[1]}] meet, "
                "expected corners in their order round the polygon, each once"
            )
        _check_height(self.height)

    @property
    def outline(self) -> NDArray[np.float64]:
        """(K, 2) corners, counter-clockwise [m]."""
        corners = np.array(self.corners, np.float64)
        return corners if _area(corners) > 0 else corners[::-1].copy()


Obstacle = Annotated[Box | Disc | Polygon, Field(discriminator="shape")]


def inside(outline: NDArray[np.float64], position: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(N,) True for the points `position` (N, 2) [m] within the polygon with corners `outline` (K, 2) [m]."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = position[:, None, 0], position[:, None, 1]
    spans = (a[:, 1] > y) != (b[:, 1] > y)
    rise = np.where(a[:, 1] == b[:, 1], 1.0, b[:, 1] - a[:, 1])
    left_of = x < a[:, 0] + (y - a[:, 1]) / rise * (b[:, 0] - a[:, 0])
    return np.asarray((spans & left_of).sum(axis=1) % 2 == 1)


def _check_height(height: float) -> None:
    if not height > 0:
        raise ValueError(f"height is {height}, expected a positive number")


def _area(corners: NDArray[np.float64]) -> float:
    """Of a polygon, positive if its corners (K, 2) go round counter-clockwise [m2]."""
    x, y = corners.T
    return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))


def _crossing(corners: tuple[Point, ...]) -> tuple[int, int] | None:
    """Two edges, by their first corners, that meet other than as neighbours do, end to end."""
    count = len(corners)
    edges = [(np.array(corners[i]), np.array(corners[(i + 1) % count])) for i in range(count)]
    for (i, (a, b)), (j, (c, d)) in combinations(enumerate(edges), 2):
        if (i + 1) % count == j or (j + 1) % count == i:
            shared, before, after = (b, a, d) if (i + 1) % count == j else (a, b, c)
            u, v = before - shared, after - shared
            if u[0] * v[1] == u[1] * v[0] and u @ v >= 0:
                return i, j
        elif _touch(a, b, c, d):
            return i, j
    return None


def _touch(a: NDArray[np.float64], b: NDArray[np.float64], c: NDArray[np.float64], d: NDArray[np.float64]) -> bool:
    """True if the segments from a to b and from c to d have a point in common."""

    def side(p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]) -> float:
        return float((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]))

    low, high = np.maximum(np.minimum(a, b), np.minimum(c, d)), np.minimum(np.maximum(a, b), np.maximum(c, d))
    return bool((low <= high).all() and side(a, b, c) * side(a, b, d) <= 0 and side(c, d, a) * side(c, d, b) <= 0)
