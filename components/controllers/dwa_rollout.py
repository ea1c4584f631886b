"""The dynamic window approach by simulation, as PythonRobotics has it and the authors of the benchmark ran it.

    C = a_goal |e| + a_speed (v_max - v) + a_obstacle max_jk 1 / d_jk,  infinite where d_jk < contact

over a grid of the velocities that can be reached within dt, each held for the horizon in steps of dt; e is the angle
to the goal at its end, d_jk the distance to the centre of obstacle j at step k, obstacles stand. The least C wins.
Sakai et al., "PythonRobotics: a Python code collection of robotics algorithms", 2018; after Fox, Burgard, Thrun, "The
dynamic window approach to collision avoidance", IEEE Robotics & Automation Magazine 4(1), 1997, from which it differs
in its objective, and in that nothing asks whether the robot can still brake: `dwa.py` follows the paper.

Known flaws that are kept, being what others measured: 1/d is of centres, so that large bodies look far; it may stand
still for ever (github.com/AtsushiSakai/PythonRobotics/issues/379), out of which it is made to turn.
Differs from their code: walls count at their nearest point; of equal costs the first wins.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.dwa import window
from components.controllers.ego import Ego, Way, command, ego_of, way_to
from components.controllers.options import require_not_negative, require_positive
from components.controllers.sight import PeopleOrScan, Sight
from components.controllers.surroundings import Discs, discs_of, frozen, nearest_image, nearest_on_segment
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, LaserScan, Odometry, RobotState, Twist

Array = NDArray[np.float64]

STUCK = 0.001
"""speeds below which the robot is stuck, and then turns at its greatest change of turn rate [m/s]"""


@dataclass(frozen=True, kw_only=True)
class CrowdBotConfig:
    """Options, with the settings of the benchmark's authors."""

    people_from: PeopleOrScan = "truth"
    """where the robot knows obstacles from"""
    mount: str | None = None
    """of `scan`: the mount on the robot that the scanner sits on; None: the base's centre, facing ahead"""
    min_speed: float = -1.0
    """[m/s]"""
    max_speed: float = 1.0
    """[m/s]"""
    max_turn_rate: float = 1.0
    """[rad/s]"""
    max_acceleration: float = 0.5
    """[m/s2]"""
    max_angular_acceleration: float = 10.0
    """[rad/s2]"""
    speed_resolution: float = 0.01
    """[m/s]"""
    turn_rate_resolution: float = 0.02
    """[rad/s]"""
    step: float = 0.1
    """dt, of the window and of the simulation [s]"""
    horizon: float = 3.0
    """for how long a velocity is held [s]"""
    goal_gain: float = 0.15
    """a_goal [1/rad]"""
    speed_gain: float = 1.0
    """a_speed [s/m]"""
    obstacle_gain: float = 1.0
    """a_obstacle [m]"""
    contact: float = 0.3
    """distance of an obstacle's centre below which a velocity is forbidden [m]"""
    sight: float = 0.6
    """distance beyond which an obstacle costs nothing; infinite if zero [m]"""

    def __post_init__(self) -> None:
        positive = ("max_speed", "max_turn_rate", "max_acceleration", "max_angular_acceleration", "speed_resolution")
        require_positive(self, *positive, "turn_rate_resolution", "step", "horizon")
        require_not_negative(self, "goal_gain", "speed_gain", "obstacle_gain", "contact", "sight")
        if not self.min_speed <= 0:
            raise ValueError(f"min_speed is {self.min_speed}, expected zero or a negative number")


@dataclass(frozen=True, kw_only=True)
class PythonRoboticsConfig(CrowdBotConfig):
    """Options, with PythonRobotics' own settings."""

    min_speed: float = -0.5
    """[m/s]"""
    max_turn_rate: float = math.radians(40.0)
    """[rad/s]"""
    max_acceleration: float = 0.2
    """[m/s2]"""
    max_angular_acceleration: float = math.radians(40.0)
    """[rad/s2]"""
    turn_rate_resolution: float = math.radians(0.1)
    """[rad/s]"""
    contact: float = 1.0
    """distance of an obstacle's centre below which a velocity is forbidden [m]"""
    sight: float = 0.0
    """distance beyond which an obstacle costs nothing; infinite if zero [m]"""


class Search(NamedTuple):
    """What one search goes by."""

    max_speed: float
    speed_resolution: float
    turn_rate_resolution: float
    step: float
    steps: int
    goal_gain: float
    speed_gain: float
    obstacle_gain: float
    contact: float
    sight: float


