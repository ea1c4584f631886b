"""Optimal reciprocal collision avoidance: the permitted velocity nearest to the preferred one.

For a neighbour at relative position p, with relative velocity w_rel = v - v', sum of radii R and time horizon tau, the
velocity obstacle is the cone of all w that lead to a collision within tau, cut off by the disc of centre p / tau and
radius R / tau (Berg, Guy, Lin and Manocha 2011, "Reciprocal n-body collision avoidance", "Preliminaries"). With u the
shortest way from w_rel to its boundary and n the outward normal there, each takes half of the change ("Optimal
reciprocal collision avoidance"):
    ORCA = {v : (v - (v_cur + u / 2)) . n >= 0}
    at the cut-off disc:  n = w / |w|, w = w_rel - p / tau, and u = (R / tau - |w|) n
    on a leg:             n . u = -n . w_rel, so that the line goes through the mean of both velocities
    when overlapping:     as at the disc, with the time step in the place of tau
The new velocity solves the linear programs of `half_planes.py`; the acceleration leads to it within one step.

A wall does nothing to avoid a collision ("Static obstacles"): its velocity obstacle is the cone of the
segment, rounded by the radius; the person takes the whole of the change, and no crowd pushes it through.

Not in the paper: the range of 5 m, without a limit to the number of neighbours (as in van Toll et al. 2020); a robot is
one more neighbour, of which its half of the change is expected, as of a person.
Differs from the paper: a wall counts for the same horizon as people; joined walls are taken one by one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import gather, shortest, sort_into_cells
from components.crowd.half_planes import best_velocity
from components.crowd.scene import RANGE, Scene
from components.crowd.walls import WallGrid, nearby, nearest_on_segment

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Orca:
    """The policy `orca`."""

    time_horizon: float | Array
    """collisions later than this are ignored: everybody's, or (N,) of each [s]"""

    def accelerate(self, scene: Scene, who: NDArray[np.int64] | None = None) -> Array:
        """(N, 2) accelerations that everybody wants, or only those whose indices are in `who` [m/s2]."""
        asked = np.ones(len(scene.position), np.bool_)
        if who is not None:
            asked[:] = False
            asked[who] = True
        return orca(
            asked,
            scene.position,
            scene.velocity,
            scene.preferred,
            scene.radius,
            scene.robots,
            scene.walls.within(self._reach(scene)),
            scene.period,
            scene.max_speed,
            np.full(len(scene.position), self.time_horizon),
            scene.dt,
        )

    def _reach(self, scene: Scene) -> float:
        """How far walls are looked for: whole metres, so that few grids are made."""
        if not len(scene.walls):
            return RANGE
        fastest, largest = scene.max_speed.max(initial=0.0), scene.radius.max(initial=0.0)
        return float(math.ceil(np.max(self.time_horizon, initial=0.0) * fastest + largest))


