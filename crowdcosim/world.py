"""The ground plane: its extent, its walls and obstacles, and where it wraps around."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from crowdcosim.mesh import Mesh, section, triangles
from crowdcosim.obstacles import HEIGHT, Obstacle, inside


@dataclass(frozen=True, kw_only=True)
class Door:
    """A closed door in a wall, which cameras see; a way through is a gap between two walls."""

    at: float
    """its middle, from the wall's start [m]"""
    width: float = 0.9
    """[m]"""
    height: float = 2.1
    """[m]"""

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")


@dataclass(frozen=True, kw_only=True)
class Wall:
    """A straight wall of no thickness, seen by every sensor."""

    start: tuple[float, float]
    """one end (x, y) [m]"""
    end: tuple[float, float]
    """other end (x, y) [m]"""
    stops_people: bool = True
    """False: people walk through it, robots do not (the paper's corridor)"""
    height: float = HEIGHT
    """above the floor [m]"""
    doors: tuple[Door, ...] = ()
    """closed doors in it, from its start to its end"""

    def __post_init__(self) -> None:
        if not self.height > 0:
            raise ValueError(f"height is {self.height}, expected a positive number")
        free = 0.0
        for i, door in enumerate(self.doors):
            left, right = door.at - 0.5 * door.width, door.at + 0.5 * door.width
            if not (free <= left and right <= self.length and door.height <= self.height):
                raise ValueError(
                    f"doors[{i}] takes up {left:g} m to {right:g} m and is {door.height:g} m high, expected a place "
                    f"between {free:g} m and the wall's length of {self.length:g} m, and at most its height of "
                    f"{self.height:g} m"
                )
            free = right

    @property
    def length(self) -> float:
        """[m]"""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, kw_only=True)
class World:
    """A rectangle from (0, 0) to `size`, in the frame `map` (x forward, y left, right-handed: REP 103)."""

    size: tuple[float, float]
    """extent in x and y [m]"""
    periodic: tuple[bool, bool] = (False, False)
    """axes along which people who leave re-enter at the opposite side, and are felt and seen across the seam"""
    walls: tuple[Wall, ...] = ()
    """all walls, numbered from 1 in this order"""
    obstacles: tuple[Obstacle, ...] = ()
    """boxes, discs and polygons that nothing goes through, numbered on after the walls"""
    mesh: Mesh | None = None
    """a mesh file, seen by LiDARs and cameras and numbered last; people and robots go through it"""
    ceiling: float | None = None
    """height of a ceiling over everything, with lamps, seen by cameras; none: the open sky [m]"""

    @cached_property
    def period(self) -> NDArray[np.float64]:
        """(2,) period of each axis [m], 0 where the world does not wrap around."""
        return np.where(self.periodic, np.asarray(self.size, np.float64), 0.0)

    @cached_property
    def outlines(self) -> tuple[NDArray[np.float64], ...]:
        """(K, 2) corners of each obstacle, counter-clockwise [m]."""
        return tuple(obstacle.outline for obstacle in self.obstacles)

    @cached_property
    def segments(self) -> NDArray[np.float64]:
        """(W, 2, 2) both ends of every wall and of every obstacle's edges [m]; what is solid is on an edge's left."""
        walls = np.array([(w.start, w.end) for w in self.walls], np.float64).reshape(-1, 2, 2)
        return np.concatenate([walls, *(np.stack([o, np.roll(o, -1, axis=0)], axis=1) for o in self.outlines)])

    @cached_property
    def segment_numbers(self) -> NDArray[np.uint32]:
        """(W,) number of the wall or obstacle that each of `segments` belongs to."""
        edges = [1] * len(self.walls) + [len(outline) for outline in self.outlines]
        return np.repeat(np.arange(1, len(edges) + 1, dtype=np.uint32), edges)

    @cached_property
    def segment_heights(self) -> NDArray[np.float64]:
        """(W,) how high each of `segments` is [m]."""
        heights = np.array([thing.height for thing in (*self.walls, *self.obstacles)], np.float64)
        return heights[self.segment_numbers.astype(np.intp) - 1]

    def mesh_section(self, height: float) -> tuple[NDArray[np.uint32], NDArray[np.float64]]:
        """(S,) its number, and (S, 2, 2) the segments in which the plane at `height` cuts the mesh [m].

        Raises:
            ValueError: if the mesh cannot be read.
        """
        cut = section(triangles(self.mesh), height) if self.mesh else np.zeros((0, 2, 2))
        return np.full(len(cut), len(self.walls) + len(self.obstacles) + 1, np.uint32), cut

    @cached_property
    def segments_for_people(self) -> NDArray[np.float64]:
        """(W', 2, 2) both ends of the walls that stop people, and of all obstacles' edges [m]."""
        stops = np.ones(len(self.segments), np.bool_)
        stops[: len(self.walls)] = [w.stops_people for w in self.walls]
        return np.ascontiguousarray(self.segments[stops])

    def obstructed(self, position: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(N,) True for the points (N, 2) [m] that are inside an obstacle, or inside its image across a seam."""
        blocked = np.zeros(len(position), np.bool_)
        for outline in self.outlines:
            middle = 0.5 * (outline.min(axis=0) + outline.max(axis=0))
            blocked |= inside(outline, middle + self.displacement(middle, position))
        return blocked

    @cached_property
    def _divisor(self) -> NDArray[np.float64]:
        """The period, infinite where there is none: then nothing is ever a whole period away."""
        return np.where(self.period > 0, self.period, np.inf)

    def wrap(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) points moved by whole periods into [0, size) along the periodic axes [m]."""
        period = np.where(self.period > 0, self.period, 1.0)
        wrapped = np.where(self.period > 0, np.mod(position, period), position)
        # A tiny negative coordinate rounds to the period itself, which is the other name of 0.
        return np.where((self.period > 0) & (wrapped >= period), 0.0, wrapped)

    def displacement(self, origin: NDArray[np.float64], target: NDArray[np.float64]) -> NDArray[np.float64]:
        """(..., 2) shortest vectors from `origin` to `target`, across the seam where that is shorter [m]."""
        d = np.subtract(target, origin, dtype=np.float64)
        return np.asarray(d - np.rint(d / self._divisor) * self.period)
