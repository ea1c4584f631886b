"""Power law: the energy of an encounter depends on the time to collision alone.

E(t) = k t^-2 exp(-t / t0), F = -dE/dx (Karamouzas, Skinner and Guy 2014, "Universal power law governing pedestrian
interactions", eqs. 2 and S2), which for two discs at relative position x = r_i - r_j and velocity v = v_i - v_j is
    F = -k exp(-t/t0) (2/t + 1/t0) / (a t^2) [v - (a x + b v) / sqrt(d)]
    a = |v|^2,  b = -x . v,  d = b^2 - a (|x|^2 - R^2),  t = (b - sqrt(d)) / a.
k = 1.5, t0 = 3 s. For the straight part of a wall t = gap / v_n, so that F = k exp(-t/t0) (2/t + 1/t0) / (t^2 v_n) n,
n away from the wall; for its ends, those of a resting disc without extent; of an obstacle, the edge that is met first.

Not in the paper: no force beyond t0, as in its authors' program; none before 0.001 s, and none on discs that overlap
(contacts part them).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Force
from components.crowd.surroundings import AX, AY, BX, BY, OX, OY, PX, PY, RADIUS, REACH, THING, VX, VY, Surroundings

Array = NDArray[np.float64]

SOONEST = 0.001
"""[s]"""


@dataclass(frozen=True, kw_only=True)
class PowerLaw(Force):
    """The cost `power_law`."""

    k: float = 1.5
    """strength [m2]"""
    t0: float = 3.0
    """time horizon [s]"""

    def __post_init__(self) -> None:
        if not self.t0 > 0:
            raise ValueError(f"t0 is {self.t0}, expected a positive number")

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add coefficient F to `total` (2, B) [m/s2]."""
        _push(around, coefficient * self.k, self.t0, total)


@njit(cache=True, nogil=True, error_model="numpy")
def steepness(t: float, t0: float) -> float:
    """-dE/dt / k at time to collision t."""
    return math.exp(-t / t0) * (2.0 / t + 1.0 / t0) / (t * t)


@njit(cache=True, nogil=True, error_model="numpy")
def disc_force(px: float, py: float, wx: float, wy: float, R: float, t0: float) -> tuple[float, float, float]:
    """Time to collision [s] and F / k of a disc at (px, py) for somebody who moves at (wx, wy) relative to it."""
    c = px * px + py * py - R * R
    b = px * wx + py * wy
    a = wx * wx + wy * wy
    across = px * wy - py * wx
    d = R * R * a - across * across
    # b + sqrt(d) <= 2 b: most of those who collide too late are seen without a root.
    if c <= 0.0 or d <= 0.0 or 2.0 * b * t0 < c:
        return np.inf, 0.0, 0.0
    root = math.sqrt(d)
    t = c / (b + root)
    if t < SOONEST or t > t0:
        return np.inf, 0.0, 0.0
    f = -steepness(t, t0) / a
    return t, f * (wx + (a * px - b * wx) / root), f * (wy + (a * py - b * wy) / root)


@njit(cache=True, nogil=True, error_model="numpy")
def wall_force(
    ax: float, ay: float, bx: float, by: float, vx: float, vy: float, r: float, t0: float
) -> tuple[float, float, float]:
    """Time to collision [s] and F / k of a wall from a to b for somebody of radius r who walks at (vx, vy)."""
    t, fx, fy = disc_force(ax, ay, vx, vy, r, t0)
    other = disc_force(bx, by, vx, vy, r, t0)
    if other[0] < t:
        t, fx, fy = other
    length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
    if length > 0.0:
        ux, uy = (bx - ax) / length, (by - ay) / length
        nx, ny = uy, -ux
        gap = nx * ax + ny * ay
        if gap < 0.0:
            nx, ny, gap = -nx, -ny, -gap
        towards = nx * vx + ny * vy
        straight = (gap - r) / towards if towards > 0.0 else np.inf
        place = (ux * vx + uy * vy) * straight - ux * ax - uy * ay
        if SOONEST <= straight <= t0 and straight <= t and 0.0 <= place <= length:
            f = steepness(straight, t0) / towards
            t, fx, fy = straight, -f * nx, -f * ny
    return t, fx, fy


@njit(cache=True, nogil=True, error_model="numpy")
def _push(around: Surroundings, k: float, t0: float, total: Array) -> None:
    own, near, edges = around.own, around.near, around.edges
    for i in range(own.shape[1]):
        vx, vy = own[VX, i], own[VY, i]
        x, y = 0.0, 0.0
        for p in range(around.first[i], around.first[i + 1]):
            _, fx, fy = disc_force(near[PX, p], near[PY, p], vx - near[OX, p], vy - near[OY, p], near[REACH, p], t0)
            x += fx
            y += fy
        q, end = around.first_edge[i], around.first_edge[i + 1]
        while q < end:
            thing, soonest, gx, gy = edges[THING, q], np.inf, 0.0, 0.0
            while q < end and edges[THING, q] == thing:
                t, fx, fy = wall_force(
                    edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q], vx, vy, own[RADIUS, i], t0
                )
                if t < soonest:
                    soonest, gx, gy = t, fx, fy
                q += 1
            x += gx
            y += gy
        total[0, i] += k * x
        total[1, i] += k * y
