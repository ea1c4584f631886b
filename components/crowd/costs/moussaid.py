"""The heuristics of Moussaid: go where the way to the goal is freest, as fast as a stop in time allows.

For each direction with angle alpha to the preferred velocity, DC = min(D, distance to the first collision at the
preferred speed v0):
    C(v) = K (1 + ((S - |v|) / S)^2),  K = D^2 + DC^2 - 2 D DC cos(alpha) + 1,  S = min(v0, DC / tau)
(heuristics 1 and 2 of Moussaid, Helbing and Theraulaz 2011, "How simple rules determine pedestrian behavior and crowd
disasters", eqs. 1 and 2, joined to one cost by van Toll et al. 2020). D = 8 m, tau the policy's relaxation time.

Not in the paper: whoever touches somebody in the direction has DC = S = 0, which forbids it; standing still counts as
going in the preferred direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.collision import collision_rates
from components.crowd.costs.cost import Cost, cosine
from components.crowd.surroundings import GX, GY, Surroundings

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Moussaid(Cost):
    """The cost `moussaid`."""

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
    hx, hy, rate = np.empty(count), np.empty(count), np.empty(count)
    for i in range(people):
        gx, gy = own[GX, i], own[GY, i]
        preferred = math.sqrt(gx * gx + gy * gy)
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            speed = math.sqrt(cx * cx + cy * cy)
            scale = preferred / speed if speed > 0.0 else 0.0
            hx[k], hy[k] = (cx * scale, cy * scale) if speed > 0.0 else (gx, gy)
        collision_rates(around, i, hx, hy, False, rate)
        for k in range(count):
            cx, cy = candidates[0, i, k], candidates[1, i, k]
            free = min(preferred / rate[k], D) if rate[k] > 0.0 else D
            best = min(preferred, free / around.relaxation_time)
            if best <= 0.0:
                total[i, k] += coefficient * np.inf
                continue
            slack = (best - math.sqrt(cx * cx + cy * cy)) / best
            K = D * D + free * free - 2.0 * D * free * cosine(cx, cy, gx, gy) + 1.0
            total[i, k] += coefficient * K * (1.0 + slack * slack)
