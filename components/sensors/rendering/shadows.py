"""Soft shadows on the floor, under bodies, feet and robots."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.buffers import FLOOR, Buffers
from components.sensors.rendering.people import InSight
from components.sensors.rendering.round_cone import ball_extent
from components.sensors.rendering.view import View

Array = NDArray[np.float64]

_BODY, _BODY_DEPTH = 0.27, 0.42
"""radius over stature, and how dark"""
_FOOT, _FOOT_DEPTH = 0.095, 0.45


@njit(cache=True, nogil=True, error_model="numpy")
def shadows(
    view: View,
    seen: InSight,
    stature: Array,
    feet: Array,
    robots: Array,
    buffers: Buffers,
    top: int,
    bottom: int,
    shade: NDArray[np.float32],
) -> None:
    """Fill the rows [top, bottom) of `shade`, (H, W): 1 in full light, less on the floor in shadow.

    Args:
        view: the camera
        seen: people in sight
        stature: (N,) of all people [m]
        feet: (V, 2, 3) middles of their feet (x, y, height) in the map [m]
        robots: (R, 3) centre and radius [m]
        buffers: what is seen
        top: first row
        bottom: row after the last
        shade: to be filled
    """
    shade[top:bottom] = 1.0
    index, centre, surface = seen.index, seen.centre, buffers.surface
    for v in range(len(index)):
        size = stature[index[v]]
        radius = _BODY * size
        _darken(view, centre[v, 0], centre[v, 1], radius, _BODY_DEPTH, surface, top, bottom, shade)
        for side in range(2):
            depth = _FOOT_DEPTH * max(1.0 - 6.0 * max(feet[v, side, 2] - 0.06, 0.0), 0.0)
            _darken(view, feet[v, side, 0], feet[v, side, 1], _FOOT * size, depth, surface, top, bottom, shade)
    for r in range(len(robots)):
        _darken(view, robots[r, 0], robots[r, 1], 1.45 * robots[r, 2], 0.65, surface, top, bottom, shade)


@njit(cache=True, nogil=True, error_model="numpy")
def _darken(
    view: View,
    x: float,
    y: float,
    radius: float,
    depth: float,
    surface: NDArray[np.int32],
    top: int,
    bottom: int,
    shade: NDArray[np.float32],
) -> None:
    """A round shadow around (x, y), darkest in its middle; in each row only the columns that cross it."""
    axes, height = view.axes, view.position[2]
    x, y, step = x - view.position[0], y - view.position[1], 1.0 / view.focal
    ahead = axes[2, 0] * x + axes[2, 1] * y - axes[2, 2] * height
    down = axes[1, 0] * x + axes[1, 1] * y - axes[1, 2] * height
    if ahead > radius:
        low, high = ball_extent(down, ahead, radius)
        top = max(math.ceil(view.cy + view.focal * low), top)
        bottom = min(math.floor(view.cy + view.focal * high) + 1, bottom)
    elif ahead < -radius:
        return
    sharp = 1.0 / (radius * radius)
    for v in range(top, bottom):
        fall = -(axes[1, 2] * (v - view.cy) * step + axes[2, 2])
        if fall <= 0.0:
            continue
        away = height / fall
        # From the shadow's middle to the floor below column u: b + s (u - cx).
        bx = away * (axes[1, 0] * (v - view.cy) * step + axes[2, 0]) - x
        by = away * (axes[1, 1] * (v - view.cy) * step + axes[2, 1]) - y
        sx, sy = away * axes[0, 0] * step, away * axes[0, 1] * step
        square, half = sx * sx + sy * sy, bx * sx + by * sy
        root = half * half - square * (bx * bx + by * by - radius * radius)
        if root <= 0.0:
            continue
        middle, reach = view.cx - half / square, math.sqrt(root) / square
        for u in range(max(math.ceil(middle - reach), 0), min(math.floor(middle + reach) + 1, view.width)):
            if surface[v, u] == FLOOR:
                px, py = bx + sx * (u - view.cx), by + sy * (u - view.cx)
                share = max(1.0 - (px * px + py * py) * sharp, 0.0)
                shade[v, u] *= 1.0 - depth * share * share