@njit(cache=True, nogil=True, error_model="numpy")
def half_plane(
    px: float, py: float, vx: float, vy: float, ox: float, oy: float, R: float, horizon: float, dt: float
) -> tuple[float, float, float]:
    """The half-plane n . v >= b that one neighbour leaves, as (n_x, n_y, b).

    NaN, which binds nobody, if the relative velocity leads exactly to the cut-off disc's centre while overlapping.

    Args:
        px: position of the neighbour relative to the person [m]
        py: [m]
        vx: velocity of the person [m/s]
        vy: [m/s]
        ox: velocity of the neighbour [m/s]
        oy: [m/s]
        R: sum of both radii [m]
        horizon: tau [s]
        dt: time step, within which an overlap is to end [s]
    """
    # Choices rather than branches: a loop over neighbours then runs four at a time.
    squared = px * px + py * py
    overlap = squared <= R * R
    rate = 1.0 / dt if overlap else 1.0 / horizon
    wx, wy = vx - ox - px * rate, vy - oy - py * rate
    w_squared = wx * wx + wy * wy
    along = wx * px + wy * py
    disc = overlap | ((along < 0.0) & (along * along > R * R * w_squared))
    w = math.sqrt(w_squared)
    leg = math.sqrt(max(squared - R * R, 0.0))
    # Positive on the left leg, negative on the right one.
    leg = leg if px * wy - py * wx > 0.0 else -leg
    scale = w if disc else squared
    nx = (wx if disc else -px * R - py * leg) / scale
    ny = (wy if disc else px * leg - py * R) / scale
    ux = vx if disc else 0.5 * (vx + ox)
    uy = vy if disc else 0.5 * (vy + oy)
    return nx, ny, nx * ux + ny * uy + (0.5 * (R * rate - w) if disc else 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def _half_planes(
    px: Array,
    py: Array,
    vx: float,
    vy: float,
    ox: Array,
    oy: Array,
    R: Array,
    horizon: float,
    dt: float,
    nx: Array,
    ny: Array,
    b: Array,
) -> None:
    """`half_plane` of many neighbours."""
    for f in range(len(px)):
        nx[f], ny[f], b[f] = half_plane(px[f], py[f], vx, vy, ox[f], oy[f], R[f], horizon, dt)


@njit(cache=True, nogil=True, error_model="numpy")
def wall_half_plane(
    ax: float, ay: float, bx: float, by: float, vx: float, vy: float, r: float, horizon: float
) -> tuple[float, float, float]:
    """The half-plane n . v >= b that a wall from a to b leaves, as (n_x, n_y, b); v = 0 is always permitted.

    The velocity obstacle is a region without thickness (the segment / tau in front, a leg from each end) widened by
    r / tau; the half-plane touches it where it is nearest to the velocity.

    Args:
        ax: one end, relative to the person [m]
        ay: [m]
        bx: other end [m]
        by: [m]
        vx: velocity of the person [m/s]
        vy: [m/s]
        r: radius of the person [m]
        horizon: tau [s]
    """
    cx, cy, _ = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
    distance = math.sqrt(cx * cx + cy * cy)
    if distance <= r:
        if distance > 0.0:
            return -cx / distance, -cy / distance, 0.0
        length = math.sqrt((bx - ax) ** 2 + (by - ay) ** 2)
        return (by - ay) / length, (ax - bx) / length, 0.0

    # The left leg touches the disc round that end which reaches farther to the left; the right leg likewise.
    a2, b2 = ax * ax + ay * ay, bx * bx + by * by
    a_leg, b_leg = math.sqrt(a2 - r * r), math.sqrt(b2 - r * r)
    lx, ly, lax, lay = (ax * a_leg - ay * r) / a2, (ax * r + ay * a_leg) / a2, ax, ay
    mx, my = (bx * b_leg - by * r) / b2, (bx * r + by * b_leg) / b2
    if lx * my - ly * mx > 0.0:
        lx, ly, lax, lay = mx, my, bx, by
    rx, ry, rbx, rby = (ax * a_leg + ay * r) / a2, (ay * a_leg - ax * r) / a2, ax, ay
    mx, my = (bx * b_leg + by * r) / b2, (by * b_leg - bx * r) / b2
    if rx * my - ry * mx < 0.0:
        rx, ry, rbx, rby = mx, my, bx, by
    lax, lay, rbx, rby = lax / horizon, lay / horizon, rbx / horizon, rby / horizon
    one_end = lax == rbx and lay == rby

    # The nearest point q of that region, and the outward normal there.
    qx, qy, share = nearest_on_segment(lax, lay, rbx, rby, vx, vy)
    along_left = (vx - lax) * lx + (vy - lay) * ly
    along_right = (vx - rbx) * rx + (vy - rby) * ry
    if (share < 0.0 and along_left < 0.0) or (share > 1.0 and along_right < 0.0):
        corner = True
    else:
        corner = one_end and along_left < 0.0 and along_right < 0.0
    if corner:
        gap = math.sqrt((vx - qx) ** 2 + (vy - qy) ** 2)
        nx, ny = (vx - qx) / gap, (vy - qy) / gap
    else:
        # Exactly one of three straight pieces.
        nearest = np.inf
        nx, ny = 0.0, 0.0
        if not one_end and 0.0 <= share <= 1.0:
            nearest = (vx - qx) ** 2 + (vy - qy) ** 2
            length = math.sqrt((rbx - lax) ** 2 + (rby - lay) ** 2)
            nx, ny = (rby - lay) / length, (lax - rbx) / length
            if nx * qx + ny * qy > 0.0:
                nx, ny = -nx, -ny
        if along_left >= 0.0:
            off = (lax - vx) * ly - (lay - vy) * lx
            if off * off < nearest:
                nearest, nx, ny, qx, qy = off * off, -ly, lx, lax, lay
        if along_right >= 0.0:
            off = (rbx - vx) * ry - (rby - vy) * rx
            if off * off < nearest:
                nx, ny, qx, qy = ry, -rx, rbx, rby
    return nx, ny, min(nx * qx + ny * qy + r / horizon, 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def orca(
    asked: NDArray[np.bool_],
    position: Array,
    velocity: Array,
    preferred: Array,
    radius: Array,
    robots: Array,
    walls: WallGrid,
    period: Array,
    max_speed: Array,
    horizon: Array,
    dt: float,
) -> Array:
    """(N, 2) accelerations to the ORCA velocities within one step [m/s2]; other arguments as in `Scene`."""
    n, m, w = len(position), len(robots), walls.most
    cells = sort_into_cells(position, period, 0.5 * RANGE)
    vx, vy, r = velocity[cells.order, 0], velocity[cells.order, 1], radius[cells.order]
    found, px, py = np.empty(n + 1, np.int64), np.empty(n + 1), np.empty(n + 1)
    ox, oy, R = np.empty(n + 1), np.empty(n + 1), np.empty(n + 1)
    nx, ny, b = np.empty(w + m + n), np.empty(w + m + n), np.empty(w + m + n)
    acceleration = np.zeros((n, 2))
    for k in range(n):
        i = cells.order[k]
        if not asked[i]:
            continue
        x, y, limit, tau = cells.x[k], cells.y[k], max_speed[i], horizon[i]
        hard = 0
        begin, end = nearby(walls, x, y)
        for q in range(begin, end):
            j = walls.listed[q]
            ax, ay, bx, by = walls.ends[j, 0] - x, walls.ends[j, 1] - y, walls.ends[j, 2] - x, walls.ends[j, 3] - y
            cx, cy, _ = nearest_on_segment(ax, ay, bx, by, 0.0, 0.0)
            if cx * cx + cy * cy <= (tau * limit + r[k]) ** 2:
                nx[hard], ny[hard], b[hard] = wall_half_plane(ax, ay, bx, by, vx[k], vy[k], r[k], tau)
                hard += 1
        count = hard
        for j in range(m):
            dx, dy = shortest(robots[j, 0] - x, period[0]), shortest(robots[j, 1] - y, period[1])
            if dx * dx + dy * dy <= RANGE * RANGE:
                nx[count], ny[count], b[count] = half_plane(
                    dx, dy, vx[k], vy[k], robots[j, 2], robots[j, 3], r[k] + robots[j, 4], tau, dt
                )
                count += 1
        near = gather(cells, k, 0, RANGE, found, px, py)
        for f in range(near):
            ox[f], oy[f], R[f] = vx[found[f]], vy[found[f]], r[k] + r[found[f]]
        end = count + near
        _half_planes(
            px[:near],
            py[:near],
            vx[k],
            vy[k],
            ox[:near],
            oy[:near],
            R[:near],
            tau,
            dt,
            nx[count:end],
            ny[count:end],
            b[count:end],
        )
        x, y = best_velocity(nx, ny, b, hard, end, limit, preferred[i, 0], preferred[i, 1])
        acceleration[i, 0], acceleration[i, 1] = (x - vx[k]) / dt, (y - vy[k]) / dt
    return acceleration
