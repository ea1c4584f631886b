"""A robot whose wheels have motors: it obeys, as fast as motors, battery and grip let it, and stops where others do."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from pydantic import ValidationError

from components.robot.motor import Motor
from components.robot.wheels import Config, Wheels
from crowdcosim.component import ComponentError, make, ports_of
from crowdcosim.messages import Contacts
from crowdcosim.robots import Differential, Holonomic, Pose, Robot, Target
from crowdcosim.setup import Setup
from crowdcosim.world import Wall, World

OPEN = World(size=(50.0, 10.0))
NO_PEOPLE = ()


class Scene:
    """One robot on its wheels."""

    def __init__(self, turtlebot, people, *, start=None, world=OPEN, config=None):
        robot = Robot(
            name="robot", number=1, model=turtlebot, start=start or Pose(x=3.0, y=4.0), goal=Target(x=0.0, y=0.0)
        )
        self.component = Wheels(config or Config())
        self.setup = Setup(component="robot", period=100_000_000, seed=1, world=world, robots=(robot,), robot="robot")
        self.nobody = people()
        self.last = self.component.reset(self.setup)

    def step(self, command, crowd=None):
        self.last = self.component.step(command, crowd or self.nobody, ())
        return self.last


@pytest.fixture
def scene(turtlebot, people):
    return lambda **options: Scene(turtlebot, people, **options)


def test_ports_are_those_of_the_kinematic_drive(bodies):
    kinematic = type(bodies(Pose(x=1.0, y=1.0)).components[0])
    assert ports_of(Wheels) == ports_of(kinematic)


def test_a_slow_command_is_reached(scene, twist):
    here = scene()
    for _ in range(40):
        state = here.step(twist(0.5, 0.4)).state
    assert np.hypot(*state.velocity) == pytest.approx(0.5, abs=1e-3)
    assert state.angular_velocity == pytest.approx(0.4, abs=1e-3)


def test_it_needs_longer_than_the_kinematic_drive_and_stays_below_the_batterys_top_speed(scene, bodies, twist):
    here, kinematic = scene(), bodies(Pose(x=3.0, y=4.0))
    for _ in range(100):
        state, ideal = here.step(twist(1.0)).state, kinematic.step(twist(1.0))[0].state
        assert state.velocity[0] < ideal.velocity[0]
    assert 0.92 < state.velocity[0] < 0.95


def test_a_straight_command_keeps_its_line(scene, twist):
    here = scene()
    for _ in range(100):
        state = here.step(twist(1.0)).state
    assert (state.position[1], state.heading) == (4.0, 0.0)


def test_it_drives_the_circle_that_its_wheels_turn(scene, twist):
    here = scene()
    for _ in range(60):
        start = here.step(twist(0.4, 0.5)).state
    centre = start.position + 0.4 / 0.5 * np.array([-math.sin(start.heading), math.cos(start.heading)])
    for _ in range(100):
        state = here.step(twist(0.4, 0.5)).state
        assert np.hypot(*(state.position - centre)) == pytest.approx(0.8, abs=2e-3)  # the transient's last per mille


def test_little_grip_limits_the_acceleration(scene, twist):
    """mu g = 0.981 m/s2, less than the motors' 4 m/s2."""
    here = scene(config=Config(grip=0.1))
    for _ in range(4):
        state = here.step(twist(1.0)).state
    assert state.velocity[0] == pytest.approx(0.4 * 0.981, rel=1e-6)


def test_limits_of_the_robot_hold(scene, twist):
    here = scene(config=Config(motor=Motor(open_circuit_voltage=48.0)))
    for _ in range(60):
        state = here.step(twist(3.0)).state
        assert state.velocity[0] < 1.15  # the regulator overshoots a little
    assert state.velocity[0] == pytest.approx(1.0, abs=1e-3)


