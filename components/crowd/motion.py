"""From wanted accelerations to the next state: limits, contacts, walls, the seam.

a' = a limited to a_max; v' = v + a' dt limited to v_max; v'' = v' + (k / m) sum overlap n dt; p' = p + v'' dt
(van Toll et al. 2020, "Generalized microscopic crowd simulation using costs in velocity space", and the defaults of
its library, k = 5000 N/m and m = 80 kg for everybody). Contacts come from the old positions: all move at once.

Not in the paper: the limit of the stiffness for long time steps; nobody's centre passes a wall or
an obstacle's edge, and an obstacle pushes from its nearest point.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.cells import gather, into_period, shortest, sort_into_cells
from components.crowd.scene import Scene
from components.crowd.walls import WallGrid, nearby, nearest_of_thing

Array = NDArray[np.float64]

STIFFNESS = 5000.0 / 80.0
"""k / m: acceleration per overlap [1/s2]"""
STABLE = 0.625
"""(k / m) dt^2 stays at or below this: a jam's fastest vibration has omega^2 = 6 k / m (hexagonal lattice), and the
integration is stable for omega dt < 2, that is below 2 / 3; the default stiffness is within at dt = 0.1 s"""

WALL_REACH = 1.0
"""walls are looked for this far, or as far as the largest body, or the longest step [m]"""


@njit(cache=True, nogil=True, error_model="numpy")
def contact_accelerations(
    position: Array,
    radius: Array,
    robots: Array,
    pushed_by_robots: NDArray[np.bool_],
    walls: WallGrid,
    period: Array,
    dt: float,
) -> Array:
    """(N, 2) accelerations by which bodies, robots and walls push those who overlap with them [m/s2]."""
    n = len(position)
    push = np.zeros((n, 2))
    if n == 0:
        return push
    stiffness = min(STIFFNESS, STABLE / (dt * dt))
    reach = 2.0 * radius.max()
    cells = sort_into_cells(position, period, reach)
    found, px, py = np.empty(n + 1, np.int64), np.empty(n + 1), np.empty(n + 1)
    for k in range(n):
        i = cells.order[k]
        for f in range(gather(cells, k, k + 1, reach, found, px, py)):
            j = cells.order[found[f]]
            distance = math.sqrt(px[f] * px[f] + py[f] * py[f])
            overlap = radius[i] + radius[j] - distance
            if overlap > 0.0:
                # Two in one place are pushed apart in x.
                nx, ny = (px[f] / distance, py[f] / distance) if distance > 0.0 else (1.0, 0.0)
                push[i, 0] -= stiffness * overlap * nx
                push[i, 1] -= stiffness * overlap * ny
                push[j, 0] += stiffness * overlap * nx
                push[j, 1] += stiffness * overlap * ny
        for f in range(len(robots) if pushed_by_robots[i] else 0):
            x = shortest(robots[f, 0] - cells.x[k], period[0])
            y = shortest(robots[f, 1] - cells.y[k], period[1])
            _push_off(push, i, x, y, radius[i] + robots[f, 4], stiffness)
        q, end = nearby(walls, cells.x[k], cells.y[k])
        while q < end:
            q, x, y = nearest_of_thing(walls, q, end, cells.x[k], cells.y[k])
            _push_off(push, i, x, y, radius[i], stiffness)
    return push


@njit(cache=True, nogil=True, error_model="numpy")
def _push_off(push: Array, i: int, x: float, y: float, reach: float, stiffness: float) -> None:
    """Push person `i` away from what is at (x, y) relative to it, if that is within `reach`."""
    squared = x * x + y * y
    if 0.0 < squared < reach * reach:
        distance = math.sqrt(squared)
        push[i, 0] -= stiffness * (reach - distance) * x / distance
        push[i, 1] -= stiffness * (reach - distance) * y / distance


@njit(cache=True, nogil=True, error_model="numpy")
def _limit(x: float, y: float, greatest: float) -> tuple[float, float]:
    """The vector, shortened to the greatest length if it is longer."""
    length = math.sqrt(x * x + y * y)
    return (x * greatest / length, y * greatest / length) if length > greatest else (x, y)


@njit(cache=True, nogil=True, error_model="numpy")
def _crossed(walls: WallGrid, x: float, y: float, sx: float, sy: float) -> int:
    """Row of `walls.ends` that the step (sx, sy) from (x, y) crosses, -1 if none."""
    near = sx * sx + sy * sy <= walls.reach * walls.reach
    begin, end = nearby(walls, x, y) if near else (0, len(walls.ends))
    for q in range(begin, end):
        f = walls.listed[q] if near else q
        ax, ay, bx, by = walls.ends[f, 0] - x, walls.ends[f, 1] - y, walls.ends[f, 2] - x, walls.ends[f, 3] - y
        ux, uy = bx - ax, by - ay
        # Positive on the right, outside of an obstacle.
        before, after = ux * ay - uy * ax, ux * (ay - sy) - uy * (ax - sx)
        if walls.solid[f]:
            # Whoever is inside may leave.
            through = before >= 0.0 and after <= 0.0 and before != after
        else:
            # Who stands on the line itself may leave it to either side.
            through = before != 0.0 and before * after <= 0.0
        on_a, on_b = sx * ay - sy * ax, sx * by - sy * bx
        if through and on_a * on_b <= 0.0:
            return f
    return -1


def move(scene: Scene, acceleration: Array) -> tuple[Array, Array]:
    """Positions and velocities, both (N, 2), one step later [m, m/s].

    Args:
        scene: the old state; contacts may exceed its `max_acceleration` and `max_speed`
        acceleration: (N, 2) wanted accelerations [m/s2]
    """
    return _move(
        scene.position,
        scene.velocity,
        acceleration,
        scene.radius,
        scene.robots,
        scene.pushed_by_robots,
        scene.walls.within(_wall_reach(scene)),
        scene.period,
        scene.max_speed,
        scene.max_acceleration,
        scene.dt,
    )


def _wall_reach(scene: Scene) -> float:
    """How far walls are looked for: whole metres, so that few grids are made."""
    return max(WALL_REACH, float(math.ceil(scene.radius.max(initial=0.0)))) if len(scene.walls) else WALL_REACH


@njit(cache=True, nogil=True, error_model="numpy")
def _move(
    position: Array,
    velocity: Array,
    acceleration: Array,
    radius: Array,
    robots: Array,
    pushed_by_robots: NDArray[np.bool_],
    walls: WallGrid,
    period: Array,
    max_speed: Array,
    max_acceleration: Array,
    dt: float,
) -> tuple[Array, Array]:
    n = len(position)
    push = contact_accelerations(position, radius, robots, pushed_by_robots, walls, period, dt)
    new_position, new_velocity = np.empty((n, 2)), np.empty((n, 2))
    for i in range(n):
        ax, ay = _limit(acceleration[i, 0], acceleration[i, 1], max_acceleration[i])
        vx, vy = _limit(velocity[i, 0] + ax * dt, velocity[i, 1] + ay * dt, max_speed[i])
        vx, vy = vx + push[i, 0] * dt, vy + push[i, 1] * dt
        x, y = position[i, 0], position[i, 1]
        wall = _crossed(walls, x, y, vx * dt, vy * dt)
        if wall >= 0:
            # Slide along it; whoever would then cross another stays.
            ux, uy = walls.ends[wall, 2] - walls.ends[wall, 0], walls.ends[wall, 3] - walls.ends[wall, 1]
            along = (vx * ux + vy * uy) / (ux * ux + uy * uy)
            vx, vy = along * ux, along * uy
            if _crossed(walls, x, y, vx * dt, vy * dt) >= 0:
                vx, vy = 0.0, 0.0
        new_velocity[i, 0], new_velocity[i, 1] = vx, vy
        new_position[i, 0] = into_period(x + vx * dt, period[0])
        new_position[i, 1] = into_period(y + vy * dt, period[1])
    return new_position, new_velocity
