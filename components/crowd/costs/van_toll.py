"""Free way, direction, speed and steadiness, each with the same weight.

C(v) = D - min(D, TTC(v) |v|) + angle(v, v_pref) + | |v| - v0 | / v0 + angle(v, v_cur), D = 8 m
(van Toll and Pettre 2019, "Connecting global and local agent navigation via topology", and van Toll et al. 2020,
"Generalized microscopic crowd simulation using costs in velocity space"). v0 is the preferred speed; angles in rad.

Not in the papers: the angle with a velocity of zero is zero; whoever wants to stand finds every speed too high by
|v| / 0.1 m/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import collision_rates
from components.crowd.costs.cost import Cost, cosine
from components.crowd.surroundings import GX, GY, VX, VY, Surroundings

Array = NDArray[np.float64]

SLOWEST = 0.1
"""lower preferred speeds count as this one in the ratio [m/s]"""


@dataclass(frozen=True, kw_only=True)
class VanToll(Cost):
    """The cost `van_toll`."""

    d_max: float = 8.0
    """D, how far people look [m]"""

    def __post_init__(self) -> None:
        if not self.d_max > 0:
            raise ValueError(f"d_max is {self.d_max}, expected a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.d_max, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, candidates: Array, coefficient: float, D: float, total: Array) -> None:
    people, count = total.shape
    own = around.own
    rate = np.empty(count)
    for i in range(people):
        gx, gy = own[GX, i], own[GY, i]
        preferred = math.sqrt(gx * gx + gy * gy)
        collision_rates(around, i, candidates[0, i], candidates[1, i], False, rate)
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            speed = math.sqrt(cx * cx + cy * cy)
            free = min(D, speed / rate[k]) if rate[k] > 0.0 else D
            total[i, k] += coefficient * (
                D
                - free
                + math.acos(cosine(cx, cy, gx, gy))
                + abs(speed - preferred) / max(preferred, SLOWEST)
                + math.acos(cosine(cx, cy, own[VX, i], own[VY, i]))
            )
