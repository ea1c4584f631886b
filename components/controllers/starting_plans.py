"""Where the search for a plan starts: the old plan carried on, or a turn and a straight drive that is clearly better.

The programme of `optimal_control.py` has a local optimum on either side of everybody, and a solver finds one near its
start. Candidates are rolled out with the programme's own dynamics, from where the robot is: one follows the speeds and
turn rates of the last plan, the others turn to one of 11 headings around the way to the goal and drive at one of 4
speeds. Each is charged the programme's cost, with all people near. The old plan is kept unless another one costs less
than 0.8 of it, so that the robot does not waver between two sides.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.differential import Limits
from components.controllers.ego import Ego
from components.controllers.optimal_control import ALPHA, FAR, OMEGA, THETA, A, Shape, V, Weights, X, Y
from components.controllers.prediction import Tracks
from components.controllers.surroundings import nearest_on_segment

Array = NDArray[np.float64]

HEADINGS = 11
"""candidates' headings, evenly over +-SPREAD around the way to the goal"""
SPREAD = 1.3
"""[rad]"""
SPEEDS = (0.0, 0.35, 0.7, 1.0)
"""candidates' speeds, as shares of the robot's maximum"""
TURN_GAIN = 2.0
"""turn rate of a candidate per radian of heading error [1/s]"""
BETTER = 0.8
"""share of the old plan's cost below which another one is started from"""
LATER = 0.15
"""how much nearer somebody must come later to count as much as now [m/s]"""
NEGLIGIBLE = 1e-4
"""share of the cost of a touch that no longer counts"""
CROSSING = 1e3
"""cost rate of a stage that goes through a wall, in touches"""


class Scales(NamedTuple):
    """All that a cost depends on besides the plan and the people."""

    way: Array
    """(2,) unit vector of the reference's line"""
    reference: Array
    """(N + 1,) how far along it the reference is [m]"""
    box: Array
    """(4,) least x, least y, greatest x, greatest y [m]"""
    segments: Array
    """(W, 2, 2) walls within the box [m]"""
    body: float
    """distance to keep from them [m]"""
    shape: Shape
    limits: Limits
    weights: Weights


@njit(cache=True, nogil=True, error_model="numpy")
def negligible_gap(weights: Weights) -> float:
    """h beyond which a disc costs nothing that counts [m]. A gap between surfaces is never more than its h."""
    return float(-math.log(NEGLIGIBLE) / weights.steepness)


@njit(cache=True, nogil=True, error_model="numpy")
def carry_on(ego: Ego, old: Array, elapsed: float, scales: Scales, plan: Array) -> None:
    """Write into `plan` how the robot goes on with the plan `old`, made `elapsed` [s] ago, and then straight."""
    _begin(ego, plan)
    last = scales.shape.stages
    for k in range(last):
        later = min(float(last), k + 1 + elapsed / scales.shape.dt)
        i = min(last - 1, int(later))
        share = later - i
        speed = (1.0 - share) * old[i, V] + share * old[i + 1, V]
        rate = (1.0 - share) * old[i, OMEGA] + share * old[i + 1, OMEGA]
        _advance(plan, k, speed, rate if k + 1 + elapsed / scales.shape.dt <= last else 0.0, scales)


@njit(cache=True, nogil=True, error_model="numpy")
def turn_and_go(ego: Ego, heading: float, speed: float, scales: Scales, plan: Array) -> None:
    """Write into `plan` a turn to `heading` [rad], the shorter way round, at `speed` [m/s]."""
    _begin(ego, plan)
    difference = heading - ego.heading
    target = ego.heading + difference - math.tau * np.rint(difference / math.tau)
    for k in range(scales.shape.stages):
        _advance(plan, k, speed, TURN_GAIN * (target - plan[k, THETA]), scales)


@njit(cache=True, nogil=True, error_model="numpy")
def _begin(ego: Ego, plan: Array) -> None:
    plan[0, X] = plan[0, Y] = 0.0
    plan[0, THETA], plan[0, V], plan[0, OMEGA] = ego.heading, ego.speed, ego.turn_rate


