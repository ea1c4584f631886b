"""A car-like base: the bicycle's circle, its limits, and how obstacles stop it."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.robot.car import CarDrive
from crowdcosim.robots import Car, Pose
from crowdcosim.world import Wall, World

R = 0.177
TOUCH = 1e-3
ROUNDING = 1e-12
BASE = Car(wheelbase=0.24, max_steering_angle=0.5, max_steering_rate=2.0)


@pytest.fixture(scope="module")
def car(turtlebot):
    return dataclasses.replace(turtlebot, base=BASE)


def settled(scene, command, steps=30):
    for _ in range(steps):
        state = scene.step(command)[0].state
    return state


def test_straight_it_drives_as_the_differential_drive_does(bodies, twist, car):
    ours, differential = bodies(Pose(x=3.0, y=4.0, heading=0.3), model=car), bodies(Pose(x=3.0, y=4.0, heading=0.3))
    for _ in range(30):
        state, other = ours.step(twist(0.8))[0].state, differential.step(twist(0.8))[0].state
        assert state.position == pytest.approx(other.position, abs=ROUNDING)
        assert state.velocity == pytest.approx(other.velocity, abs=ROUNDING)
        assert state.heading == pytest.approx(0.3, abs=ROUNDING)


def test_the_rear_axle_draws_the_commanded_circle(bodies, twist, car):
    scene = bodies(Pose(x=3.0, y=4.0), model=car)
    command = twist(0.5, 0.4)
    state = settled(scene, command)

    def rear_axle(state):
        return state.position - 0.12 * np.array([math.cos(state.heading), math.sin(state.heading)])

    centre = rear_axle(state) + 0.5 / 0.4 * np.array([-math.sin(state.heading), math.cos(state.heading)])
    for _ in range(100):
        state = scene.step(command)[0].state
        # An arc of the means of each inner step is exact where rates are constant.
        assert np.hypot(*(rear_axle(state) - centre)) == pytest.approx(1.25, abs=1e-11)
        assert state.angular_velocity == pytest.approx(0.4, abs=ROUNDING)


def test_the_velocity_is_that_of_the_centre(bodies, twist, car):
    """It is ahead of the rear axle and moves sideways by omega L / 2; positions say the same."""
    scene = bodies(Pose(x=3.0, y=4.0), model=car, period=1_000_000)
    for _ in range(2000):
        before = scene.last[0].state
        state = scene.step(twist(0.5, 0.6))[0].state
    mean = (state.position - before.position) / 1e-3
    assert mean == pytest.approx(0.5 * (before.velocity + state.velocity), abs=1e-6)  # O(h^2 omega^2 v)
    left = math.cos(state.heading) * state.velocity[1] - math.sin(state.heading) * state.velocity[0]
    assert left == pytest.approx(0.6 * 0.12, abs=ROUNDING)


def test_it_cannot_turn_on_the_spot_nor_tighter_than_its_steering_allows(bodies, twist, car):
    scene = bodies(Pose(x=3.0, y=4.0), model=car)
    state = settled(scene, twist(0.0, 2.0))
    assert (state.heading, state.position.tolist()) == (0.0, [3.0, 4.0])
    state = settled(scene, twist(0.3, 3.0))
    assert state.angular_velocity == pytest.approx(0.3 * math.tan(0.5) / 0.24, abs=ROUNDING)


def test_backwards_the_commanded_turn_rate_holds_too(bodies, twist, car):
    state = settled(bodies(Pose(x=3.0, y=4.0), model=car), twist(-0.2, 0.3))
    assert state.angular_velocity == pytest.approx(0.3, abs=ROUNDING)


@given(
    commands=st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=20),
    h=st.floats(1e-4, 0.5),
)
def test_no_command_exceeds_the_limits(car, twist, commands, h):
    drive = CarDrive(model=car, x=0.0, y=0.0, heading=0.0)
    for speed, turn_rate in commands:
        before = drive.speed, drive.steering
        motion = drive.plan(twist(speed, turn_rate), h)
        drive.move(motion)
        assert -0.2 <= drive.speed <= 1.0
        assert abs(drive.steering) <= 0.5
        assert abs(drive.speed - before[0]) <= 5.0 * h + ROUNDING
        assert abs(drive.steering - before[1]) <= 2.0 * h + ROUNDING
        assert math.hypot(*drive.velocity) <= drive.top_speed + ROUNDING
        assert math.hypot(motion.dx, motion.dy) <= drive.top_speed * h + ROUNDING


def test_a_wall_stops_it_where_it_touches_and_it_stays_on_its_line(bodies, twist, car):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(4.5, 0.0), end=(7.5, 10.0)),))
    scene = bodies(Pose(x=3.0, y=4.0), world=world, model=car)
    state = settled(scene, twist(1.0), 60)
    assert (state.position[1], state.heading) == (4.0, 0.0)
    distance = abs(10.0 * (state.position[0] - 4.5) - 3.0 * state.position[1]) / math.hypot(3.0, 10.0)
    assert distance == pytest.approx(R, abs=TOUCH)
    assert state.velocity.tolist() == [0.0, 0.0]


def test_held_at_a_wall_it_cannot_turn_but_back_out(bodies, twist, car):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(4.0, 0.0), end=(4.0, 10.0)),))
    scene = bodies(Pose(x=3.0, y=4.0), world=world, model=car)
    settled(scene, twist(1.0))
    state = settled(scene, twist(1.0, 1.0))
    assert state.heading == pytest.approx(0.0, abs=ROUNDING)
    assert state.angular_velocity == 0.0
    state = settled(scene, twist(-0.2, 0.0), 20)
    assert state.position[0] < 3.6


def test_a_person_ahead_holds_it_until_they_leave(bodies, twist, people, car):
    scene = bodies(Pose(x=3.0, y=4.0), model=car)
    for _ in range(20):
        state = scene.step(twist(1.0), crowd=people((4.0, 4.05, 0.0, 0.0)))[0].state
    assert state.velocity.tolist() == [0.0, 0.0]
    for _ in range(5):
        state = scene.step(twist(1.0), crowd=people((4.0, 9.0, 0.0, 0.0)))[0].state
    assert state.velocity == pytest.approx([1.0, 0.0])
    assert state.position[1] == 4.0
