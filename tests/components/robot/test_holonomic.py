"""A base that moves in any direction: closed forms of its motion, its limits, and how obstacles deflect it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.robot.drive import Bound
from components.robot.holonomic import HolonomicDrive, nearest_within
from crowdcosim.messages import Contacts
from crowdcosim.robots import Holonomic, Pose
from crowdcosim.world import Wall, World

R = 0.177
TOUCH = 1e-3
ROUNDING = 1e-12


@pytest.fixture(scope="module")
def holonomic(turtlebot):
    return dataclasses.replace(turtlebot, min_speed=-1.0, base=Holonomic(max_lateral_speed=0.5))


def test_it_moves_aside_without_turning(bodies, twist, holonomic):
    scene = bodies(Pose(x=3.0, y=4.0, heading=math.pi / 2), model=holonomic)
    for _ in range(20):
        state = scene.step(twist(0.0, 0.0, 0.5))[0].state
    # To the left of north is west; 0.5 m/s at 5 m/s2 costs v^2 / 2a = 25 mm.
    assert state.position == pytest.approx([3.0 - 1.0 + 0.025, 4.0], abs=ROUNDING)
    assert state.velocity == pytest.approx([-0.5, 0.0], abs=ROUNDING)
    assert state.heading == math.pi / 2


def test_turning_on_the_way_bends_the_path_but_not_its_speed(bodies, twist, holonomic):
    """A velocity that is constant in the robot's frame turns with it: a circle of v / omega."""
    scene = bodies(Pose(x=3.0, y=4.0), model=holonomic)
    command = twist(0.3, 0.5, 0.4)
    for _ in range(5):
        start = scene.step(command)[0].state
    normal = np.array([-start.velocity[1], start.velocity[0]])  # of length v, to the left of the way
    centre = start.position + normal / 0.5
    for _ in range(100):
        state = scene.step(command)[0].state
        assert np.hypot(*(state.position - centre)) == pytest.approx(0.5 / 0.5, abs=1e-11)
        assert np.hypot(*state.velocity) == pytest.approx(0.5, abs=ROUNDING)


@given(
    commands=st.lists(st.tuples(*[st.floats(-1e6, 1e6)] * 3), min_size=1, max_size=20),
    h=st.floats(1e-4, 0.5),
)
def test_no_command_exceeds_the_limits(holonomic, twist, commands, h):
    model = dataclasses.replace(holonomic, min_speed=-0.2)
    drive = HolonomicDrive(model=model, x=0.0, y=0.0, heading=0.0)
    for ahead, turn_rate, left in commands:
        before = drive.speed, drive.lateral_speed
        drive.move(drive.plan(twist(ahead, turn_rate, left), h))
        assert drive.speed >= -0.2 - ROUNDING
        assert math.hypot(drive.speed, drive.lateral_speed) <= 1.0 + ROUNDING
        assert abs(drive.lateral_speed) <= 0.5 + ROUNDING
        change = math.hypot(drive.speed - before[0], drive.lateral_speed - before[1])
        assert change <= 5.0 * h + ROUNDING


def test_a_command_beyond_the_limits_keeps_its_direction(bodies, twist, holonomic):
    scene = bodies(Pose(x=3.0, y=4.0), model=holonomic)
    for _ in range(10):
        state = scene.step(twist(3.0, 0.0, 3.0))[0].state
    assert state.velocity == pytest.approx([0.5, 0.5], abs=ROUNDING)


def test_a_wall_deflects_it_along_itself(bodies, twist, holonomic):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(0.0, 5.0), end=(50.0, 5.0)),))
    scene = bodies(Pose(x=3.0, y=4.0), world=world, model=holonomic)
    for _ in range(60):
        state, contacts = scene.step(twist(0.4, 0.0, 0.4))[0]
    assert state.position[1] == pytest.approx(5.0 - R, abs=ROUNDING)
    assert state.velocity == pytest.approx([0.4, 0.0], abs=ROUNDING)
    assert state.position[0] > 3.0 + 0.4 * 5.8
    assert contacts.kind.tolist() == [Contacts.WALL]


