"""No jagged edges: pixels on the edge between two surfaces get a share of both colours.

For two neighbours that see different surfaces, the geometry says where between their centres the edge is: where the
nearer surface ends, or where both are equally far. The pixel that reaches over the edge takes the other's colour
for that part; of its four neighbours the one that gives it most. After Persson, Geometry buffer anti-aliasing, 2011.
Differs from it: the edge's place comes from the surfaces themselves and not from a buffer. Colours only: a depth or an
id is never a mixture.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.buffers import PEOPLE, SKY, TRIANGLES, Buffers
from components.sensors.rendering.people import Bodies
from components.sensors.rendering.round_cone import gap, holds_camera, met, round_cone
from components.sensors.rendering.triangles import Outlines, outside
from components.sensors.rendering.view import View
from crowdcosim.avatar import CAPSULES

Array = NDArray[np.float64]

_ALIKE = 10
"""summed difference of two colours, of 765, below which no edge shows"""


@njit(cache=True, nogil=True, error_model="numpy")
def smooth_rows(
    view: View,
    ceiling: float,
    outlines: Outlines,
    bodies: Bodies,
    buffers: Buffers,
    colour: NDArray[np.uint8],
    top: int,
    bottom: int,
    smooth: NDArray[np.uint8],
) -> None:
    """Smooth the rows [top, bottom) of `smooth`, (H, W, 3), which begins as a copy of `colour`."""
    share = np.zeros((bottom - top, view.width), np.float32)
    other = np.zeros((bottom - top, view.width), np.int8)
    surface, depth, edge, plane, cone = (
        buffers.surface,
        buffers.inverse_depth,
        outlines.edge,
        outlines.plane,
        bodies.cone,
    )
    floor, roof = 1.0 / view.position[2], 1.0 / (ceiling - view.position[2])
    tilt, ahead, step = view.axes[1, 2], view.axes[2, 2], 1.0 / view.focal
    for v in range(max(top - 1, 0), bottom):
        y = (v - view.cy) * step
        rise, next_rise = tilt * y + ahead, tilt * (y + step) + ahead
        for u in range(view.width):
            here = surface[v, u]
            if v >= top and u + 1 < view.width and surface[v, u + 1] != here and _differ(colour, v, u, v, u + 1):
                x = (u - view.cx) * step
                plain = rise * (roof if rise > 0.0 else -floor)
                at = _edge(
                    (here, surface[v, u + 1]),
                    (depth[v, u], depth[v, u + 1]),
                    (x, y),
                    (x + step, y),
                    (plain, plain),
                    edge,
                    plane,
                    cone,
                )
                _note(share, other, v - top, u, 0.5 - at, 0)
                _note(share, other, v - top, u + 1, at - 0.5, 1)
            if v + 1 < view.height and surface[v + 1, u] != here and _differ(colour, v, u, v + 1, u):
                x = (u - view.cx) * step
                plain = rise * (roof if rise > 0.0 else -floor)
                below = next_rise * (roof if next_rise > 0.0 else -floor)
                at = _edge(
                    (here, surface[v + 1, u]),
                    (depth[v, u], depth[v + 1, u]),
                    (x, y),
                    (x, y + step),
                    (plain, below),
                    edge,
                    plane,
                    cone,
                )
                if v >= top:
                    _note(share, other, v - top, u, 0.5 - at, 2)
                if v + 1 < bottom:
                    _note(share, other, v + 1 - top, u, at - 0.5, 3)
    for v in range(top, bottom):
        for u in range(view.width):
            part = share[v - top, u]
            if part > 0.0:
                which = other[v - top, u]
                j, i = v + (which == 2) - (which == 3), u + (which == 0) - (which == 1)
                for k in range(3):
                    mine, yours = float(colour[v, u, k]), float(colour[j, i, k])
                    smooth[v, u, k] = np.uint8(mine + part * (yours - mine) + 0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def _differ(colour: NDArray[np.uint8], v: int, u: int, j: int, i: int) -> bool:
    total = 0
    for k in range(3):
        total += abs(int(colour[v, u, k]) - int(colour[j, i, k]))
    return total > _ALIKE


@njit(cache=True, nogil=True, error_model="numpy")
def _note(share: NDArray[np.float32], other: NDArray[np.int8], v: int, u: int, part: float, which: int) -> None:
    if part > share[v, u]:
        share[v, u], other[v, u] = part, which


@njit(cache=True, nogil=True, error_model="numpy")
def _edge(
    surfaces: tuple[int, int],
    depths: tuple[float, float],
    ray: tuple[float, float],
    other_ray: tuple[float, float],
    plain: tuple[float, float],
    edge: Array,
    plane: Array,
    cone: Array,
) -> float:
    """How far the edge between two neighbouring pixels is from the first one's centre, 0 to 1.

    They look along rays (x, y, 1) and see surfaces at inverse depths; `plain` are those of the floor or ceiling there.
    """
    (first, second), (x, y), (p, q) = surfaces, ray, other_ray
    # The nearer one first: where it ends, nothing else matters.
    nearer = depths[0] >= depths[1]
    for _ in range(2):
        if nearer:
            there = _beside(first, edge, cone, p, q)
            if there > 0.0:
                return _crossing(-_beside(first, edge, cone, x, y), there)
        else:
            back = _beside(second, edge, cone, x, y)
            if back > 0.0:
                return 1.0 - _crossing(-_beside(second, edge, cone, p, q), back)
        nearer = not nearer
    here = depths[0] - _inverse_depth(second, plain[0], plane, cone, x, y)
    return _crossing(here, depths[1] - _inverse_depth(first, plain[1], plane, cone, p, q))


@njit(cache=True, nogil=True, error_model="numpy")
def _crossing(inside: float, outside: float) -> float:
    """Where a linear function that is `inside` at 0 and -`outside` at 1 is zero."""
    inside, outside = max(inside, 0.0), max(outside, 0.0)
    return inside / (inside + outside) if inside + outside > 0.0 else 0.5


@njit(cache=True, nogil=True, error_model="numpy")
def _beside(surface: int, edge: Array, cone: Array, x: float, y: float) -> float:
    """How far the ray (x, y, 1) passes by a surface, negative through it."""
    if surface >= PEOPLE:
        k = (surface - PEOPLE) // CAPSULES
        return gap(cone, k, surface - PEOPLE - CAPSULES * k, x, y)
    if surface >= TRIANGLES:
        return outside(edge, surface - TRIANGLES, x, y)
    return -1.0


@njit(cache=True, nogil=True, error_model="numpy")
def _inverse_depth(surface: int, plain: float, plane: Array, cone: Array, x: float, y: float) -> float:
    """Of a surface that the ray (x, y, 1) meets."""
    if surface >= PEOPLE:
        k = (surface - PEOPLE) // CAPSULES
        limb = round_cone(cone, k, surface - PEOPLE - CAPSULES * k)
        return 0.0 if holds_camera(limb) else met(limb, x, y)
    if surface >= TRIANGLES:
        t = surface - TRIANGLES
        return plane[t, 0] * x + plane[t, 1] * y + plane[t, 2]
    return 0.0 if surface == SKY else plain
