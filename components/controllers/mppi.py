"""Model predictive path integral control: the average of many sampled plans, weighted by what they cost.

    U <- sum_s w_s U_s / sum_s w_s,  w_s = exp(-(C_s - min C) / lambda)

U holds speed and turn rate at N steps, and U_s is U and noise as the robot's limits let it follow. A plan costs

    C = G (way that the top speed would make - way made) + sum_k dt (Q omega^2 + soft_k / (1 + t_k / 2 s) + 1000 [wall])
    soft_k = sum_j K [g_jk < 0] + P max(0, 1 - max(0, g_jk) / margin)^2,  g_jk the gap to person j at step k

Williams, Wagener, Goldfain, Drews, Rehg, Boots, Theodorou, "Information theoretic MPC for model-based reinforcement
learning", ICRA 2017, algorithm 2.

Not in the paper: the cost; people count less the later, for predictions are worth less; noise that is linear between a
few knots, for smooth commands; samples that turn and go straight, by which another way round somebody is found (as
Trevisan and Alonso-Mora, "Biased-MPPI", RA-L 9(6), 2024).
Differs from the paper: the term lambda u' Sigma^-1 e is left out, in which the biased samples would need a density of
their own; no smoothing filter, since the noise is smooth.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.differential import Limits, Motion, advance, limits_of
from components.controllers.ego import TURN_GAIN, Ego, command, ego_of, way_to
from components.controllers.options import require_not_negative, require_positive
from components.controllers.prediction import Horizon, Prediction, Predictor, Tracks
from components.controllers.sight import People, Sight
from components.controllers.surroundings import frozen, nearest_on_segment, walls_near
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, Odometry, RobotState, Twist

Array = NDArray[np.float64]

HEADINGS = 11
"""biased samples' headings, evenly over +-SPREAD around the way to the goal"""
SPREAD = 1.3
"""[rad]"""
SPEEDS = (0.0, 0.35, 0.7, 1.0)
"""biased samples' speeds, as shares of the robot's maximum"""
TURNING = 0.05
"""Q, cost rate of turning [s]"""
FADE = 0.5
"""how fast people count less with time [1/s]"""
WALL = 1000.0
"""cost rate of being nearer to a wall than `WALL_MARGIN`"""
WALL_MARGIN = 0.05
"""[m]"""
NEGLIGIBLE = 1e-6
"""weight of a sample that no longer counts"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of model predictive path integral control."""

    people_from: People = "truth"
    """where the robot knows people from"""
    prediction: Prediction = field(default_factory=Prediction)
    """how people are expected to walk"""
    samples: int = 1000
    """plans with noise"""
    steps: int = 20
    """N"""
    step: float = 0.2
    """time between two of them [s]"""
    knot: float = 0.6
    """time between two knots of the noise [s]"""
    speed_noise: float = 0.4
    """standard deviation of the speed at a knot [m/s]"""
    turn_noise: float = 1.0
    """standard deviation of the turn rate at a knot [rad/s]"""
    temperature: float = 0.3
    """lambda, difference in cost that counts"""
    collision: float = 80.0
    """K, cost per second of touching somebody"""
    proximity: float = 8.0
    """P, and of nearly touching them"""
    margin: float = 0.15
    """gap from which proximity costs nothing [m]"""
    goal: float = 12.0
    """G, cost per metre of falling behind"""

    def __post_init__(self) -> None:
        require_positive(self, "step", "knot", "temperature")
        require_not_negative(self, "speed_noise", "turn_noise", "collision", "proximity", "margin", "goal")
        if not self.samples >= 0:
            raise ValueError(f"samples is {self.samples}, expected zero or more")
        if not self.steps >= 2:
            raise ValueError(f"steps is {self.steps}, expected at least 2")


class Charges(NamedTuple):
    """What a plan is charged by."""

    way_x: float
    """unit vector to the goal"""
    way_y: float
    distance: float
    """to the goal, infinite to a line [m]"""
    body: float
    """radius of the robot [m]"""
    dt: float
    """[s]"""
    temperature: float
    collision: float
    proximity: float
    margin: float
    goal: float


