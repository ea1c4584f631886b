"""The colour of floor, ceiling, sky, walls, doors, obstacles and robots where a pixel sees them."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.light import (
    Colour,
    Light,
    beyond,
    brightness,
    haziness,
    mixed,
    put,
    put_blend,
    scaled,
    shortening,
    speckle,
    striped,
)
from components.sensors.rendering.scenery import (
    DOOR,
    MESH,
    PILLAR,
    ROBOT,
    ROBOT_TOP,
    TOP,
    WALL,
    Scenery,
)
from components.sensors.rendering.view import View

Array = NDArray[np.float64]

_TILE, _JOINT = 0.8, 0.012
_PANEL = 0.6
_OFTEN = 8
"""what changes little from pixel to pixel is worked out for one in so many"""


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def paint_level(
    view: View,
    light: Light,
    size: Array,
    inverse: float,
    shade: NDArray[np.float32],
    x: float,
    y: float,
    floor: bool,
    one: NDArray[np.float32],
    two: NDArray[np.float32],
    line: NDArray[np.uint8],
) -> None:
    """Fill P neighbours in a row, from the ray (x, y, 1) on, in which the floor, or else the ceiling, is seen.

    `size`: (2,) of the world [m]; `inverse`: inverse depth of them all [1/m]; `shade`: (P,) shadows on the floor; `one`
    and `two`: (P,) or longer, to work with; `line`: (3 P,) to be filled.
    """
    axes, step = view.axes, 1.0 / view.focal
    rise, z = axes[1, 2] * y + axes[2, 2], 1.0 / inverse
    # Ray and point are linear in the column.
    sx, sy = axes[0, 0] * step, axes[0, 1] * step
    rx, ry = axes[0, 0] * x + axes[1, 0] * y + axes[2, 0], axes[0, 1] * x + axes[1, 1] * y + axes[2, 1]
    slide = step * axes[1, 2] / rise
    # How far a pixel reaches along x and y.
    downx, downy, acrossx, acrossy = axes[1, 0] * step * z, axes[1, 1] * step * z, abs(sx) * z, abs(sy) * z
    hx, hy = view.position[0], view.position[1]
    haze = haziness(z * z * (rx * rx + ry * ry))
    if floor:
        _floor(hx, hy, rx, ry, sx, sy, z, downx, downy, acrossx, acrossy, slide, size[0], size[1], shade, one, two)
        put_blend(line, one, two, (0.60, 0.605, 0.60), (0.655, 0.635, 0.605), light.haze, haze)
    else:
        _ceiling(hx, hy, rx, ry, sx, sy, z, downx, downy, acrossx, acrossy, slide, len(shade), one, two)
        put_blend(line, one, two, (0.80, 0.80, 0.785), (1.0, 1.0, 0.985), light.haze, haze)


@njit(cache=True, nogil=True, error_model="numpy")
def _floor(
    hx: float,
    hy: float,
    rx: float,
    ry: float,
    sx: float,
    sy: float,
    z: float,
    downx: float,
    downy: float,
    acrossx: float,
    acrossy: float,
    slide: float,
    length: float,
    width: float,
    shade: NDArray[np.float32],
    ground: NDArray[np.float32],
    tiles: NDArray[np.float32],
) -> None:
    """How bright the ground and the tiles are, times the share of a pixel outside and within the world."""
    often = 1.0 / _TILE
    for u in range(len(shade)):
        dx, dy = rx + sx * u, ry + sy * u
        px, py = hx + dx * z, hy + dy * z
        wx, wy = acrossx + abs(downx - dx * z * slide), acrossy + abs(downy - dy * z * slide)
        gap = (1.0 - striped(px, _TILE, often, _JOINT, wx)) * (1.0 - striped(py, _TILE, often, _JOINT, wy))
        clear = max(1.0 - max(wx, wy) * often, 0.0)
        tint = 1.0 + 0.09 * clear * (speckle(np.floor(px * often), np.floor(py * often)) - 0.5)
        inside = min(max(min(min(px, length - px) / wx, min(py, width - py) / wy) + 0.5, 0.0), 1.0)
        ground[u] = shade[u] * (1.0 - inside)
        tiles[u] = shade[u] * inside * tint * (0.70 + 0.30 * gap)


@njit(cache=True, nogil=True, error_model="numpy")
def _ceiling(
    hx: float,
    hy: float,
    rx: float,
    ry: float,
    sx: float,
    sy: float,
    z: float,
    downx: float,
    downy: float,
    acrossx: float,
    acrossy: float,
    slide: float,
    count: int,
    panels: NDArray[np.float32],
    lamps: NDArray[np.float32],
) -> None:
    """How bright the panels are, times the share of a pixel on them, and the share on a lamp."""
    often = 1.0 / _PANEL
    for u in range(count):
        dx, dy = rx + sx * u, ry + sy * u
        px, py = hx + dx * z, hy + dy * z
        wx, wy = acrossx + abs(downx - dx * z * slide), acrossy + abs(downy - dy * z * slide)
        gap = (1.0 - striped(px, _PANEL, often, 0.012, wx)) * (1.0 - striped(py, _PANEL, often, 0.012, wy))
        lamp = striped(px - 1.5, 3.0, 1.0 / 3.0, 1.2, wx) * striped(py - 1.25, 2.5, 0.4, 0.6, wy)
        panels[u], lamps[u] = (0.92 + 0.08 * gap) * (1.0 - lamp), lamp


@njit(cache=True, nogil=True, error_model="numpy")
def paint_sky(view: View, light: Light, y: float, line: NDArray[np.uint8]) -> None:
    """Fill all pixels of `line`, (3 P,), neighbours in a row of rays (x, y, 1) in which the sky is seen."""
    rise = view.axes[1, 2] * y + view.axes[2, 2]
    rgb = mixed(light.haze, (0.50, 0.67, 0.88), min(max(1.4 * rise, 0.0), 1.0))
    for i in range(len(line) // 3):
        put(line, i, rgb)


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def paint_triangle(
    view: View,
    light: Light,
    scenery: Scenery,
    t: int,
    start: float,
    y: float,
    depth: NDArray[np.float32],
    line: NDArray[np.uint8],
) -> None:
    """Fill P neighbours in a row, from the ray (start, y, 1) on, in which triangle t is seen.

    `depth`: (P,) inverse depths [1/m]; `line`: (3 P,) to be filled.
    """
    axes, step = view.axes, 1.0 / view.focal
    hx, hy, hz = view.position[0], view.position[1], view.position[2]
    paint, number = scenery.paint[t], int(scenery.number[t])
    ox, oy, ux, uy, length, height = (
        scenery.place[t, 0],
        scenery.place[t, 1],
        scenery.place[t, 2],
        scenery.place[t, 3],
        scenery.place[t, 4],
        scenery.place[t, 5],
    )
    nx, ny, nz = scenery.normal[t, 0], scenery.normal[t, 1], scenery.normal[t, 2]
    if paint == WALL:
        _wall_line(view, light, (ox, oy), (ux, uy), (nx, ny), start, y, depth, line)
        return
    round_ = paint in (PILLAR, ROBOT)
    light_here = haze = 0.0
    rgb = (0.0, 0.0, 0.0)
    for i in range(len(depth)):
        x, z = start + i * step, 1.0 / depth[i]
        dx = (axes[0, 0] * x + axes[1, 0] * y + axes[2, 0]) * z
        dy = (axes[0, 1] * x + axes[1, 1] * y + axes[2, 1]) * z
        dz = (axes[0, 2] * x + axes[1, 2] * y + axes[2, 2]) * z
        px, py, pz, pixel = hx + dx, hy + dy, hz + dz, z * step
        if round_:
            nx, ny = (px - ox) / length, (py - oy) / length
            norm = 1.0 / math.sqrt(nx * nx + ny * ny)
            nx, ny, nz = nx * norm, ny * norm, 0.0
        if round_ or i % _OFTEN == 0:
            # Flat things are seen from either side.
            sign = -1.0 if dx * nx + dy * ny + dz * nz > 0.0 else 1.0
            light_here = brightness(
                light,
                sign * (axes[0, 0] * nx + axes[0, 1] * ny + axes[0, 2] * nz),
                sign * (axes[1, 0] * nx + axes[1, 1] * ny + axes[1, 2] * nz),
                sign * (axes[2, 0] * nx + axes[2, 1] * ny + axes[2, 2] * nz),
                x,
                y,
                shortening(x, y),
            )
            haze = haziness(dx * dx + dy * dy)
        shade = _standing(light_here, pz)
        qx, qy = px - ox, py - oy
        along, left = qx * ux + qy * uy, qy * ux - qx * uy
        if paint == DOOR:
            rgb = _door(along, pz, length, height, pixel)
        elif paint == ROBOT:
            rgb = _robot(along / length, left / length, pz / height, number, pixel / length, pixel / height)
        elif paint == ROBOT_TOP:
            rgb = _robot_top(along / length, left / length, number, pixel / length)
        elif paint == MESH:
            rgb = (0.70, 0.685, 0.65)
        elif paint == PILLAR:
            rgb = (0.72, 0.71, 0.69)
        else:
            rgb = scaled(
                mixed((0.62, 0.49, 0.36), (0.55, 0.58, 0.60), speckle(number, 7)), 1.08 if paint == TOP else 1.0
            )
        put(line, i, mixed(scaled(rgb, shade), light.haze, haze))


@njit(cache=True, nogil=True, error_model="numpy")
def _wall_line(
    view: View,
    light: Light,
    place: tuple[float, float],
    ahead: tuple[float, float],
    normal: tuple[float, float],
    start: float,
    y: float,
    depth: NDArray[np.float32],
    line: NDArray[np.uint8],
) -> None:
    """A wall, as in `paint_triangle`: by far the most frequent, so without branches, as vector instructions.

    `place`: (x, y) where it begins [m]; `ahead` and `normal`: (x, y) unit vectors.
    """
    axes, step = view.axes, 1.0 / view.focal
    rx, ry, rz = axes[0, 0], axes[0, 1], axes[0, 2]
    dx, dy, dz = axes[1, 0] * y + axes[2, 0], axes[1, 1] * y + axes[2, 1], axes[1, 2] * y + axes[2, 2]
    hx, hy, hz = view.position[0] - place[0], view.position[1] - place[1], view.position[2]
    # The normal towards the camera, in its frame.
    sign = -1.0 if hx * normal[0] + hy * normal[1] < 0.0 else 1.0
    nx = sign * (axes[0, 0] * normal[0] + axes[0, 1] * normal[1])
    ny = sign * (axes[1, 0] * normal[0] + axes[1, 1] * normal[1])
    nz = sign * (axes[2, 0] * normal[0] + axes[2, 1] * normal[1])
    for i in range(len(depth)):
        x, z = start + i * step, 1.0 / depth[i]
        px, py, pz = (rx * x + dx) * z, (ry * x + dy) * z, hz + (rz * x + dz) * z
        light_here = brightness(light, nx, ny, nz, x, y, shortening(x, y))
        rgb = _wall((hx + px) * ahead[0] + (hy + py) * ahead[1], pz, z * step)
        put(line, i, mixed(scaled(rgb, _standing(light_here, pz)), light.haze, haziness(px * px + py * py)))


@njit(cache=True, nogil=True, error_model="numpy")
def _standing(light: float, height: float) -> float:
    """How bright an upright thing in this light is: less reaches the foot of what stands on the floor."""
    return (0.42 + 0.66 * light) * (0.86 + 0.28 * min(max(height, 0.0), 0.5))


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def _wall(along: float, height: float, pixel: float) -> Colour:
    colour = mixed((0.80, 0.775, 0.72), (0.845, 0.835, 0.80), beyond(height, 1.0, pixel + 0.02))
    colour = scaled(colour, 1.0 - 0.05 * striped(along, 2.4, 1.0 / 2.4, 0.015, pixel))
    rail = 1.0 - beyond(abs(height - 1.0), 0.03, pixel)
    colour = mixed(colour, (0.66, 0.62, 0.55), rail)
    return mixed((0.42, 0.40, 0.37), colour, beyond(height, 0.10, pixel))


@njit(cache=True, nogil=True, error_model="numpy")
def _door(along: float, height: float, width: float, top: float, pixel: float) -> Colour:
    inset = min(along, width - along, top - height)
    colour = mixed((0.36, 0.26, 0.18), (0.55, 0.40, 0.27), beyond(inset, 0.06, pixel))
    groove = max(abs(along - 0.5 * width) - 0.5 * width + 0.2, abs(height - 0.5 * top) - 0.5 * top + 0.25)
    colour = scaled(colour, 1.0 - 0.2 * (1.0 - beyond(abs(groove), 0.01, pixel)))
    handle = max(abs(along - 0.13) - 0.06, abs(height - 1.05) - 0.015)
    return mixed((0.80, 0.79, 0.76), colour, beyond(handle, 0.0, pixel))


@njit(cache=True, nogil=True, error_model="numpy")
def _accent(number: int) -> Colour:
    which = number % 4
    if which == 1:
        return 0.93, 0.45, 0.12
    if which == 2:
        return 0.13, 0.55, 0.80
    if which == 3:
        return 0.36, 0.70, 0.30
    return 0.78, 0.24, 0.45


@njit(cache=True, nogil=True, error_model="numpy")
def _robot(ahead: float, left: float, height: float, number: int, width: float, rise: float) -> Colour:
    """A dark base, a light body with a ring in the robot's own colour, and a screen ahead.

    Places are over the robot's radius and height; `width` and `rise` are what a pixel is of them.
    """
    colour = mixed((0.14, 0.14, 0.15), (0.86, 0.86, 0.85), beyond(height, 0.22, rise))
    colour = mixed(_accent(number), colour, beyond(abs(height - 0.80), 0.05, rise))
    if ahead > 0.0:
        on_screen = (1.0 - beyond(abs(left), 0.55, width)) * (1.0 - beyond(abs(height - 0.50), 0.16, rise))
        colour = mixed(colour, (0.10, 0.12, 0.15), on_screen)
        eye = (1.0 - beyond(abs(abs(left) - 0.24), 0.07, width)) * (1.0 - beyond(abs(height - 0.52), 0.05, rise))
        colour = mixed(colour, (0.55, 0.90, 0.95), eye)
    return colour


@njit(cache=True, nogil=True, error_model="numpy")
def _robot_top(ahead: float, left: float, number: int, width: float) -> Colour:
    """A disc with an arrow ahead."""
    rim = math.sqrt(ahead * ahead + left * left)
    colour = mixed((0.90, 0.90, 0.89), _accent(number), beyond(rim, 0.84, width))
    arrow = max(abs(left) - 0.5 * (0.62 - ahead), -0.45 - ahead)
    return mixed((0.16, 0.17, 0.19), colour, beyond(arrow, 0.0, width))
