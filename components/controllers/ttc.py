"""Time-to-collision sampling: of all ways to turn and go straight, the best trade of lateness against collision.

    C(V) = |V_pref - V| / v_max + w exp(-t_c / tau) / t_c + s exp(-g / l) + h |sin((V - V_before) / 2)|

over headings x speeds, with t_c the time until the robot, which turns to V's heading and drives on, touches somebody or
a wall, and g the least gap on the way there; the last part, of the angle between V and what was chosen before, is
against wavering. The robot drives at V's speed and turns to V's heading.

The penalty w / t_c + |V_pref - V| of a sampled velocity: van den Berg, Lin, Manocha, "Reciprocal velocity obstacles for
real-time multi-agent navigation", ICRA 2008, equation (10); its decay: Karamouzas, Skinner, Guy, "Universal power law
governing pedestrian interactions", Physical Review Letters 113, 2014, equation (3).

Not in the papers: the last two parts.
Differs from the papers: t_c is that of the turn which the robot has to make first, within its limits, not of V taken on
at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.differential import Limits, Motion, advance, limits_of
from components.controllers.ego import TURN_GAIN, Ego, command, ego_of, heading_error, turn, way_to
from components.controllers.options import require_not_negative, require_positive
from components.controllers.prediction import Horizon, Prediction, Predictor, Tracks
from components.controllers.sight import People, Sight
from components.controllers.surroundings import frozen, nearest_on_segment, walls_near
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, Odometry, RobotState, Twist

Array = NDArray[np.float64]

HEADINGS = 37
"""sampled headings, evenly over +-SPREAD around the way to the goal"""
SPREAD = 1.6
"""[rad]"""
SPEEDS = 6
"""sampled speeds, evenly from 0 to the robot's maximum"""
STEP = 0.2
"""time between two instants at which a way is looked at; in between, all go straight [s]"""
GAP = 0.5
"""gap beyond which its part of the cost is not counted [m]"""
WALL_MARGIN = 0.03
"""added to the robot's radius beside a wall, which is looked at between steps only [m]"""
GAP_LENGTH = 0.1
"""l, over which that falls by e [m]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of time-to-collision sampling."""

    people_from: People = "truth"
    """where the robot knows people from"""
    prediction: Prediction = field(default_factory=Prediction)
    """how people are expected to walk"""
    horizon: float = 6.0
    """collisions later than this are ignored [s]"""
    urgency: float = 3.0
    """w, cost of a collision in one second, before its decay [s]"""
    decay: float = 2.0
    """tau, over which that falls by e [s]"""
    clearance: float = 0.3
    """s, cost of grazing somebody"""
    steadiness: float = 0.1
    """h, cost of turning round"""

    def __post_init__(self) -> None:
        require_positive(self, "horizon", "decay")
        require_not_negative(self, "urgency", "clearance", "steadiness")


class Charges(NamedTuple):
    """What a velocity is charged by."""

    bearing: float
    """of the goal [rad]"""
    before: float
    """heading chosen before [rad]"""
    body: float
    """radius of the robot [m]"""
    urgency: float
    decay: float
    clearance: float
    steadiness: float


