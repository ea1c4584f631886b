"""The colour of a person where a pixel sees them: cloth, skin, hair and a face."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.clothing import BALD, LONG
from components.sensors.rendering.light import (
    Colour,
    Light,
    Vector,
    beyond,
    brightness,
    haziness,
    mixed,
    put,
    put_blend,
    scaled,
    shortening,
)
from components.sensors.rendering.tube import Tube, normal_of, tube_of
from crowdcosim.avatar import CAPSULES
from crowdcosim.body import SEGMENTS

Array = NDArray[np.float64]

_FOOT_END = max(i for i, s in enumerate(SEGMENTS) if "foot" in s) + 1
_PELVIS, _NECK, _HEAD = SEGMENTS.index("pelvis"), SEGMENTS.index("neck"), SEGMENTS.index("head")
_LEFT_TRUNK, _RIGHT_TRUNK = SEGMENTS.index("left trunk"), SEGMENTS.index("right trunk")
_HAIR, _SHIRT_UNDER = CAPSULES, CAPSULES + 1

_TRUNK_ROUND = 0.36
"""square of depth over width of the oval that a trunk is shaded as"""


@njit(cache=True, nogil=True, error_model="numpy", inline="always")
def paint_limb(
    step: float,
    x: float,
    y: float,
    floor: float,
    light: Light,
    cone: Array,
    facing: Array,
    cloth: NDArray[np.float32],
    style: int,
    jacket: bool,
    untucked: bool,
    n: int,
    k: int,
    c: int,
    depth: NDArray[np.float32],
    one: NDArray[np.float32],
    two: NDArray[np.float32],
    line: NDArray[np.uint8],
) -> None:
    """Fill P neighbours in a row in which limb c of a person is seen.

    Args:
        step: from column to column, over the focal length
        x: of the first pixel's ray (x, y, 1)
        y: of all their rays
        floor: how far it is below the camera [m]
        light: the light
        cone: (V, 17, 8) of all people in sight, as in `Bodies`
        facing: (V, 3) likewise
        cloth: (N, 19, 3) of all people, as in `Clothing`
        style: of the person's hair
        jacket: whether they wear an open one
        untucked: whether the shirt covers the hips
        n: the person in the crowd
        k: the person in sight
        c: the limb
        depth: (P,) inverse depths [1/m]
        one: (P,) or longer, to work with
        two: likewise
        line: (3 P,) to be filled
    """
    up = light.up
    ahead = (facing[k, 0], facing[k, 1], facing[k, 2])
    own = _of(cloth, n, c)
    # What hardly changes from pixel to pixel.
    shorter = shortening(x + 0.5 * len(depth) * step, y)
    there, rise = 1.0 / depth[0], x * up[0] + y * up[1] + up[2]
    haze = haziness(there * there * (x * x + y * y + 1.0 - rise * rise))
    tube = tube_of(cone, k, c)
    if c in (_LEFT_TRUNK, _RIGHT_TRUNK, _PELVIS):
        oval = _oval(cone, k, ahead, _left(up, ahead))
        _trunk(tube, oval, light, step, x, y, floor, shorter, c == _PELVIS, jacket, untucked, depth, one, two)
        put_blend(line, one, two, own, _under_or_over(cloth, n, c), light.haze, haze)
    elif c == _HEAD or c < _FOOT_END or (c == _NECK and style == LONG):
        hair, left = _of(cloth, n, _HAIR), _left(up, ahead)
        for i in range(len(depth)):
            here, z = x + i * step, 1.0 / depth[i]
            shade, rgb = _detailed(tube, light, ahead, left, here, y, z, step, floor, shorter, style, c, own, hair)
            put(line, i, mixed(scaled(rgb, shade), light.haze, haze))
    else:
        _limb(tube, light, step, x, y, floor, shorter, depth, one)
        put_blend(line, one, one, own, (0.0, 0.0, 0.0), light.haze, haze)


@njit(cache=True, nogil=True, error_model="numpy")
def _low(floor: float, up: Vector, x: float, y: float, z: float) -> float:
    """Less light reaches what is low and between others."""
    return 0.80 + 0.20 * min(max(floor + z * (x * up[0] + y * up[1] + up[2]), 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _limb(
    tube: Tube,
    light: Light,
    step: float,
    x: float,
    y: float,
    floor: float,
    shorter: float,
    depth: NDArray[np.float32],
    tone: NDArray[np.float32],
) -> None:
    """How bright the pixels of a limb of one colour are."""
    for i in range(len(depth)):
        here, z = x + i * step, 1.0 / depth[i]
        nx, ny, nz, _, _ = normal_of(tube, here, y, z)
        tone[i] = brightness(light, nx, ny, nz, here, y, shorter) * _low(floor, light.up, here, y, z)


class Oval(NamedTuple):
    """The oval in the place of a trunk's two tubes: what is ahead of its axis and what is to the left of it."""

    ahead: Vector
    left: Vector
    ahead_start: float
    """of the axis' lower end, along `ahead` [m]"""
    ahead_change: float
    """what is added to it at the upper end"""
    left_start: float
    left_change: float


