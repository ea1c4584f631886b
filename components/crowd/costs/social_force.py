"""Social forces of neighbours and walls, for mixing with other costs.

The repulsions of `../social_force.py` without the drive (Johansson, Helbing and Shukla 2007, elliptical specification
II, with the values given there). The policy `social_force` is this cost and `goal_reaching` in one kernel, which meets
every pair once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Force
from components.crowd.costs.wall_repulsion import repulsion_of_wall
from components.crowd.social_force import WALL_LENGTH, WALL_REPULSION, repulsion, weight
from components.crowd.surroundings import OX, OY, PX, PY, VX, VY, Surroundings, nearest_of_thing

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class SocialForceCost(Force):
    """The cost `social_force`."""

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add coefficient F to `total` (2, B) [m/s2]."""
        _push(around, coefficient, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _push(around: Surroundings, coefficient: float, total: Array) -> None:
    own, near, edges = around.own, around.near, around.edges
    for i in range(own.shape[1]):
        vx, vy = own[VX, i], own[VY, i]
        x, y = 0.0, 0.0
        for p in range(around.first[i], around.first[i + 1]):
            px, py = near[PX, p], near[PY, p]
            fx, fy = repulsion(-px, -py, near[OX, p] - vx, near[OY, p] - vy)
            w = weight(-px, -py, vx, vy)
            x += w * fx
            y += w * fy
        q, end = around.first_edge[i], around.first_edge[i + 1]
        while q < end:
            q, cx, cy = nearest_of_thing(edges, q, end)
            fx, fy = repulsion_of_wall(cx, cy, 0.0, WALL_REPULSION, WALL_LENGTH)
            x += fx
            y += fy
        total[0, i] += coefficient * x
        total[1, i] += coefficient * y
