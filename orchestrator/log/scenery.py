"""What a log draws in Foxglove and RViz without any set-up: the world, robots, goals, walking people, contacts."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from crowdcosim import body
from crowdcosim.avatar import pose
from crowdcosim.messages import Contacts, Crowd
from crowdcosim.robots import Robot
from crowdcosim.world import World
from orchestrator.lockstep import Committed
from orchestrator.log.marker import (
    ARRAY_TYPE,
    CYLINDER,
    LINE_LIST,
    LINE_STRIP,
    SPHERE_LIST,
    TRIANGLE_LIST,
    Colour,
    Marker,
    encode_markers,
)
from orchestrator.log.recorder import Channel, Record

PERIOD = 200_000_000
"""people are drawn this often, in simulated time: more would make up most of a log [ns]"""

WORLD, PEOPLE, CONTACTS = "/markers/world", "/markers/people", "/markers/contacts"
MARKER_CHANNELS = (
    Channel(WORLD, ARRAY_TYPE, "", "markers", latched=True),
    Channel(PEOPLE, ARRAY_TYPE, "", "markers"),
    Channel(CONTACTS, ARRAY_TYPE, "", "markers"),
)

_WALL: Colour = (0.62, 0.64, 0.67, 0.6)
_FLOOR: Colour = (0.93, 0.93, 0.91, 1.0)
_ROBOT: Colour = (0.90, 0.45, 0.10, 1.0)
_GOAL: Colour = (0.15, 0.65, 0.35, 1.0)
_CONTACT: Colour = (0.85, 0.10, 0.15, 0.9)
_SKIN: Colour = (0.87, 0.68, 0.55, 1.0)
_SHIRT: Colour = (0.22, 0.45, 0.70, 1.0)
_TROUSERS: Colour = (0.20, 0.22, 0.30, 1.0)

_SEEN = 800_000_000
"""a contact stays in sight for so long [ns]"""


def _limbs(*names: str) -> NDArray[np.intp]:
    """Indices of the capsules whose names end so."""
    return np.array([i for i, segment in enumerate(body.SEGMENTS) if segment.endswith(names)])


# What is drawn of a body, from the feet up: as few lines as show that somebody walks.
_PARTS = (
    ("legs", _limbs("shank", "thigh"), 0.12, _TROUSERS),
    ("trunk", _limbs("left trunk"), 0.30, _SHIRT),
)
"""name, capsules, width of the lines [m], colour"""
_TRUNK, _OTHER_TRUNK = _limbs("trunk")
_HEAD = _limbs("head")

_GRID = 1024.0
"""points lie on multiples of 1 / 1024 m: numbers with few digits compress to half their size"""


class Scenery:
    """Draws what moves while a run is recorded."""

    def __init__(self, types: Mapping[tuple[str, str], str], newest: Callable[[str, str], Any]) -> None:
        """Args: the type of each output, by component and port; the newest message of one."""
        self._types = types
        self._newest = newest
        self._drawn: dict[str, int] = {}

    def records(self, made: list[Committed]) -> list[Record]:
        """The markers of what was made in one tick."""
        records = []
        for component, port, time_ns, _ in made:
            type_ = self._types[component, port]
            if type_ == Crowd.TYPE and time_ns // PERIOD > self._drawn.get(component, -1):
                self._drawn[component] = time_ns // PERIOD
                records.append(people_record(self._newest(component, port), time_ns))
            elif type_ == Contacts.TYPE:
                records += contact_records(self._newest(component, port), time_ns)
        return records


def world_record(world: World, robots: tuple[Robot, ...]) -> Record:
    """Floor, walls, obstacles, goals, and a body for every robot that follows its frame; at t = 0."""
    markers = [*_ground(world), *(marker for robot in robots for marker in _robot(robot))]
    return Record(WORLD, 0, encode_markers(0, markers))


def people_record(crowd: Crowd, time_ns: int) -> Record:
    """Everybody's legs, trunk and head."""
    capsules = pose(crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)[:, :, :6]
    capsules[:, _TRUNK] = 0.5 * (capsules[:, _TRUNK] + capsules[:, _OTHER_TRUNK])
    capsules = np.rint(capsules * _GRID) / _GRID
    markers = [
        Marker(
            namespace=name,
            frame="map",
            type=LINE_LIST,
            scale=(width, 0.0, 0.0),
            colour=colour,
            points=capsules[:, chosen].reshape(-1, 3),
        )
        for name, chosen, width, colour in _PARTS
    ]
    centres = 0.5 * (capsules[:, _HEAD, :3] + capsules[:, _HEAD, 3:6]).reshape(-1, 3)
    markers.append(
        Marker(
            namespace="heads",
            frame="map",
            type=SPHERE_LIST,
            scale=(0.18, 0.18, 0.24),
            colour=_SKIN,
            points=centres,
        )
    )
    return Record(PEOPLE, time_ns, encode_markers(time_ns, markers))