@njit(cache=True, nogil=True, error_model="numpy")
def _oval(cone: Array, k: int, ahead: Vector, left: Vector) -> Oval:
    a, b = _LEFT_TRUNK, _RIGHT_TRUNK
    low = (
        0.5 * (cone[k, a, 0] + cone[k, b, 0]),
        0.5 * (cone[k, a, 1] + cone[k, b, 1]),
        0.5 * (cone[k, a, 2] + cone[k, b, 2]),
    )
    high = (
        0.5 * (cone[k, a, 4] + cone[k, b, 4]),
        0.5 * (cone[k, a, 5] + cone[k, b, 5]),
        0.5 * (cone[k, a, 6] + cone[k, b, 6]),
    )
    start, aside = _dot(low, ahead), _dot(low, left)
    return Oval(ahead, left, start, _dot(high, ahead) - start, aside, _dot(high, left) - aside)


@njit(cache=True, nogil=True, error_model="numpy")
def _trunk(
    tube: Tube,
    oval: Oval,
    light: Light,
    step: float,
    x: float,
    y: float,
    floor: float,
    shorter: float,
    pelvis: bool,
    jacket: bool,
    untucked: bool,
    depth: NDArray[np.float32],
    one: NDArray[np.float32],
    two: NDArray[np.float32],
) -> None:
    """How bright the pixels of a trunk or pelvis are, in its own colour and in that of what is over or under it."""
    ahead, left, up, p = oval.ahead, oval.left, light.up, tube.p
    along = 0.0 if pelvis else 1.0
    shirt, open_ = pelvis and untucked, jacket and not pelvis
    for i in range(len(depth)):
        here, z = x + i * step, 1.0 / depth[i]
        nx, ny, nz, s, _ = normal_of(tube, here, y, z)
        t, pixel = s * along, z * step
        forth = z * (here * ahead[0] + y * ahead[1] + ahead[2]) - oval.ahead_start - t * oval.ahead_change
        aside = z * (here * left[0] + y * left[1] + left[2]) - oval.left_start - t * oval.left_change
        rise = (nx * up[0] + ny * up[1] + nz * up[2] + 0.25) * p
        over = beyond(rise, 0.0, pixel) if shirt else 0.0
        under = 1.0 - beyond(abs(aside), (0.10 + 0.25 * s) * p, pixel) if open_ and forth > 0.0 else 0.0
        # It rounds off at the shoulders.
        wide = _TRUNK_ROUND * aside
        size = 0.75 / math.sqrt(forth * forth + wide * wide + 1e-9)
        forth, wide = forth * size, wide * size
        nx, ny, nz = (
            0.35 * nx + forth * ahead[0] + wide * left[0],
            0.35 * ny + forth * ahead[1] + wide * left[1],
            0.35 * nz + forth * ahead[2] + wide * left[2],
        )
        norm = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz)
        shade = brightness(light, nx * norm, ny * norm, nz * norm, here, y, shorter) * _low(floor, up, here, y, z)
        other = shade * (over + under)
        one[i], two[i] = shade - other, other