def test_a_wall_stops_it_and_the_wheels_stall(scene, twist):
    here = scene(world=World(size=(50.0, 10.0), walls=(Wall(start=(6.0, 0.0), end=(6.0, 10.0)),)))
    for _ in range(80):
        state, contacts = here.step(twist(1.0))
    assert contacts.kind.tolist() == [Contacts.WALL]
    assert contacts.approach_speed[0] > 0.9
    assert state.velocity.tolist() == [0.0, 0.0]
    assert state.position[0] == pytest.approx(6.0 - 0.177, abs=1e-3)
    motors = here.component._motors
    assert np.abs(motors.state[2:4]).max() < 1e-6
    assert motors.state[0] == pytest.approx(Motor().current_limit, rel=1e-3)


def test_it_backs_off_from_a_wall_and_turns_away(scene, twist):
    here = scene(world=World(size=(50.0, 10.0), walls=(Wall(start=(6.0, 0.0), end=(6.0, 10.0)),)))
    for _ in range(60):
        here.step(twist(1.0))
    for _ in range(10):
        state, contacts = here.step(twist(-0.2))
    assert state.velocity[0] == pytest.approx(-0.2, abs=0.02)
    assert len(contacts.kind) == 0
    for _ in range(20):
        state = here.step(twist(0.0, 2.0)).state
    assert abs(state.heading) > 2.0


def test_it_waits_behind_a_person_and_goes_on(scene, twist, people):
    here = scene()
    for _ in range(30):
        state, contacts = here.step(twist(0.8), people((4.0, 4.0, 0.0, 0.0)))
    assert contacts.agent.tolist() == [101]
    assert state.velocity.tolist() == [0.0, 0.0]
    for _ in range(30):
        state, contacts = here.step(twist(0.8))
    assert state.velocity[0] == pytest.approx(0.8, abs=0.02)
    assert len(contacts.kind) == 0


@pytest.mark.parametrize(
    ("base", "text"),
    [
        (Differential(track=0.23), "gives no wheel_radius and track"),
        (Holonomic(max_lateral_speed=1.0), "is of kind 'holonomic', expected 'differential'"),
    ],
)
def test_a_robot_without_two_known_wheels_is_refused(turtlebot, people, base, text):
    with pytest.raises(ComponentError, match=text):
        Scene(dataclasses.replace(turtlebot, base=base), people)


def test_a_reset_begins_anew(scene, twist):
    here = scene()
    first = [here.step(twist(1.0, 0.3)).state.position.tolist() for _ in range(20)]
    here.component.reset(here.setup)
    assert [here.step(twist(1.0, 0.3)).state.position.tolist() for _ in range(20)] == first


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"grip": 0.0}, "grip is 0.0"),
        ({"fmu": "mine.fmu"}, "fmu is 'mine.fmu', expected built-in, built-in-fmi2, or a path that begins with"),
        ({"track": 0.3}, "track"),
        ({"motor": {"resistance": -1.0}}, "resistance is -1.0"),
        ({"motor": {"resistence": 1.0}}, "resistence"),
        ({"parameters": {"mass": 1.0}}, "only an FMU of your own"),
        ({"fmu": "built-in", "parameters": {"mass": 1.0}}, "only an FMU of your own"),
        ({"fmu": "./mine.fmu", "motor": {"resistance": 1.0}}, "expected none beside an FMU of your own"),
        ({"fmu": "./mine.fmu", "variables": {"left_command": {"name": "a"}}}, "right_command is missing"),
        ({"fmu": "./mine.fmu", "variables": {"left_comand": {"name": "a"}}}, "left_comand"),
        (
            {"fmu": "./mine.fmu", "variables": {"left_command": {"name": "a"}, "right_command": {"name": "b"}}},
            "results: found neither, expected either left_speed and right_speed, or left_torque and right_torque",
        ),
    ],
)
def test_wrong_options_are_refused(options, text):
    with pytest.raises(ValidationError, match=text):
        make(Wheels, options)
