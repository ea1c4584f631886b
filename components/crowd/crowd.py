"""The crowd: people who walk for ever in their flow's direction and react to each other, to walls and to robots."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.crowd.flows import Flow, directions
from components.crowd.gait import walk
from components.crowd.mixture import Mixture, Share, draw_groups
from components.crowd.motion import move
from components.crowd.people import draw_bodies, draw_speeds
from components.crowd.placement import check, place
from components.crowd.policies import PolicyName, make_policy
from components.crowd.sampling import next_streams
from components.crowd.scene import Policy, Scene
from components.crowd.steering import Recipe
from components.crowd.walls import Walls
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.setup import Setup, time_of

Array = NDArray[np.float64]

PLACES, SPEEDS, BODIES, STEPS, CHOICES, GROUPS = range(6)
"""streams of chance: given positions leave speeds and bodies as they are"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Who is in the crowd, where they go, and how they react. Either `count` or `positions` must be given."""

    policy: PolicyName | Recipe | tuple[Share, ...] = "orca"
    """how people avoid each other: a shipped policy, costs and an optimiser of your own, or shares of several"""
    time_horizon: float = 1.5
    """of `orca`: collisions later than this are ignored [s]"""
    reactive: bool = True
    """people see robots, avoid them as they avoid each other and are pushed by them; False: they walk through robots"""
    flow: Flow = "1d+"
    """where people go: 1d+ along x, 1d- against x, 1dx half and half, 2d along y, 2dx half and half in y"""
    count: int | None = None
    """number of people, placed at random without overlap"""
    positions: tuple[tuple[float, float], ...] | None = None
    """initial centres, [x, y] of everybody [m]"""
    radius: float = 0.3
    """radius of everybody's disc [m]"""
    preferred_speed: float = 1.3
    """mean of the speeds that people walk at when they are free [m/s]"""
    preferred_speed_deviation: float = 0.2
    """standard deviation of them [m/s]"""
    preferred_speed_limits: tuple[float, float] = (0.8, 1.8)
    """slower and faster draws are clipped to these [m/s]"""
    max_speed: float = 1.8
    """nobody wants to be faster [m/s]"""
    max_acceleration: float = 5.0
    """nobody wants to accelerate or brake harder [m/s2]"""

    def __post_init__(self) -> None:
        if (self.count is None) == (self.positions is None):
            given = "neither" if self.count is None else "both"
            raise ValueError(f"{given} of count and positions given, expected one of them")
        if self.policy == ():
            raise ValueError("policy is empty, expected a policy, or a list of at least one share")
        if self.count is not None and self.count < 0:
            raise ValueError(f"count is {self.count}, expected zero or more")
        for name in ("time_horizon", "radius", "preferred_speed", "max_speed", "max_acceleration"):
            value = getattr(self, name)
            if not (value > 0 and math.isfinite(value)):
                raise ValueError(f"{name} is {value}, expected a positive number")
        if not (self.preferred_speed_deviation >= 0 and math.isfinite(self.preferred_speed_deviation)):
            raise ValueError(
                f"preferred_speed_deviation is {self.preferred_speed_deviation}, expected zero or a positive number"
            )
        low, high = self.preferred_speed_limits
        if not 0 < low <= high <= self.max_speed:
            raise ValueError(
                f"preferred_speed_limits are {low} and {high}, expected two positive numbers in ascending order, "
                f"at most max_speed ({self.max_speed})"
            )
        if not low <= self.preferred_speed <= high:
            raise ValueError(
                f"preferred_speed is {self.preferred_speed}, expected within preferred_speed_limits ({low} to {high})"
            )
        for i, centre in enumerate(self.positions or ()):
            if not all(math.isfinite(c) for c in centre):
                raise ValueError(f"positions[{i}] is {list(centre)}, expected two finite numbers")


@dataclass(frozen=True, kw_only=True, slots=True)
class _State:
    """What changes from step to step."""

    position: Array
    """(N, 2) [m]"""
    velocity: Array
    """(N, 2) [m/s]"""
    heading: Array
    """(N,) [rad]"""
    pace: Array
    """(N,) smoothed speeds that the steps follow [m/s]"""
    phase: Array
    """(N,) [cycles]"""
    stream: NDArray[np.uint64]
    """(N,) numbers that random choices begin with"""