@njit(cache=True, nogil=True, error_model="numpy")
def _under_or_over(cloth: NDArray[np.float32], n: int, c: int) -> Colour:
    """What shows beside a trunk's own colour: a shirt over the pelvis, or under a jacket."""
    return _of(cloth, n, _LEFT_TRUNK if c == _PELVIS else _SHIRT_UNDER)


@njit(cache=True, nogil=True, error_model="numpy")
def _detailed(
    tube: Tube,
    light: Light,
    ahead: Vector,
    left: Vector,
    x: float,
    y: float,
    z: float,
    step: float,
    floor: float,
    shorter: float,
    style: int,
    c: int,
    own: Colour,
    hair: Colour,
) -> tuple[float, Colour]:
    """How bright a pixel of a head, a neck under long hair or a foot is, and its colour."""
    up, pixel = light.up, z * step
    nx, ny, nz, _, thin = normal_of(tube, x, y, z)
    shade = brightness(light, nx, ny, nz, x, y, shorter) * _low(floor, up, x, y, z)
    if c == _HEAD:
        size = tube.thick + tube.thinner
        there = (x * z - tube.ax - tube.ex, y * z - tube.ay - tube.ey, z - tube.az - tube.ez)
        aside = _dot(there, left) * size
        return shade, _head(_dot(there, ahead) * size, aside, _dot(there, up) * size, pixel * size, style, own, hair)
    if c < _FOOT_END:
        fall = -(nx * up[0] + ny * up[1] + nz * up[2]) - 0.35
        return shade, scaled(own, 1.0 - 0.55 * beyond(fall, 0.0, pixel * thin))
    back = 0.2 - (nx * ahead[0] + ny * ahead[1] + nz * ahead[2])
    return shade, mixed(own, hair, beyond(back, 0.0, pixel * thin))


@njit(cache=True, nogil=True, error_model="numpy")
def _left(up: Vector, ahead: Vector) -> Vector:
    return (
        up[1] * ahead[2] - up[2] * ahead[1],
        up[2] * ahead[0] - up[0] * ahead[2],
        up[0] * ahead[1] - up[1] * ahead[0],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True, nogil=True, error_model="numpy")
def _of(cloth: NDArray[np.float32], n: int, part: int) -> Colour:
    return float(cloth[n, part, 0]), float(cloth[n, part, 1]), float(cloth[n, part, 2])


@njit(cache=True, nogil=True, error_model="numpy")
def _head(ahead: float, left: float, rise: float, width: float, style: int, skin: Colour, hair: Colour) -> Colour:
    """Skin, hair and a face, at a point seen from the skull's middle, over its radius; `width` is a pixel's."""
    line = 0.18 + 0.38 * ahead  # the hair's lower edge
    if style == LONG:
        line = 0.50 if ahead > 0.45 else -2.5 + 5.0 * max(ahead + 0.15, 0.0)
    elif style == BALD:
        line = 2.0
        if ahead < -0.1:
            line = -0.75 if rise < 0.45 else 2.0
    elif ahead < -0.2:
        line = -0.75
    colour = mixed(skin, hair, beyond(rise, line, width + 0.06))
    if ahead > 0.3 and width < 0.5:
        side = abs(left) - 0.37
        eye = math.sqrt(side * side + 1.6 * (rise + 0.22) * (rise + 0.22))
        colour = mixed((0.93, 0.92, 0.90), colour, beyond(eye, 0.15, width))
        colour = mixed((0.13, 0.10, 0.09), colour, beyond(eye, 0.10, width))
        brow = max(abs(side) - 0.20, abs(rise - 0.06) - 0.03)
        colour = mixed(hair, colour, beyond(brow, 0.02, width))
        mouth = max(abs(left) - 0.24, abs(rise + 1.05) - 0.035)
        colour = mixed((0.55, 0.25, 0.22), colour, 0.4 + 0.6 * beyond(mouth, 0.02, width))
        if -0.75 < rise < -0.25:
            nose = abs(left) - 0.10 - 0.10 * min(max(-0.30 - rise, 0.0), 0.4)
            colour = scaled(colour, 0.86 + 0.14 * beyond(nose, 0.0, width))
    return colour
