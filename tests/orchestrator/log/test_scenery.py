"""A log shows the world, robots, goals, walking people and new contacts."""

import math
from typing import Any

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from crowdcosim.messages import Contacts, Crowd
from crowdcosim.obstacles import Box
from crowdcosim.world import World
from orchestrator.lockstep import Committed
from orchestrator.log.marker import ARRAY_TYPE
from orchestrator.log.scenery import CONTACTS, PEOPLE, Scenery, world_record
from orchestrator.stimuli import ROBOT, WORLD, stimulus

STORE = get_typestore(Stores.ROS2_JAZZY)


def markers(payload: bytes) -> dict[str, Any]:
    return {m.ns: m for m in STORE.deserialize_cdr(payload, ARRAY_TYPE).markers}


def points(marker: Any) -> np.ndarray:
    return np.array([(p.x, p.y, p.z) for p in marker.points])


@pytest.fixture
def crowd() -> Crowd:
    message = stimulus(Crowd, 0.0)
    component = message()
    component._period, component._tick = 0, 0  # type: ignore[attr-defined]
    return component.step()  # type: ignore[attr-defined, no-any-return]


def scenery(message: Any) -> Scenery:
    return Scenery({("c", "p"): type(message).TYPE}, lambda component, port: message)


def test_everybody_has_a_head_as_high_as_he_is_tall_and_feet_on_the_ground(crowd: Crowd) -> None:
    (record,) = scenery(crowd).records([Committed("c", "p", 0, b"")])
    assert record.topic == PEOPLE
    shown = markers(record.payload)
    heads = points(shown["heads"])
    assert len(heads) == len(crowd.id)
    # A head's centre is 5% of the stature below its top, and walking lowers it; the trunk leans ahead.
    assert (np.abs(heads[:, 2] / crowd.stature - 0.92) < 0.03).all()
    assert (np.hypot(*(heads[:, :2] - crowd.position).T) < 0.15).all()
    assert points(shown["legs"])[:, 2].min() < 0.2


def test_people_are_drawn_five_times_a_second(crowd: Crowd) -> None:
    drawing = scenery(crowd)
    drawn = [k for k in range(101) if drawing.records([Committed("c", "p", k * 10_000_000, b"")])]
    assert drawn == [0, 20, 40, 60, 80, 100]


def test_a_contact_is_drawn_when_it_begins_unless_it_is_with_a_wall() -> None:
    common: dict[str, Any] = {"body_part": [0, 0, 0], "reflected_mass": [1.0] * 3, "energy": [1.0] * 3}
    common |= {"robot_part": [1] * 3, "striker": [1] * 3, "robot_closing_speed": [1.0] * 3}
    contacts = Contacts(
        robot="robot",
        kind=[Contacts.PERSON, Contacts.PERSON, Contacts.WALL],
        agent=[1, 2, 3],
        position=[[1.0, 2.0], [3.0, 4.0], [5.0, 6.0]],
        normal=[[1.0, 0.0]] * 3,
        relative_velocity=[[0.0, 0.0]] * 3,
        approach_speed=[1.0] * 3,
        duration=[0.0, 0.1, 0.0],
        **common,
    )
    (record,) = scenery(contacts).records([Committed("c", "p", 500_000_000, b"")])
    assert record.topic == CONTACTS
    (marker,) = markers(record.payload).values()
    assert points(marker)[:, :2].tolist() == [[1.0, 2.0]]
    assert scenery(Contacts()).records([Committed("c", "p", 0, b"")]) == []


def test_walls_and_obstacles_stand_on_the_floor_as_high_as_they_are() -> None:
    world = World(
        size=WORLD.size, walls=WORLD.walls, obstacles=(Box(shape="box", centre=(5, 5), size=(1, 1), height=0.8),)
    )
    shown = markers(world_record(world, (ROBOT,)).payload)
    walls = points(shown["walls"])
    assert sorted(set(walls[:, 2])) == [0.0, 0.8, 2.5]
    assert len(walls) == (2 + 4) * 2 * 2 * 3  # two triangles, seen from both sides
    assert shown["robot body"].header.frame_id == "robot/base_link"
    assert shown["robot body"].frame_locked
    assert shown["robot body"].scale.x == 2 * ROBOT.model.radius
    goal = points(shown["robot goal"])
    assert (goal[:, 0] == ROBOT.goal.x).all()
    assert math.dist(goal[0], goal[1]) == 4.0
