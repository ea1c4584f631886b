"""Passing before or behind: in each direction, neighbours leave ranges of speeds that do not collide.

In direction d (a unit vector) the speeds s that lead to a collision with neighbour j form one interval (s2, s1):
slower people pass behind, faster ones before. With the deviation D_j(s) = min(s1 - s, s - s2) / v0 within it and 0
outside, the weight of what is soon W_j(v) = max(0, 1 - TTC_j(v) / (t_max + w_b)), and alpha the angle between d and
v_pref:
    C(v) = 1000 [w_a mean_j D_j(v0) W_j(v0 d) + (1 - w_a) (1 - cos(alpha)) / 2]
           + sum_j D_j(|v|) W_j(v) + 0.001 |v - v_pref|
(Paris, Pettre and Donikian 2007, "Pedestrian reactive navigation for crowd simulation: a predictive approach", the best
direction first and then the best speed, joined to one cost by van Toll et al. 2020). w_a = 0.5, w_b = 0, t_max = 8 s.

Not in the paper: D_j(v0) counts at most 1; a wall leaves s2 = 0 and s1 = infinity where its W is not 0; standing still
counts as going in the preferred direction. Whoever overlaps already is ignored.
Differs from the paper: the interval is exact, that of the velocity obstacle on the ray along d, rather than bounds from
the times at which the neighbour crosses the ray; so that resting and parallel neighbours are no special case.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import raise_to_wall
from components.crowd.costs.cost import Cost, cosine
from components.crowd.surroundings import AX, AY, BX, BY, GX, GY, OX, OY, PX, PY, RADIUS, REACH, THING, Surroundings

Array = NDArray[np.float64]

SLOWEST = 0.1
"""lower preferred speeds count as this one in the ratio [m/s]"""
DIRECTION, DIFFERENCE = 1000.0, 0.001
"""weights of the direction and of the difference to the preferred velocity"""


@dataclass(frozen=True, kw_only=True)
class Paris(Cost):
    """The cost `paris`."""

    w_a: float = 0.5
    """weight of collisions, against that of the angle to the preferred velocity, 0 to 1"""
    w_b: float = 0.0
    """added to t_max in the weight of what is soon [s]"""
    t_max: float = 8.0
    """later collisions are ignored [s]"""

    def __post_init__(self) -> None:
        if not 0 <= self.w_a <= 1:
            raise ValueError(f"w_a is {self.w_a}, expected 0 to 1")
        if not self.w_b >= 0:
            raise ValueError(f"w_b is {self.w_b}, expected zero or a positive number")
        if not self.t_max > 0:
            raise ValueError(f"t_max is {self.t_max}, expected a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.w_a, self.t_max + self.w_b, total)


@njit(cache=True, nogil=True, error_model="numpy")
def blocked_speeds(px: float, py: float, ox: float, oy: float, R: float, hx: float, hy: float) -> tuple[float, float]:
    """(s2, s1) [m/s]: the speeds in direction h (a unit vector) that collide; s2 > s1 where there are none.

    A disc at p that moves at o blocks w = s h - o where R^2 |w|^2 >= (p cross w)^2 and p . w > 0: between the roots of
    A s^2 - 2 B s + C, beyond the greater one, or before the smaller one.
    """
    m, q = px * hy - py * hx, px * oy - py * ox
    A = R * R - m * m
    B = R * R * (hx * ox + hy * oy) - m * q
    C = R * R * (ox * ox + oy * oy) - q * q
    root = math.sqrt(max(B * B - A * C, 0.0))
    # The two roots without cancellation.
    z = B + (root if B >= 0.0 else -root)
    one, other = z / A, C / z
    low, high = min(one, other), max(one, other)
    towards = px * hx + py * hy > 0.0
    middle = 0.5 * (low + high)
    between = (B * B > A * C) & (px * (middle * hx - ox) + py * (middle * hy - oy) > 0.0)
    if A < 0.0:
        return (low, high) if between else (np.inf, -np.inf)
    return (high, np.inf) if towards else (-np.inf, low)


@njit(cache=True, nogil=True, error_model="numpy")
def _soon(c: float, px: float, py: float, wx: float, wy: float, R: float, horizon: float) -> float:
    """W_j: 1 for a collision now, 0 from the horizon on; c = |p|^2 - R^2, w the relative velocity."""
    b = px * wx + py * wy
    across = px * wy - py * wx
    d = R * R * (wx * wx + wy * wy) - across * across
    t = c / (b + math.sqrt(max(d, 0.0)))
    return max(1.0 - t / horizon, 0.0) if (b > 0.0) & (d >= 0.0) else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _conflicts(
    near: Array,
    p: int,
    preferred: float,
    horizon: float,
    hx: Array,
    hy: Array,
    speed: Array,
    ahead: Array,
    here: Array,
) -> None:
    """Add neighbour p's D W to `ahead` (at the preferred speed) and `here` (at the candidates'), all (K,)."""
    px, py, ox, oy, R = near[PX, p], near[PY, p], near[OX, p], near[OY, p], near[REACH, p]
    c = px * px + py * py - R * R
    if c <= 0.0:
        return
    scale = 1.0 / max(preferred, SLOWEST)
    for k in range(len(hx)):
        slow, fast = blocked_speeds(px, py, ox, oy, R, hx[k], hy[k])
        off = min(fast - preferred, preferred - slow)
        if off > 0.0:
            soon = _soon(c, px, py, preferred * hx[k] - ox, preferred * hy[k] - oy, R, horizon)
            ahead[k] += min(off * scale, 1.0) * soon
        off = min(fast - speed[k], speed[k] - slow)
        if off > 0.0:
            soon = _soon(c, px, py, speed[k] * hx[k] - ox, speed[k] * hy[k] - oy, R, horizon)
            here[k] += off * scale * soon


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, candidates: Array, coefficient: float, w_a: float, horizon: float, total: Array) -> None:
    people, count = total.shape
    own, edges = around.own, around.edges
    hx, hy, speed = np.empty(count), np.empty(count), np.empty(count)
    gx, gy, ahead, here = np.empty(count), np.empty(count), np.empty(count), np.empty(count)
    rate, rate_ahead = np.empty(count), np.empty(count)
    for i in range(people):
        vx, vy = own[GX, i], own[GY, i]
        preferred = math.sqrt(vx * vx + vy * vy)
        ux, uy = (vx / preferred, vy / preferred) if preferred > 0.0 else (1.0, 0.0)
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            speed[k] = math.sqrt(cx * cx + cy * cy)
            hx[k], hy[k] = (cx / speed[k], cy / speed[k]) if speed[k] > 0.0 else (ux, uy)
            gx[k], gy[k] = preferred * hx[k], preferred * hy[k]
            ahead[k], here[k] = 0.0, 0.0
        for p in range(around.first[i], around.first[i + 1]):
            _conflicts(around.near, p, preferred, horizon, hx, hy, speed, ahead, here)
        met = around.first[i + 1] - around.first[i]
        q, end = around.first_edge[i], around.first_edge[i + 1]
        while q < end:
            thing = edges[THING, q]
            rate[:], rate_ahead[:] = 0.0, 0.0
            while q < end and edges[THING, q] == thing:
                ax, ay, bx, by = edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q]
                raise_to_wall(ax, ay, bx, by, own[RADIUS, i], gx, gy, True, rate_ahead)
                raise_to_wall(ax, ay, bx, by, own[RADIUS, i], candidates[0, i], candidates[1, i], True, rate)
                q += 1
            for k in range(count):
                ahead[k] += max(1.0 - 1.0 / (rate_ahead[k] * horizon), 0.0)
                here[k] += speed[k] / max(preferred, SLOWEST) * max(1.0 - 1.0 / (rate[k] * horizon), 0.0)
            met += 1
        for k in range(count):
            x, y = candidates[0, i, k] - vx, candidates[1, i, k] - vy
            turn = (1.0 - cosine(hx[k], hy[k], ux, uy)) / 2.0
            direction = w_a * ahead[k] / max(met, 1) + (1.0 - w_a) * turn
            total[i, k] += coefficient * (DIRECTION * direction + here[k] + DIFFERENCE * math.sqrt(x * x + y * y))
