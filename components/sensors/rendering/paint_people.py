"""The colour of a person where a pixel sees them: cloth, skin, hair and a face."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.clothing import BALD, LONG
from components.sensors.rendering.light import (
    Colour,
    Light,
    beyond,
    brightness,
    haziness,
    mixed,
    put,
    scaled,
    shortening,
)
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
    focal: float,
    cx: float,
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
    depths: NDArray[np.float32],
    v: int,
    first: int,
    end: int,
    tone: Array,
    colour: NDArray[np.uint8],
) -> None:
    """Fill the columns [first, end) of row v of `colour`, (H, W, 3), in which limb c of a person is seen.

    Args:
        focal: of the camera [pixels]
        cx: column of its axis
        y: of the rays (x, y, 1) of this row
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
        depths: (H, W) inverse depths [1/m]
        v: the row
        first: column
        end: column after the last
        tone: (W,) to work with
        colour: to be filled
    """
    up = light.up
    ax, ay, az, p = cone[k, c, 0], cone[k, c, 1], cone[k, c, 2], cone[k, c, 3]
    ex, ey, ez, taper = cone[k, c, 4] - ax, cone[k, c, 5] - ay, cone[k, c, 6] - az, p - cone[k, c, 7]
    per = 1.0 / (ex * ex + ey * ey + ez * ez - taper * taper)
    ahead = (facing[k, 0], facing[k, 1], facing[k, 2])
    left = (
        up[1] * ahead[2] - up[2] * ahead[1],
        up[2] * ahead[0] - up[0] * ahead[2],
        up[0] * ahead[1] - up[1] * ahead[0],
    )
    thick, thinner = 1.0 / p, 1.0 / (p - taper) - 1.0 / p
    own, hair = _of(cloth, n, c), _of(cloth, n, _HAIR)
    step = 1.0 / focal
    # What hardly changes from pixel to pixel.
    shorter = shortening((0.5 * (first + end) - cx) * step, y)
    there, x = 1.0 / depths[v, first], (first - cx) * step
    rise = x * up[0] + y * up[1] + up[2]
    haze = haziness(there * there * (x * x + y * y + 1.0 - rise * rise))
    head = c == _HEAD
    trunk = c in (_LEFT_TRUNK, _RIGHT_TRUNK, _PELVIS)
    plain = not (head or trunk or c < _FOOT_END or (c == _NECK and style == LONG))
    if trunk:
        shirt, under = _of(cloth, n, _LEFT_TRUNK), _of(cloth, n, _SHIRT_UNDER)
        jacket, untucked = jacket and c != _PELVIS, untucked and c == _PELVIS
        a, b = _LEFT_TRUNK, _RIGHT_TRUNK
        mx, my, mz = (
            0.5 * (cone[k, a, 0] + cone[k, b, 0]),
            0.5 * (cone[k, a, 1] + cone[k, b, 1]),
            0.5 * (cone[k, a, 2] + cone[k, b, 2]),
        )
        tx, ty, tz = (
            0.5 * (cone[k, a, 4] + cone[k, b, 4]) - mx,
            0.5 * (cone[k, a, 5] + cone[k, b, 5]) - my,
            0.5 * (cone[k, a, 6] + cone[k, b, 6]) - mz,
        )
    if plain:
        # Of one colour: without branches, so that the loop becomes vector instructions.
        u0, u1, u2 = up[0], up[1], up[2]
        for u in range(first, end):
            x, z = (u - cx) * step, 1.0 / depths[v, u]
            qx, qy, qz = x * z - ax, y * z - ay, z - az
            s = min(max((ex * qx + ey * qy + ez * qz - p * taper) * per, 0.0), 1.0)
            thin = thick + s * thinner
            nx, ny, nz = (qx - s * ex) * thin, (qy - s * ey) * thin, (qz - s * ez) * thin
            height = min(max(floor + z * (x * u0 + y * u1 + u2), 0.0), 1.0)
            tone[u] = brightness(light, nx, ny, nz, x, y, shorter) * (0.80 + 0.20 * height)
        for u in range(first, end):
            put(colour, v, u, mixed(scaled(own, tone[u]), light.haze, haze))
        return
    for u in range(first, end):
        x, z = (u - cx) * step, 1.0 / depths[v, u]
        px, py = x * z, y * z
        pixel = z * step
        qx, qy, qz = px - ax, py - ay, z - az
        s = min(max((ex * qx + ey * qy + ez * qz - p * taper) * per, 0.0), 1.0)
        thin = thick + s * thinner
        nx, ny, nz = (qx - s * ex) * thin, (qy - s * ey) * thin, (qz - s * ez) * thin
        rgb = own
        if head:
            i, j, m, size = px - ax - ex, py - ay - ey, z - az - ez, thick + thinner
            rgb = _head(
                (i * ahead[0] + j * ahead[1] + m * ahead[2]) * size,
                (i * left[0] + j * left[1] + m * left[2]) * size,
                (i * up[0] + j * up[1] + m * up[2]) * size,
                pixel * size,
                style,
                own,
                hair,
            )
        elif trunk:
            t = s if c != _PELVIS else 0.0
            i, j, m = px - mx - t * tx, py - my - t * ty, z - mz - t * tz
            forth = i * ahead[0] + j * ahead[1] + m * ahead[2]
            aside = i * left[0] + j * left[1] + m * left[2]
            if untucked:
                rise = (nx * up[0] + ny * up[1] + nz * up[2] + 0.25) * p
                rgb = mixed(own, shirt, beyond(rise, 0.0, pixel))
            elif jacket and forth > 0.0:
                rgb = mixed(under, own, beyond(abs(aside), (0.10 + 0.25 * s) * p, pixel))
            # An oval in the place of two tubes, which rounds off at the shoulders.
            wide = _TRUNK_ROUND * aside
            oval = 0.75 / math.sqrt(forth * forth + wide * wide + 1e-9)
            forth, wide = forth * oval, wide * oval
            nx, ny, nz = (
                0.35 * nx + forth * ahead[0] + wide * left[0],
                0.35 * ny + forth * ahead[1] + wide * left[1],
                0.35 * nz + forth * ahead[2] + wide * left[2],
            )
            norm = 1.0 / math.sqrt(nx * nx + ny * ny + nz * nz)
            nx, ny, nz = nx * norm, ny * norm, nz * norm
        elif c < _FOOT_END:
            fall = -(nx * up[0] + ny * up[1] + nz * up[2]) - 0.35
            rgb = scaled(own, 1.0 - 0.55 * beyond(fall, 0.0, pixel * thin))
        else:
            back = 0.2 - (nx * ahead[0] + ny * ahead[1] + nz * ahead[2])
            rgb = mixed(own, hair, beyond(back, 0.0, pixel * thin))
        # Less light reaches what is low and between others.
        height = min(max(floor + px * up[0] + py * up[1] + z * up[2], 0.0), 1.0)
        shade = brightness(light, nx, ny, nz, x, y, shorter) * (0.80 + 0.20 * height)
        put(colour, v, u, mixed(scaled(rgb, shade), light.haze, haze))


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
