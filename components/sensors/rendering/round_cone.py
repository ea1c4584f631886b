"""A ray against a round cone, exactly: the hull of two balls, such as a limb that tapers.

With the ends a and b, radii p and q, e = b - a, r = p - q, and the ray t d from the camera, the cone is all x with
F(x, s) = |x - a - s e|^2 - (p - s r)^2 <= 0 for some 0 <= s <= 1. F is least at s = (e.(x - a) - p r) / m with
m = e.e - r^2, which leaves, for the inverse depth w = 1 / t,
    C w^2 - 2 B w + A = 0,   A = m d.d - (e.d)^2,   B = m a.d - k e.d,   C = m (a.a - p^2) - k^2,   k = a.e + p r;
the ray enters at w = (B + sqrt(B^2 - A C)) / C, where s = (e.d - k w) / (m w). F is convex in (t, s), so beyond its
ends, s < 0 or s > 1, it is the ball around that end which counts: with n = a.a - p^2,
    w = (a.d + sqrt((a.d)^2 - n d.d)) / n.
A camera with C <= 0 is in the cone's continuation beyond an end, and sees the balls only.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

WITHIN = 1e4
"""inverse depth [1/m] of a body that holds the camera: in front of all else"""
_NO_CENTRE = 1e-9
"""the square of the distance to a ball [m2] below which its surface counts as held"""


class RoundCone(NamedTuple):
    """A round cone in the camera's frame, with what its rays have in common."""

    ax: float
    ay: float
    az: float
    ex: float
    ey: float
    ez: float
    k: float
    m: float
    c: float
    clear_a: float
    """a.a - p^2"""
    hx: float
    """b"""
    hy: float
    hz: float
    clear_b: float
    """b.b - q^2"""


@njit(cache=True, nogil=True, error_model="numpy")
def round_cone(cone: Array, v: int, c: int) -> RoundCone:
    """From `cone`, (V, 17, 8): a, p, b, q of limb c of body v in the camera's frame [m]."""
    ax, ay, az, p = cone[v, c, 0], cone[v, c, 1], cone[v, c, 2], cone[v, c, 3]
    bx, by, bz, q = cone[v, c, 4], cone[v, c, 5], cone[v, c, 6], cone[v, c, 7]
    ex, ey, ez = bx - ax, by - ay, bz - az
    r = p - q
    m = ex * ex + ey * ey + ez * ez - r * r
    k = ax * ex + ay * ey + az * ez + p * r
    clear_a = ax * ax + ay * ay + az * az - p * p
    clear_b = bx * bx + by * by + bz * bz - q * q
    return RoundCone(ax, ay, az, ex, ey, ez, k, m, m * clear_a - k * k, clear_a, bx, by, bz, clear_b)


@njit(cache=True, nogil=True, error_model="numpy")
def holds_camera(cone: RoundCone) -> bool:
    """True if the camera is within."""
    s = -cone.k / cone.m
    if s <= 0.0:
        return cone.clear_a <= _NO_CENTRE
    if s >= 1.0:
        return cone.clear_b <= _NO_CENTRE
    return cone.c <= _NO_CENTRE * cone.m


@njit(cache=True, nogil=True, error_model="numpy")
def ball_met(x: float, y: float, dd: float, cx: float, cy: float, cz: float, clear: float) -> float:
    """Inverse depth at which the ray (x, y, 1) enters a ball, 0 if it does not."""
    h = cx * x + cy * y + cz
    root = h * h - dd * clear
    if root < 0.0 or h <= 0.0:
        return 0.0
    return (h + math.sqrt(root)) / clear


@njit(cache=True, nogil=True, error_model="numpy")
def met(cone: RoundCone, x: float, y: float) -> float:
    """Inverse depth [1/m] at which the ray (x, y, 1) enters, 0 if it does not; the camera is outside."""
    dd = x * x + y * y + 1.0
    if cone.c > 0.0:
        g = cone.ex * x + cone.ey * y + cone.ez
        a = cone.m * dd - g * g
        b = cone.m * (cone.ax * x + cone.ay * y + cone.az) - g * cone.k
        root = b * b - a * cone.c
        if root < 0.0:
            return 0.0
        w = (b + math.sqrt(root)) / cone.c
        along = g - cone.k * w
        if w > 0.0 and 0.0 <= along <= cone.m * w:
            return w
        if a > 0.0:
            if along < 0.0:
                return ball_met(x, y, dd, cone.ax, cone.ay, cone.az, cone.clear_a)
            return ball_met(x, y, dd, cone.hx, cone.hy, cone.hz, cone.clear_b)
    return max(
        ball_met(x, y, dd, cone.ax, cone.ay, cone.az, cone.clear_a),
        ball_met(x, y, dd, cone.hx, cone.hy, cone.hz, cone.clear_b),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def gap(cone: Array, v: int, c: int, x: float, y: float) -> float:
    """How far the ray (x, y, 1) passes by a limb of `cone`, (V, 17, 8), negative through it, over its depth there.

    From the point of the axis that is nearest to the ray; exact at the outline, where it is 0.
    """
    limb = round_cone(cone, v, c)
    dd = x * x + y * y + 1.0
    g = limb.ex * x + limb.ey * y + limb.ez
    h = limb.ax * x + limb.ay * y + limb.az
    a = limb.m * dd - g * g
    s = 0.0
    if a > 0.0:
        # F is least over both t and s where t = B / A.
        s = min(max((g * (limb.m * h - g * limb.k) - limb.k * a) / (a * limb.m), 0.0), 1.0)
    px, py, pz = limb.ax + s * limb.ex, limb.ay + s * limb.ey, limb.az + s * limb.ez
    ahead = px * x + py * y + pz
    away = px * px + py * py + pz * pz - ahead * ahead / dd
    radius = cone[v, c, 3] + s * (cone[v, c, 7] - cone[v, c, 3])
    return (math.sqrt(max(away, 0.0)) - radius) / max(pz, 1e-6)


@njit(cache=True, nogil=True, error_model="numpy")
def ball_extent(across: float, ahead: float, radius: float) -> tuple[float, float]:
    """Least and most tangent of the angle, from ahead, under which a ball that is wholly ahead is seen: exactly."""
    depth = 1.0 / (ahead * ahead - radius * radius)
    half = radius * math.sqrt(across * across + ahead * ahead - radius * radius)
    return (across * ahead - half) * depth, (across * ahead + half) * depth
