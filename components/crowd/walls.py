"""Walls and the edges of obstacles, listed by the places from which they are near, across the seam.

A grid of cells lies over the world; each lists what comes within a given reach of any of its points, at every image
across the seam that does, so that somebody looks only at what is near however many edges there are. An obstacle is
solid: a cell that lies wholly behind one of its edges does not list it.

Edges of one obstacle's image share a number, its `thing`, and follow each other in a list, so that an obstacle can act
as one, by its nearest point. A wall is a thing of its own.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from crowdcosim.world import World

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FINEST = 0.5
"""least size of a cell [m]"""
MOST_CELLS = 1_000_000
"""cells grow in a larger world"""


class WallGrid(NamedTuple):
    """What is near each cell."""

    ends: Array
    """(Q, 4) both ends of each image: ax, ay, bx, by [m]"""
    thing: Indices
    """(Q,) number of the wall or obstacle that the image is of, another one for each image"""
    solid: NDArray[np.bool_]
    """(Q,) an obstacle's edge, with the obstacle on its left"""
    listed: Indices
    """(K,) rows of `ends`, cell by cell, in ascending order"""
    first: Indices
    """(columns * rows + 1,) where each cell's list begins"""
    columns: int
    rows: int
    left: float
    """x of the first column's edge [m]"""
    bottom: float
    """y of the first row's edge [m]"""
    size: float
    """width and height of a cell [m]"""
    reach: float
    """everything within this distance is listed [m]"""
    most: int
    """length of the longest list"""


class Walls:
    """The walls and obstacles of a world, in a grid for each reach that is asked for."""

    def __init__(
        self, segments: Array, period: Array, thing: Indices | None = None, solid: Array | None = None
    ) -> None:
        """Ends of the walls (W, 2, 2) [m] and the period of each axis (2,), 0 where it does not wrap around [m].

        `thing` (W,) says what each is part of, in ascending order (else each is one), `solid` (W,) which are edges of
        obstacles (else none is).
        """
        self._segments = np.ascontiguousarray(segments, np.float64).reshape(-1, 2, 2)
        self._period = np.asarray(period, np.float64)
        count = len(self._segments)
        self._thing = np.arange(count) if thing is None else np.asarray(thing, np.int64)
        self._solid = np.zeros(count, np.bool_) if solid is None else np.asarray(solid, np.bool_)
        self._grids: dict[float, WallGrid] = {}

    @classmethod
    def of(cls, world: World) -> Walls:
        """What stops people in a world."""
        stops = np.array([wall.stops_people for wall in world.walls] + [True] * len(world.obstacles), np.bool_)
        thing = world.segment_numbers.astype(np.int64)
        thing = thing[stops[thing - 1]]
        return cls(world.segments_for_people, world.period, thing, thing > len(world.walls))

    def __len__(self) -> int:
        return len(self._segments)

    def within(self, reach: float) -> WallGrid:
        """The grid that lists what is within `reach` [m]; made at the first time that it is asked for."""
        if reach not in self._grids:
            self._grids[reach] = self._grid(reach)
        return self._grids[reach]

    def _grid(self, reach: float) -> WallGrid:
        ends, thing, solid = self._images(reach)
        low, high = np.zeros(2), self._period
        if len(ends):
            points = ends.reshape(-1, 2)
            low = np.where(self._period > 0, 0.0, points.min(axis=0) - reach)
            high = np.where(self._period > 0, self._period, points.max(axis=0) + reach)
        size = max(FINEST, reach / 4, math.sqrt(float(np.prod(high - low)) / MOST_CELLS))
        columns, rows = (int(n) for n in np.ceil((high - low) / size)) if len(ends) else (0, 0)
        listed, first = _list(ends, solid, columns, rows, low, size, reach)
        most = int(np.diff(first).max(initial=0))
        return WallGrid(
            ends, thing, solid, listed, first, columns, rows, float(low[0]), float(low[1]), size, reach, most
        )

    def _images(self, reach: float) -> tuple[Array, Indices, NDArray[np.bool_]]:
        """Ends (Q, 4), things and solidity (Q,) of all images that may come within `reach` of somebody."""
        low, high = self._segments.min(axis=1), self._segments.max(axis=1)
        wraps = self._period > 0
        period = np.where(wraps, self._period, 1.0)
        fewest = np.where(wraps, np.ceil((-reach - high) / period), 0.0).astype(np.int64)
        most = np.where(wraps, np.floor((period + reach - low) / period), 0.0).astype(np.int64)
        if not len(self._segments):
            return np.empty((0, 4)), np.empty(0, np.int64), np.empty(0, np.bool_)
        rows = []
        for i in range(fewest[:, 0].min(), most[:, 0].max() + 1):
            for j in range(fewest[:, 1].min(), most[:, 1].max() + 1):
                shift = (i, j)
                here = ((fewest <= shift) & (shift <= most)).all(axis=1)
                rows.append((self._segments[here] + self._period * shift, self._thing[here], self._solid[here]))
        ends = np.concatenate([ends for ends, _, _ in rows]).reshape(-1, 4)
        labels = np.concatenate(
            [np.column_stack([thing, np.full_like(thing, n)]) for n, (_, thing, _) in enumerate(rows)]
        )
        thing = np.unique(labels, axis=0, return_inverse=True)[1].reshape(-1)
        order = np.argsort(thing, kind="stable")
        solid = np.concatenate([solid for _, _, solid in rows])
        return np.ascontiguousarray(ends[order]), thing[order].astype(np.int64), solid[order]


