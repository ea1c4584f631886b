"""Time and distance of the closest approach: people turn and change speed down the slope of what they see coming.

C(v) = sum_j s_j exp(-((ttca_j / sigma_t)^2 + (dca_j / sigma_d)^2) / 2) / sum_j s_j
       + 1 - (exp(-(alpha / sigma_a)^2 / 2) + exp(-(ds / sigma_s)^2 / 2)) / 2
over all within 90 deg of the walking direction; ttca and dca are the time, zero at least, and the distance of the
closest approach, s_j = 1 / gap^2 stands for the size of the neighbour's image, alpha is the angle to v_pref, ds =
|v| - |v_pref| (Dutra, Marques, Cavalcante-Neto, Vidal and Pettre 2017, "Gradient-based steering for vision-based crowd
simulation algorithms", eqs. 4 to 8; the image is replaced as in van Toll et al. 2020). sigma_t = 1 s,
sigma_d = 0.3 m, sigma_a = 2 rad, sigma_s = 2 m/s. The slope is that in angle and speed:
    a = -(|v| dC/dtheta e_theta + dC/ds e_s)

Not in the paper: bodies count by p = (|x| - R) x / |x| in the place of their relative position x; a gap of less than
0.05 m counts as that; who moves as the person does (to 0.03 m/s) has no slope; who walks at less than 0.1 m/s turns
from the preferred velocity.
Differs from the paper: neighbours are seen one by one, without pixels; walls are left to `wall_repulsion`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Cost
from components.crowd.surroundings import GX, GY, OX, OY, PX, PY, REACH, VX, VY, Surroundings, facing

Array = NDArray[np.float64]

LEAST_GAP = 0.05
"""[m]"""
PARALLEL = 0.001
"""squared relative velocity that has no slope [m2/s2]"""
AT_REST = 0.1
"""[m/s]"""
FAR = 80.0
"""squared distance in standard deviations at which exp(-squared / 2) is below rounding, and not worth computing"""


@dataclass(frozen=True, kw_only=True)
class TtcaDca(Cost):
    """The cost `ttca_dca`."""

    sigma_ttca: float = 1.0
    """of the time to the closest approach [s]"""
    sigma_dca: float = 0.3
    """of the distance at the closest approach [m]"""
    sigma_angle: float = 2.0
    """of the angle to the preferred velocity [rad]"""
    sigma_speed: float = 2.0
    """of the difference to the preferred speed [m/s]"""

    def __post_init__(self) -> None:
        for name in ("sigma_ttca", "sigma_dca", "sigma_angle", "sigma_speed"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, *self._sigmas(), total)

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add the accelerations down the slope."""
        _push(around, coefficient, *self._sigmas(), total)

    def _sigmas(self) -> tuple[float, float, float, float]:
        return self.sigma_ttca, self.sigma_dca, self.sigma_angle, self.sigma_speed


@njit(cache=True, nogil=True, error_model="numpy")
def approach(px: float, py: float, wx: float, wy: float, sigma_t: float, sigma_d: float) -> tuple[float, float, float]:
    """The price of one neighbour and its gradient by the person's velocity.

    Args:
        px: gap to the neighbour, p [m]
        py: [m]
        wx: velocity of the neighbour relative to the person [m/s]
        wy: [m/s]
        sigma_t: [s]
        sigma_d: [m]
    """
    a = wx * wx + wy * wy
    t = max(-(px * wx + py * wy) / a, 0.0) if a > 0.0 else 0.0
    dx, dy = px + t * wx, py + t * wy
    squared = (t / sigma_t) ** 2 + (dx * dx + dy * dy) / sigma_d**2
    if squared > FAR:
        return 0.0, 0.0, 0.0
    price = math.exp(-0.5 * squared)
    if t == 0.0 or a <= PARALLEL:
        return price, 0.0, 0.0
    # grad_w ttca = -(p + 2 t w) / |w|^2, grad_w dca^2 / 2 = t (p + t w); w falls as the person's velocity grows.
    by_t, by_d = t / sigma_t**2, 1.0 / sigma_d**2
    slope_x = by_t * -(px + 2.0 * t * wx) / a + by_d * t * dx
    slope_y = by_t * -(py + 2.0 * t * wy) / a + by_d * t * dy
    return price, price * slope_x, price * slope_y


