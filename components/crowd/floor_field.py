"""The way to an area from everywhere, round walls and obstacles: down the slope of the travel time T.

|grad T| = 1 / f with T = 0 at the area, solved on a grid of square cells by fast marching (Sethian 1996, "A fast
marching level set method for monotonically advancing fronts"; `scikit-fmm`, second order). The direction of descent is
that to the next corner of the quickest path. f = 1 where the body has room on all sides; it falls to SLOWEST over the
last COMFORT metres before a body touches a wall, so that people keep off walls if there is room; cells in which a body
would touch one are closed (Hartmann 2010, "Adaptive pedestrian dynamics based on geodesics", uses the same equation).

Whoever is pushed into a closed cell is led back to the nearest open one. Between the centres of cells directions are
interpolated. In a world without walls nothing is solved: the way is straight.
"""

from __future__ import annotations

import math

import numpy as np
import skfmm
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import shortest
from components.crowd.placement import solid_edges
from components.crowd.walls import WallGrid, Walls, nearby, nearest_of_thing
from crowdcosim.world import World

Array = NDArray[np.float64]

CELL = 0.1
"""least size of a cell [m]"""
MOST_CELLS = 500_000
"""cells grow in a world of more than 5,000 m2"""
COMFORT = 0.15
"""[m]"""
SLOWEST = 0.3
"""f where a body just does not touch"""
BACK = 2.0
"""time per length in closed cells, against that in open ones: out of them, and on"""


class Ways:
    """The ways to several areas for bodies of one size."""

    def __init__(self, world: World, areas: Array, radius: float) -> None:
        """Ways to `areas` (F, 2, 2), lower left and upper right corners [m], for bodies of `radius` [m]."""
        self._period = world.period.copy()
        self._areas = np.ascontiguousarray(areas, np.float64)
        self._extent = np.asarray(world.size, np.float64)
        walls = Walls.of(world)
        size = max(CELL, math.sqrt(float(np.prod(self._extent)) / MOST_CELLS))
        shape = np.maximum(np.ceil(self._extent / size).astype(int), 2) if len(walls) else np.zeros(2, int)
        self._cell = self._extent / np.maximum(shape, 1)
        self.cell = float(self._cell.max()) if len(walls) else 0.0
        """width of the cells in which ways are searched, 0 where none are [m]"""
        self.time = np.empty((len(areas), *shape))
        """(F, columns, rows) travel time at unit speed from each cell's centre [s]; infinite where there is no way"""
        self._way = np.zeros((len(areas) if len(walls) else 0, *shape, 2), np.float32)
        if len(walls):
            clear = _clearance(walls.within(radius + COMFORT), *shape, *self._cell)
            _fill_obstacles(clear, solid_edges(world), self._cell, self._period)
            for f, bounds in enumerate(self._areas):
                self.time[f] = self._march(bounds, clear, radius)
                _descend(self.time[f], self._cell, self._period, self._way[f])

    def directions(self, position: Array, which: NDArray[np.int64]) -> Array:
        """(N, 2) unit vectors of the ways from `position` (N, 2) [m] to the areas `which` (N,); zero within them."""
        return _directions(position, which, self._areas, self._way, self._cell, self._period)

    def reachable(self, bounds: Array, which: int) -> bool:
        """True if there is a way to area `which` from somewhere within `bounds` (2, 2) [m]."""
        if not len(self._way):
            return True
        low = np.clip((bounds[0] / self._cell).astype(int), 0, np.array(self.time.shape[1:]) - 1)
        high = np.clip((bounds[1] / self._cell).astype(int), low, np.array(self.time.shape[1:]) - 1)
        return bool(np.isfinite(self.time[which, low[0] : high[0] + 1, low[1] : high[1] + 1]).any())

    def _march(self, bounds: Array, clear: Array, radius: float) -> Array:
        """(columns, rows) travel times to the area `bounds` [s], infinite where there is no way."""
        x, y = ((np.arange(n) + 0.5) * c for n, c in zip(clear.shape, self._cell, strict=True))
        middle, half = bounds.mean(axis=0), np.maximum(0.5 * (bounds[1] - bounds[0]), self._cell)
        off = [
            np.abs(v - m - (np.rint((v - m) / p) * p if p else 0.0)) - h
            for v, m, h, p in zip((x, y), middle, half, self._period, strict=True)
        ]
        dx, dy = off[0][:, None], off[1][None, :]
        distance = np.hypot(np.maximum(dx, 0.0), np.maximum(dy, 0.0)) + np.minimum(np.maximum(dx, dy), 0.0)
        closed = clear < radius
        speed = np.clip((clear - radius) / COMFORT, SLOWEST, 1.0)
        time = np.full(clear.shape, np.inf)
        if (closed | (distance > 0)).all() or (closed | (distance <= 0)).all():
            # Nobody fits into the area; or there is nothing else.
            time[~closed & (distance <= 0)] = 0.0
        else:
            try:
                found = skfmm.travel_time(
                    np.ma.MaskedArray(distance, closed), speed, dx=list(self._cell), periodic=tuple(self._period > 0)
                )
                time = np.ma.filled(found, np.inf)
            except ValueError:
                # No open cell of the area touches one outside.
                time[~closed & (distance <= 0)] = 0.0
        _lead_back(time, closed, clear < 0.75 * self._cell.max(), self._cell, self._period)
        return time


