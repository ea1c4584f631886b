"""Social forces: people drive at their preferred velocity and repel each other by an elliptical potential.

With R = r_i - r_j, V = (v_j - v_i) T and 2 b = sqrt((|R| + |R - V|)^2 - |V|^2), the semi-minor axis of the ellipse that
the neighbour's way of the next T seconds spans:
    a_i = (v_pref - v_i) / tau - sum_j w_j grad V0 exp(-b / sigma) - sum_walls grad U0 exp(-d / R_U)
        = (v_pref - v_i) / tau + sum_j w_j f_ij + sum_walls (U0 / R_U) exp(-d / R_U) n
    f_ij = (V0 / sigma) exp(-b / sigma) (|R| + |R - V|) / (4 b) (R / |R| + (R - V) / |R - V|)
(Johansson, Helbing and Shukla 2007, "Specification of the social force pedestrian model by evolutionary adjustment to
video tracking data", elliptical specification II). V0 = 2.1 m2/s2, sigma = 0.3 m, U0 = 10 m2/s2, R_U = 0.2 m,
tau = 0.5 s, T = 2 s, the walls' term, and w_j = 0.5 for neighbours outside of 100 deg to either side of the walking
direction, are those of Helbing and Molnar 1995, "Social force model for pedestrian dynamics".

Not in the papers: the range of 5 m; a robot repels as a person does; whoever stands still is repelled fully from all
sides; two who walk exactly at each other (b = 0, where the potential has no gradient) do not repel.
Differs from the papers: the walking direction is that of the velocity, and w_j goes by where the neighbour is, not by
where its force points. There is no fluctuation term.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import gather, shortest, sort_into_cells
from components.crowd.scene import RANGE, Scene
from components.crowd.walls import WallGrid, nearby, nearest_of_thing

Array = NDArray[np.float64]

RELAXATION = 0.5
"""tau [s]"""
REPULSION = 2.1
"""V0 [m2/s2]"""
REPULSION_LENGTH = 0.3
"""sigma [m]"""
ANTICIPATION = 2.0
"""T [s]"""
WALL_REPULSION = 10.0
"""U0 [m2/s2]"""
WALL_LENGTH = 0.2
"""R_U [m]"""
COS_SIGHT = math.cos(math.radians(100.0))
"""neighbours outside of this angle to the walking direction are behind"""
BEHIND = 0.5
"""weight of a neighbour behind"""


@dataclass(frozen=True, kw_only=True)
class SocialForce:
    """The policy `social_force`."""

    def accelerate(self, scene: Scene, who: NDArray[np.int64] | None = None) -> Array:
        """(N, 2) accelerations that everybody wants [m/s2]."""
        return social_force(
            scene.position,
            scene.velocity,
            scene.preferred,
            scene.robots,
            scene.walls.within(RANGE),
            scene.period,
        )


@njit(cache=True, nogil=True, error_model="numpy")
def repulsion(rx: float, ry: float, vx: float, vy: float) -> tuple[float, float]:
    """f_ij [m/s2] of a neighbour.

    Args:
        rx: R, from the neighbour to the person [m]
        ry: [m]
        vx: velocity of the neighbour relative to the person [m/s]
        vy: [m/s]
    """
    Vx, Vy = vx * ANTICIPATION, vy * ANTICIPATION
    qx, qy = rx - Vx, ry - Vy
    r, q = math.sqrt(rx * rx + ry * ry), math.sqrt(qx * qx + qy * qy)
    V = math.sqrt(Vx * Vx + Vy * Vy)
    # (s - V)(s + V) rather than s^2 - V^2, which cancels where the two are almost on one line.
    s = r + q
    squared = (s - V) * (s + V)
    if not (squared > 0.0 and r > 0.0 and q > 0.0):
        return 0.0, 0.0
    b = 0.5 * math.sqrt(squared)
    f = REPULSION / REPULSION_LENGTH * math.exp(-b / REPULSION_LENGTH) * s / (4.0 * b)
    return f * (rx / r + qx / q), f * (ry / r + qy / q)


@njit(cache=True, nogil=True, error_model="numpy")
def weight(rx: float, ry: float, vx: float, vy: float) -> float:
    """w_j of a neighbour that is at -R from a person who walks at (vx, vy)."""
    ahead = -(rx * vx + ry * vy)
    return 1.0 if ahead >= COS_SIGHT * math.sqrt((rx * rx + ry * ry) * (vx * vx + vy * vy)) else BEHIND


@njit(cache=True, nogil=True, error_model="numpy")
def social_force(
    position: Array, velocity: Array, preferred: Array, robots: Array, walls: WallGrid, period: Array
) -> Array:
    """(N, 2) accelerations [m/s2]; arguments as in `Scene`."""
    n, m = len(position), len(robots)
    cells = sort_into_cells(position, period, 0.5 * RANGE)
    found, px, py = np.empty(n + 1, np.int64), np.empty(n + 1), np.empty(n + 1)
    vx, vy = velocity[cells.order, 0], velocity[cells.order, 1]
    fx, fy = np.zeros(n), np.zeros(n)
    for k in range(n):
        # f_ji = -f_ij: meet every pair once.
        neighbours = gather(cells, k, k + 1, RANGE, found, px, py)
        for f in range(neighbours):
            j = found[f]
            ax, ay = repulsion(-px[f], -py[f], vx[j] - vx[k], vy[j] - vy[k])
            w = weight(-px[f], -py[f], vx[k], vy[k])
            fx[k] += w * ax
            fy[k] += w * ay
            w = weight(px[f], py[f], vx[j], vy[j])
            fx[j] -= w * ax
            fy[j] -= w * ay
        x, y = cells.x[k], cells.y[k]
        for j in range(m):
            rx, ry = shortest(x - robots[j, 0], period[0]), shortest(y - robots[j, 1], period[1])
            if rx * rx + ry * ry <= RANGE * RANGE:
                ax, ay = repulsion(rx, ry, robots[j, 2] - vx[k], robots[j, 3] - vy[k])
                w = weight(rx, ry, vx[k], vy[k])
                fx[k] += w * ax
                fy[k] += w * ay
        q, end = nearby(walls, x, y)
        while q < end:
            q, cx, cy = nearest_of_thing(walls, q, end, x, y)
            d = math.sqrt(cx * cx + cy * cy)
            if 0.0 < d <= RANGE:
                steepness = WALL_REPULSION / WALL_LENGTH * math.exp(-d / WALL_LENGTH) / d
                fx[k] -= steepness * cx
                fy[k] -= steepness * cy
    acceleration = np.empty((n, 2))
    for k in range(n):
        i = cells.order[k]
        acceleration[i, 0] = fx[k] + (preferred[i, 0] - vx[k]) / RELAXATION
        acceleration[i, 1] = fy[k] + (preferred[i, 1] - vy[k]) / RELAXATION
    return acceleration
