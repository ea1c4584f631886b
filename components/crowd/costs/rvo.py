"""Reciprocal velocity obstacles: a price on imminent collisions and on the way off the preferred velocity.

C(v) = w / TTC(2 v - v_cur) + |v_pref - v|, infinite if |v| > v_max (Berg, Lin and Manocha 2008, "Reciprocal velocity
obstacles for real-time multi-agent navigation", section V.B): the other is expected to take half of the change, so
that one's own choice v leads to the relative velocity 2 v - v_cur - v_other. w = 1 m. Times to collision
are those of `collision.py`; whoever overlaps already is ignored.

Not in the paper: a robot is one more neighbour. A wall does nothing to avoid a collision, so that its time is TTC(v).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import raise_to_people, raise_to_walls
from components.crowd.costs.cost import Cost
from components.crowd.surroundings import GX, GY, MAX_SPEED, VX, VY, Surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Rvo(Cost):
    """The cost `rvo`."""

    w: float = 1.0
    """price of a collision in one second, against that of 1 m/s off the preferred velocity [m]"""

    def __post_init__(self) -> None:
        if not self.w >= 0:
            raise ValueError(f"w is {self.w}, expected zero or a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.w, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, candidates: Array, coefficient: float, w: float, total: Array) -> None:
    people, count = total.shape
    own = around.own
    mx, my, rate = np.empty(count), np.empty(count), np.empty(count)
    for i in range(people):
        cx, cy = candidates[0, i], candidates[1, i]
        for k in range(count):
            mx[k], my[k] = 2.0 * cx[k] - own[VX, i], 2.0 * cy[k] - own[VY, i]
            rate[k] = 0.0
        raise_to_people(around, i, mx, my, True, rate)
        raise_to_walls(around, i, cx, cy, True, rate)
        for k in range(count):
            x, y = cx[k] - own[GX, i], cy[k] - own[GY, i]
            price = w * rate[k] + math.sqrt(x * x + y * y)
            price = np.inf if cx[k] * cx[k] + cy[k] * cy[k] > own[MAX_SPEED, i] * own[MAX_SPEED, i] else price
            total[i, k] += coefficient * price