@njit(cache=True, nogil=True, error_model="numpy")
def _clearance(walls: WallGrid, columns: int, rows: int, width: float, height: float) -> Array:
    """(columns, rows) distances from the cells' centres to what stops people, as far as `walls` reach [m]."""
    clear = np.full((columns, rows), walls.reach)
    for c in range(columns):
        for r in range(rows):
            x, y = (c + 0.5) * width, (r + 0.5) * height
            q, end = nearby(walls, x, y)
            while q < end:
                q, px, py = nearest_of_thing(walls, q, end, x, y)
                clear[c, r] = min(clear[c, r], math.sqrt(px * px + py * py))
    return clear


@njit(cache=True, nogil=True, error_model="numpy")
def _fill_obstacles(clear: Array, solid: Array, cell: Array, period: Array) -> None:
    """Set the clearance of cells whose centres are in obstacles (`solid_edges`) to 0."""
    columns, rows = clear.shape
    begin = 0
    while begin < len(solid):
        end = begin
        while end < len(solid) and solid[end, 6] == solid[begin, 6]:
            end += 1
        low_c = math.floor(solid[begin:end, 0].min() / cell[0])
        high_c = math.floor(solid[begin:end, 0].max() / cell[0])
        low_r = math.floor(solid[begin:end, 1].min() / cell[1])
        high_r = math.floor(solid[begin:end, 1].max() / cell[1])
        for c in range(low_c, high_c + 1):
            for r in range(low_r, high_r + 1):
                inside = 0 <= c < columns or period[0] > 0.0
                if not (inside and (0 <= r < rows or period[1] > 0.0)):
                    continue
                x, y = (c + 0.5) * cell[0], (r + 0.5) * cell[1]
                odd = False
                for f in range(begin, end):
                    ax, ay, bx, by = solid[f, 0], solid[f, 1], solid[f, 2], solid[f, 3]
                    if (ay > y) != (by > y) and x < ax + (y - ay) / (by - ay) * (bx - ax):
                        odd = not odd
                if odd:
                    clear[c % columns, r % rows] = 0.0
        begin = end


@njit(cache=True, nogil=True, error_model="numpy")
def _neighbour(k: int, step: int, count: int, wraps: bool) -> int:
    """The cell after or before cell k along an axis, -1 where there is none."""
    k += step
    if wraps:
        return k % count
    return k if 0 <= k < count else -1


@njit(cache=True, nogil=True, error_model="numpy")
def _lead_back(time: Array, closed: NDArray[np.bool_], barrier: NDArray[np.bool_], cell: Array, period: Array) -> None:
    """Give closed cells that are no `barrier` the time to the nearest open one with a way, and from there."""
    columns, rows = time.shape
    changed = True
    while changed:
        changed = False
        old = time.copy()
        for c in range(columns):
            for r in range(rows):
                if not closed[c, r] or barrier[c, r] or np.isfinite(old[c, r]):
                    continue
                least = np.inf
                for step in range(4):
                    i = _neighbour(c, (1, -1, 0, 0)[step], columns, period[0] > 0.0)
                    j = _neighbour(r, (0, 0, 1, -1)[step], rows, period[1] > 0.0)
                    if i >= 0 and j >= 0 and not barrier[i, j]:
                        least = min(least, old[i, j] + BACK * cell[0 if step < 2 else 1])
                if least < np.inf:
                    time[c, r] = least
                    changed = True


