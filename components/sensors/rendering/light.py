"""The light in a picture: how bright a surface is, and what distance does to its colour."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.view import View

Colour = tuple[float, float, float]
"""red, green and blue, 0 to 1"""
Vector = tuple[float, float, float]

_KEY = (0.35, 0.25, 0.90)
_HAZE = 75.0


class Light(NamedTuple):
    """Directions in the camera's frame."""

    up: Vector
    """unit vector"""
    key: Vector
    """unit vector to where most light comes from"""
    haze: Colour
    """what is far away fades into this"""


def light_of(view: View, ceiling: float) -> Light:
    """The light under a ceiling at this height [m], or under the open sky if it is infinite."""
    up, key = view.axes[:, 2].tolist(), (view.axes @ np.array(_KEY) / np.linalg.norm(_KEY)).tolist()
    return Light(tuple(up), tuple(key), (0.80, 0.80, 0.79) if ceiling < np.inf else (0.84, 0.88, 0.92))


@njit(cache=True, nogil=True, error_model="numpy")
def shortening(x: float, y: float) -> float:
    """One over the length of the ray (x, y, 1)."""
    return 1.0 / math.sqrt(x * x + y * y + 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def brightness(light: Light, nx: float, ny: float, nz: float, x: float, y: float, shorter: float) -> float:
    """Of a surface with the unit normal n in the camera's frame, seen along (x, y, 1), whose `shortening` is given."""
    up = nx * light.up[0] + ny * light.up[1] + nz * light.up[2]
    key = nx * light.key[0] + ny * light.key[1] + nz * light.key[2]
    facing = -(nx * x + ny * y + nz) * shorter
    return 0.42 + 0.16 * up + 0.30 * max(key, 0.0) + 0.24 * max(facing, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def haziness(square: float) -> float:
    """Share of the haze in a colour, by the square of its distance over the ground [m2]: from above, all is clear."""
    return square / (square + _HAZE * _HAZE)


@njit(cache=True, nogil=True, error_model="numpy")
def mixed(a: Colour, b: Colour, share: float) -> Colour:
    """`a` where `share` is 0, `b` where it is 1."""
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])


@njit(cache=True, nogil=True, error_model="numpy")
def scaled(a: Colour, by: float) -> Colour:
    return a[0] * by, a[1] * by, a[2] * by


@njit(cache=True, nogil=True, error_model="numpy")
def beyond(x: float, edge: float, width: float) -> float:
    """Share of a pixel of this width around x that is beyond an edge: no jagged edges between two paints."""
    return min(max((x - edge) / width + 0.5, 0.0), 1.0)


@njit(cache=True, nogil=True, error_model="numpy")
def striped(x: float, period: float, often: float, stripe: float, width: float) -> float:
    """Share of a pixel of this width around x that is on stripes centred on the multiples of `period`, 1 / `often`.

    Without branches, so that a loop over pixels becomes vector instructions.
    """
    turn = x * often
    away = abs(turn - np.floor(turn + 0.5)) * period
    half, reach = 0.5 * width, 0.5 * stripe
    inside = max(min(away + half, reach) - max(away - half, -reach), 0.0) / width
    return stripe * often if width >= period else inside


@njit(cache=True, nogil=True, error_model="numpy")
def speckle(i: float, j: float) -> float:
    """A number from 0 to 1 for a place (i, j), whole numbers, of a grid."""
    h = np.uint32(np.int32(i)) * np.uint32(0x85EBCA6B) ^ np.uint32(np.int32(j)) * np.uint32(0xC2B2AE35)
    h = np.uint32((h ^ (h >> np.uint32(15))) * np.uint32(0x27D4EB2F))
    return np.float64(np.int32((h ^ (h >> np.uint32(13))) & np.uint32(0xFFFF))) * (1.0 / 65535.0)


@njit(cache=True, nogil=True, error_model="numpy")
def put(line: NDArray[np.uint8], i: int, rgb: Colour) -> None:
    """Write a colour into pixel i of `line`, (3 P,): red, green and blue of one pixel after the other."""
    least, most = np.float32(0.5), np.float32(255.5)
    line[3 * i] = np.uint8(min(max(np.float32(255.0 * rgb[0] + 0.5), least), most))
    line[3 * i + 1] = np.uint8(min(max(np.float32(255.0 * rgb[1] + 0.5), least), most))
    line[3 * i + 2] = np.uint8(min(max(np.float32(255.0 * rgb[2] + 0.5), least), most))


@njit(cache=True, nogil=True, error_model="numpy")
def put_blend(
    line: NDArray[np.uint8],
    one: NDArray[np.float32],
    two: NDArray[np.float32],
    a: Colour,
    b: Colour,
    beyond: Colour,
    haze: float,
) -> None:
    """Write one a + two b, behind this much haze of the colour `beyond`, into all pixels of `line`, (3 P,).

    `one` and `two`: (P,) or longer. In single precision, with as many pixels at once as the machine can.
    """
    clear = 255.0 * (1.0 - haze)
    least, most = np.float32(0.5), np.float32(255.5)
    a0, a1, a2 = np.float32(clear * a[0]), np.float32(clear * a[1]), np.float32(clear * a[2])
    b0, b1, b2 = np.float32(clear * b[0]), np.float32(clear * b[1]), np.float32(clear * b[2])
    h0 = np.float32(255.0 * haze * beyond[0] + 0.5)
    h1 = np.float32(255.0 * haze * beyond[1] + 0.5)
    h2 = np.float32(255.0 * haze * beyond[2] + 0.5)
    for i in range(len(line) // 3):
        p, q = one[i], two[i]
        line[3 * i] = np.uint8(min(max(p * a0 + q * b0 + h0, least), most))
        line[3 * i + 1] = np.uint8(min(max(p * a1 + q * b1 + h1, least), most))
        line[3 * i + 2] = np.uint8(min(max(p * a2 + q * b2 + h2, least), most))
