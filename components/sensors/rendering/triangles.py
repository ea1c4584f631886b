"""Flat surfaces before a camera: triangles whose edges and inverse depth are linear in the picture.

With the corners a, b, c in the camera's frame and n = (b - a) x (c - a), the ray d meets the plane at the inverse depth
w = n.d / n.a, and passes the edge from a to b on the side of (a x b).d n.a. No clipping is needed (Olano and Greer,
Triangle scan conversion using 2D homogeneous coordinates, 1997): the ray meets the triangle where all are positive.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.view import View

Array = NDArray[np.float64]

_NEAR = 1e-3
_EDGE_ON = 1e-12


class Outlines(NamedTuple):
    """Triangles in the picture."""

    edge: Array
    """(T, 3, 3) functions of the ray that are positive inside, in pixels of its plane over the focal length"""
    plane: Array
    """(T, 3) function of the ray: the inverse depth [1/m]; all 0 if the triangle is not in the picture"""
    row: Array
    """(T, 2) first and last row [pixels]"""


@njit(cache=True, nogil=True, error_model="numpy")
def outlines(view: View, corner: Array) -> Outlines:
    """From corners in the map, (T, 3, 3) [m]."""
    count = len(corner)
    edge, plane, row = np.zeros((count, 3, 3)), np.zeros((count, 3)), np.empty((count, 2))
    p = np.empty((3, 3))
    for t in range(count):
        for i in range(3):
            dx = corner[t, i, 0] - view.position[0]
            dy = corner[t, i, 1] - view.position[1]
            dz = corner[t, i, 2] - view.position[2]
            for axis in range(3):
                p[i, axis] = view.axes[axis, 0] * dx + view.axes[axis, 1] * dy + view.axes[axis, 2] * dz
        if _out_of_picture(view, p, row[t]):
            continue
        nx, ny, nz = _cross(p[1] - p[0], p[2] - p[0])
        volume = nx * p[0, 0] + ny * p[0, 1] + nz * p[0, 2]
        if abs(volume) < _EDGE_ON:
            continue
        plane[t, 0], plane[t, 1], plane[t, 2] = nx / volume, ny / volume, nz / volume
        for i in range(3):
            ex, ey, ez = _cross(p[i], p[(i + 1) % 3])
            scale = math.sqrt(ex * ex + ey * ey)
            scale = math.copysign(1.0 / scale, volume) if scale > 0.0 else math.copysign(1.0, volume)
            edge[t, i, 0], edge[t, i, 1], edge[t, i, 2] = ex * scale, ey * scale, ez * scale
    return Outlines(edge, plane, row)


@njit(cache=True, nogil=True, error_model="numpy")
def _out_of_picture(view: View, p: Array, row: Array) -> bool:
    """True if the corners `p`, (3, 3), are all beyond one side; else the rows that they span are in `row`, (2,)."""
    row[0], row[1] = 0.0, view.height - 1.0
    if max(p[0, 2], p[1, 2], p[2, 2]) <= 0.0:
        return True
    for axis, half in ((0, 0.5 * view.width), (1, 0.5 * view.height)):
        t = (half + 1.0) / view.focal
        for sign in (-1.0, 1.0):
            if sign * p[0, axis] > t * p[0, 2] and sign * p[1, axis] > t * p[1, 2] and sign * p[2, axis] > t * p[2, 2]:
                return True
    if min(p[0, 2], p[1, 2], p[2, 2]) > _NEAR:
        a, b, c = p[0, 1] / p[0, 2], p[1, 1] / p[1, 2], p[2, 1] / p[2, 2]
        row[0] = max(view.cy + view.focal * min(a, b, c), row[0])
        row[1] = min(view.cy + view.focal * max(a, b, c), row[1])
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _cross(a: Array, b: Array) -> tuple[float, float, float]:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


@njit(cache=True, nogil=True, error_model="numpy")
def span(edge: Array, plane: Array, t: int, y: float, width: int, focal: float, cx: float) -> tuple[int, int]:
    """Columns [first, end) of the row whose rays are (x, y, 1) in which triangle t is seen.

    Two triangles with the same corners get the same quotient for their common edge, so that no column falls between.
    """
    low, high = 0.0, width - 1.0
    for i in range(4):
        if i < 3:
            slope, rest = edge[t, i, 0], edge[t, i, 1] * y + edge[t, i, 2]
        else:
            slope, rest = plane[t, 0], plane[t, 1] * y + plane[t, 2]
        if slope > 0.0:
            low = max(low, cx - focal * (rest / slope))
        elif slope < 0.0:
            high = min(high, cx - focal * (rest / slope))
        elif rest < 0.0:
            return 0, 0
    if low > high:
        return 0, 0
    return math.ceil(low), math.floor(high) + 1


@njit(cache=True, nogil=True, error_model="numpy")
def outside(edge: Array, t: int, x: float, y: float) -> float:
    """How far the ray (x, y, 1) is outside of the edges of triangle t, negative inside, over the focal length."""
    return -min(
        edge[t, 0, 0] * x + edge[t, 0, 1] * y + edge[t, 0, 2],
        edge[t, 1, 0] * x + edge[t, 1, 1] * y + edge[t, 1, 2],
        edge[t, 2, 0] * x + edge[t, 2, 1] * y + edge[t, 2, 2],
    )