@njit(cache=True, nogil=True, error_model="numpy")
def _slope(before: float, here: float, after: float, size: float) -> float:
    """dT/dx from the cells on both sides: central; where one has no way, or is a ridge, towards the earlier one."""
    if before < here and after < here:
        return (here - before) / size if before < after else (after - here) / size
    if np.isfinite(before) and np.isfinite(after):
        return (after - before) / (2.0 * size)
    if before < here:
        return (here - before) / size
    return (after - here) / size if after < here else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _descend(time: Array, cell: Array, period: Array, way: NDArray[np.float32]) -> None:
    """Set `way` (columns, rows, 2) to the unit vectors down the slope of `time`; zero where there is no way."""
    columns, rows = time.shape
    for c in range(columns):
        for r in range(rows):
            here = time[c, r]
            if not np.isfinite(here):
                continue
            west = _neighbour(c, -1, columns, period[0] > 0.0)
            east = _neighbour(c, 1, columns, period[0] > 0.0)
            south = _neighbour(r, -1, rows, period[1] > 0.0)
            north = _neighbour(r, 1, rows, period[1] > 0.0)
            x = -_slope(time[west, r] if west >= 0 else np.inf, here, time[east, r] if east >= 0 else np.inf, cell[0])
            y = -_slope(
                time[c, south] if south >= 0 else np.inf, here, time[c, north] if north >= 0 else np.inf, cell[1]
            )
            length = math.sqrt(x * x + y * y)
            if length > 0.0:
                way[c, r, 0], way[c, r, 1] = x / length, y / length


@njit(cache=True, nogil=True, error_model="numpy")
def _interpolated(
    way: NDArray[np.float32], f: int, x: float, y: float, cell: Array, period: Array
) -> tuple[float, float]:
    """The way to area f at a point, between the four nearest cells; that of the nearest where they disagree."""
    columns, rows = way.shape[1], way.shape[2]
    u, v = x / cell[0] - 0.5, y / cell[1] - 0.5
    if period[0] <= 0.0:
        u = min(max(u, 0.0), columns - 1.0)
    if period[1] <= 0.0:
        v = min(max(v, 0.0), rows - 1.0)
    c, r = math.floor(u), math.floor(v)
    share_x, share_y = u - c, v - r
    wx, wy = 0.0, 0.0
    for i in range(2):
        for j in range(2):
            weight = (share_x if i else 1.0 - share_x) * (share_y if j else 1.0 - share_y)
            column = (c + i) % columns if period[0] > 0.0 else min(c + i, columns - 1)
            row = (r + j) % rows if period[1] > 0.0 else min(r + j, rows - 1)
            wx += weight * way[f, column, row, 0]
            wy += weight * way[f, column, row, 1]
    length = math.sqrt(wx * wx + wy * wy)
    if length > 0.3:
        return wx / length, wy / length
    column = math.floor(u + 0.5)
    row = math.floor(v + 0.5)
    column = column % columns if period[0] > 0.0 else min(column, columns - 1)
    row = row % rows if period[1] > 0.0 else min(row, rows - 1)
    return float(way[f, column, row, 0]), float(way[f, column, row, 1])


@njit(cache=True, nogil=True, error_model="numpy")
def _directions(
    position: Array, which: NDArray[np.int64], areas: Array, way: NDArray[np.float32], cell: Array, period: Array
) -> Array:
    result = np.zeros((len(position), 2))
    for i in range(len(position)):
        f, x, y = which[i], position[i, 0], position[i, 1]
        # The straight way to the nearest point of the area.
        half_x, half_y = 0.5 * (areas[f, 1, 0] - areas[f, 0, 0]), 0.5 * (areas[f, 1, 1] - areas[f, 0, 1])
        dx, dy = shortest(areas[f, 0, 0] + half_x - x, period[0]), shortest(areas[f, 0, 1] + half_y - y, period[1])
        dx -= min(max(dx, -half_x), half_x)
        dy -= min(max(dy, -half_y), half_y)
        distance = math.sqrt(dx * dx + dy * dy)
        if distance == 0.0:
            continue
        if len(way) > 0:
            result[i, 0], result[i, 1] = _interpolated(way, f, x, y, cell, period)
        else:
            result[i, 0], result[i, 1] = dx / distance, dy / distance
    return result
