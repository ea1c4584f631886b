"""The linear programs of ORCA over half-planes n . v >= b within the disc |v| <= limit, n of unit length.

Berg, Guy, Lin and Manocha 2011, "Reciprocal n-body collision avoidance": the velocity nearest to the preferred one in
all half-planes ("Basic approach"); and where they have no point in common, the velocity that violates the worst of them
the least, a linear program in three dimensions ("Densely packed conditions"), with those of walls kept in any case.

Differs from the paper: half-planes are not taken in random order. Each time the most violated one comes next, which
keeps the working set to the few that matter and makes the result independent of the order of neighbours. The optimum
is the same: it is unique. Where two exactly opposite half-planes leave a choice, the slowest velocity is taken.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

SATISFIED = 1e-10
"""violation that counts as none [m/s]"""
PARALLEL = 1e-9
"""sine of the angle between two lines that count as parallel"""


@njit(cache=True, nogil=True, error_model="numpy")
def _most_violated(nx: Array, ny: Array, b: Array, begin: int, end: int, x: float, y: float) -> tuple[int, float]:
    """Index in begin..end of the half-plane that (x, y) violates most, and by how much [m/s]."""
    worst, violation = -1, -np.inf
    for j in range(begin, end):
        v = b[j] - nx[j] * x - ny[j] * y
        if v > violation:
            worst, violation = j, v
    return worst, violation


@njit(cache=True, nogil=True, error_model="numpy")
def _bring_forward(nx: Array, ny: Array, b: Array, k: int, j: int) -> None:
    """Swap half-planes `k` and `j`."""
    nx[k], nx[j] = nx[j], nx[k]
    ny[k], ny[j] = ny[j], ny[k]
    b[k], b[j] = b[j], b[k]


@njit(cache=True, nogil=True, error_model="numpy")
def _on_line(nx: Array, ny: Array, b: Array, k: int, limit: float) -> tuple[bool, float, float]:
    """The part of line `k` in the disc and in the half-planes before it: is there one, from and to where [m/s].

    Points of the line are b n + t d with d = (n_y, -n_x), so that t is measured from the foot of the origin.
    """
    if abs(b[k]) > limit:
        return False, 0.0, 0.0
    high = math.sqrt(limit * limit - b[k] * b[k])
    low = -high
    for j in range(k):
        slope = nx[j] * ny[k] - ny[j] * nx[k]
        lacking = b[j] - b[k] * (nx[j] * nx[k] + ny[j] * ny[k])
        if abs(slope) <= PARALLEL:
            if lacking > SATISFIED:
                return False, 0.0, 0.0
        elif slope > 0.0:
            low = max(low, lacking / slope)
        else:
            high = min(high, lacking / slope)
        if low > high:
            return False, 0.0, 0.0
    return True, low, high


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(
    nx: Array, ny: Array, b: Array, begin: int, end: int, limit: float, gx: float, gy: float, x: float, y: float
) -> tuple[int, float, float]:
    """Go on from (x, y), the point of half-planes 0..begin nearest to (gx, gy), to that of 0..end.

    Returns:
        How many were taken up before one could not be met (`end` if all are met), and the point.
    """
    k = begin
    while k < end:
        worst, violation = _most_violated(nx, ny, b, k, end, x, y)
        if violation <= SATISFIED:
            return end, x, y
        _bring_forward(nx, ny, b, k, worst)
        possible, low, high = _on_line(nx, ny, b, k, limit)
        if not possible:
            return k, x, y
        t = min(max(gx * ny[k] - gy * nx[k], low), high)
        x, y = b[k] * nx[k] + t * ny[k], b[k] * ny[k] - t * nx[k]
        k += 1
    return end, x, y


@njit(cache=True, nogil=True, error_model="numpy")
def _farthest(
    nx: Array, ny: Array, b: Array, count: int, limit: float, gx: float, gy: float
) -> tuple[bool, float, float]:
    """The point of all half-planes that is farthest in direction (gx, gy), of unit length."""
    x, y = limit * gx, limit * gy
    for k in range(count):
        worst, violation = _most_violated(nx, ny, b, k, count, x, y)
        if violation <= SATISFIED:
            break
        _bring_forward(nx, ny, b, k, worst)
        possible, low, high = _on_line(nx, ny, b, k, limit)
        if not possible:
            return False, x, y
        rise = gx * ny[k] - gy * nx[k]
        if rise > PARALLEL:
            t = high
        elif rise < -PARALLEL:
            t = low
        else:
            t = min(max(0.0, low), high)
        x, y = b[k] * nx[k] + t * ny[k], b[k] * ny[k] - t * nx[k]
    return True, x, y


@njit(cache=True, nogil=True, error_model="numpy")
def _least_violation(
    nx: Array, ny: Array, b: Array, hard: int, begin: int, end: int, limit: float, x: float, y: float
) -> tuple[float, float]:
    """Go on from (x, y), which meets half-planes 0..begin, to the point whose worst violation is least."""
    mx, my, c = np.empty(end), np.empty(end), np.empty(end)
    accepted = 0.0
    for k in range(begin, end):
        worst, violation = _most_violated(nx, ny, b, k, end, x, y)
        if violation <= accepted + SATISFIED:
            break
        _bring_forward(nx, ny, b, k, worst)
        # Violate `k` as little as the others allow, each of which must not be violated more than `k`.
        mx[:hard], my[:hard], c[:hard] = nx[:hard], ny[:hard], b[:hard]
        count = hard
        for j in range(hard, k):
            dx, dy = nx[j] - nx[k], ny[j] - ny[k]
            length = math.sqrt(dx * dx + dy * dy)
            if length > PARALLEL:
                mx[count], my[count], c[count] = dx / length, dy / length, (b[j] - b[k]) / length
                count += 1
        possible, fx, fy = _farthest(mx, my, c, count, limit, nx[k], ny[k])
        # In exact arithmetic always possible; when rounding says otherwise, the old point is as good.
        if possible:
            x, y = fx, fy
        accepted = b[k] - nx[k] * x - ny[k] * y
    return x, y


@njit(cache=True, nogil=True, error_model="numpy")
def best_velocity(
    nx: Array, ny: Array, b: Array, hard: int, count: int, limit: float, gx: float, gy: float
) -> tuple[float, float]:
    """The velocity in all half-planes nearest to the preferred one, else the one of least worst violation [m/s].

    Args:
        nx: (at least count,) x of the unit normals, which point to the permitted side; reordered
        ny: (at least count,) y of them; reordered
        b: (at least count,) permitted is n . v >= b [m/s]; reordered
        hard: the first so many are met in any case; v = 0 must meet them
        count: number of half-planes
        limit: greatest speed [m/s]
        gx: preferred velocity [m/s]
        gy: preferred velocity [m/s]
    """
    x, y = gx, gy
    speed = math.sqrt(gx * gx + gy * gy)
    if speed > limit:
        x, y = gx * limit / speed, gy * limit / speed
    met, x, y = _nearest(nx, ny, b, 0, hard, limit, gx, gy, x, y)
    if met < hard:
        return 0.0, 0.0
    met, x, y = _nearest(nx, ny, b, hard, count, limit, gx, gy, x, y)
    if met < count:
        x, y = _least_violation(nx, ny, b, hard, met, count, limit, x, y)
    return x, y
