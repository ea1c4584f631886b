"""What walls, people and other robots do to a robot that drives at them, and what they do not."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crowdcosim.messages import Contacts
from crowdcosim.robots import Pose
from crowdcosim.world import Wall, World

CORRIDOR = World(
    size=(50.0, 10.0),
    periodic=(True, True),
    walls=(
        Wall(start=(0.0, 0.0), end=(50.0, 0.0), stops_people=False),
        Wall(start=(50.0, 0.0), end=(50.0, 10.0), stops_people=False),
        Wall(start=(50.0, 10.0), end=(0.0, 10.0), stops_people=False),
        Wall(start=(0.0, 10.0), end=(0.0, 0.0), stops_people=False),
    ),
)
R = 0.177
# What counts as touching, and so the most by which a robot may be off.
TOUCH = 1e-3


def distance_to_wall(position, wall):
    start, end = np.array(wall.start), np.array(wall.end)
    along = np.clip((position - start) @ (end - start) / ((end - start) @ (end - start)), 0.0, 1.0)
    return np.hypot(*(start + along * (end - start) - position))


def gap(a, b, world):
    return np.hypot(*world.displacement(a.position, b.position)) - a.radius - b.radius


@settings(max_examples=40, deadline=None)
@given(
    wall=st.tuples(*[st.floats(-1.5, 1.5)] * 4).filter(lambda w: np.hypot(w[0] - w[2], w[1] - w[3]) > 0.1),
    heading=st.floats(-math.pi, math.pi),
    turns=st.lists(st.floats(-3, 3), min_size=8, max_size=8),
)
def test_no_wall_is_entered(bodies, twist, wall, heading, turns):
    wall = Wall(start=(5.0 + wall[0], 5.0 + wall[1]), end=(5.0 + wall[2], 5.0 + wall[3]))
    if distance_to_wall(np.array([5.0, 5.0]), wall) < R:
        return
    scene = bodies(Pose(x=5.0, y=5.0, heading=heading), world=World(size=(50.0, 10.0), walls=(wall,)))
    for turn in np.repeat(turns, 4):
        state = scene.step(twist(1.0, turn))[0].state
        assert distance_to_wall(state.position, wall) >= R - TOUCH


@settings(max_examples=40, deadline=None)
@given(
    speed=st.sampled_from([1.0, 30.0]),
    heading=st.floats(-math.pi, math.pi),
    turns=st.lists(st.floats(-3, 3), min_size=8, max_size=8),
)
def test_no_wall_is_driven_through_at_any_speed(bodies, twist, turtlebot, speed, heading, turns):
    corners = [(0.0, 0.0), (3.0, 0.0), (4.0, 3.0), (0.0, 2.0)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    model = dataclasses.replace(turtlebot, max_speed=speed, max_acceleration=1000.0)
    scene = bodies(Pose(x=1.0, y=1.0, heading=heading), world=World(size=(4.0, 3.0), walls=walls), model=model)
    for turn in np.repeat(turns, 4):
        state = scene.step(twist(speed, turn))[0].state
        for wall in walls:
            (x, y), (dx, dy) = wall.start, np.subtract(wall.end, wall.start)
            inside = (dx * (state.position[1] - y) - dy * (state.position[0] - x)) / np.hypot(dx, dy)
            assert inside >= R - TOUCH


@pytest.mark.parametrize("speed", [0.3, 1.0, 30.0])
def test_a_wall_ahead_stops_the_robot_where_it_touches(bodies, twist, turtlebot, speed):
    model = dataclasses.replace(turtlebot, max_speed=speed, max_acceleration=100.0)
    scene = bodies(Pose(x=47.0, y=5.0), world=CORRIDOR, model=model)
    for _ in range(120):
        state = scene.step(twist(speed))[0].state
    assert state.position == pytest.approx([50.0 - R, 5.0], abs=1e-12)  # exact against a plane
    assert state.velocity.tolist() == [0.0, 0.0]


def test_a_corner_stops_the_robot_at_both_walls(bodies, twist):
    scene = bodies(Pose(x=48.0, y=8.0, heading=math.pi / 4), world=CORRIDOR)
    for _ in range(40):
        state, contacts = scene.step(twist(1.0))[0]
    assert state.position == pytest.approx([50.0 - R, 10.0 - R], abs=TOUCH)
    assert contacts.agent.tolist() == [2, 3]


@pytest.mark.parametrize("heading", [0.0, math.pi / 2, math.pi, -math.pi / 2])
def test_a_robot_drives_along_a_wall_that_it_touches(bodies, twist, heading):
    c, s = math.cos(heading), math.sin(heading)
    wall = Wall(start=(5 - 9 * c - R * s, 5 - 9 * s + R * c), end=(5 + 9 * c - R * s, 5 + 9 * s + R * c))
    scene = bodies(Pose(x=5.0, y=5.0, heading=heading), world=World(size=(20.0, 20.0), walls=(wall,)))
    for _ in range(20):
        state, contacts = scene.step(twist(1.0))[0]
    assert state.position == pytest.approx([5 + 1.9 * c, 5 + 1.9 * s], abs=1e-9)  # 0.1 m lost in accelerating
    assert contacts.kind.tolist() == [Contacts.WALL]


def test_a_robot_at_a_wall_can_turn_and_drive_away(bodies, twist):
    scene = bodies(Pose(x=49.5, y=5.0), world=CORRIDOR)
    for _ in range(10):
        scene.step(twist(1.0))
    for _ in range(16):
        scene.step(twist(0.0, 2.0))
    for _ in range(20):
        state = scene.step(twist(1.0))[0].state
    assert state.position[0] < 48.5


def test_a_person_ahead_stops_the_robot_until_contact_ends(bodies, twist, people):
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(20):
        state = scene.step(twist(1.0), crowd=people((4.0, 4.0, 0.0, 0.0)))[0].state
    assert state.position == pytest.approx([4.0 - 0.3 - R, 4.0], abs=TOUCH)
    assert state.velocity.tolist() == [0.0, 0.0]
    for _ in range(2):
        state = scene.step(twist(1.0), crowd=people((4.0, 9.0, 0.0, 0.0)))[0].state
    assert state.velocity == pytest.approx([1.0, 0.0])


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_a_straight_driver_stays_on_its_line_and_only_loses_time(bodies, twist, people, seed):
    """People who see no robot walk through it from everywhere; it is neither pushed aside nor backwards."""
    rng = np.random.default_rng(seed)
    position = rng.uniform((0.0, 2.0), (8.0, 8.0), (25, 2))
    velocity = rng.uniform(-1.5, 1.5, (25, 2))
    scene = bodies(Pose(x=3.0, y=5.0))
    before = 3.0
    for _ in range(60):
        state = scene.step(twist(1.0), crowd=people(*np.hstack([position, velocity])))[0].state
        assert state.position[1] == 5.0
        assert before <= state.position[0] <= before + 0.1 + 1e-12
        assert 0.0 <= state.velocity[0] <= 1.0
        position += velocity * 0.1
        before = state.position[0]


@settings(max_examples=50, deadline=None)
@given(angle=st.floats(-math.pi, math.pi), depth=st.floats(0.0, 0.45), reverse=st.booleans())
def test_only_contact_ahead_holds_the_robot(bodies, twist, people, angle, depth, reverse):
    ahead = (math.cos(angle) > 0.0) != reverse
    if abs(math.cos(angle)) < 1e-3:
        return
    reach = 0.3 + R - depth
    crowd = people((3.0 + reach * math.cos(angle), 4.0 + reach * math.sin(angle), 0.0, 0.0))
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(10):
        state = scene.step(twist(-0.2 if reverse else 1.0), crowd=crowd)[0].state
    moved = abs(state.position[0] - 3.0)
    if ahead:
        assert moved <= TOUCH
    else:
        assert moved == pytest.approx(0.2 * 0.98 if reverse else 0.9, abs=1e-9)


def test_a_robot_held_by_someone_ahead_can_turn_and_leave(bodies, twist, people):
    crowd = people((3.3, 4.0, 0.0, 0.0))
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(20):
        scene.step(twist(0.0, math.pi / 2), crowd=crowd)
    for _ in range(10):
        state = scene.step(twist(1.0), crowd=crowd)[0].state
    assert np.hypot(*(state.position - (3.0, 4.0))) > 0.8


def test_people_across_the_seam_are_touched(bodies, twist, people):
    seam = World(size=(50.0, 10.0), periodic=(True, False))
    scene = bodies(Pose(x=49.0, y=4.0), world=seam)
    for _ in range(30):
        state, contacts = scene.step(twist(1.0), crowd=people((0.5, 4.0, 0.0, 0.0)))[0]
    assert state.position == pytest.approx([50.5 - 0.3 - R, 4.0], abs=TOUCH)
    assert contacts.agent.tolist() == [101]
    assert contacts.normal[0] == pytest.approx([1.0, 0.0])


def test_someone_fast_who_crosses_within_one_step_is_noticed(bodies, twist, people):
    """At both ends of the step they are 0.14 m apart; in between they overlap."""
    contacts = bodies(Pose(x=3.0, y=4.0)).step(twist(), crowd=people((3.45, 3.575, 0.0, 8.5)))[0].contacts
    assert contacts.agent.tolist() == [101]
    assert contacts.approach_speed[0] > 0.0


@pytest.mark.parametrize("distance", [1.7, 3.03, 2.5 + R])
def test_two_robots_head_on_stop_where_they_meet(bodies, twist, distance):
    scene = bodies(Pose(x=3.0, y=4.0), Pose(x=3.0 + distance, y=4.0, heading=math.pi), world=CORRIDOR)
    first = None
    for _ in range(30):
        a, b = scene.step(twist(1.0), twist(1.0))
        assert len(a.contacts.kind) == len(b.contacts.kind)
        if first is None and len(a.contacts.kind):
            first = a.contacts, b.contacts
    middle = 3.0 + distance / 2
    assert a.state.position == pytest.approx([middle - R, 4.0], abs=TOUCH)
    assert b.state.position == pytest.approx([middle + R, 4.0], abs=TOUCH)
    assert a.state.velocity.tolist() == b.state.velocity.tolist() == [0.0, 0.0]
    mine, theirs = first
    assert (mine.agent.tolist(), theirs.agent.tolist()) == ([2], [1])
    assert mine.energy == pytest.approx(theirs.energy, rel=1e-12)
    assert mine.relative_velocity == pytest.approx(-theirs.relative_velocity, abs=1e-12)
    # Both at full speed: reduced mass 10 kg at 2 m/s.
    assert mine.energy == pytest.approx([0.5 * 10.0 * 2.0**2], rel=1e-12)


def test_a_standing_robot_is_not_displaced(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0), Pose(x=4.5, y=4.05))
    for _ in range(30):
        a, b = scene.step(twist(1.0), twist(0.0))
    assert b.state.position.tolist() == [4.5, 4.05]
    assert gap(a.state, b.state, CORRIDOR) == pytest.approx(0.0, abs=TOUCH)
    assert a.contacts.energy == pytest.approx(b.contacts.energy, rel=1e-12)


def test_robots_that_touch_can_part(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0), Pose(x=3.354, y=4.0, heading=math.pi))
    for _ in range(5):
        scene.step(twist(1.0), twist(1.0))
    for _ in range(10):
        a, b = scene.step(twist(-0.2), twist(-0.2))
    assert gap(a.state, b.state, CORRIDOR) == pytest.approx(2 * 0.2 * 0.98, abs=TOUCH)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_robots_that_jostle_overlap_by_less_than_what_both_accelerate_in_one_step(bodies, twist, seed):
    """Each takes the others to keep their velocity: it errs by a dt^2 / 2, a = 5 m/s2 forward, v omega sideways.

    Of two, both may err.
    """
    rng = np.random.default_rng(seed)
    starts = [Pose(x=x, y=y, heading=rng.uniform(-4, 4)) for x in (4.0, 4.6) for y in (4.0, 4.6)]
    world = World(size=(3.0, 10.0), periodic=(True, False))
    scene = bodies(*starts, world=world)
    bound = 2 * 0.5 * math.hypot(5.0, math.pi) * 0.1**2
    for _ in range(60):
        results = scene.step(*(twist(*rng.uniform((-0.5, -3.0), (1.5, 3.0))) for _ in starts))
        states = [result.state for result in results]
        assert min(gap(a, b, world) for k, a in enumerate(states) for b in states[:k]) >= -bound - TOUCH


def test_the_same_inputs_give_the_same_bits(bodies, twist, people):
    def run():
        rng = np.random.default_rng(7)
        scene = bodies(Pose(x=3.0, y=5.0), Pose(x=6.0, y=5.0, heading=math.pi), world=CORRIDOR)
        for _ in range(50):
            crowd = people(*rng.uniform((2, 4, -1, -1), (7, 6, 1, 1), (20, 4)))
            yield scene.step(twist(1.0, rng.normal()), twist(1.0, rng.normal()), crowd=crowd)

    assert list(run()) == list(run())


def test_people_who_are_near_but_not_touched_change_nothing(bodies, twist, people):
    alone, among = bodies(Pose(x=3.0, y=4.0)), bodies(Pose(x=3.0, y=4.0))
    for _ in range(30):
        crowd = people((among.last[0].state.position[0] + 0.2, 4.0 + 0.3 + R + 2 * TOUCH, 1.0, 0.0))
        assert among.step(twist(1.0), crowd=crowd) == alone.step(twist(1.0))
