"""Distances from people to straight walls, across the seam of a periodic world."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import shortest

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def seen_from(wall: Array, x: float, y: float, period: Array) -> tuple[float, float, float, float]:
    """Both ends (ax, ay, bx, by) of a wall (2, 2), at its nearest image, relative to the point (x, y) [m]."""
    hx, hy = 0.5 * (wall[1, 0] - wall[0, 0]), 0.5 * (wall[1, 1] - wall[0, 1])
    mx = shortest(wall[0, 0] + hx - x, period[0])
    my = shortest(wall[0, 1] + hy - y, period[1])
    return mx - hx, my - hy, mx + hx, my + hy


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
