"""Predictive avoidance with limits: the sooner the collision, the more people turn and change their speed.

C(v) = alpha (1 - cos(theta)) / 2 + beta | |v| - |v_cur| | / v_max + gamma |v - v_pref| / (2 v_max)
       + delta max(0, T - TTC(v)) / T,   theta the angle between v and v_pref
(Karamouzas and Overmars 2010, "A velocity-based approach for simulating human collision avoidance", section 4), for
velocities that the time t to the first collision at v_pref permits (section 3.2), others are forbidden:
    theta <= d_mid + (1 - t / t_min)^2 (d_max - d_mid)   t < t_min = 2.5 s, any speed
             d_mid = 30 deg                              t < t_mid = 6 s
             d_mid (T - t) / (T - t_mid)                 t < T = 8 s
             0                                           else, at the preferred speed
    and the speed within v_pref +- (v_max - v_pref) from t_min to T; d_max = 90 deg.
alpha = 5, beta = 0.5, gamma = 1, delta = 1. Whoever overlaps already is ignored.

Not in the paper: margins of 0.05 rad and 0.05 m/s, since candidates rarely meet v_pref exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import collision_rates
from components.crowd.costs.cost import Cost, cosine
from components.crowd.surroundings import GX, GY, MAX_SPEED, VX, VY, Surroundings

Array = NDArray[np.float64]

T_MIN, T_MID = 2.5, 6.0
"""[s]"""
D_MID, D_MAX = math.pi / 6, math.pi / 2
"""[rad]"""
MARGIN = 0.05
"""[rad], and [m/s]"""


@dataclass(frozen=True, kw_only=True)
class Karamouzas(Cost):
    """The cost `karamouzas`."""

    alpha: float = 5.0
    """price of a turn"""
    beta: float = 0.5
    """price of a change of speed"""
    gamma: float = 1.0
    """price of the difference from the preferred velocity"""
    delta: float = 1.0
    """price of an imminent collision"""
    t_max: float = 8.0
    """T, later collisions are ignored [s]"""

    def __post_init__(self) -> None:
        if not self.t_max > T_MID:
            raise ValueError(f"t_max is {self.t_max}, expected more than {T_MID} (t_mid)")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.alpha, self.beta, self.gamma, self.delta, self.t_max, total)


@njit(cache=True, nogil=True, error_model="numpy")
def greatest_turn(t: float, T: float) -> float:
    """Greatest angle to the preferred velocity [rad] where that leads to a collision after t [s]."""
    if t < T_MIN:
        return D_MID + (1.0 - t / T_MIN) ** 2 * (D_MAX - D_MID)
    if t < T_MID:
        return D_MID
    return D_MID * (T - t) / (T - T_MID) if t < T else 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    around: Surroundings,
    candidates: Array,
    coefficient: float,
    alpha: float,
    beta: float,
    gamma: float,
    delta: float,
    T: float,
    total: Array,
) -> None:
    people, count = total.shape
    own = around.own
    gx, gy, soonest = np.empty(1), np.empty(1), np.empty(1)
    ax, ay, rate = np.empty(count), np.empty(count), np.empty(count)
    price, allowed = np.empty(count), np.empty(count, np.int64)
    for i in range(people):
        gx[0], gy[0], limit = own[GX, i], own[GY, i], own[MAX_SPEED, i]
        collision_rates(around, i, gx, gy, True, soonest)
        t = 1.0 / soonest[0] if soonest[0] > 0.0 else np.inf
        least_cosine = math.cos(min(greatest_turn(t, T) + MARGIN, math.pi))
        preferred = math.sqrt(gx[0] * gx[0] + gy[0] * gy[0])
        current = math.sqrt(own[VX, i] ** 2 + own[VY, i] ** 2)
        play = limit if t < T_MIN else (max(limit - preferred, 0.0) if t < T else 0.0)
        # Times to collision are wanted only for what is allowed: closing the ranks first saves most of the work.
        m = 0
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            speed = math.sqrt(cx * cx + cy * cy)
            turn = cosine(cx, cy, gx[0], gy[0])
            if turn < least_cosine or abs(speed - preferred) > play + MARGIN:
                total[i, k] += coefficient * np.inf
                continue
            x, y = cx - gx[0], cy - gy[0]
            price[m] = (
                alpha * (1.0 - turn) / 2.0
                + beta * abs(speed - current) / limit
                + gamma * math.sqrt(x * x + y * y) / (2.0 * limit)
            )
            ax[m], ay[m], allowed[m] = cx, cy, k
            m += 1
        collision_rates(around, i, ax[:m], ay[:m], True, rate[:m])
        for j in range(m):
            late = 1.0 / (rate[j] * T) if rate[j] * T > 1.0 else 1.0
            total[i, allowed[j]] += coefficient * (price[j] + delta * (1.0 - late))