def contact_records(contacts: Contacts, time_ns: int) -> list[Record]:
    """A red ball, for a while, at each contact with a person or robot that has just begun."""
    new = (contacts.duration == 0.0) & (contacts.kind != Contacts.WALL)
    if not new.any():
        return []
    marker = Marker(
        namespace=f"{contacts.robot} contacts",
        number=time_ns // 1_000_000 % 2**31,
        frame="map",
        type=SPHERE_LIST,
        scale=(0.2, 0.2, 0.2),
        colour=_CONTACT,
        points=np.column_stack([contacts.position[new], np.full(int(new.sum()), 0.3)]),
        lifetime=_SEEN,
    )
    return [Record(CONTACTS, time_ns, encode_markers(time_ns, [marker]))]


def _ground(world: World) -> Iterator[Marker]:
    width, depth = world.size
    corners = np.array([(0.0, 0.0, -0.01), (width, 0.0, -0.01), (width, depth, -0.01), (0.0, depth, -0.01)])
    yield _triangles("floor", corners[[0, 1, 2, 0, 2, 3]], _FLOOR)
    ends, heights = world.segments, world.segment_heights
    if len(ends):
        low = np.concatenate([ends, np.zeros((len(ends), 2, 1))], axis=2)
        high = np.concatenate([ends, np.broadcast_to(heights[:, None, None], (len(ends), 2, 1))], axis=2)
        faces = np.stack([low[:, 0], low[:, 1], high[:, 1], low[:, 0], high[:, 1], high[:, 0]], axis=1)
        # Both sides, as viewers may leave out those that look away.
        yield _triangles("walls", np.concatenate([faces, faces[:, ::-1]]).reshape(-1, 3), _WALL)


def _triangles(namespace: str, points: NDArray[np.float64], colour: Colour) -> Marker:
    return Marker(
        namespace=namespace, frame="map", type=TRIANGLE_LIST, scale=(1.0, 1.0, 1.0), colour=colour, points=points
    )


def _robot(robot: Robot) -> Iterator[Marker]:
    model, goal = robot.model, robot.goal
    yield Marker(
        namespace=f"{robot.name} body",
        frame=f"{robot.name}/base_link",
        type=CYLINDER,
        position=(0.0, 0.0, 0.5 * model.height),
        scale=(2.0 * model.radius, 2.0 * model.radius, model.height),
        colour=_ROBOT,
        moves_with_frame=True,
    )
    yield Marker(
        namespace=f"{robot.name} front",
        frame=f"{robot.name}/base_link",
        type=LINE_STRIP,
        scale=(0.04, 0.0, 0.0),
        colour=_FLOOR,
        points=np.array([(0.0, 0.0, model.height + 0.02), (model.radius, 0.0, model.height + 0.02)]),
        moves_with_frame=True,
    )
    yield Marker(
        namespace=f"{robot.name} goal",
        frame="map",
        type=LINE_STRIP,
        scale=(0.08, 0.0, 0.0),
        colour=_GOAL,
        points=_goal_line(goal.x, goal.y, goal.direction, goal.tolerance),
    )


def _goal_line(x: float, y: float, direction: tuple[float, float], tolerance: float) -> NDArray[np.float64]:
    """The line to cross, 4 m of it, or the circle to enter."""
    if any(direction):
        aside = 2.0 * np.array([(-direction[1], direction[0]), (direction[1], -direction[0])])
        return np.column_stack([np.add(aside, (x, y)), np.full(2, 0.02)])
    angle = np.linspace(0.0, 2.0 * math.pi, 33)
    return np.column_stack([x + tolerance * np.cos(angle), y + tolerance * np.sin(angle), np.full(33, 0.02)])
