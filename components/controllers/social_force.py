"""Social forces: the robot is drawn to its goal and pushed off by people, walls and other robots.

With R from the neighbour to the robot, W = (v_neighbour - v_robot) T, 2 b = sqrt((|R| + |R - W|)^2 - |W|^2):

    F = (v_pref - v) / tau - sum grad A exp(-b / B) + sum_walls A_w exp(-(d - r) / B_w) n
    V = v + tau F,  driven as `differential.py` says

The potential is the elliptical specification II of Johansson, Helbing and Shukla, "Specification of the social force
pedestrian model by evolutionary adjustment to video tracking data", Advances in Complex Systems 10, 2007; b is the
semi-minor axis of the ellipse that the neighbour's way of the next T seconds spans. Social forces as a robot's
controller: Ferrer, Garrell, Sanfeliu, "Robot companion: a social-force based approach with human awareness-navigation
in crowded environments", IROS 2013.

Not in the papers: a neighbour straight ahead counts as a little to one side, since exact symmetry has no gradient;
people behind count as much as those ahead.
Differs from the papers: the robot follows the velocity that the force asks for, not the force: its drive is not a mass;
b is measured from the bodies' contact, so that large robots keep off as far as small ones.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.differential import drive, without_retreat
from components.controllers.ego import Ego, command, ego_of, heading_error, turn, way_to
from components.controllers.options import require_not_negative, require_positive
from components.controllers.sight import People, Sight
from components.controllers.surroundings import Discs, discs_of, frozen, nearest_image, nearest_on_segment
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, Odometry, RobotState, Twist

Array = NDArray[np.float64]

OFF_AXIS = 0.01
"""least distance of a neighbour from the line through the robot along the way to the goal [m]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of the social forces."""

    people_from: People = "truth"
    """where the robot knows people from"""
    relaxation: float = 0.5
    """tau, within which the robot takes on the velocity that it prefers [s]"""
    strength: float = 0.5
    """A, of the potential of a person [m2/s2]"""
    length: float = 0.2
    """B, over which that falls by e [m]"""
    anticipation: float = 1.0
    """T, for how long the others' way counts [s]"""
    wall_strength: float = 5.0
    """A_w, acceleration at a wall [m/s2]"""
    wall_length: float = 0.1
    """B_w, over which that falls by e [m]"""
    range: float = 5.0
    """how far neighbours are felt, from centre to centre [m]"""

    def __post_init__(self) -> None:
        require_positive(self, "relaxation", "length", "anticipation", "wall_length", "range")
        require_not_negative(self, "strength", "wall_strength")


class Forces(NamedTuple):
    """What the forces go by: the options, and the robot's limits."""

    relaxation: float
    strength: float
    length: float
    anticipation: float
    wall_strength: float
    wall_length: float
    range: float
    body: float
    """radius [m]"""
    max_speed: float


class SocialForce(Controller):
    """A robot among social forces."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits and the walls, and load the kernels."""
        config, model = self._config, setup.own_robot.model
        self._sight = Sight(config.people_from, setup)
        self._walls = frozen(setup.world.segments)
        self._period = frozen(setup.world.period)
        self._max_turn_rate = model.max_angular_velocity
        self._forces = Forces(
            relaxation=config.relaxation,
            strength=config.strength,
            length=config.length,
            anticipation=config.anticipation,
            wall_strength=config.wall_strength,
            wall_length=config.wall_length,
            range=config.range,
            body=model.radius,
            max_speed=model.max_speed,
        )
        nobody = discs_of(Crowd(), (), "")
        wished_velocity(Ego(0.0, 0.0, 0.0, 0.0, 0.0), 0.0, nobody, self._walls, self._period, self._forces)

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
    ) -> Twist:
        """Towards the velocity that the forces ask for; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        if way is None:
            return command(0.0, 0.0)
        x, y = wished_velocity(ego, way.bearing, discs, self._walls, self._period, self._forces)
        speed, direction = drive(*without_retreat(x, y, way.bearing), ego.heading)
        return command(speed, turn(heading_error(direction, ego.heading), self._max_turn_rate))


@njit(cache=True, nogil=True, error_model="numpy")
def wished_velocity(
    ego: Ego, bearing: float, discs: Discs, walls: Array, period: Array, forces: Forces
) -> tuple[float, float]:
    """V = v + tau F, no faster than the robot can be [m/s].

    Args:
        ego: pose and speed of the robot.
        bearing: direction of the goal [rad].
        discs: people and other robots.
        walls: (W, 2, 2) both ends of every wall [m].
        period: (2,) period of each axis, 0 for none [m].
        forces: options and limits.
    """
    vx, vy = ego.speed * math.cos(ego.heading), ego.speed * math.sin(ego.heading)
    ahead_x, ahead_y = math.cos(bearing), math.sin(bearing)
    # v + tau (v_pref - v) / tau
    x, y = forces.max_speed * ahead_x, forces.max_speed * ahead_y
    for i in range(len(discs.radius)):
        dx, dy = discs.position[i, 0] - ego.x, discs.position[i, 1] - ego.y
        if i < discs.people:
            dx, dy = nearest_image(dx, period[0]), nearest_image(dy, period[1])
        if math.hypot(dx, dy) > forces.range:
            continue
        aside = ahead_x * dy - ahead_y * dx
        if abs(aside) < OFF_AXIS:
            shift = math.copysign(OFF_AXIS, aside) - aside
            dx, dy = dx - shift * ahead_y, dy + shift * ahead_x
        contact = forces.body + discs.radius[i]
        fx, fy = repulsion(-dx, -dy, discs.velocity[i, 0] - vx, discs.velocity[i, 1] - vy, contact, forces)
        x, y = x + forces.relaxation * fx, y + forces.relaxation * fy
    for i in range(len(walls)):
        ax, ay = walls[i, 0, 0] - ego.x, walls[i, 0, 1] - ego.y
        bx, by = walls[i, 1, 0] - ego.x, walls[i, 1, 1] - ego.y
        wx, wy = nearest_on_segment(ax, ay, bx, by)
        distance = math.hypot(wx, wy)
        if distance > 0.0:
            push = forces.wall_strength * math.exp(-max(0.0, distance - forces.body) / forces.wall_length) / distance
            x, y = x - forces.relaxation * push * wx, y - forces.relaxation * push * wy
    shorten = forces.max_speed / max(forces.max_speed, math.hypot(x, y))
    return shorten * x, shorten * y


@njit(cache=True, nogil=True, error_model="numpy")
def repulsion(rx: float, ry: float, vx: float, vy: float, contact: float, forces: Forces) -> tuple[float, float]:
    """Acceleration that a neighbour gives the robot [m/s2].

    Args:
        rx: R, from the neighbour to the robot [m].
        ry: [m]
        vx: velocity of the neighbour relative to the robot [m/s].
        vy: [m/s]
        contact: sum of the radii [m].
        forces: options.
    """
    wx, wy = vx * forces.anticipation, vy * forces.anticipation
    qx, qy = rx - wx, ry - wy
    r, q, way = math.hypot(rx, ry), math.hypot(qx, qy), math.hypot(wx, wy)
    s = r + q
    squared = (s - way) * (s + way)
    if not (squared > 0.0 and r > 0.0 and q > 0.0):
        return 0.0, 0.0
    b = 0.5 * math.sqrt(squared)
    f = forces.strength / forces.length * math.exp(-max(0.0, b - contact) / forces.length) * s / (4.0 * b)
    return f * (rx / r + qx / q), f * (ry / r + qy / q)
