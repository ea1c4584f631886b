"""Optimal reciprocal collision avoidance as a price on velocities, for mixing with other costs.

C(v) = |v - v_pref| where v is in every ORCA half-plane n . v >= b and |v| <= v_max; otherwise 2 v_max + the greatest
violation max(b - n . v) (van Toll et al. 2020, "Generalized microscopic crowd simulation using costs in velocity
space"; half-planes: Berg, Guy, Lin and Manocha 2011, see `../orca.py`). Time horizon 5 s.

The policy `orca` finds the velocity of least cost exactly, by linear programs; this is for sampling, and for sums.

Not in the papers: a speed beyond v_max counts as a violation by |v| - v_max.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.costs.cost import Cost
from components.crowd.orca import half_plane, wall_half_plane
from components.crowd.surroundings import (
    AX,
    AY,
    BX,
    BY,
    GX,
    GY,
    MAX_SPEED,
    OX,
    OY,
    PX,
    PY,
    RADIUS,
    REACH,
    VX,
    VY,
    Surroundings,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class OrcaCost(Cost):
    """The cost `orca`."""

    time_horizon: float = 5.0
    """collisions later than this are ignored [s]"""

    def __post_init__(self) -> None:
        if not self.time_horizon > 0:
            raise ValueError(f"time_horizon is {self.time_horizon}, expected a positive number")

    def add(self, around: Surroundings, candidates: Array, coefficient: float, total: Array) -> None:
        """Add the costs of all candidates."""
        _add(around, candidates, coefficient, self.time_horizon, total)


@njit(cache=True, nogil=True, error_model="numpy")
def _raise(nx: float, ny: float, b: float, cx: Array, cy: Array, violation: Array) -> None:
    """Raise `violation` (K,) to how far (cx, cy) (K,) are outside of n . v >= b [m/s]."""
    for k in range(len(cx)):
        off = b - nx * cx[k] - ny * cy[k]
        violation[k] = off if off > violation[k] else violation[k]


@njit(cache=True, nogil=True, error_model="numpy")
def _add(around: Surroundings, candidates: Array, coefficient: float, horizon: float, total: Array) -> None:
    people, count = total.shape
    own, near, edges = around.own, around.near, around.edges
    violation = np.empty(count)
    for i in range(people):
        cx, cy = candidates[0, i], candidates[1, i]
        vx, vy, limit = own[VX, i], own[VY, i], own[MAX_SPEED, i]
        for k in range(count):
            violation[k] = math.sqrt(cx[k] * cx[k] + cy[k] * cy[k]) - limit
        for p in range(around.first[i], around.first[i + 1]):
            nx, ny, b = half_plane(
                near[PX, p], near[PY, p], vx, vy, near[OX, p], near[OY, p], near[REACH, p], horizon, around.dt
            )
            _raise(nx, ny, b, cx, cy, violation)
        for q in range(around.first_edge[i], around.first_edge[i + 1]):
            nx, ny, b = wall_half_plane(
                edges[AX, q], edges[AY, q], edges[BX, q], edges[BY, q], vx, vy, own[RADIUS, i], horizon
            )
            _raise(nx, ny, b, cx, cy, violation)
        for k in range(count):
            x, y = cx[k] - own[GX, i], cy[k] - own[GY, i]
            off = math.sqrt(x * x + y * y)
            total[i, k] += coefficient * (off if violation[k] <= 0.0 else 2.0 * limit + violation[k])
