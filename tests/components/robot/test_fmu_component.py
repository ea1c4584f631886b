"""Any FMU as a controller or a sensor: ports from its variables, numbers in and out, and what can be wrong with it."""

from __future__ import annotations

import dataclasses
import shutil

import numpy as np
import pytest
from pydantic import ValidationError

from components.robot.fmu_component import FmuController, FmuSensor
from components.robot.fmu_file import FmuError
from components.robot.message_field import made_of, message_field
from crowdcosim.component import make, ports_of, ports_with
from crowdcosim.messages import (
    Contacts,
    Crowd,
    Goal,
    Header,
    Odometry,
    Pose,
    PoseWithCovariance,
    RobotState,
    Time,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from crowdcosim.robots import Pose as Place
from crowdcosim.robots import Robot, Target
from crowdcosim.setup import Setup
from crowdcosim.world import World

needs_compiler = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="building an FMU needs a C compiler"
)


def begun(component, turtlebot):
    robot = Robot(name="robot", number=1, model=turtlebot, start=Place(x=1.0, y=1.0), goal=Target(x=0.0, y=0.0))
    world = World(size=(50.0, 10.0))
    setup = Setup(component="robot/mine", period=100_000_000, seed=1, world=world, robots=(robot,), robot="robot")
    component.reset(setup)
    return component


def odometry(speed):
    twist = TwistWithCovariance(twist=Twist(linear=Vector3(x=speed)))
    return Odometry(pose=PoseWithCovariance(pose=Pose()), twist=twist)


LINKS = {
    "inputs": {"left_command": "odometry.twist.twist.linear.x", "right_command": "goal.position[1]"},
    "outputs": {"left_speed": {"field": "twist.linear.x", "factor": 0.5}, "right_speed": "twist.angular.z"},
}


@needs_compiler
def test_ports_follow_from_the_fields_that_are_linked(foreign):
    ports = ports_with(FmuController, {"file": str(foreign()), **LINKS})
    assert [(port.name, port.type) for port in ports.inputs] == [("odometry", Odometry), ("goal", Goal)]
    assert [(port.name, port.type) for port in ports.outputs] == [("twist", Twist)]
    assert ports.kind == "reactor"


@needs_compiler
def test_numbers_go_in_and_come_out_with_their_factors(foreign, turtlebot):
    """This FMU gives what it is given; two steps and a new episode."""
    controller = begun(make(FmuController, {"file": str(foreign()), **LINKS}), turtlebot)
    goal = Goal(position=np.array([45.0, 0.25]))
    assert controller.step(odometry=odometry(0.8), goal=goal) == Twist(linear=Vector3(x=0.4), angular=Vector3(z=0.25))
    assert controller.step(odometry=odometry(-2.0), goal=goal).linear.x == -1.0
    begun(controller, turtlebot)
    assert controller.step(odometry=odometry(0.1), goal=goal).linear.x == 0.05


@needs_compiler
def test_variables_that_are_called_like_fields_need_no_links(foreign, turtlebot):
    names = {
        "left_command": "robot_state.velocity[0]",
        "right_command": "robot_state.angular_velocity",
        "left_speed": "odometry.twist.twist.linear.x",
        "right_speed": "twist.angular.z",
    }
    sensor = make(FmuSensor, {"file": str(foreign(names=names))})
    ports = ports_of(type(sensor))
    assert [port.name for port in ports.inputs] == ["robot_state"]
    assert [(port.name, port.type) for port in ports.outputs] == [("odometry", Odometry), ("twist", Twist)]
    state = RobotState(velocity=np.array([0.7, 0.0]), angular_velocity=-0.3)
    begun(sensor, turtlebot).step(robot_state=state)
    result = sensor.step(robot_state=state)
    assert result.odometry.twist.twist.linear.x == 0.7
    assert result.odometry.header == Header(stamp=Time(sec=0, nanosec=100_000_000), frame_id="robot/mine")
    assert result.twist.angular.z == -0.3


