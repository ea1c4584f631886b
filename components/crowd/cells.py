"""Who is near whom: people sorted into a grid of cells, across the seam of a periodic world.

Cells are sorted by place, not by the order in which people are listed, so that sums over neighbours do not depend
on that order. Neighbours follow the minimum image convention: each is met once, at its nearest image, also where the
range is more than half the period.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

CELLS_PER_PERSON = 8
"""a grid of a large and almost empty plane grows no finer than this"""


class Cells(NamedTuple):
    """People in the order of their cells, column by column."""

    order: NDArray[np.int64]
    """(N,) index of the person at each place of the order"""
    x: Array
    """(N,) in that order [m]"""
    y: Array
    """(N,) in that order [m]"""
    first: NDArray[np.int64]
    """(columns * rows + 1,) place of each cell's first person"""
    columns: int
    rows: int
    left: float
    """x of the first column's edge [m]"""
    bottom: float
    """y of the first row's edge [m]"""
    width: float
    """of a cell, in x [m]"""
    height: float
    """of a cell, in y [m]"""
    period_x: float
    """[m], 0 where the world does not wrap around"""
    period_y: float
    """[m], 0 where the world does not wrap around"""


@njit(cache=True, nogil=True, error_model="numpy")
def shortest(d: float, period: float) -> float:
    """A difference of coordinates, across the seam where that is shorter [m]; exact for any number of periods."""
    return d - period * np.round(d / period) if period > 0.0 else d


@njit(cache=True, nogil=True, error_model="numpy")
def into_period(x: float, period: float) -> float:
    """A coordinate moved by whole periods into [0, period)."""
    if period <= 0.0:
        return x
    x -= math.floor(x / period) * period
    # A tiny negative coordinate rounds to the period itself, which is the other name of 0.
    return 0.0 if x >= period else x


@njit(cache=True, nogil=True, error_model="numpy")
def _axis(values: Array, period: float, size: float) -> tuple[float, float, int]:
    """Origin, extent and number of cells of at least `size` along one axis."""
    if period > 0.0:
        return 0.0, period, max(1, int(period / size))
    low, high = values.min(), values.max()
    # One cell more than fits, so that the highest value is inside.
    count = int((high - low) / size) + 1
    return low, count * size, count


@njit(cache=True, nogil=True, error_model="numpy")
def sort_into_cells(position: Array, period: Array, size: float) -> Cells:
    """Sort people into cells of at least `size`.

    Args:
        position: (N, 2) centres, within [0, period) along periodic axes [m]
        period: (2,) period of each axis, 0 where the world does not wrap around [m]
        size: least width and height of a cell [m]
    """
    n = len(position)
    x, y = np.empty(n), np.empty(n)
    order = np.empty(n, np.int64)
    if n == 0:
        return Cells(order, x, y, np.zeros(2, np.int64), 1, 1, 0.0, 0.0, size, size, period[0], period[1])
    left, extent_x, columns = _axis(position[:, 0], period[0], size)
    bottom, extent_y, rows = _axis(position[:, 1], period[1], size)
    while columns * rows > CELLS_PER_PERSON * n + 64:
        if columns >= rows:
            columns = (columns + 1) // 2
        else:
            rows = (rows + 1) // 2
    width, height = extent_x / columns, extent_y / rows

    cell = np.empty(n, np.int64)
    first = np.zeros(columns * rows + 1, np.int64)
    for i in range(n):
        column = min(max(int((position[i, 0] - left) / width), 0), columns - 1)
        row = min(max(int((position[i, 1] - bottom) / height), 0), rows - 1)
        cell[i] = column * rows + row
        first[cell[i] + 1] += 1
    for c in range(columns * rows):
        first[c + 1] += first[c]
    filled = first[:-1].copy()
    for i in range(n):
        # Insert where (x, y) belongs among those already in the cell.
        k = filled[cell[i]]
        filled[cell[i]] += 1
        px, py = position[i, 0], position[i, 1]
        while k > first[cell[i]] and (x[k - 1] > px or (x[k - 1] == px and y[k - 1] > py)):
            x[k], y[k], order[k] = x[k - 1], y[k - 1], order[k - 1]
            k -= 1
        x[k], y[k], order[k] = px, py, i
    return Cells(order, x, y, first, columns, rows, left, bottom, width, height, period[0], period[1])