class MPPI(Controller):
    """Samples plans among people who are predicted."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Take the robot's limits and the walls, and load the kernels."""
        config, model = self._config, setup.own_robot.model
        self._dt, self._walls = setup.dt, frozen(setup.world.segments)
        self._sight, self._predictor = Sight(config.people_from, setup), Predictor(config.prediction, setup)
        self._limits = limits_of(model)
        self._charges = Charges(
            way_x=1.0,
            way_y=0.0,
            distance=math.inf,
            body=model.radius,
            dt=config.step,
            temperature=config.temperature,
            collision=config.collision,
            proximity=config.proximity,
            margin=config.margin,
            goal=config.goal,
        )
        self._horizon = Horizon(config.steps, config.step, model.max_speed, model.radius + config.margin, model.radius)
        self._times = config.step * np.arange(1, config.steps + 1)
        knots = np.arange(math.ceil(self._times[-1] / config.knot) + 1)
        self._reach = model.max_speed * float(self._times[-1]) + model.radius + WALL_MARGIN
        self._spread = np.maximum(0.0, 1.0 - np.abs(self._times[:, None] / config.knot - knots))
        """(N, knots) how much each knot counts at each step"""
        self._rng = setup.rng()
        self._plan = np.zeros((config.steps, 2))
        nobody = Tracks(np.empty((config.steps + 1, 0, 2)), np.empty(0))
        improve(
            Ego(0.0, 0.0, 0.0, 0.0, 0.0), self._plan, self._noise(0), nobody, self._walls, self._limits, self._charges
        )

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
    ) -> Twist:
        """The beginning of the average plan; rest at the goal."""
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        if way is None:
            self._plan[:] = 0.0
            return command(0.0, 0.0)
        config, distance = self._config, math.hypot(way.x, way.y)
        charges = self._charges._replace(
            way_x=way.x / distance, way_y=way.y / distance, distance=distance if way.weight else math.inf
        )
        earlier = self._plan
        self._plan = np.column_stack([np.interp(self._times + self._dt, self._times, u) for u in earlier.T])
        own = followed(ego, self._plan, config.step, self._limits)
        tracks = self._predictor.tracks(ego, odometry.header, discs, own, self._horizon)
        walls = walls_near(ego, self._walls, self._reach)
        self._plan = improve(ego, self._plan, self._noise(config.samples), tracks, walls, self._limits, charges)
        times = np.concatenate([[0.0], self._times])
        now = np.array([ego.speed, ego.turn_rate])
        speed, turn_rate = (float(np.interp(self._dt, times, u)) for u in np.vstack([now, self._plan]).T)
        return command(speed, turn_rate)

    def _noise(self, samples: int) -> Array:
        """(S, N, 2) deviations of speed [m/s] and turn rate [rad/s]."""
        deviation = np.array([self._config.speed_noise, self._config.turn_noise])
        knots = self._rng.standard_normal((samples, self._spread.shape[1], 2)) * deviation
        return np.ascontiguousarray(self._spread @ knots)


@njit(cache=True, nogil=True, error_model="numpy")
def followed(ego: Ego, plan: Array, dt: float, limits: Limits) -> Array:
    """(N + 1, 2) where a (N, 2) plan takes the robot, relative to where it is [m]."""
    way = np.zeros((len(plan) + 1, 2))
    motion = Motion(0.0, 0.0, ego.heading, ego.speed, ego.turn_rate)
    for k in range(len(plan)):
        motion = advance(motion, plan[k, 0], plan[k, 1], dt, limits)
        way[k + 1] = motion.x, motion.y
    return way