class CrowdBotDWA(Controller):
    """PythonRobotics' dynamic window approach with the gains of the benchmark's authors."""

    def __init__(self, config: CrowdBotConfig) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the walls, and load the kernel."""
        config = self._config
        self._sight = Sight(config.people_from, setup, config.mount)
        self._walls = frozen(setup.world.segments if config.people_from != "scan" else np.empty((0, 2, 2)))
        self._period = frozen(setup.world.period)
        self._search = Search(
            max_speed=config.max_speed,
            speed_resolution=config.speed_resolution,
            turn_rate_resolution=config.turn_rate_resolution,
            step=config.step,
            steps=max(1, round(config.horizon / config.step)),
            goal_gain=config.goal_gain,
            speed_gain=config.speed_gain,
            obstacle_gain=config.obstacle_gain,
            contact=config.contact,
            sight=config.sight or math.inf,
        )
        self._decide(Ego(0.0, 0.0, 0.0, 0.0, 0.0), Way(1.0, 0.0, 0.0), discs_of(Crowd(), (), ""))

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
        scan: LaserScan | None = None,
    ) -> Twist:
        """The cheapest velocity of the window; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections, scan)
        if way is None:
            return command(0.0, 0.0)
        return command(*self._decide(ego, way, discs))

    def _decide(self, ego: Ego, way: Way, discs: Discs) -> tuple[float, float]:
        config = self._config
        change, turn_change = config.max_acceleration * config.step, config.max_angular_acceleration * config.step
        slow, fast = window(ego.speed, change, config.min_speed, config.max_speed)
        right, left = window(ego.turn_rate, turn_change, -config.max_turn_rate, config.max_turn_rate)
        points = obstacle_points(ego, discs, self._walls, self._period, config.max_speed * config.horizon + 5.0)
        speed, turn_rate = cheapest(ego, way, points, slow, fast, right, left, self._search)
        if abs(speed) < STUCK and abs(ego.speed) < STUCK:
            turn_rate = -turn_change
        return speed, turn_rate


class PythonRoboticsDWA(CrowdBotDWA):
    """PythonRobotics' dynamic window approach with its own settings."""

    def __init__(self, config: PythonRoboticsConfig) -> None:
        super().__init__(config)


@njit(cache=True, nogil=True, error_model="numpy")
def obstacle_points(ego: Ego, discs: Discs, walls: Array, period: Array, reach: float) -> Array:
    """(M, 2) centres of discs and nearest points of walls within `reach`, relative to the robot's position [m]."""
    points, m = np.empty((len(discs.radius) + len(walls), 2)), 0
    for i in range(len(discs.radius)):
        x, y = discs.position[i, 0] - ego.x, discs.position[i, 1] - ego.y
        if i < discs.people:
            x, y = nearest_image(x, period[0]), nearest_image(y, period[1])
        if math.hypot(x, y) <= reach:
            points[m] = x, y
            m += 1
    for i in range(len(walls)):
        ax, ay = walls[i, 0, 0] - ego.x, walls[i, 0, 1] - ego.y
        bx, by = walls[i, 1, 0] - ego.x, walls[i, 1, 1] - ego.y
        x, y = nearest_on_segment(ax, ay, bx, by)
        if math.hypot(x, y) <= reach:
            points[m] = x, y
            m += 1
    return points[:m]


@njit(cache=True, nogil=True, error_model="numpy")
def cheapest(
    ego: Ego, way: Way, points: Array, slow: float, fast: float, right: float, left: float, search: Search
) -> tuple[float, float]:
    """The velocity of least cost; standing if all are forbidden.

    Args:
        ego: pose and speeds of the robot.
        way: from the robot to its goal.
        points: (M, 2) obstacles, relative to the robot's position [m].
        slow: window [m/s].
        fast: [m/s]
        right: [rad/s]
        left: [rad/s]
        search: settings.
    """
    least, best_v, best_omega = np.inf, 0.0, 0.0
    speeds = int((fast - slow) / search.speed_resolution + 1e-9) + 1
    rates = int((left - right) / search.turn_rate_resolution + 1e-9) + 1
    for i in range(speeds):
        v = slow + i * search.speed_resolution
        for j in range(rates):
            omega = right + j * search.turn_rate_resolution
            x, y, theta, square = 0.0, 0.0, ego.heading, np.inf
            for _ in range(search.steps):
                theta += omega * search.step
                x += v * search.step * math.cos(theta)
                y += v * search.step * math.sin(theta)
                for k in range(len(points)):
                    square = min(square, (points[k, 0] - x) ** 2 + (points[k, 1] - y) ** 2)
                if square < search.contact * search.contact:
                    break
            distance = math.sqrt(square)
            if distance < search.contact:
                continue
            error = math.atan2(way.y - way.weight * y, way.x - way.weight * x) - theta
            cost = search.goal_gain * abs(error - math.tau * np.rint(error / math.tau))
            cost += search.speed_gain * (search.max_speed - v)
            if distance <= search.sight:
                cost += search.obstacle_gain / distance
            if cost < least:
                least, best_v, best_omega = cost, v, omega
    return best_v, best_omega
