"""Motion without obstacles, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.robot.differential import DifferentialDrive
from components.robot.drive import chord
from components.robot.kinematic import Kinematic
from crowdcosim.component import ports_of
from crowdcosim.messages import Contacts, RobotState
from crowdcosim.robots import Pose
from crowdcosim.setup import nanoseconds_of

# Sums of some hundred double-precision increments of at most 1.
ROUNDING = 1e-12


def test_ports_are_those_that_scenarios_wire():
    ports = ports_of(Kinematic)
    assert [port.name for port in ports.inputs] == ["twist", "crowd", "others"]
    assert [(port.name, port.type) for port in ports.outputs] == [("state", RobotState), ("contacts", Contacts)]


def test_first_state_is_the_start_pose_at_rest(bodies):
    state, contacts = bodies(Pose(x=3.0, y=4.0, heading=0.5)).last[0]
    assert nanoseconds_of(state.header.stamp) == 0
    assert state.header.frame_id == "map"
    assert (state.name, state.radius, state.heading) == ("robot1", 0.177, 0.5)
    assert state.position.tolist() == [3.0, 4.0]
    assert state.velocity.tolist() == [0.0, 0.0]
    assert (contacts.robot, len(contacts.kind)) == ("robot1", 0)


def test_stamps_advance_by_the_period(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0), period=30_000_000)
    for k in range(1, 4):
        state, contacts = scene.step(twist(1.0))[0]
        assert nanoseconds_of(state.header.stamp) == 30_000_000 * k
        assert contacts.header == state.header


def test_distance_to_reach_full_speed_is_v_squared_over_2a(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(2):  # 1 m/s at 5 m/s2 takes 0.2 s
        state = scene.step(twist(1.0))[0].state
    assert state.velocity == pytest.approx([1.0, 0.0], abs=ROUNDING)
    assert state.position == pytest.approx([3.0 + 1.0 / (2 * 5.0), 4.0], abs=ROUNDING)


def test_braking_distance_is_v_squared_over_2a(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0))
    for _ in range(2):
        start = scene.step(twist(1.0))[0].state
    for _ in range(3):
        state = scene.step(twist(0.0))[0].state
    assert state.velocity == pytest.approx([0.0, 0.0], abs=ROUNDING)
    assert state.position - start.position == pytest.approx([0.1, 0.0], abs=ROUNDING)


def test_constant_command_draws_a_circle(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0, heading=2.0))
    command = twist(0.8, 0.5)
    for _ in range(5):
        start = scene.step(command)[0].state
    radius = 0.8 / 0.5
    centre = start.position + radius * np.array([-math.sin(start.heading), math.cos(start.heading)])
    for k in range(1, 200):
        state = scene.step(command)[0].state
        angle = start.heading + 0.5 * 0.1 * k
        expected = centre + radius * np.array([math.sin(angle), -math.cos(angle)])
        assert state.position == pytest.approx(expected, abs=ROUNDING)
        assert math.remainder(state.heading - angle, 2 * math.pi) == pytest.approx(0.0, abs=ROUNDING)
        assert state.velocity == pytest.approx([0.8 * math.cos(angle), 0.8 * math.sin(angle)], abs=ROUNDING)
        assert state.angular_velocity == 0.5


def test_full_turn_on_the_spot_comes_back_to_the_same_heading(bodies, twist):
    scene = bodies(Pose(x=3.0, y=4.0, heading=1.0))
    for _ in range(100):
        state = scene.step(twist(0.0, 1.0))[0].state
        assert -math.pi <= state.heading <= math.pi
    assert state.position.tolist() == [3.0, 4.0]
    # 1 rad/s at 10 rad/s2 takes 0.1 s, in which it turns by 0.05 rad instead of 0.1.
    assert state.heading == pytest.approx(math.remainder(1.0 + 10.0 - 0.05, 2 * math.pi), abs=ROUNDING)


@given(
    commands=st.lists(st.tuples(st.floats(-1e6, 1e6), st.floats(-1e6, 1e6)), min_size=1, max_size=20),
    h=st.floats(1e-4, 0.5),
)
def test_no_command_exceeds_the_limits(turtlebot, twist, commands, h):
    drive = DifferentialDrive(model=turtlebot, x=0.0, y=0.0, heading=0.0)
    for speed, turn_rate in commands:
        before = (drive.speed, drive.turn_rate)
        drive.move(drive.plan(twist(speed, turn_rate), h))
        assert -0.2 <= drive.speed <= 1.0
        assert abs(drive.turn_rate) <= math.pi
        assert abs(drive.speed - before[0]) <= 5.0 * h + ROUNDING
        assert abs(drive.turn_rate - before[1]) <= 10.0 * h + ROUNDING


@given(heading=st.floats(-4, 4), distance=st.floats(-1, 1), turn=st.floats(-3, 3), share=st.floats(0, 1))
def test_an_arc_in_two_parts_is_the_same_arc(heading, distance, turn, share):
    whole = np.array(chord(heading, distance, turn))
    first = np.array(chord(heading, share * distance, share * turn))
    second = np.array(chord(heading + share * turn, (1 - share) * distance, (1 - share) * turn))
    assert first + second == pytest.approx(whole, abs=ROUNDING)
