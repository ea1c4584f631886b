"""Least effort: the velocity that takes people to their goal with the least energy.

C(v) = t_M (w_a + w_b |v|^2) + 2 |g - p - t_M v| sqrt(w_a w_b), infinite if TTC(v) < t_min
(Guy, Chhugani, Curtis, Dubey, Lin and Manocha 2010, "PLEdestrians: a least-effort approach to crowd simulation", eqs. 3
to 5): the energy of t_M seconds at v and of the rest of the way at the cheapest speed sqrt(w_a / w_b).
w_b = 1.26 J s/kg m2, t_min = 0.5 s, t_M = 3 s. Whoever overlaps already is ignored.

Differs from the paper: the goal g is far away in the direction of the preferred velocity, so that
|g - p - t_M v| = const - t_M v . v_pref / |v_pref|, without the constant; and w_a = w_b v0^2, so that everybody's
preferred speed v0 is the cheapest (the paper's w_a = 2.23 W/kg makes that 1.33 m/s for everybody).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import collision_rates
from components.crowd.costs.cost import Cost
from components.crowd.surroundings import GX, GY, Surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Pledestrians(Cost):
    """The cost `pledestrians`."""

    w_b: float = 1.26
    """power per squared speed [J s/(kg m2)]"""
    t_min: float = 0.5
    """velocities that lead to a collision sooner are forbidden [s]"""
    t_max: float = 3.0
    """t_M, how long a velocity is kept [s]"""

    def __post_init__(self) -> None:
        for name in ("w_b", "t_min", "t_max"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.w_b, self.t_min, self.t_max, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _add(
    around: Surroundings, candidates: Array, coefficient: float, w_b: float, t_min: float, t_M: float, total: Array
) -> None:
    people, count = total.shape
    own = around.own
    rate = np.empty(count)
    for i in range(people):
        gx, gy = own[GX, i], own[GY, i]
        squared = gx * gx + gy * gy
        collision_rates(around, i, candidates[0, i], candidates[1, i], True, rate)
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            # sqrt(w_a w_b) v_pref / |v_pref| = w_b v_pref.
            price = t_M * w_b * (squared + cx * cx + cy * cy) - 2.0 * t_M * w_b * (cx * gx + cy * gy)
            total[i, k] += coefficient * (np.inf if rate[k] * t_min > 1.0 else price)