@needs_compiler
@pytest.mark.parametrize(
    ("links", "text"),
    [
        ({}, "has no output that is called like a field of a message"),
        ({"outputs": {"left_sped": "twist.linear.x"}}, r"no variable 'left_sped' \(did you mean 'left_speed'\?\)"),
        (
            {"inputs": {"left_speed": "twist.linear.x"}, "outputs": {"left_speed": "twist.linear.x"}},
            "'left_speed' of .* is of causality output, expected an input: left_command, right_command",
        ),
    ],
)
def test_variables_that_there_are_not_are_named(foreign, turtlebot, links, text):
    with pytest.raises(FmuError, match=text):
        begun(make(FmuController, {"file": str(foreign()), **links}), turtlebot)


@needs_compiler
def test_a_field_that_is_not_there_in_this_tick_is_named(foreign, turtlebot):
    links = {"inputs": {"left_command": "crowd.position[2][0]"}, "outputs": {"left_speed": "twist.linear.x"}}
    controller = begun(make(FmuController, {"file": str(foreign()), **links}), turtlebot)
    with pytest.raises(FmuError, match=r"at step 0: crowd\.position\[2\]\[0\] is asked for, but there are 0"):
        controller.step(crowd=Crowd())


@needs_compiler
def test_an_fmu_that_fails_is_quoted(foreign, turtlebot):
    controller = begun(make(FmuController, {"file": str(foreign(fault="discard", at=1)), **LINKS}), turtlebot)
    controller.step(odometry=odometry(1.0), goal=Goal())
    with pytest.raises(FmuError, match="Discard.*the solver gave up"):
        controller.step(odometry=odometry(1.0), goal=Goal())


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({}, "file"),
        ({"file": "mine.fmu"}, "file is 'mine.fmu', expected a path that begins with"),
        ({"file": "./a.fmu", "inputs": {"a": "twist.linear.x"}}, "outputs is empty"),
        ({"file": "./a.fmu", "outputs": {"a": "twist.linear"}}, "variable 'a': 'twist.linear' is a Vector3, expected"),
        ({"file": "./a.fmu", "outputs": {"a": "twist.linear.q"}}, "has no 'q', expected one of .*: x, y, z"),
        ({"file": "./a.fmu", "outputs": {"a": "twits.linear.x"}}, "begins with 'twits', expected a message"),
        ({"file": "./a.fmu", "outputs": {"a": "goal.position"}}, r"is an array, expected 1 indices: position\[0\]"),
        ({"file": "./a.fmu", "outputs": {"a": "goal.tolerance[0]"}}, "has indices, but 'tolerance' is no array"),
        ({"file": "./a.fmu", "outputs": {"a": "goal.robot"}}, "is a str, expected a single number"),
        ({"file": "./a.fmu", "outputs": {"a": {"field": "twist.linear.x", "factor": 0.0}}}, "factor is 0.0"),
        ({"file": "./a.fmu", "outputs": {"a": {"feld": "twist.linear.x"}}}, "feld"),
    ],
)
def test_wrong_options_are_refused(options, text):
    with pytest.raises(ValidationError, match=text):
        make(FmuController, options)


def test_every_field_that_is_written_can_be_read():
    texts = (
        "goal.position[1]",
        "goal.tolerance",
        "contacts.agent[2]",
        "contacts.position[0][1]",
        "odometry.pose.pose.position.x",
    )
    for text in texts:
        field = message_field(text)
        assert str(field) == text
        if field.type is not Contacts:
            assert field.read(made_of(field.type, {field: 3.0}, Header(frame_id="f"))) == 3.0


def test_a_message_keeps_what_no_variable_fills():
    field = message_field("goal.position[1]")
    goal = made_of(Goal, {field: 2.0}, Header(frame_id="here"))
    assert goal == dataclasses.replace(Goal(), header=Header(frame_id="here"), position=np.array([0.0, 2.0]))