class CrowdModel(Mover):
    """People who start at rest and walk for ever in the direction of their flow."""

    def __init__(self, config: Config) -> None:
        self._config = config
        minds = config.policy if isinstance(config.policy, tuple) else (Share(policy=config.policy, share=1.0),)
        self._shares = [mind.share for mind in minds]
        self._policies = [make_policy(mind.policy, time_horizon=float(config.time_horizon)) for mind in minds]

    def reset(self, setup: Setup) -> Crowd:
        """The people of the episode at t = 0, at rest.

        Raises:
            ValueError: if the people do not fit into the world.
        """
        config, world = self._config, setup.world
        position = self._places(setup)
        count = len(position)
        ways = directions(config.flow, count)
        speed = draw_speeds(
            setup.rng(SPEEDS),
            count,
            config.preferred_speed,
            config.preferred_speed_deviation,
            *config.preferred_speed_limits,
        )
        bodies = draw_bodies(setup.rng(BODIES), count)
        self._people = {
            "id": _read_only(np.arange(1, count + 1, dtype=np.uint32)),
            "group": _read_only(np.zeros(count, np.uint32)),
            "radius": _read_only(np.full(count, config.radius, np.float64)),
            "stature": _read_only(bodies.stature),
            "mass": _read_only(bodies.mass),
        }
        self._state = _State(
            position=position,
            velocity=np.zeros((count, 2)),
            heading=np.arctan2(ways[:, 1], ways[:, 0]),
            pace=np.zeros(count),
            phase=setup.rng(STEPS).random(count),
            stream=setup.rng(CHOICES).integers(0, 2**64, count, np.uint64),
        )
        self._scene = Scene(
            position=position,
            velocity=self._state.velocity,
            preferred=speed[:, None] * ways,
            radius=np.full(count, config.radius, np.float64),
            robots=np.empty((0, 5)),
            pushed_by_robots=np.ones(count, np.bool_),
            walls=Walls.of(world),
            period=world.period.copy(),
            max_speed=np.full(count, config.max_speed, np.float64),
            max_acceleration=np.full(count, config.max_acceleration, np.float64),
            stream=self._state.stream,
            dt=setup.dt,
        )
        self._policy: Policy = self._policies[0]
        if len(self._policies) > 1:
            self._policy = Mixture(self._policies, draw_groups(setup.rng(GROUPS), count, self._shares))
        self._stature = bodies.stature
        self._period, self._time = setup.period, 0
        # Compiles or loads the kernels, so that no step has to.
        self._next(self._state, np.empty((0, 5)))
        return self._message()

    def step(self, robots: tuple[RobotState, ...]) -> Crowd:
        """The people one time step later; they react to the robots as these were."""
        seen = robots if self._config.reactive else ()
        self._state = self._next(
            self._state,
            np.array([(*r.position, *r.velocity, r.radius) for r in seen], np.float64).reshape(-1, 5),
        )
        self._time += self._period
        return self._message()

    def _places(self, setup: Setup) -> Array:
        config, world = self._config, setup.world
        if setup.alone:
            return np.empty((0, 2))
        robots = np.array([(r.start.x, r.start.y, r.model.radius) for r in setup.robots], np.float64).reshape(-1, 3)
        if config.positions is None:
            assert config.count is not None, "Config checks that one of them is given"
            return place(setup.rng(PLACES), np.full(config.count, config.radius, np.float64), world, robots)
        position = np.array(config.positions, np.float64).reshape(-1, 2)
        check(position, np.full(len(position), config.radius, np.float64), world, robots)
        return position

    def _next(self, old: _State, robots: Array) -> _State:
        scene = replace(self._scene, position=old.position, velocity=old.velocity, robots=robots, stream=old.stream)
        position, velocity = move(scene, self._policy.accelerate(scene))
        heading, pace, phase = walk(velocity, old.heading, old.pace, old.phase, self._stature, scene.dt)
        return _State(
            position=position,
            velocity=velocity,
            heading=heading,
            pace=pace,
            phase=phase,
            stream=next_streams(old.stream),
        )

    def _message(self) -> Crowd:
        state = self._state
        return Crowd(
            header=Header(stamp=time_of(self._time), frame_id="map"),
            position=_read_only(state.position),
            velocity=_read_only(state.velocity),
            heading=_read_only(state.heading),
            gait_phase=_read_only(state.phase),
            gait_speed=_read_only(state.pace),
            **self._people,
        )


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A view that nobody can write through; a message takes it as it is, without a copy."""
    view = array.view()
    view.flags.writeable = False
    return view