@njit(cache=True, nogil=True, error_model="numpy")
def _advance(plan: Array, k: int, speed: float, rate: float, scales: Scales) -> None:
    """Write the inputs of stage k that come nearest to `speed` and `rate` within the limits, and the next state."""
    limits, dt = scales.limits, scales.shape.dt
    v, omega = plan[k, V], plan[k, OMEGA]
    next_v = min(limits.max_speed, max(limits.min_speed, speed))
    next_omega = min(limits.max_turn_rate, max(-limits.max_turn_rate, rate))
    a = min(limits.max_acceleration, max(-limits.max_acceleration, (next_v - v) / dt))
    alpha = (next_omega - omega) / dt
    alpha = min(limits.max_angular_acceleration, max(-limits.max_angular_acceleration, alpha))
    plan[k, A], plan[k, ALPHA] = a, alpha
    middle_v, middle_theta = v + 0.5 * dt * a, plan[k, THETA] + 0.5 * dt * omega
    x = plan[k, X] + dt * middle_v * math.cos(middle_theta)
    y = plan[k, Y] + dt * middle_v * math.sin(middle_theta)
    plan[k + 1, X] = min(scales.box[2], max(scales.box[0], x))
    plan[k + 1, Y] = min(scales.box[3], max(scales.box[1], y))
    plan[k + 1, THETA] = plan[k, THETA] + dt * (omega + 0.5 * dt * alpha)
    plan[k + 1, V], plan[k + 1, OMEGA] = v + dt * a, omega + dt * alpha
    plan[k + 1, A] = plan[k + 1, ALPHA] = 0.0


@njit(cache=True, nogil=True, error_model="numpy")
def best_start(ego: Ego, old: Array, elapsed: float, near: Tracks, scales: Scales, plan: Array) -> float:
    """Write into `plan` the best place to start from; its cost."""
    carry_on(ego, old, elapsed, scales, plan)
    best = cost(plan, near, scales, np.inf)
    bar = BETTER * best
    bearing = math.atan2(scales.way[1], scales.way[0])
    candidate = np.empty_like(plan)
    for i in range(HEADINGS):
        heading = bearing + SPREAD * (2.0 * i / (HEADINGS - 1) - 1.0)
        for share in SPEEDS:
            turn_and_go(ego, heading, share * scales.limits.max_speed, scales, candidate)
            total = cost(candidate, near, scales, bar)
            if total < bar:
                best = bar = total
                plan[:] = candidate
    return best


@njit(cache=True, nogil=True, error_model="numpy")
def cost(plan: Array, near: Tracks, scales: Scales, enough: float) -> float:
    """The programme's cost of a plan with all of `near`; summed no further than `enough`."""
    weights, dt, way, total = scales.weights, scales.shape.dt, scales.way, 0.0
    for k in range(len(plan)):
        x, y = plan[k, X], plan[k, Y]
        lag, offset = way[0] * x + way[1] * y - scales.reference[k], way[0] * y - way[1] * x
        rate = (
            weights.lag * lag * lag
            + weights.offset * offset * offset
            + weights.turning * plan[k, OMEGA] ** 2
            + weights.acceleration * plan[k, A] ** 2
            + weights.angular_acceleration * plan[k, ALPHA] ** 2
        )
        if k > 0:
            rate += weights.proximity * (_discs_touch(x, y, k, near, weights) + _walls_touch(plan, k, scales))
        total += dt * float(rate)
        if total >= enough:
            break
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _discs_touch(x: float, y: float, k: int, near: Tracks, weights: Weights) -> float:
    """sum_j exp(-S h_j) of the robot at (x, y) [m] at stage k."""
    cutoff = negligible_gap(weights)
    total = 0.0
    for j in range(len(near.radius)):
        dx, dy = x - near.position[k, j, 0], y - near.position[k, j, 1]
        radius = near.radius[j]
        gap = (dx * dx + dy * dy - radius * radius) / (2.0 * radius)
        if gap < cutoff:
            total += math.exp(-weights.steepness * gap)
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def _walls_touch(plan: Array, k: int, scales: Scales) -> float:
    """sum_i exp(-S_w g_i) of the walls within the box, and `CROSSING` for each that the way to stage k goes through."""
    total = 0.0
    for i in range(len(scales.segments)):
        x, y = to_wall(plan[k, X], plan[k, Y], scales.segments[i])
        total += math.exp(-scales.weights.wall_steepness * (math.hypot(x, y) - scales.body))
        if crosses(plan[k - 1, X], plan[k - 1, Y], plan[k, X], plan[k, Y], scales.segments[i]):
            total += CROSSING
    return total