def test_a_corner_stops_it(bodies, twist, holonomic):
    world = World(
        size=(50.0, 10.0), walls=(Wall(start=(0.0, 5.0), end=(6.0, 5.0)), Wall(start=(6.0, 0.0), end=(6.0, 5.0)))
    )
    scene = bodies(Pose(x=5.0, y=4.3), world=world, model=holonomic)
    for _ in range(60):
        state = scene.step(twist(0.4, 0.0, 0.4))[0].state
    assert state.position == pytest.approx([6.0 - R, 5.0 - R], abs=TOUCH)
    assert state.velocity == pytest.approx([0.0, 0.0], abs=ROUNDING)


def test_somebody_who_stands_off_its_line_is_passed(bodies, twist, people, holonomic):
    scene = bodies(Pose(x=3.0, y=4.0), model=holonomic)
    crowd = people((4.0, 4.1, 0.0, 0.0))
    touched = 0
    for _ in range(60):
        state, contacts = scene.step(twist(1.0), crowd=crowd)[0]
        touched += len(contacts.agent)
        assert np.hypot(*(state.position - (4.0, 4.1))) >= 0.3 + R - TOUCH
    assert touched > 0
    assert state.position[0] > 5.0
    assert state.position[1] < 4.1 - 0.3 - R + TOUCH


def test_somebody_dead_ahead_stops_it(bodies, twist, people, holonomic):
    scene = bodies(Pose(x=3.0, y=4.0), model=holonomic)
    for _ in range(30):
        state = scene.step(twist(1.0), crowd=people((4.0, 4.0, 0.0, 0.0)))[0].state
    assert state.position == pytest.approx([4.0 - 0.3 - R, 4.0], abs=TOUCH)
    assert state.velocity == pytest.approx([0.0, 0.0], abs=ROUNDING)


@settings(max_examples=40, deadline=None)
@given(
    speed=st.sampled_from([1.0, 30.0]),
    start=st.tuples(st.floats(-3.0, 3.0), st.floats(-3.0, 3.0)),
    ways=st.lists(st.floats(-math.pi, math.pi), min_size=8, max_size=8),
)
def test_no_wall_is_driven_through_at_any_speed(bodies, twist, holonomic, speed, start, ways):
    corners = [(0.0, 0.0), (3.0, 0.0), (4.0, 3.0), (0.0, 2.0)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    model = dataclasses.replace(
        holonomic,
        max_speed=speed,
        min_speed=-speed,
        max_acceleration=1000.0,
        base=Holonomic(max_lateral_speed=speed),
    )
    scene = bodies(Pose(x=1.0, y=1.0, heading=start[0]), world=World(size=(4.0, 3.0), walls=walls), model=model)
    for way in np.repeat(ways, 4):
        state = scene.step(twist(speed * math.cos(way), start[1], speed * math.sin(way)))[0].state
        for wall in walls:
            (x, y), (dx, dy) = wall.start, np.subtract(wall.end, wall.start)
            inside = (dx * (state.position[1] - y) - dy * (state.position[0] - x)) / np.hypot(dx, dy)
            assert inside >= R - TOUCH


@given(
    way=st.tuples(st.floats(-1, 1), st.floats(-1, 1)),
    planes=st.lists(st.tuples(st.floats(-math.pi, math.pi), st.floats(0, 0.5)), max_size=4),
)
def test_what_is_left_is_the_nearest_way_within_the_bounds(way, planes):
    """The oracle looks for it on a fine grid."""
    bounds = [Bound(math.cos(angle), math.sin(angle), most, 1.0) for angle, most in planes]
    x, y = nearest_within(way, bounds)
    assert all(b.nx * x + b.ny * y <= b.most + 1e-9 for b in bounds)
    grid = np.stack(np.meshgrid(np.linspace(-1.5, 1.5, 121), np.linspace(-1.5, 1.5, 121)), axis=-1).reshape(-1, 2)
    fits = np.all([grid @ (b.nx, b.ny) <= b.most for b in bounds], axis=0) if bounds else np.ones(len(grid), bool)
    if bounds and not all(b.nx * way[0] + b.ny * way[1] <= b.most for b in bounds):
        least = np.hypot(*(grid[fits] - way).T).min(initial=np.inf)
        assert math.hypot(x - way[0], y - way[1]) <= least + 1e-9
