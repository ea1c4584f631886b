"""Optimal reciprocal collision avoidance (ORCA) for a differential drive, by default one that brakes rather than flees.

Each neighbour takes a half-plane from the robot's velocities: with u the least change that brings the relative
velocity out of the cone of velocities that collide within tau, the robot takes half of it,

    (v - (v_robot + u / 2)) . n >= 0,  n the outward normal of the cone there.

A wall at distance d with normal n leaves  v . n <= (d - r) / tau_wall. Among what is left, ORCA's linear programs give
the velocity V nearest to the preferred one, v_pref, which is straight at the goal (`half_planes.py`). Then, as `drive`
says, with e from the heading to V,

    brake     V <- V without its part against v_pref,  v = max(0, |V| cos e),  omega = 2 e
    nh_orca   v = |V| e sin e / (2 (1 - cos e)),  omega = e / T:  the arc that is where V leads to after T
    orca_dd   v = V_forward,  omega = V_left / D:  a point D ahead of the axle moves at V
    heading   v = |V|,  omega = e / 1 s

van den Berg, Guy, Lin, Manocha, "Reciprocal n-body collision avoidance", ISRR 2009, section 4. nh_orca: Alonso-Mora,
Breitenmoser, Rufli, Beardsley, Siegwart, "Optimal reciprocal collision avoidance for multiple non-holonomic robots",
DARS 2010, equations (4) and (5). orca_dd: Snape, van den Berg, Guy, Manocha, "Smooth and collision-free navigation for
multiple robots under differential-drive constraints", IROS 2010, section III. heading: as the authors of the benchmark
drove RVO2 (`rvo_crowdbot.py`).

Not in the paper: a margin around the robot; all of u, not half of it, for a neighbour who stands and so avoids nobody;
a neighbour straight ahead on the way to the goal counts as a little to one side, since exact symmetry makes ORCA stop
and wait for good; v never so large that the robot, which moves along its heading and not along V, would break the
half-plane of a wall or of somebody who stands (brake only).
Differs from the paper: the half-plane of a wall lies across the line of sight to its nearest point; the robot is not
holonomic, and all but brake back away from a dense crowd that comes towards the robot: brake waits, turns, and then
drives. nh_orca enlarges the body by `error`, but does not bound V to the velocities that it follows within that error.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.differential import STANDING, drive, without_retreat
from components.controllers.ego import Ego, command, ego_of, heading_error, turn, way_to
from components.controllers.half_planes import best_velocity, escape
from components.controllers.sight import People, Sight
from components.controllers.surroundings import Discs, discs_of, frozen, nearest_image, nearest_on_segment
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, Odometry, RobotState, Twist

Array = NDArray[np.float64]

AT_REST = 0.1
"""speed below which a neighbour stands [m/s]"""
OFF_AXIS = 0.01
"""least distance of a neighbour from the line through the robot along the way to the goal [m]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of reciprocal avoidance."""

    people_from: People = "truth"
    """where the robot knows people from"""
    horizon: float = 1.5
    """tau, for how long the robot wants to be free of collisions with neighbours [s]"""
    wall_horizon: float = 1.0
    """tau_wall, and with walls [s]"""
    neighbours: int = 5
    """how many, at most, are avoided, the nearest first"""
    range: float = 5.0
    """how far neighbours are seen, from centre to centre [m]"""
    margin: float = 0.02
    """added to the robot's radius [m]"""
    share: float = 0.5
    """how much of the avoidance of somebody who walks the robot takes; half is reciprocal, 1 is all of it"""

    drive: Literal["brake", "nh_orca", "orca_dd", "heading"] = "brake"
    """how the robot follows the velocity that ORCA asks for"""
    catch_up: float = 0.4
    """T of `nh_orca` [s]"""
    error: float = 0.05
    """of `nh_orca`: distance from V's way that the arc may have, added to the radius [m]"""
    lead: float = 0.15
    """D of `orca_dd`, how far ahead of the axle the point is that moves at V, added to the radius [m]"""
    radius: float | None = None
    """of the robot, None for its own [m]"""
    person_radius: float | None = None
    """of everybody, None for their own [m]"""
    overlap_time: float | None = None
    """within which to part from who is touched, None for one period [s]"""

    def __post_init__(self) -> None:
        for name in ("radius", "person_radius", "overlap_time"):
            if getattr(self, name) is not None and not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")
        for name in ("horizon", "wall_horizon", "range", "catch_up", "lead"):
            if not getattr(self, name) > 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected a positive number")
        if not self.neighbours >= 0:
            raise ValueError(f"neighbours is {self.neighbours}, expected zero or more")
        for name in ("margin", "error"):
            if not getattr(self, name) >= 0:
                raise ValueError(f"{name} is {getattr(self, name)}, expected zero or more")
        if not 0 <= self.share <= 1:
            raise ValueError(f"share is {self.share}, expected 0 to 1")


