"""The dynamic window approach: of the velocities within reach, the best whose arc leaves room to brake.

    G(v, omega) = alpha heading + beta dist + gamma velocity

over the velocities that the robot can have after one period (the dynamic window) and from which it can stop in time
when it brakes after that period, v <= sqrt(2 (dist - v dt) a) (admissible). `heading` is 1 - |e| / pi, with e the angle
to the goal from where the robot would be after one period and then braking; `dist` the arc length up to the first
contact, and `velocity` the speed, both over their maxima. People and other robots are standing discs.

Fox, Burgard, Thrun, "The dynamic window approach to collision avoidance", IEEE Robotics & Automation Magazine 4(1),
1997: objective (13), admissible velocities (14), dynamic window (15).

Not in the paper: an inflated body; dist of standing velocities, which is zero: a robot that stands clears nothing, and
would otherwise stand rather than pass an obstacle; what to do when every arc is blocked: the robot turns on the spot,
away from the nearest obstacle, until one is free.
Differs from the paper: dist is exact, for discs and segments (`arc.py`); the way driven before the next decision is
taken off it, so that the robot stops in time whatever its period; the objective is not smoothed over the window; no
bound on omega by dist, since a disc that turns on the spot hits nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.arc import clearance, obstacles_near
from components.controllers.ego import Ego, Way, command, ego_of, way_to
from components.controllers.sight import PeopleOrScan, Sight
from components.controllers.surroundings import Discs, discs_of, frozen
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, LaserScan, Odometry, RobotState, Twist

Array = NDArray[np.float64]

STANDING = 1e-3
"""speed below which a robot stands [m/s]"""
SPIN = 1.0
"""turn rate of a robot that is blocked [rad/s]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of the dynamic window approach."""

    people_from: PeopleOrScan = "truth"
    """where the robot knows obstacles from"""
    mount: str | None = None
    """of `scan`: the mount on the robot that the scanner sits on; None: the base's centre, facing ahead"""
    heading: float = 0.8
    """alpha, weight of the angle to the goal"""
    clearance: float = 0.1
    """beta, weight of the distance to the first contact"""
    velocity: float = 0.1
    """gamma, weight of the speed"""
    horizon: float = 3.0
    """distance to the first contact beyond which more is no better [m]"""
    inflation: float = 0.05
    """added to the robot's radius [m]"""
    braking: float = 0.4
    """share of the robot's braking that it counts on to stop in time"""
    speeds: int = 11
    """samples of v across the window"""
    turn_rates: int = 31
    """samples of omega across the window"""

    def __post_init__(self) -> None:
        for name in ("heading", "clearance", "velocity", "inflation"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected zero or more")
        if not self.horizon > 0:
            raise ValueError(f"horizon is {self.horizon}, expected a positive number")
        if not 0 < self.braking <= 1:
            raise ValueError(f"braking is {self.braking}, expected a share above 0 and up to 1")
        for name in ("speeds", "turn_rates"):
            if not getattr(self, name) >= 2:
                raise ValueError(f"{name} is {getattr(self, name)}, expected at least 2, both ends of the window")


class Search(NamedTuple):
    """What one search of the window goes by: the options, and the robot's limits."""

    heading: float
    clearance: float
    velocity: float
    horizon: float
    speeds: int
    turn_rates: int
    dt: float
    """period [s]"""
    body: float
    """radius with inflation [m]"""
    braking: float
    """deceleration counted on [m/s2]"""
    max_speed: float
    max_acceleration: float
    max_turn_rate: float
    max_angular_acceleration: float


class Choice(NamedTuple):
    """The velocity to command."""

    speed: float
    """[m/s]"""
    turn_rate: float
    """[rad/s]"""
    blocked: bool
    """every arc in the window that moves the robot is inadmissible"""
    right: float
    """lowest turn rate in the window [rad/s]"""
    left: float
    """highest turn rate in the window [rad/s]"""
    nearest_y: float
    """y of the nearest obstacle in the robot's frame [m], NaN if there is none"""


class DWA(Controller):
    """Fox's dynamic window approach, for a differential drive among people who are taken to stand."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits and the walls, and load the kernels."""
        config, model = self._config, setup.own_robot.model
        self._sight = Sight(config.people_from, setup, config.mount)
        # A scan shows walls too.
        self._walls = frozen(setup.world.segments if config.people_from != "scan" else np.empty((0, 2, 2)))
        self._period = frozen(setup.world.period)
        self._search = Search(
            heading=config.heading,
            clearance=config.clearance,
            velocity=config.velocity,
            horizon=config.horizon,
            speeds=config.speeds,
            turn_rates=config.turn_rates,
            dt=setup.dt,
            body=model.radius + config.inflation,
            braking=config.braking * model.max_acceleration,
            max_speed=model.max_speed,
            max_acceleration=model.max_acceleration,
            max_turn_rate=model.max_angular_velocity,
            max_angular_acceleration=model.max_angular_acceleration,
        )
        self._side = 0.0
        nobody = discs_of(Crowd(), (), "")
        best_velocity(Ego(0.0, 0.0, 0.0, 0.0, 0.0), Way(1.0, 0.0, 0.0), nobody, self._walls, self._period, self._search)

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
        scan: LaserScan | None = None,
    ) -> Twist:
        """The best admissible velocity of the window; a turn on the spot where there is none; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections, scan)
        if way is None:
            return command(0.0, 0.0)
        choice = best_velocity(ego, way, discs, self._walls, self._period, self._search)
        return command(choice.speed, self._turn_rate(choice))

    def _turn_rate(self, choice: Choice) -> float:
        if not choice.blocked:
            self._side = 0.0
            return choice.turn_rate
        if self._side == 0.0:
            self._side = -1.0 if choice.nearest_y > 0.0 else 1.0
        return max(choice.right, min(choice.left, self._side * SPIN))


@njit(cache=True, nogil=True, error_model="numpy")
def best_velocity(ego: Ego, way: Way, discs: Discs, walls: Array, period: Array, search: Search) -> Choice:
    """Score the samples of the dynamic window, and take the first of the best.

    Args:
        ego: pose and speeds of the robot.
        way: from the robot to its goal.
        discs: people and other robots.
        walls: (W, 2, 2) both ends of every wall [m].
        period: (2,) period of each axis, 0 for none [m].
        search: options and limits.
    """
    # Nearer contacts than the longest way to stop decide what is admissible, even if they no longer count for dist.
    stopping = search.max_speed * (search.dt + search.max_speed / (2.0 * search.braking))
    reach = max(search.horizon, stopping)
    obstacles = obstacles_near(ego, discs, walls, period, search.body, reach)
    lowest, highest = window(ego.speed, search.max_acceleration * search.dt, 0.0, search.max_speed)
    right, left = window(
        ego.turn_rate, search.max_angular_acceleration * search.dt, -search.max_turn_rate, search.max_turn_rate
    )
    best, blocked, best_v, best_omega = -np.inf, True, lowest, 0.5 * (right + left)
    for i in range(search.speeds):
        v = sample(lowest, highest, i, search.speeds)
        for j in range(search.turn_rates):
            omega = sample(right, left, j, search.turn_rates)
            dist = 0.0
            if v > STANDING:
                dist = min(reach, clearance(omega / v, obstacles))
                if not admissible(v, dist, search.dt, search.braking):
                    continue
                blocked = False
            score = (
                search.heading * heading(ego, way, v, omega, search)
                + search.clearance * min(1.0, dist / search.horizon)
                + search.velocity * v / search.max_speed
            )
            if score > best:
                best, best_v, best_omega = score, v, omega
    return Choice(best_v, best_omega, blocked, right, left, obstacles.nearest_y)


@njit(cache=True, nogil=True, error_model="numpy")
def window(now: float, change: float, lowest: float, highest: float) -> tuple[float, float]:
    """What a speed can be after one period: within `change` of what it is `now`, as far as its limits allow."""
    return min(highest, max(lowest, now - change)), max(lowest, min(highest, now + change))


@njit(cache=True, nogil=True, error_model="numpy")
def sample(first: float, last: float, i: int, count: int) -> float:
    """The i-th of `count` values evenly spaced from `first` to `last`; both ends are hit exactly."""
    share = i / (count - 1)
    return (1.0 - share) * first + share * last


@njit(cache=True, nogil=True, error_model="numpy")
def admissible(v: float, dist: float, dt: float, braking: float) -> bool:
    """Whether a robot that drives at v [m/s] for dt [s] and then brakes at `braking` [m/s2] stops within dist [m]."""
    return v * v <= 2.0 * (dist - v * dt) * braking


@njit(cache=True, nogil=True, error_model="numpy")
def heading(ego: Ego, way: Way, v: float, omega: float, search: Search) -> float:
    """1 - |e| / pi, e the angle to the goal where the robot is after one period at (v, omega) and then braking."""
    ahead = v * search.dt + v * v / (2.0 * search.max_acceleration)
    turned = omega * search.dt
    if search.max_angular_acceleration > 0.0:
        turned += omega * abs(omega) / (2.0 * search.max_angular_acceleration)
    middle = ego.heading + 0.5 * turned
    x = way.x - way.weight * ahead * math.cos(middle)
    y = way.y - way.weight * ahead * math.sin(middle)
    error = math.atan2(y, x) - ego.heading - turned
    return float(1.0 - abs(error - math.tau * np.rint(error / math.tau)) / math.pi)
