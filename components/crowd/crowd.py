"""The crowd: people who walk with a flow or on journeys, and react to each other, to walls and to robots."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from components.crowd.areas import Area, check_areas
from components.crowd.config import Config
from components.crowd.distributions import bounds
from components.crowd.flows import directions
from components.crowd.gait import walk
from components.crowd.groups import Groups, abreast
from components.crowd.journeys import Itineraries, Journey, Progress
from components.crowd.mixture import mix
from components.crowd.motion import move
from components.crowd.people import CHOICES, PLACES, STEPS, People, draw_people
from components.crowd.placement import check, place
from components.crowd.reactions import Reactions, face
from components.crowd.rows import join, select
from components.crowd.sampling import next_streams
from components.crowd.scene import Scene
from components.crowd.sources import COMING, Sources, stream_of
from components.crowd.walls import Walls
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.setup import Setup, time_of

Array = NDArray[np.float64]

AT_GOAL = 0.3
"""whoever is this near to a goal of their own has arrived [m]"""


@dataclass(frozen=True, kw_only=True, slots=True)
class _State:
    """The N people who are there: what changes from step to step, and who they are."""

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
    preferred: Array
    """(N, 2) velocities that people would walk at if they were alone [m/s]"""
    progress: Progress
    """on their journeys"""
    id: NDArray[np.uint32]
    """(N,) in the order in which they came"""
    people: People
    """what they are like"""


class CrowdModel(Mover):
    """People who start at rest and walk for ever in the direction of their flow, or on journeys."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> Crowd:
        """The people of the episode at t = 0, at rest.

        Raises:
            ValueError: if the people do not fit into the world, or cannot get to where they are to go.
        """
        config, world = self._config, setup.world
        self._period, self._time, self._dt = setup.period, 0, setup.dt
        self._walls, self._world_period = Walls.of(world), world.period.copy()
        self._rng = setup.rng(COMING)
        robots = np.array([(r.start.x, r.start.y, r.model.radius) for r in setup.robots], np.float64).reshape(-1, 3)
        areas, journeys = (config.areas, config.journeys) if config.goals is None else self._to_goals()
        journeys = () if setup.alone else journeys
        self._itineraries = Itineraries(journeys, areas, world, max(bounds(t.radius)[1] for _, _, t in config.parts))
        if config.journeys:
            people, journey, position, ways = self._on_journeys(setup, journeys, robots)
        else:
            people = draw_people(setup.rng, 0 if setup.alone else self._count, config.parts)
            journey = np.arange(len(people.radius)) if journeys else np.zeros(len(people.radius), np.int64)
            ways = directions(config.flow, int(people.party.max(initial=-1)) + 1)[people.party]
            position = self._places(setup, people, ways, robots)
        count = len(people.radius)
        progress = self._itineraries.begin(journey, self._rng)
        if config.goals is not None:
            progress = replace(progress, place=np.full((count, 2), 0.5))
            ways = self._itineraries.preferred(progress, position, np.ones(count))
        self._state = _State(
            position=position,
            velocity=np.zeros((count, 2)),
            heading=np.arctan2(ways[:, 1], ways[:, 0]),
            pace=np.zeros(count),
            phase=setup.rng(STEPS).random(count),
            stream=setup.rng(CHOICES).integers(0, 2**64, count, np.uint64),
            attended=np.zeros(count),
            preferred=people.preferred_speed[:, None] * ways,
            progress=progress,
            id=np.arange(1, count + 1, dtype=np.uint32),
            people=people,
        )
        self._last_id = count
        self._sources = Sources(setup, journeys, areas, config.parts) if config.journeys and journeys else None
        self._compose()
        # Compiles or loads the kernels, so that no step has to.
        self._next(self._state, np.empty((0, 5)))
        return self._message()

    def step(self, robots: tuple[RobotState, ...]) -> Crowd:
        """The people one time step later; they react to the robots as these were."""
        seen = np.array([(*r.position, *r.velocity, r.radius) for r in robots], np.float64).reshape(-1, 5)
        self._time += self._period
        self._state = self._next(self._state, seen)
        if self._config.goals is not None or self._config.journeys:
            self._come_and_go(seen)
        return self._message()

    @property
    def _count(self) -> int:
        return len(self._config.positions or ()) if self._config.count is None else self._config.count

    def _to_goals(self) -> tuple[dict[str, Area], tuple[Journey, ...]]:
        """A journey for everybody from their place to their goal, where they stay."""
        areas: dict[str, Area] = {}
        journeys = []
        for ends in zip(self._config.positions or (), self._config.goals or (), strict=True):
            names = [f"({x:g}, {y:g})" for x, y in ends]
            for name, (x, y) in zip(names, ends, strict=True):
                areas[name] = Area(x=(x - AT_GOAL, x + AT_GOAL), y=(y - AT_GOAL, y + AT_GOAL))
            journeys.append(Journey(start=names[0], goal=names[1], then="stay", count=1))
        return areas, tuple(journeys)

    def _on_journeys(
        self, setup: Setup, journeys: Sequence[Journey], robots: Array
    ) -> tuple[People, NDArray[np.int64], Array, Array]:
        """Those who are there at t = 0, the index of everybody's journey (N,), their places and first ways (N, 2)."""
        check_areas(self._config.areas, setup.world)
        people = draw_people(setup.rng, 0, self._config.parts)
        position = ways = np.empty((0, 2))
        for j, journey in enumerate(journeys):
            some = draw_people(stream_of(setup, j, 0), journey.count, self._config.parts)
            area = self._config.areas[journey.start].bounds
            progress = self._itineraries.begin(np.full(1, j), setup.rng(PLACES))
            way = np.repeat(
                self._itineraries.preferred(progress, area.mean(axis=0)[None], np.ones(1)), journey.count, 0
            )
            occupied = np.vstack([robots, np.column_stack([position, people.radius])])
            try:
                own = self._places(setup, some, way, occupied, stream=(PLACES, j + 1), area=area)
            except ValueError as error:
                raise ValueError(f"journeys[{j}], in area '{journey.start}': {error}") from None
            grouped = np.where(some.group > 0, some.group + people.group.max(initial=0), 0).astype(np.uint32)
            people = join(people, replace(some, group=grouped, party=some.party + people.party.max(initial=-1) + 1))
            position, ways = np.vstack([position, own]), np.vstack([ways, way])
        return people, np.repeat(np.arange(len(journeys)), [j.count for j in journeys]), position, ways

    def _places(
        self,
        setup: Setup,
        people: People,
        ways: Array,
        occupied: Array,
        *,
        stream: tuple[int, ...] = (PLACES,),
        area: Array | None = None,
    ) -> Array:
        """(N, 2) where people are at t = 0, in an area or anywhere, clear of what is `occupied` (M, 3) [m]."""
        config, world, radius = self._config, setup.world, people.radius
        if config.positions is not None and len(radius):
            position = np.array(config.positions, np.float64).reshape(-1, 2)
            check(position, radius, world, occupied)
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
        position[order] = place(
            setup.rng(*stream), radius[order], world, occupied, offset=offset, parties=sizes, bounds=area
        )
        return position

    def _compose(self) -> None:
        """Gather what is the same until somebody comes or goes."""
        config, state, people = self._config, self._state, self._state.people
        self._groups = Groups(people.group)
        self._mixture = mix(
            [traits.policy for _, _, traits in config.parts], people.population, people.variant, people.time_horizon
        )
        self._reactions = Reactions(
            [traits.reaction if config.reactive else "none" for _, _, traits in config.parts], people.population
        )
        self._scene = Scene(
            position=state.position,
            velocity=state.velocity,
            preferred=state.preferred,
            radius=people.radius,
            robots=np.empty((0, 5)),
            pushed_by_robots=self._reactions.pushed,
            walls=self._walls,
            period=self._world_period,
            max_speed=people.max_speed,
            max_acceleration=people.max_acceleration,
            stream=state.stream,
            dt=self._dt,
        )
        self._who = {
            "id": _read_only(state.id),
            "group": _read_only(people.group),
            "radius": _read_only(people.radius),
            "stature": _read_only(people.stature),
            "mass": _read_only(people.mass),
        }

    def _next(self, old: _State, robots: Array) -> _State:
        scene = replace(
            self._scene,
            position=old.position,
            velocity=old.velocity,
            preferred=old.preferred,
            robots=robots,
            stream=old.stream,
        )
        scene = replace(scene, preferred=self._groups.preferred(scene))
        reacted = self._reactions.react(scene, old.heading, old.attended)
        scene = replace(scene, preferred=reacted.preferred)
        position, velocity = move(scene, self._mixture.accelerate(scene, reacted.sight))
        heading, pace, phase = walk(velocity, old.heading, old.pace, old.phase, old.people.stature, scene.dt)
        return replace(
            old,
            position=position,
            velocity=velocity,
            heading=face(heading, reacted.bearing, velocity, scene.dt),
            pace=pace,
            phase=phase,
            stream=next_streams(old.stream),
            attended=reacted.attended,
        )

    def _come_and_go(self, robots: Array) -> None:
        """Who has arrived leaves, who is due comes, and everybody's preferred velocity is that of the new place."""
        state = self._state
        progress, leaves = self._itineraries.advance(state.progress, state.position, self._time, self._rng)
        state = replace(state, progress=progress)
        changed = bool(leaves.any())
        if changed:
            state = select(state, ~leaves)
        if self._sources is not None:
            # Robots have moved on since, for at most one step.
            reach = robots[:, 4] + np.hypot(robots[:, 2], robots[:, 3]) * self._dt
            occupied = np.column_stack([robots[:, :2], reach])
            for journey, some, place_ in self._sources.enter(self._time, state.position, state.people.radius, occupied):
                state, changed = join(state, self._newcomer(journey, some, place_)), True
        people = state.people
        preferred = self._itineraries.preferred(state.progress, state.position, people.preferred_speed)
        self._state = replace(state, preferred=preferred)
        if changed:
            self._compose()

    def _newcomer(self, journey: int, people: People, position: Array) -> _State:
        """Somebody who walks in at `position` (1, 2) [m] at the preferred velocity."""
        progress = self._itineraries.begin(np.full(1, journey), self._rng)
        velocity = self._itineraries.preferred(progress, position, people.preferred_speed)
        self._last_id += 1
        return _State(
            position=position,
            velocity=velocity,
            heading=np.arctan2(velocity[:, 1], velocity[:, 0]),
            pace=people.preferred_speed,
            phase=self._rng.random(1),
            stream=self._rng.integers(0, 2**64, 1, np.uint64),
            attended=np.zeros(1),
            preferred=velocity,
            progress=progress,
            id=np.full(1, self._last_id, np.uint32),
            people=people,
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
            **self._who,
        )


def _read_only(array: NDArray[Any]) -> NDArray[Any]:
    """A view that nobody can write through; a message takes it as it is, without a copy."""
    view = array.view()
    view.flags.writeable = False
    return view