class Avoidance(NamedTuple):
    """What the avoidance goes by: the options, and the robot's limits."""

    horizon: float
    wall_horizon: float
    neighbours: int
    range: float
    share: float
    dt: float
    """within which to part from who is touched [s]"""
    body: float
    """radius with margin [m]"""
    max_speed: float


class RVO(Controller):
    """ORCA for a differential drive: predicts people, and expects half of the avoidance from them."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits and the walls, and load the kernels."""
        config, model = self._config, setup.own_robot.model
        self._sight = Sight(config.people_from, setup)
        self._walls = frozen(setup.world.segments)
        self._period = frozen(setup.world.period)
        self._max_turn_rate = model.max_angular_velocity
        extra = {"nh_orca": config.error, "orca_dd": config.lead}.get(config.drive, 0.0)
        self._avoidance = Avoidance(
            horizon=config.horizon,
            wall_horizon=config.wall_horizon,
            neighbours=config.neighbours,
            range=config.range,
            share=config.share,
            dt=config.overlap_time or setup.dt,
            body=(config.radius or model.radius) + config.margin + extra,
            max_speed=model.max_speed,
        )
        self._decide(Ego(0.0, 0.0, 0.0, 0.0, 0.0), 0.0, discs_of(Crowd(), (), ""))

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
    ) -> Twist:
        """Towards the velocity that ORCA asks for; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        if way is None:
            return command(0.0, 0.0)
        if self._config.person_radius is not None:
            discs = discs._replace(radius=frozen(np.full(len(discs.radius), self._config.person_radius)))
        speed, turn_rate = self._decide(ego, way.bearing, discs)
        return command(speed, max(-self._max_turn_rate, min(self._max_turn_rate, turn_rate)))

    def _decide(self, ego: Ego, bearing: float, discs: Discs) -> tuple[float, float]:
        """Speed [m/s] and turn rate [rad/s], which may be more than the robot can do."""
        config, cos, sin = self._config, math.cos(ego.heading), math.sin(ego.heading)
        vx, vy, point = ego.speed * cos, ego.speed * sin, ego
        if config.drive == "orca_dd":
            along = ego.turn_rate * config.lead
            vx, vy = vx - along * sin, vy + along * cos
            point = ego._replace(x=ego.x + config.lead * cos, y=ego.y + config.lead * sin)
        x, y, planes, binding = safe_velocity(point, vx, vy, bearing, discs, self._walls, self._period, self._avoidance)
        if config.drive == "brake":
            speed, direction = brake(ego.heading, bearing, x, y, planes, binding)
            return speed, turn(heading_error(direction, ego.heading), self._max_turn_rate)
        if config.drive == "orca_dd":
            return x * cos + y * sin, (y * cos - x * sin) / config.lead
        error = heading_error(math.atan2(y, x), ego.heading) if math.hypot(x, y) > STANDING else 0.0
        if config.drive == "heading":
            return math.hypot(x, y), error
        # e sin e / (2 (1 - cos e)) is e / (2 tan(e / 2)), and 1 straight ahead.
        share = 0.5 * error / math.tan(0.5 * error) if error else 1.0
        return math.hypot(x, y) * share, error / config.catch_up


@njit(cache=True, nogil=True, error_model="numpy")
def safe_velocity(
    ego: Ego,
    vx: float,
    vy: float,
    bearing: float,
    discs: Discs,
    walls: Array,
    period: Array,
    avoidance: Avoidance,
) -> tuple[float, float, Array, NDArray[np.bool_]]:
    """The velocity V nearest to the preferred one.

    Args:
        ego: position of the robot.
        vx: its velocity [m/s].
        vy: [m/s]
        bearing: direction of the goal [rad].
        discs: people and other robots.
        walls: (W, 2, 2) both ends of every wall [m].
        period: (2,) period of each axis, 0 for none [m].
        avoidance: options and limits.

    Returns:
        V [m/s]; (P, 3) the half-planes n_x, n_y, b: n . v <= b [m/s]; (P,) which are of walls or of who stands.
    """
    ahead_x, ahead_y = math.cos(bearing), math.sin(bearing)
    planes = np.empty((len(walls) + avoidance.neighbours, 3))
    binding = np.zeros(len(planes), np.bool_)
    hard = _put_wall_planes(ego, walls, avoidance, planes)
    binding[:hard] = True
    near, count = nearest_discs(ego, discs, period, avoidance.neighbours, avoidance.range)
    for k in range(count):
        i = near[k]
        x, y = displacement(ego, discs, i, period)
        aside = ahead_x * y - ahead_y * x
        if abs(aside) < OFF_AXIS:
            shift = math.copysign(OFF_AXIS, aside) - aside
            x, y = x - shift * ahead_y, y + shift * ahead_x
        wx, wy = discs.velocity[i, 0], discs.velocity[i, 1]
        contact = avoidance.body + discs.radius[i]
        ux, uy, nx, ny = escape(x, y, vx - wx, vy - wy, contact, avoidance.horizon, avoidance.dt)
        binding[hard + k] = math.hypot(wx, wy) < AT_REST
        share = 1.0 if binding[hard + k] else avoidance.share
        planes[hard + k] = -nx, -ny, -(nx * (vx + share * ux) + ny * (vy + share * uy))
    max_speed = avoidance.max_speed
    x, y = best_velocity(planes[: hard + count], hard, max_speed, max_speed * ahead_x, max_speed * ahead_y)
    return x, y, planes[: hard + count], binding[: hard + count]


@njit(cache=True, nogil=True, error_model="numpy")
def brake(
    heading: float, bearing: float, x: float, y: float, planes: Array, binding: NDArray[np.bool_]
) -> tuple[float, float]:
    """How fast to drive along the heading [m/s], and the direction to turn to [rad], for V = (x, y) [m/s].

    Args:
        heading: of the robot [rad].
        bearing: direction of the goal [rad].
        x: V [m/s].
        y: [m/s]
        planes: half-planes as `safe_velocity` gives them.
        binding: which of them the speed along the heading must obey.
    """
    speed, direction = drive(*without_retreat(x, y, bearing), heading)
    facing_x, facing_y = math.cos(heading), math.sin(heading)
    for k in range(len(planes)):
        closing = planes[k, 0] * facing_x + planes[k, 1] * facing_y
        if binding[k] and closing > 0.0:
            speed = min(speed, max(0.0, planes[k, 2]) / closing)
    return speed, direction


@njit(cache=True, nogil=True, error_model="numpy")
def displacement(ego: Ego, discs: Discs, i: int, period: Array) -> tuple[float, float]:
    """From the robot to disc i [m]; people are seen across the seam."""
    x, y = discs.position[i, 0] - ego.x, discs.position[i, 1] - ego.y
    if i < discs.people:
        return nearest_image(x, period[0]), nearest_image(y, period[1])
    return x, y


@njit(cache=True, nogil=True, error_model="numpy")
def nearest_discs(ego: Ego, discs: Discs, period: Array, most: int, reach: float) -> tuple[NDArray[np.int64], int]:
    """(most,) numbers of the nearest discs, near to far, whose centres are within `reach` [m], and how many."""
    near, squares, count = np.empty(most, np.int64), np.empty(most), 0
    limit = reach * reach
    for i in range(len(discs.radius)):
        x, y = displacement(ego, discs, i, period)
        square = x * x + y * y
        if square > limit or most == 0:
            continue
        k = min(count, most - 1)
        while k > 0 and squares[k - 1] > square:
            near[k], squares[k] = near[k - 1], squares[k - 1]
            k -= 1
        near[k], squares[k] = i, square
        count = min(count + 1, most)
        if count == most:
            limit = min(limit, squares[most - 1])
    return near, count


@njit(cache=True, nogil=True, error_model="numpy")
def _put_wall_planes(ego: Ego, walls: Array, avoidance: Avoidance, planes: Array) -> int:
    """Write a half-plane for every wall that can be reached within its horizon; how many."""
    count = 0
    for i in range(len(walls)):
        ax, ay = walls[i, 0, 0] - ego.x, walls[i, 0, 1] - ego.y
        bx, by = walls[i, 1, 0] - ego.x, walls[i, 1, 1] - ego.y
        x, y = nearest_on_segment(ax, ay, bx, by)
        distance = math.hypot(x, y)
        room = max(0.0, distance - avoidance.body) / avoidance.wall_horizon
        if distance > 0.0 and room < avoidance.max_speed:
            planes[count] = x / distance, y / distance, room
            count += 1
    return count