@njit(cache=True, nogil=True, error_model="numpy")
def nearby(grid: WallGrid, x: float, y: float) -> tuple[int, int]:
    """Where the list of what is near the point (x, y) begins and ends in `grid.listed`."""
    column, row = math.floor((x - grid.left) / grid.size), math.floor((y - grid.bottom) / grid.size)
    if column < 0 or row < 0 or column >= grid.columns or row >= grid.rows:
        return 0, 0
    cell = int(column) * grid.rows + int(row)
    return grid.first[cell], grid.first[cell + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_on_segment(ax: float, ay: float, bx: float, by: float, x: float, y: float) -> tuple[float, float, float]:
    """The point of the segment from a to b nearest to (x, y), and its share of the way from a to b, unclipped."""
    ux, uy = bx - ax, by - ay
    squared = ux * ux + uy * uy
    if squared == 0.0:
        return ax, ay, 0.0
    share = ((x - ax) * ux + (y - ay) * uy) / squared
    s = min(max(share, 0.0), 1.0)
    return ax + s * ux, ay + s * uy, share


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_of_thing(grid: WallGrid, q: int, end: int, x: float, y: float) -> tuple[int, float, float]:
    """Of the wall or obstacle that the list goes on with at `q`: where the next one begins, at most `end`, and the way
    from (x, y) to its nearest point [m]."""
    thing = grid.thing[grid.listed[q]]
    nearest, nx, ny = np.inf, 0.0, 0.0
    while q < end:
        f = grid.listed[q]
        if grid.thing[f] != thing:
            break
        px, py, _ = nearest_on_segment(
            grid.ends[f, 0] - x, grid.ends[f, 1] - y, grid.ends[f, 2] - x, grid.ends[f, 3] - y, 0.0, 0.0
        )
        squared = px * px + py * py
        if squared < nearest:
            nearest, nx, ny = squared, px, py
        q += 1
    return q, nx, ny


@njit(cache=True, nogil=True, error_model="numpy")
def _list(
    ends: Array, solid: NDArray[np.bool_], columns: int, rows: int, low: Array, size: float, reach: float
) -> tuple[Indices, Indices]:
    """`listed` and `first` of a `WallGrid`."""
    first = np.zeros(columns * rows + 1, np.int64)
    half = 0.5 * size
    # A circle round the cell holds all of it.
    far = reach + half * math.sqrt(2.0)
    listed = np.empty(0, np.int64)
    filled = first
    for fill in range(2):
        for q in range(len(ends)):
            ax, ay, bx, by = ends[q]
            ux, uy = bx - ax, by - ay
            depth = half * (abs(ux) + abs(uy))
            start = max(int((min(ax, bx) - far - low[0]) / size), 0)
            for c in range(start, min(int((max(ax, bx) + far - low[0]) / size) + 1, columns)):
                start = max(int((min(ay, by) - far - low[1]) / size), 0)
                for r in range(start, min(int((max(ay, by) + far - low[1]) / size) + 1, rows)):
                    x, y = low[0] + (c + 0.5) * size, low[1] + (r + 0.5) * size
                    px, py, _ = nearest_on_segment(ax, ay, bx, by, x, y)
                    if (px - x) ** 2 + (py - y) ** 2 > far * far:
                        continue
                    if solid[q] and ux * (y - ay) - uy * (x - ax) > depth:
                        continue
                    if fill:
                        listed[filled[c * rows + r]] = q
                        filled[c * rows + r] += 1
                    else:
                        first[c * rows + r + 1] += 1
        if not fill:
            for cell in range(columns * rows):
                first[cell + 1] += first[cell]
            listed = np.empty(first[-1], np.int64)
            filled = first[:-1].copy()
    return listed, first