@njit(cache=True, nogil=True, error_model="numpy")
def _gap(near: Array, p: int) -> tuple[float, float, float]:
    """The vector between the bodies' edges and its length [m], for a neighbour."""
    x, y = near[PX, p], near[PY, p]
    distance = math.sqrt(x * x + y * y)
    if distance == 0.0:
        return LEAST_GAP, 0.0, LEAST_GAP
    gap = max(distance - near[REACH, p], LEAST_GAP)
    return gap * x / distance, gap * y / distance, gap


@njit(cache=True, nogil=True, error_model="numpy")
def _turn(cx: float, cy: float, gx: float, gy: float) -> float:
    """Angle from the preferred velocity to the other, counter-clockwise [rad]; 0 if one of them is zero."""
    return math.atan2(gx * cy - gy * cx, gx * cx + gy * cy)


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    around: Surroundings,
    candidates: Array,
    coefficient: float,
    sigma_t: float,
    sigma_d: float,
    sigma_a: float,
    sigma_s: float,
    total: Array,
) -> None:
    people, count = total.shape
    own, near = around.own, around.near
    price = np.empty(count)
    for i in range(people):
        gx, gy = own[GX, i], own[GY, i]
        preferred = math.sqrt(gx * gx + gy * gy)
        price[:] = 0.0
        size = 0.0
        for p in range(around.first[i], around.first[i + 1]):
            if near[PX, p] * own[VX, i] + near[PY, p] * own[VY, i] < 0.0:
                continue
            px, py, gap = _gap(near, p)
            size += 1.0 / gap**2
            for k in range(count):
                wx, wy = near[OX, p] - candidates[0, i, k], near[OY, p] - candidates[1, i, k]
                price[k] += approach(px, py, wx, wy, sigma_t, sigma_d)[0] / gap**2
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            alpha = _turn(cx, cy, gx, gy) / sigma_a
            ds = (math.sqrt(cx * cx + cy * cy) - preferred) / sigma_s
            moving = 1.0 - 0.5 * (math.exp(-0.5 * alpha * alpha) + math.exp(-0.5 * ds * ds))
            total[i, k] += coefficient * ((price[k] / size if size > 0.0 else 0.0) + moving)


@njit(cache=True, nogil=True, error_model="numpy")
def _push(
    around: Surroundings,
    coefficient: float,
    sigma_t: float,
    sigma_d: float,
    sigma_a: float,
    sigma_s: float,
    total: Array,
) -> None:
    own, near = around.own, around.near
    for i in range(own.shape[1]):
        vx, vy, gx, gy = own[VX, i], own[VY, i], own[GX, i], own[GY, i]
        x, y, size = 0.0, 0.0, 0.0
        for p in range(around.first[i], around.first[i + 1]):
            if near[PX, p] * vx + near[PY, p] * vy < 0.0:
                continue
            px, py, gap = _gap(near, p)
            size += 1.0 / gap**2
            _, fx, fy = approach(px, py, near[OX, p] - vx, near[OY, p] - vy, sigma_t, sigma_d)
            x += fx / gap**2
            y += fy / gap**2
        if size > 0.0:
            x, y = x / size, y / size
        hx, hy, speed = facing(own, i, AT_REST)
        alpha = 0.0 if vx * vx + vy * vy <= AT_REST**2 else _turn(vx, vy, gx, gy)
        ds = math.sqrt(vx * vx + vy * vy) - math.sqrt(gx * gx + gy * gy)
        by_angle = speed * (x * -hy + y * hx)
        by_angle += 0.5 * alpha / sigma_a**2 * math.exp(-0.5 * (alpha / sigma_a) ** 2)
        by_speed = x * hx + y * hy + 0.5 * ds / sigma_s**2 * math.exp(-0.5 * (ds / sigma_s) ** 2)
        total[0, i] -= coefficient * (speed * by_angle * -hy + by_speed * hx)
        total[1, i] -= coefficient * (speed * by_angle * hx + by_speed * hy)