@njit(cache=True, nogil=True, error_model="numpy")
def to_wall(x: float, y: float, segment: Array) -> tuple[float, float]:
    """From the point (x, y) to the nearest point of a (2, 2) segment [m]."""
    return nearest_on_segment(segment[0, 0] - x, segment[0, 1] - y, segment[1, 0] - x, segment[1, 1] - y)


@njit(cache=True, nogil=True, error_model="numpy")
def crosses(ax: float, ay: float, bx: float, by: float, segment: Array) -> bool:
    """Whether the way from a to b goes through a (2, 2) segment [m]."""
    px, py, qx, qy = segment[0, 0], segment[0, 1], segment[1, 0], segment[1, 1]
    p, q = (bx - ax) * (py - ay) - (by - ay) * (px - ax), (bx - ax) * (qy - ay) - (by - ay) * (qx - ax)
    a, b = (qx - px) * (ay - py) - (qy - py) * (ax - px), (qx - px) * (by - py) - (qy - py) * (bx - px)
    return bool(p * q < 0.0 and a * b < 0.0)


@njit(cache=True, nogil=True, error_model="numpy")
def choose_discs(plan: Array, near: Tracks, dt: float, radius: Array, disc: Array) -> None:
    """Write the discs that matter to `plan`, those of least min_k (clearance + LATER t_k), and where they are when.

    Args:
        plan: (N + 1, 7).
        near: of whom to choose, with R as radii.
        dt: time between two stages [s].
        radius: (K,) with K at least 1, for R [m]; that of somebody far away where there are not so many.
        disc: (N, K, 2) for the centres at the stages 1 to N [m].
    """
    most, stages = len(radius), len(plan) - 1
    chosen, urgency, count = np.empty(most, np.int64), np.empty(most), 0
    for j in range(len(near.radius)):
        least = np.inf
        for k in range(1, stages + 1):
            dx, dy = plan[k, X] - near.position[k, j, 0], plan[k, Y] - near.position[k, j, 1]
            least = min(least, math.sqrt(dx * dx + dy * dy) - near.radius[j] + LATER * k * dt)
        if count == most and least >= urgency[most - 1]:
            continue
        slot = min(count, most - 1)
        while slot > 0 and urgency[slot - 1] > least:
            chosen[slot], urgency[slot] = chosen[slot - 1], urgency[slot - 1]
            slot -= 1
        chosen[slot], urgency[slot] = j, least
        count = min(count + 1, most)
    radius[:], disc[:] = 1.0, FAR
    for slot in range(count):
        j = chosen[slot]
        radius[slot] = near.radius[j]
        for k in range(stages):
            disc[k, slot] = near.position[k + 1, j]


@njit(cache=True, nogil=True, error_model="numpy")
def choose_planes(plan: Array, scales: Scales, plane: Array) -> None:
    """Write the half-planes of the nearest walls, on whose side a plan is, at each of its stages.

    Args:
        plan: (N + 1, 7).
        scales: the walls, and the distance to keep.
        plane: (N, W, 3) for n_x, n_y, b [m]: n . p >= b; all of the plane where there are not so many walls.
    """
    plane[:] = 0.0
    plane[:, :, 2] = -FAR
    most = plane.shape[1]
    for k in range(len(plane)):
        x, y = plan[k + 1, X], plan[k + 1, Y]
        distances = np.full(most, np.inf)
        for i in range(len(scales.segments)):
            dx, dy = to_wall(x, y, scales.segments[i])
            distance = math.hypot(dx, dy)
            if most == 0 or distance >= distances[most - 1] or distance == 0.0:
                continue
            slot = most - 1
            while slot > 0 and distances[slot - 1] > distance:
                distances[slot] = distances[slot - 1]
                plane[k, slot] = plane[k, slot - 1]
                slot -= 1
            distances[slot] = distance
            nx, ny = -dx / distance, -dy / distance
            plane[k, slot] = nx, ny, nx * (x + dx) + ny * (y + dy) + scales.body