@njit(cache=True, nogil=True, error_model="numpy")
def improve(
    ego: Ego, plan: Array, noise: Array, tracks: Tracks, walls: Array, limits: Limits, charges: Charges
) -> Array:
    """The weighted average of all samples.

    Args:
        ego: pose and speeds of the robot.
        plan: (N, 2) speed [m/s] and turn rate [rad/s] at the end of every step.
        noise: (S, N, 2) of the samples with noise.
        tracks: where people will be.
        walls: (W, 2, 2) both ends of the walls that can be reached, relative to the robot's position [m].
        limits: of the robot.
        charges: what a plan costs.
    """
    samples, steps = len(noise), len(plan)
    biased = HEADINGS * len(SPEEDS)
    driven, costs = np.empty((samples + biased + 1, steps, 2)), np.empty(samples + biased + 1)
    near, count = near_each(tracks, limits.max_speed, charges)
    bearing = math.atan2(charges.way_y, charges.way_x)
    for s in range(len(costs)):
        go, heading = -1.0, 0.0
        if s < samples:
            driven[s] = plan + noise[s]
        elif s == samples:
            driven[s] = plan
        else:
            i = s - samples - 1
            go = SPEEDS[i % len(SPEEDS)] * limits.max_speed
            heading = bearing + SPREAD * (2.0 * (i // len(SPEEDS)) / (HEADINGS - 1) - 1.0)
            difference = heading - ego.heading
            heading -= math.tau * np.rint(difference / math.tau)
        costs[s] = cost(ego, driven[s], go, heading, near, count, walls, limits, charges)
    least, total, average = costs.min(), 0.0, np.zeros((steps, 2))
    for s in range(len(costs)):
        weight = math.exp((least - costs[s]) / charges.temperature)
        if weight > NEGLIGIBLE:
            total += weight
            average += weight * driven[s]
    return average / total


@njit(cache=True, nogil=True, error_model="numpy")
def near_each(tracks: Tracks, speed: float, charges: Charges) -> tuple[Array, NDArray[np.int64]]:
    """(N + 1, M, 3) centre and contact distance of whom the robot can be near to at each step [m], and how many."""
    stages, people = tracks.position.shape[:2]
    near, count = np.empty((stages, people, 3)), np.zeros(stages, np.int64)
    for k in range(1, stages):
        reach = speed * k * charges.dt + charges.body + charges.margin
        for j in range(people):
            x, y, radius = tracks.position[k, j, 0], tracks.position[k, j, 1], tracks.radius[j]
            if math.hypot(x, y) < reach + radius:
                near[k, count[k]] = x, y, radius + charges.body
                count[k] += 1
    return near, count


@njit(cache=True, nogil=True, error_model="numpy")
def cost(
    ego: Ego,
    plan: Array,
    go: float,
    heading: float,
    near: Array,
    count: NDArray[np.int64],
    walls: Array,
    limits: Limits,
    charges: Charges,
) -> float:
    """Drive a plan, write what the robot does into it, and charge it.

    Args:
        ego: pose and speeds of the robot.
        plan: (N, 2) wanted and then driven speed [m/s] and turn rate [rad/s]; only written if `go` is not negative.
        go: speed of a plan that turns and goes straight [m/s].
        heading: where that turns to, within pi of the robot's [rad].
        near: whom it can touch, and
        count: how many of them, from `near_each`.
        walls: as for `improve`.
        limits: of the robot.
        charges: what it costs.
    """
    dt, total = charges.dt, 0.0
    motion = Motion(0.0, 0.0, ego.heading, ego.speed, ego.turn_rate)
    for k in range(len(plan)):
        if go >= 0.0:
            motion = advance(motion, go, TURN_GAIN * (heading - motion.heading), dt, limits)
        else:
            motion = advance(motion, plan[k, 0], plan[k, 1], dt, limits)
        plan[k, 0], plan[k, 1] = motion.speed, motion.turn_rate
        soft = 0.0
        for j in range(count[k + 1]):
            dx, dy, contact = near[k + 1, j, 0] - motion.x, near[k + 1, j, 1] - motion.y, near[k + 1, j, 2]
            square = dx * dx + dy * dy
            if square < (contact + charges.margin) ** 2:
                gap = math.sqrt(square) - contact
                if gap < 0.0:
                    soft += charges.collision
                soft += charges.proximity * (1.0 - max(0.0, gap) / charges.margin) ** 2
        rate = TURNING * motion.turn_rate * motion.turn_rate + soft / (1.0 + FADE * (k + 1) * dt)
        for i in range(len(walls)):
            ax, ay = walls[i, 0, 0] - motion.x, walls[i, 0, 1] - motion.y
            bx, by = walls[i, 1, 0] - motion.x, walls[i, 1, 1] - motion.y
            x, y = nearest_on_segment(ax, ay, bx, by)
            if math.hypot(x, y) < charges.body + WALL_MARGIN:
                rate += WALL
        total += dt * rate
    made = charges.way_x * motion.x + charges.way_y * motion.y
    return total + charges.goal * (min(charges.distance, limits.max_speed * dt * len(plan)) - made)
