"""The crowd: people who walk for ever in their flow's direction and react to each other, to walls and to robots."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.crowd.flows import Flow, directions
from components.crowd.gait import walk
from components.crowd.groups import Groups, abreast
from components.crowd.mixture import mix
from components.crowd.motion import move
from components.crowd.people import CHOICES, PLACES, STEPS, People, Population, Traits, draw_people
from components.crowd.placement import check, place
from components.crowd.reactions import Reactions, face
from components.crowd.sampling import next_streams
from components.crowd.scene import Scene
from components.crowd.walls import Walls
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.setup import Setup, time_of

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Config(Traits):
    """Who is in the crowd, where they go, and how they react. Either `count` or `positions` must be given."""

    reactive: bool = True
    """False: everybody walks through robots, whatever their `reaction`"""
    flow: Flow = "1d+"
    """where people go: 1d+ along x, 1d- against x, 1dx half and half, 2d along y, 2dx half and half in y"""
    count: int | None = None
    """number of people, placed at random without overlap"""
    positions: tuple[tuple[float, float], ...] | None = None
    """initial centres, [x, y] of everybody [m]"""
    populations: tuple[Population, ...] = ()
    """parts of the crowd that differ from the rest of this config"""

    def __post_init__(self) -> None:
        super().__post_init__()
        if (self.count is None) == (self.positions is None):
            given = "neither" if self.count is None else "both"
            raise ValueError(f"{given} of count and positions given, expected one of them")
        if self.count is not None and self.count < 0:
            raise ValueError(f"count is {self.count}, expected zero or more")
        for i, centre in enumerate(self.positions or ()):
            if not all(math.isfinite(c) for c in centre):
                raise ValueError(f"positions[{i}] is {list(centre)}, expected two finite numbers")
        names = [part.name for part in self.populations]
        for i, name in enumerate(names):
            if name in names[:i]:
                raise ValueError(f"populations[{i}].name: '{name}' is there twice, expected names of their own")
        for i, (_, _, traits) in enumerate(self.parts):
            if self.positions is not None and any(share > 0 for share in traits.groups[1:]):
                name = f"populations[{i}].groups" if self.populations else "groups"
                raise ValueError(
                    f"{name} is {list(traits.groups)}, expected [1]: whoever has a place in `positions` walks alone"
                )

    @property
    def parts(self) -> list[tuple[str, float, Traits]]:
        """Name, share and traits of each population, of the whole crowd if it has none."""
        if not self.populations:
            return [("", 1.0, self)]
        return [(part.name, part.share, part.traits(self)) for part in self.populations]


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
    attended: Array
    """(N,) how long people have attended to a robot [s]"""


class CrowdModel(Mover):
    """People who start at rest and walk for ever in the direction of their flow."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> Crowd:
        """The people of the episode at t = 0, at rest.

        Raises:
            ValueError: if the people do not fit into the world.
        """
        config, world = self._config, setup.world
        people = draw_people(setup.rng, 0 if setup.alone else self._count, config.parts)
        count = len(people.radius)
        ways = directions(config.flow, int(people.party.max(initial=-1)) + 1)[people.party]
        position = self._places(setup, people, ways)
        self._people = {
            "id": _read_only(np.arange(1, count + 1, dtype=np.uint32)),
            "group": _read_only(people.group),
            "radius": _read_only(people.radius),
            "stature": _read_only(people.stature),
            "mass": _read_only(people.mass),
        }
        self._state = _State(
            position=position,
            velocity=np.zeros((count, 2)),
            heading=np.arctan2(ways[:, 1], ways[:, 0]),
            pace=np.zeros(count),
            phase=setup.rng(STEPS).random(count),
            stream=setup.rng(CHOICES).integers(0, 2**64, count, np.uint64),
            attended=np.zeros(count),
        )
        self._groups = Groups(people.group)
        self._mixture = mix([traits.policy for _, _, traits in config.parts], people.population, people.time_horizon)
        self._reactions = Reactions(
            [traits.reaction if config.reactive else "none" for _, _, traits in config.parts], people.population
        )
        self._scene = Scene(
            position=position,
            velocity=self._state.velocity,
            preferred=people.preferred_speed[:, None] * ways,
            radius=people.radius,
            robots=np.empty((0, 5)),
            pushed_by_robots=self._reactions.pushed,
            walls=Walls.of(world),
            period=world.period.copy(),
            max_speed=people.max_speed,
            max_acceleration=people.max_acceleration,
            stream=self._state.stream,
            dt=setup.dt,
        )
        self._stature = people.stature
        self._period, self._time = setup.period, 0
        # Compiles or loads the kernels, so that no step has to.
        self._next(self._state, np.empty((0, 5)))
        return self._message()

    def step(self, robots: tuple[RobotState, ...]) -> Crowd:
        """The people one time step later; they react to the robots as these were."""
        self._state = self._next(
            self._state,
            np.array([(*r.position, *r.velocity, r.radius) for r in robots], np.float64).reshape(-1, 5),
        )
        self._time += self._period
        return self._message()

    @property
    def _count(self) -> int:
        return len(self._config.positions) if self._config.count is None else self._config.count

    def _places(self, setup: Setup, people: People, ways: Array) -> Array:
        config, world, radius = self._config, setup.world, people.radius
        robots = np.array([(r.start.x, r.start.y, r.model.radius) for r in setup.robots], np.float64).reshape(-1, 3)
        if config.positions is not None and len(radius):
            position = np.array(config.positions, np.float64).reshape(-1, 2)
            check(position, radius, world, robots)
            return position
        # Parties one after another.
        order = np.argsort(people.party, kind="stable")
        _, sizes = np.unique(people.party, return_counts=True)
        offset = np.zeros((len(order), 2))
        for first, size in zip(np.cumsum(sizes) - sizes, sizes, strict=True):
            if size > 1:
                who = order[first : first + size]
                offset[first : first + size] = abreast(ways[who[0]], radius[who])
        position = np.empty((len(order), 2))
        position[order] = place(setup.rng(PLACES), radius[order], world, robots, offset=offset, parties=sizes)
        return position

    def _next(self, old: _State, robots: Array) -> _State:
        scene = replace(self._scene, position=old.position, velocity=old.velocity, robots=robots, stream=old.stream)
        scene = replace(scene, preferred=self._groups.preferred(scene))
        reacted = self._reactions.react(scene, old.heading, old.attended)
        scene = replace(scene, preferred=reacted.preferred)
        position, velocity = move(scene, self._mixture.accelerate(scene, reacted.sight))
        heading, pace, phase = walk(velocity, old.heading, old.pace, old.phase, self._stature, scene.dt)
        return _State(
            position=position,
            velocity=velocity,
            heading=face(heading, reacted.bearing, velocity, scene.dt),
            pace=pace,
            phase=phase,
            stream=next_streams(old.stream),
            attended=reacted.attended,
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