class TTC(Controller):
    """Turns to where, and drives as fast as, the next collision is far enough away."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits and the walls, and load the kernels."""
        config, model = self._config, setup.own_robot.model
        self._walls = frozen(setup.world.segments)
        self._sight, self._predictor = Sight(config.people_from, setup), Predictor(config.prediction, setup)
        self._limits = limits_of(model)
        stages = max(1, round(config.horizon / STEP))
        self._horizon = Horizon(stages, STEP, model.max_speed, model.radius + GAP, model.radius)
        self._reach = model.max_speed * stages * STEP + model.radius
        self._charges = Charges(
            0.0, 0.0, model.radius, config.urgency, config.decay, config.clearance, config.steadiness
        )
        self._chosen: tuple[float, float] | None = None
        nobody = Tracks(np.empty((stages + 1, 0, 2)), np.empty(0))
        ego = Ego(0.0, 0.0, 0.0, 0.0, 0.0)
        best_velocity(ego, nobody, walls_near(ego, self._walls, self._reach), self._limits, self._charges)
        followed(ego, 0.0, 0.0, stages, self._limits)

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
    ) -> Twist:
        """The best velocity, driven; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        if way is None:
            self._chosen = None
            return command(0.0, 0.0)
        speed, before = self._chosen or (0.0, ego.heading)
        own = followed(ego, speed, before, self._horizon.stages, self._limits)
        tracks = self._predictor.tracks(ego, odometry.header, discs, own, self._horizon)
        charges = self._charges._replace(bearing=way.bearing, before=before)
        if self._chosen is None:
            charges = charges._replace(steadiness=0.0)
        walls = walls_near(ego, self._walls, self._reach)
        speed, direction = self._chosen = best_velocity(ego, tracks, walls, self._limits, charges)
        if way.weight:
            # No faster than it can still stop within the goal's disc.
            speed = min(speed, math.sqrt(2.0 * self._limits.max_acceleration * math.hypot(way.x, way.y)))
        return command(speed, turn(heading_error(direction, ego.heading), self._limits.max_turn_rate))


@njit(cache=True, nogil=True, error_model="numpy")
def best_velocity(ego: Ego, tracks: Tracks, walls: Array, limits: Limits, charges: Charges) -> tuple[float, float]:
    """The speed [m/s] and the heading [rad] of least cost; of equals, the nearest to the way to the goal.

    Args:
        ego: pose and speeds of the robot.
        tracks: where people will be.
        walls: (W, 2, 2) both ends of the walls that can be reached, relative to the robot's position [m].
        limits: of the robot.
        charges: what a velocity costs.
    """
    least, speed, direction = np.inf, 0.0, ego.heading
    for i in range(HEADINGS):
        side = 1.0 if i % 2 else -1.0
        offset = side * SPREAD * ((i + 1) // 2) / (HEADINGS // 2)
        heading = charges.bearing + offset
        heading -= math.tau * np.rint((heading - ego.heading) / math.tau)
        waver = charges.steadiness * abs(math.sin(0.5 * (heading - charges.before)))
        for j in range(SPEEDS):
            share = 1.0 - j / (SPEEDS - 1)
            cost = waver + math.sqrt(max(0.0, 1.0 + share * share - 2.0 * share * math.cos(offset)))
            if cost >= least:
                continue
            t, gap = first_contact(ego, share * limits.max_speed, heading, tracks, walls, charges.body, limits)
            cost += charges.clearance * math.exp(-max(0.0, gap) / GAP_LENGTH)
            # Nobody reacts within half a step, and 1 / 0 would make all collisions equal.
            cost += charges.urgency * math.exp(-t / charges.decay) / max(t, 0.5 * STEP)
            if cost < least:
                least, speed, direction = cost, share * limits.max_speed, heading
    return speed, direction


@njit(cache=True, nogil=True, error_model="numpy")
def followed(ego: Ego, speed: float, heading: float, stages: int, limits: Limits) -> Array:
    """(N + 1, 2) where a turn to a heading [rad] at a speed [m/s] takes the robot, relative to where it is [m]."""
    way = np.zeros((stages + 1, 2))
    motion = Motion(0.0, 0.0, ego.heading, ego.speed, ego.turn_rate)
    heading -= math.tau * np.rint((heading - ego.heading) / math.tau)
    for k in range(stages):
        motion = advance(motion, speed, TURN_GAIN * (heading - motion.heading), STEP, limits)
        way[k + 1] = motion.x, motion.y
    return way


@njit(cache=True, nogil=True, error_model="numpy")
def first_contact(
    ego: Ego, speed: float, heading: float, tracks: Tracks, walls: Array, body: float, limits: Limits
) -> tuple[float, float]:
    """When a turn to a heading [rad] at a speed [m/s] ends in a contact, and the least gap to people until then.

    Returns:
        The time at the beginning of that step, infinite if there is none [s]; the gap, at most `GAP` [m].
    """
    least = GAP
    motion = Motion(0.0, 0.0, ego.heading, ego.speed, ego.turn_rate)
    for k in range(1, len(tracks.position)):
        x, y = motion.x, motion.y
        motion = advance(motion, speed, TURN_GAIN * (heading - motion.heading), STEP, limits)
        touched = False
        for j in range(len(tracks.radius)):
            px, py = tracks.position[k - 1, j, 0] - x, tracks.position[k - 1, j, 1] - y
            qx, qy = tracks.position[k, j, 0] - motion.x, tracks.position[k, j, 1] - motion.y
            contact = body + tracks.radius[j]
            if max(abs(px + qx) - abs(px - qx), abs(py + qy) - abs(py - qy)) > 2.0 * (contact + GAP):
                continue
            nx, ny = nearest_on_segment(px, py, qx, qy)
            gap = math.hypot(nx, ny) - contact
            least = min(least, gap)
            # To leave somebody whom the robot touches already is no collision to come.
            if gap < 0.0 and (math.hypot(px, py) > contact or qx * qx + qy * qy < px * px + py * py):
                touched = True
        for i in range(len(walls)):
            ax, ay = walls[i, 0, 0] - motion.x, walls[i, 0, 1] - motion.y
            bx, by = walls[i, 1, 0] - motion.x, walls[i, 1, 1] - motion.y
            wx, wy = nearest_on_segment(ax, ay, bx, by)
            if math.hypot(wx, wy) < body + WALL_MARGIN:
                touched = True
        if touched:
            return (k - 1) * STEP, least
    return np.inf, least
