"""Which surface each pixel sees, and how far away: the z-buffer of one picture."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.people import Bodies
from components.sensors.rendering.round_cone import WITHIN, ball_met, holds_camera, met, round_cone
from components.sensors.rendering.triangles import Outlines, span
from components.sensors.rendering.view import View
from crowdcosim.avatar import CAPSULES

Array = NDArray[np.float64]
Depths = NDArray[np.float32]
Surfaces = NDArray[np.int32]

SKY, FLOOR, CEILING, TRIANGLES = 0, 1, 2, 3
"""surfaces of a pixel; triangle t is TRIANGLES + t"""
PEOPLE = 1 << 24
"""limb c of the v-th person in sight is PEOPLE + CAPSULES v + c"""


class Buffers(NamedTuple):
    """One picture before it is coloured."""

    inverse_depth: NDArray[np.float32]
    """(H, W) one over the distance along the optical axis [1/m], 0 for the sky"""
    surface: NDArray[np.int32]
    """(H, W) what is seen"""


@njit(cache=True, nogil=True, error_model="numpy")
def draw(
    view: View, ceiling: float, outlines: Outlines, bodies: Bodies, top: int, bottom: int, buffers: Buffers
) -> None:
    """Fill the rows [top, bottom).

    Args:
        view: the camera
        ceiling: its height [m], infinite if there is none
        outlines: all flat surfaces
        bodies: all people, nearest first
        top: first row
        bottom: row after the last
        buffers: to be filled
    """
    depths, surfaces = buffers.inverse_depth, buffers.surface
    _background(view, ceiling, top, bottom, depths, surfaces)
    _triangles(view, outlines, top, bottom, depths, surfaces)
    nearest, extent, front = bodies.nearest, bodies.extent, bodies.front
    for n in range(len(front)):
        if front[n] > 0.0 and not _hidden(extent, front, n, top, bottom, depths):
            for c in range(CAPSULES):
                if nearest[n, c] > 0.0:
                    _limb(
                        bodies.cone,
                        bodies.box,
                        n,
                        c,
                        nearest[n, c],
                        view.focal,
                        view.cx,
                        view.cy,
                        top,
                        bottom,
                        depths,
                        surfaces,
                    )


@njit(cache=True, nogil=True, error_model="numpy")
def _background(view: View, ceiling: float, top: int, bottom: int, depths: Depths, surfaces: Surfaces) -> None:
    """Floor, ceiling and sky: cameras do not roll, so that all of a row is equally far."""
    for v in range(top, bottom):
        rise = view.axes[1, 2] * (v - view.cy) / view.focal + view.axes[2, 2]
        surface, w = SKY, 0.0
        if rise < 0.0 and view.position[2] > 0.0:
            surface, w = FLOOR, -rise / view.position[2]
        elif rise > 0.0 and view.position[2] < ceiling < np.inf:
            surface, w = CEILING, rise / (ceiling - view.position[2])
        for u in range(view.width):
            depths[v, u] = w
            surfaces[v, u] = surface


@njit(cache=True, nogil=True, error_model="numpy")
def _triangles(view: View, outlines: Outlines, top: int, bottom: int, depths: Depths, surfaces: Surfaces) -> None:
    edge, plane, row = outlines.edge, outlines.plane, outlines.row
    for t in range(len(plane)):
        a, b, c = plane[t, 0], plane[t, 1], plane[t, 2]
        if a == 0.0 and b == 0.0 and c == 0.0:
            continue
        for v in range(max(math.ceil(row[t, 0]), top), min(math.floor(row[t, 1]) + 1, bottom)):
            y = (v - view.cy) / view.focal
            first, end = span(edge, plane, t, y, view.width, view.focal, view.cx)
            for u in range(first, end):
                w = np.float32(a * ((u - view.cx) / view.focal) + (b * y + c))
                if w > depths[v, u]:
                    depths[v, u] = min(w, np.float32(WITHIN))
                    surfaces[v, u] = TRIANGLES + t


@njit(cache=True, nogil=True, error_model="numpy")
def _hidden(extent: Array, front: Array, n: int, top: int, bottom: int, depths: Depths) -> bool:
    """True if what has been drawn is nearer than body n everywhere in its extent."""
    left, right = max(math.ceil(extent[n, 0]), 0), min(math.floor(extent[n, 1]) + 1, depths.shape[1])
    for v in range(max(math.ceil(extent[n, 2]), top), min(math.floor(extent[n, 3]) + 1, bottom)):
        for u in range(left, right):
            if depths[v, u] < front[n]:
                return False
    return True


@njit(cache=True, nogil=True, error_model="numpy")
def _limb(
    cones: Array,
    boxes: Array,
    n: int,
    c: int,
    nearest: float,
    focal: float,
    cx: float,
    cy: float,
    top: int,
    bottom: int,
    depths: Depths,
    surfaces: Surfaces,
) -> None:
    """Limb c of body n, as `round_cone.met`, with what is the same along a row taken out of the loop."""
    cone = round_cone(cones, n, c)
    within, width, surface = holds_camera(cone), depths.shape[1], PEOPLE + CAPSULES * n + c
    a0, a1, a2, a3 = boxes[n, c, 0, 0], boxes[n, c, 0, 1], boxes[n, c, 0, 2], boxes[n, c, 0, 3]
    b0, b1, b2, b3 = boxes[n, c, 1, 0], boxes[n, c, 1, 1], boxes[n, c, 1, 2], boxes[n, c, 1, 3]
    step = 1.0 / focal
    for v in range(max(math.ceil(min(a2, b2)), top), min(math.floor(max(a3, b3)) + 1, bottom)):
        low, high = _columns(a0, a1, a2, a3, b0, b1, b2, b3, v)
        left, right = max(math.ceil(low), 0), min(math.floor(high) + 1, width)
        y = (v - cy) * step
        if within or cone.c <= 0.0:
            for u in range(left, right):
                w = np.float32(WITHIN if within else min(met(cone, (u - cx) * step, y), WITHIN))
                if w > depths[v, u]:
                    depths[v, u], surfaces[v, u] = w, surface
            continue
        g0, h0, d0 = cone.ey * y + cone.ez, cone.ay * y + cone.az, y * y + 1.0
        s1, s0 = cone.m * cone.ax - cone.k * cone.ex, cone.m * h0 - cone.k * g0
        scale = 1.0 / cone.c
        for u in range(left, right):
            if depths[v, u] >= nearest:
                continue
            x = (u - cx) * step
            g = cone.ex * x + g0
            dd = x * x + d0
            a = cone.m * dd - g * g
            b = s1 * x + s0
            root = b * b - a * cone.c
            if root < 0.0:
                continue
            w = (b + math.sqrt(root)) * scale
            along = g - cone.k * w
            if along < 0.0 or along > cone.m * w:
                if a <= 0.0:
                    w = met(cone, x, y)
                elif along < 0.0:
                    w = ball_met(x, y, dd, cone.ax, cone.ay, cone.az, cone.clear_a)
                else:
                    w = ball_met(x, y, dd, cone.hx, cone.hy, cone.hz, cone.clear_b)
            near = np.float32(min(w, WITHIN))
            if near > depths[v, u]:
                depths[v, u], surfaces[v, u] = near, surface


@njit(cache=True, nogil=True, error_model="numpy")
def _columns(
    a0: float, a1: float, a2: float, a3: float, b0: float, b1: float, b2: float, b3: float, v: float
) -> tuple[float, float]:
    """First and last column in row `v` of the hull of two boxes a and b: between them, boxes change linearly."""
    start, stop = 0.0, 1.0
    # The box between them reaches over the row where its top is at most v and its bottom at least v.
    for room, change in ((v - a2, b2 - a2), (a3 - v, a3 - b3)):
        if change > 0.0:
            stop = min(stop, room / change)
        elif change < 0.0:
            start = max(start, room / change)
        elif room < 0.0:
            return 1.0, 0.0
    if start > stop:
        return 1.0, 0.0
    left, right = b0 - a0, b1 - a1
    return a0 + min(start * left, stop * left) - 1e-6, a1 + max(start * right, stop * right) + 1e-6
