"""A level ray against a capsule, exactly: where it enters, and within which angles it may.

The ray starts at the origin with the unit vector u = (ux, uy, 0); the capsule is all that is within r of its axis
p + s d, 0 <= s <= 1. With D = |d|^2, m = D - (d.u)^2, b = (p.d)(d.u) - D (p.u) and
c = D |p|^2 - (p.d)^2 - r^2 D the ray enters the cylinder around the axis at t = (b' - sqrt(b'^2 - m c)) / m, b' = -b,
where the axis is at s = (t d.u - p.d) / D; beyond its ends, s < 0 or s > 1, it is the sphere around that end which
counts, entered at q.u - sqrt((q.u)^2 - |q|^2 + r^2) for its centre q.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Sine squared of the angle to the axis [rad2] below which a ray runs along it and can only enter at an end.
_PARALLEL = 1e-12
# Tangent of an angle between the ends that counts as small.
_SMALL = 0.1


class Axis(NamedTuple):
    """A capsule seen from the sensor."""

    x: float
    """of one end [m]"""
    y: float
    z: float
    dx: float
    """from there to the other end [m]"""
    dy: float
    dz: float
    radius: float
    """[m]"""


class Outline(NamedTuple):
    """Where a capsule may be seen."""

    start: float
    """first direction, counter-clockwise from ahead [rad]"""
    extent: float
    """from the first to the last direction [rad]"""
    nearest: float
    """no ray meets it nearer than this [m]"""


@njit(cache=True, nogil=True, error_model="numpy")
def in_slab(capsule: NDArray[np.float64], z: float) -> bool:
    """True if the plane at the height `z` [m] cuts a capsule of `crowdcosim.avatar`, (7,)."""
    low, high = min(capsule[2], capsule[5]), max(capsule[2], capsule[5])
    return low - capsule[6] <= z <= high + capsule[6]


@njit(cache=True, nogil=True, error_model="numpy")
def holds_origin(axis: Axis) -> bool:
    """True if the sensor is within the capsule."""
    square = axis.dx * axis.dx + axis.dy * axis.dy + axis.dz * axis.dz
    s = min(max(-(axis.x * axis.dx + axis.y * axis.dy + axis.z * axis.dz) / square, 0.0), 1.0)
    x, y, z = axis.x + s * axis.dx, axis.y + s * axis.dy, axis.z + s * axis.dz
    return x * x + y * y + z * z <= axis.radius * axis.radius


@njit(cache=True, nogil=True, error_model="numpy")
def outline(axis: Axis) -> Outline:
    """Where the sensor, which is outside, sees the section of the capsule by its plane, which must cut the capsule.

    The section is within r of that part of the axis, seen from above, that is within r of the plane.
    """
    low, high = 0.0, 1.0
    if axis.dz != 0.0:
        s, t = (-axis.radius - axis.z) / axis.dz, (axis.radius - axis.z) / axis.dz
        low, high = max(min(s, t), 0.0), min(max(s, t), 1.0)
    ax, ay = axis.x + low * axis.dx, axis.y + low * axis.dy
    bx, by = axis.x + high * axis.dx, axis.y + high * axis.dy
    cross, dot = ax * by - ay * bx, ax * bx + ay * by
    a, b = math.sqrt(ax * ax + ay * ay), math.sqrt(bx * bx + by * by)
    near = min(a, b)
    if near <= axis.radius:
        return Outline(0.0, 2.0 * math.pi, 0.0)
    if near > 2.0 * axis.radius and abs(cross) < _SMALL * dot:
        # Bounds in the place of an arc tangent and two arc sines, which are what takes time.
        turn, half_a, half_b = cross / dot, _most_arc_sine(axis.radius / a), _most_arc_sine(axis.radius / b)
        nearest = near / math.sqrt(1.0 + _SMALL * _SMALL) - axis.radius
    else:
        turn, half_a, half_b = math.atan2(cross, dot), math.asin(axis.radius / a), math.asin(axis.radius / b)
        nearest = 0.0
    right, left = min(-half_a, turn - half_b), max(half_a, turn + half_b)
    if left - right >= math.pi:
        return Outline(0.0, 2.0 * math.pi, 0.0)
    return Outline(math.atan2(ay, ax) + right, left - right, nearest)


@njit(cache=True, nogil=True, error_model="numpy")
def _most_arc_sine(sine: float) -> float:
    """At least the arc sine, for at most one half: (asin x - x) / x^3 grows with x, to 0.18880."""
    return sine + 0.1888 * sine * sine * sine


@njit(cache=True, nogil=True, error_model="numpy")
def meets(axis: Axis, ux: float, uy: float) -> float:
    """Distance [m] to where the ray along (ux, uy) enters the capsule, infinite if it does not; it starts outside."""
    du = axis.dx * ux + axis.dy * uy
    pu = axis.x * ux + axis.y * uy
    pd = axis.x * axis.dx + axis.y * axis.dy + axis.z * axis.dz
    square = axis.dx * axis.dx + axis.dy * axis.dy + axis.dz * axis.dz
    away = axis.x * axis.x + axis.y * axis.y + axis.z * axis.z - axis.radius * axis.radius
    m = square - du * du
    if m > _PARALLEL * square:
        b = square * pu - pd * du
        root = b * b - m * (square * away - pd * pd)
        if root < 0.0:
            return np.inf
        t = (b - math.sqrt(root)) / m
        s = t * du - pd
        if 0.0 <= s <= square:
            return t if t > 0.0 else np.inf
        far_end = s > square
    else:
        far_end = du < 0.0
    if far_end:
        pu += du
        away += 2.0 * pd + square
    root = pu * pu - away
    if root < 0.0:
        return np.inf
    t = pu - math.sqrt(root)
    return t if t > 0.0 else np.inf
