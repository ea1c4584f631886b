"""Model predictive control: drive the beginning of the best plan for the next 4 s, then plan again.

The plan minimises its lag behind and offset from a reference that moves straight at the goal at the robot's top speed,
effort, and soft penalties for coming near to people, where they are predicted (`prediction.py`). The programme and
its solvers are in `optimal_control.py`, where the search starts in `starting_plans.py`.

Walls along the edges of the world are hard bounds of the plan. Other walls are soft half-planes, one per stage for each
of the nearest, on the side on which the search starts: unlike discs along a wall they leave no gaps, and cost ever more
the further behind them, so that no plan leads through a wall. Where no solver finds a plan, the robot brakes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from components.controllers.differential import limits_of
from components.controllers.ego import Ego, Way, command, ego_of, way_to
from components.controllers.optimal_control import OMEGA, THETA, OptimalControl, Shape, V, Weights, X, Y
from components.controllers.options import require_not_negative, require_positive
from components.controllers.prediction import Horizon, Prediction, Predictor, Tracks
from components.controllers.sight import People, Sight
from components.controllers.starting_plans import (
    Scales,
    best_start,
    carry_on,
    choose_discs,
    choose_planes,
    negligible_gap,
)
from crowdcosim import Controller, Setup
from crowdcosim.messages import (
    Crowd,
    Detections,
    Goal,
    Header,
    Odometry,
    Path,
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    RobotState,
    Twist,
)
from crowdcosim.setup import nanoseconds_of, time_of
from crowdcosim.world import World

Array = NDArray[np.float64]

WALLS = 4
"""walls within the world that count at a stage, the nearest first"""
WALL_MARGIN = 0.03
"""added to the robot's radius beside a wall [m]"""
GIVE = 1e-3
"""how far a bound gives way beyond where the robot can stop, so that there always is a plan [m]"""
HOPELESS = 1e9
"""cost of the best start beyond which the robot brakes: numbers on the way to infinity stop a solver, or never do"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of model predictive control."""

    people_from: People = "truth"
    """where the robot knows people from"""
    prediction: Prediction = field(default_factory=Prediction)
    """how people are expected to walk"""
    margin: float = 0.1
    """distance from people below which a plan is charged more than the proximity [m]"""
    proximity: float = 4.0
    """cost per second of being `margin` away from somebody; a lag of 1 m behind the reference costs 1"""
    steepness: float = 6.0
    """how fast that cost falls with the distance: by e in 1 / steepness [1/m]"""
    people: int = 8
    """how many people and robots the programme knows, the most urgent first"""
    stages: int = 20
    """steps of the plan"""
    stage: float = 0.2
    """time between two of them [s]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "margin", "proximity")
        require_positive(self, "steepness", "stage")
        if not self.people >= 0:
            raise ValueError(f"people is {self.people}, expected zero or more")
        if not self.stages >= 2:
            raise ValueError(f"stages is {self.stages}, expected at least 2")


class Decision(NamedTuple):
    """What the controller says."""

    twist: Twist
    """the command for the next period"""
    plan: Path
    """where the robot expects to be, in the frame `map`"""


class MPC(Controller):
    """Plans a few seconds ahead among people who are predicted."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Build the solvers, and load the kernels.

        Raises:
            ValueError: if the robot cannot turn.
        """
        config, model = self._config, setup.own_robot.model
        if not (model.max_angular_velocity > 0 and model.max_angular_acceleration > 0):
            raise ValueError(
                "the robot cannot turn, expected max_angular_velocity and max_angular_acceleration above 0"
            )
        self._sight, self._predictor = Sight(config.people_from, setup), Predictor(config.prediction, setup)
        self._dt = setup.dt
        self._body = model.radius + config.margin
        self._free, self._walls = free_box(setup.world, model.radius + WALL_MARGIN)
        shape = Shape(config.stages, config.stage, config.people, min(WALLS, len(self._walls)))
        limits = limits_of(model)
        weights = Weights(proximity=config.proximity, steepness=config.steepness)
        self._control = OptimalControl(shape, limits, weights)
        self._scales = Scales(
            way=self._control.task.way,
            reference=self._control.task.reference,
            box=np.zeros(4),
            segments=np.zeros_like(self._walls),
            body=model.radius + WALL_MARGIN,
            shape=shape,
            limits=limits,
            weights=weights,
        )
        self._horizon = Horizon(
            shape.stages, shape.dt, model.max_speed, self._body + negligible_gap(weights), model.radius
        )
        self._times = shape.dt * np.arange(shape.stages + 1)
        self._later = [round(t * 1e9) for t in self._times.tolist()]
        self._plan, self._carried = np.zeros((shape.stages + 1, 7)), np.zeros((shape.stages + 1, 7))
        nobody = Tracks(np.empty((shape.stages + 1, 0, 2)), np.empty(0))
        self._search(Ego(0.0, 0.0, 0.0, 0.0, 0.0), Way(1.0, 0.0, 0.0), nobody)
        self._plan = np.zeros((shape.stages + 1, 7))

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
    ) -> Decision:
        """The beginning of the plan, and the plan; rest at the goal.

        Raises:
            ValueError: if odometry, people or robots are not finite.
        """
        ego = ego_of(odometry)
        if not all(map(math.isfinite, ego)):
            raise ValueError(f"odometry is {ego}, expected finite numbers")
        ego = self._within_limits(ego)
        way = way_to(goal, ego)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        if not all(np.isfinite(array).all() for array in (discs.position, discs.velocity, discs.radius)):
            raise ValueError("people or robots hold NaN or infinity, expected finite numbers")
        found = None
        if way is not None:
            carry_on(ego, self._plan, self._dt, self._scales, self._carried)
            own = self._carried[:, [X, Y]].copy()
            found = self._search(ego, way, self._predictor.tracks(ego, odometry.header, discs, own, self._horizon))
        self._plan = _standing(ego, len(self._plan)) if found is None else found
        speed, rate = (float(np.interp(self._dt, self._times, self._plan[:, column])) for column in (V, OMEGA))
        wanted = self._within_limits(ego._replace(speed=speed, turn_rate=rate))
        return Decision(command(wanted.speed, wanted.turn_rate), self._path(ego, odometry.header))

    def _search(self, ego: Ego, way: Way, tracks: Tracks) -> Array | None:
        """The best plan that is found; None where the robot can do no better than brake."""
        scales, control = self._scales, self._control
        self._set_task(ego, way)
        near = tracks._replace(radius=tracks.radius + self._body)
        expected = best_start(ego, self._plan, self._dt, near, scales, control.guess)
        if not expected < HOPELESS:
            return None
        choose_discs(control.guess, near, scales.shape.dt, control.task.radius, control.task.disc)
        choose_planes(control.guess, scales, control.task.plane)
        return control.solve(scales.box)

    def _set_task(self, ego: Ego, way: Way) -> None:
        """Write where the robot is, where it should be when, and what bounds it."""
        task, scales, limits = self._control.task, self._scales, self._scales.limits
        distance = math.hypot(way.x, way.y)
        task.start[:] = ego.heading, ego.speed, ego.turn_rate
        task.way[:] = way.x / distance, way.y / distance
        np.minimum(limits.max_speed * self._times, distance if way.weight else math.inf, out=task.reference)
        position = np.array([ego.x, ego.y])
        np.subtract(self._walls, position, out=scales.segments)
        # Where the robot stops if it brakes from now on, be it over whole stages.
        braking = ego.speed * max(abs(ego.speed) / limits.max_acceleration, scales.shape.dt) / 2
        stop = braking * np.array([math.cos(ego.heading), math.sin(ego.heading)])
        low, high = self._free[:2] - position, self._free[2:] - position
        scales.box[:2] = np.where(stop < low + GIVE, np.minimum(stop, 0.0) - GIVE, low)
        scales.box[2:] = np.where(stop > high - GIVE, np.maximum(stop, 0.0) + GIVE, high)

    def _within_limits(self, ego: Ego) -> Ego:
        """`ego` with speeds that the robot can have: noisy odometry may report others, from which there is no plan."""
        limits = self._scales.limits
        return ego._replace(
            speed=min(limits.max_speed, max(limits.min_speed, ego.speed)),
            turn_rate=min(limits.max_turn_rate, max(-limits.max_turn_rate, ego.turn_rate)),
        )

    def _path(self, ego: Ego, header: Header) -> Path:
        now = nanoseconds_of(header.stamp)
        poses = [
            PoseStamped(
                header=Header(stamp=time_of(now + later), frame_id="map"),
                pose=Pose(
                    position=Point(x=ego.x + x, y=ego.y + y),
                    orientation=Quaternion(z=math.sin(theta / 2), w=math.cos(theta / 2)),
                ),
            )
            for later, (x, y, theta) in zip(self._later, self._plan[:, [X, Y, THETA]].tolist(), strict=True)
        ]
        return Path(header=Header(stamp=header.stamp, frame_id="map"), poses=tuple(poses))


def _standing(ego: Ego, stages: int) -> Array:
    """A plan to stay."""
    plan = np.zeros((stages, 7))
    plan[:, THETA] = ego.heading
    return plan


def free_box(world: World, body: float) -> tuple[Array, Array]:
    """Where a robot's centre may be between the walls along the world's edges, and the other walls.

    Args:
        world: an edge bounds the robot if walls cover all of it.
        body: how near the centre may come to a wall [m].

    Returns:
        (4,) least x, least y, greatest x, greatest y, infinite where the world is open [m];
        (W, 2, 2) both ends of the walls that bound none of these [m].
    """
    box = np.array([-np.inf, -np.inf, np.inf, np.inf])
    inner = np.ones(len(world.segments), np.bool_)
    for axis in (0, 1):
        for side, edge in ((0, 0.0), (2, world.size[axis])):
            on_edge = (world.segments[:, :, axis] == edge).all(axis=1)
            if covered(np.sort(world.segments[on_edge, :, 1 - axis], axis=1), world.size[1 - axis]):
                box[side + axis] = edge + body if side == 0 else edge - body
                inner &= ~on_edge
    return box, world.segments[inner].copy()


def covered(intervals: Array, length: float) -> bool:
    """Whether (M, 2) intervals [m] leave no gap from 0 to `length` [m]."""
    end = 0.0
    for first, last in sorted(intervals.tolist()):
        if first > end:
            return False
        end = max(end, last)
    return end >= length