@njit(cache=True, nogil=True, error_model="numpy")
def _span(value: float, low: float, size: float, count: int, reach: float, wraps: bool) -> tuple[int, int]:
    """First cell and number of cells along one axis that may hold anything within `reach`; may exceed the axis."""
    here = min(max(int((value - low) / size), 0), count - 1)
    k = int(np.ceil(reach / size))
    if wraps:
        return (0, count) if 2 * k + 1 >= count else (here - k, 2 * k + 1)
    start = max(here - k, 0)
    return start, min(here + k, count - 1) - start + 1


@njit(cache=True, nogil=True, error_model="numpy")
def _wrapped(cell: int, count: int) -> int:
    """A cell's number that is less than `count` beyond either end; quicker than a division."""
    if cell < 0:
        return cell + count
    return cell - count if cell >= count else cell


@njit(cache=True, nogil=True, error_model="numpy")
def _offsets(
    xs: Array,
    ys: Array,
    begin: int,
    end: int,
    x: float,
    y: float,
    period_x: float,
    period_y: float,
    m: int,
    found: NDArray[np.int64],
    dx: Array,
    dy: Array,
) -> None:
    """Append places `begin` to `end`, and the shortest ways there from (x, y), to the `m` found so far.

    Simple enough to run four at a time. Places are less than a period away. Unsigned indices, because signed ones would
    be checked for counting from the end; whole arrays, because numba counts references at every slice.
    """
    half_x = 0.5 * period_x if period_x > 0.0 else np.inf
    half_y = 0.5 * period_y if period_y > 0.0 else np.inf
    start, to = np.uint64(begin), np.uint64(m)
    for t in range(np.uint64(end - begin)):
        u, v = xs[start + t] - x, ys[start + t] - y
        u = u - period_x if u > half_x else u
        u = u + period_x if u < -half_x else u
        v = v - period_y if v > half_y else v
        v = v + period_y if v < -half_y else v
        dx[to + t] = u
        dy[to + t] = v
    for t in range(np.uint64(end - begin)):
        found[to + t] = np.int64(start + t)


@njit(cache=True, nogil=True, error_model="numpy")
def gather(cells: Cells, k: int, after: int, reach: float, found: NDArray[np.int64], dx: Array, dy: Array) -> int:
    """Find everybody within `reach` of the person at place `k` of the order, that person left out.

    Args:
        cells: of everybody
        k: place of the person in the order
        after: only places from this one on; 0 for all, `k + 1` to meet every pair once
        reach: range, centre to centre [m]
        found: (N + 1,) receives the places of the neighbours
        dx: (N + 1,) receives their x relative to the person [m]
        dy: (N + 1,) receives their y relative to the person [m]

    Returns:
        How many there are.
    """
    # Taken out once: numba counts references at every access to a field.
    xs, ys, first = cells.x, cells.y, cells.first
    x, y = xs[k], ys[k]
    column, columns = _span(x, cells.left, cells.width, cells.columns, reach, cells.period_x > 0.0)
    row, rows = _span(y, cells.bottom, cells.height, cells.rows, reach, cells.period_y > 0.0)
    m = 0
    for c in range(column, column + columns):
        base = _wrapped(c, cells.columns) * cells.rows
        # A column's rows are contiguous: one run, or two where they wrap around.
        begin, left_over = _wrapped(row, cells.rows), rows
        while left_over > 0:
            length = min(left_over, cells.rows - begin)
            a, z = max(first[base + begin], after), first[base + begin + length]
            if z > a:
                _offsets(xs, ys, a, z, x, y, cells.period_x, cells.period_y, m, found, dx, dy)
                m += z - a
            left_over -= length
            begin = 0
    n = 0
    for t in range(m):
        # Written first and counted afterwards: no branch to mispredict.
        j, u, v = found[t], dx[t], dy[t]
        found[n], dx[n], dy[n] = j, u, v
        n += int((u * u + v * v <= reach * reach) & (j != k))
    return n
