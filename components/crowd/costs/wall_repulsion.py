"""Wall repulsion: walls push people away, for policies whose own costs know only people.

F = (U0 / R_U) exp(-(d - r) / R_U) n, d the distance to the nearest point of the wall or obstacle, r the person's
radius, n away from it (Helbing and Molnar 1995, "Social force model for pedestrian dynamics", eq. 5). R_U = 0.2 m.

Differs from the paper: the distance is that of the body's edge, and U0 is 2 m2/s2 rather than 10, so that
whoever touches a wall is pushed with 10 m/s2, twice what people can do on their own.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Force
from components.crowd.surroundings import RADIUS, Surroundings, nearest_of_thing

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class WallRepulsion(Force):
    """The cost `wall_repulsion`."""

    strength: float = 2.0
    """U0 [m2/s2]"""
    length: float = 0.2
    """R_U [m]"""

    def __post_init__(self) -> None:
        if not self.length > 0:
            raise ValueError(f"length is {self.length}, expected a positive number")

    def push(self, around: Surroundings, coefficient: float, total: Array) -> None:
        """Add coefficient F to `total` (2, B) [m/s2]."""
        _push(around, coefficient * self.strength, self.length, total)


@njit(cache=True, nogil=True, error_model="numpy")
def repulsion_of_wall(cx: float, cy: float, r: float, strength: float, length: float) -> tuple[float, float]:
    """F [m/s2] of a wall with its nearest point at (cx, cy) from the person [m]; none on whose centre is there."""
    d = math.sqrt(cx * cx + cy * cy)
    if d == 0.0:
        return 0.0, 0.0
    steepness = strength / length * math.exp((r - d) / length) / d
    return -steepness * cx, -steepness * cy


@njit(cache=True, nogil=True, error_model="numpy")
def _push(around: Surroundings, strength: float, length: float, total: Array) -> None:
    edges = around.edges
    for i in range(around.own.shape[1]):
        q, end = around.first_edge[i], around.first_edge[i + 1]
        while q < end:
            q, cx, cy = nearest_of_thing(edges, q, end)
            fx, fy = repulsion_of_wall(cx, cy, around.own[RADIUS, i], strength, length)
            total[0, i] += fx
            total[1, i] += fy
