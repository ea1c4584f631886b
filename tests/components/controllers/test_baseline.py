"""The baseline drives at the goal and sees nobody."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.controllers.baseline import Baseline, Config
from crowdcosim.component import make, ports_of


def baseline(scene, **options) -> Baseline:
    controller = make(Baseline, options)
    controller.reset(scene.setup())
    return controller


@given(x=st.floats(0.2, 49.8), y=st.floats(0.2, 9.8), v=st.floats(-0.2, 1.0))
def test_in_the_corridor_the_command_is_exactly_one_and_zero(scene, x, y, v):
    twist = baseline(scene).step(odometry=scene.odometry(x, y, 0.0, v), goal=scene.line())
    assert (twist.linear.x, twist.angular.z) == (1.0, 0.0)


def test_it_takes_neither_people_nor_walls():
    assert [port.name for port in ports_of(Baseline).inputs] == ["odometry", "goal"]


def test_it_crosses_the_corridor_in_forty_seconds(scene):
    trace = scene.drive(baseline(scene), scene.line(), until_x=45.0)
    assert trace[-1, 0] >= 45.0
    assert 39.0 <= 0.1 * (len(trace) - 1) <= 41.5
    assert np.ptp(trace[:, 1]) == 0.0


@settings(max_examples=30, deadline=None)
@given(bearing=st.floats(-math.pi, math.pi), distance=st.floats(0.1, 6.0), heading=st.floats(-math.pi, math.pi))
def test_it_enters_a_disc_wherever_it_lies(scene, bearing, distance, heading):
    goal = scene.disc(5.0 + distance * math.cos(bearing), 5.0 + distance * math.sin(bearing))
    # One second to turn round at 2 e, bounded by pi; the rest at more than cos 45 degrees of the speed.
    trace = scene.drive(baseline(scene), goal, pose=(5.0, 5.0, heading), seconds=4.0 + distance / math.cos(math.pi / 4))
    assert math.dist(trace[-1, :2], goal.position) <= 0.3
    assert trace[-1, 3] == 0.0


@pytest.mark.parametrize("heading", [math.pi, 2.0, -1.0])
def test_it_turns_on_the_spot_when_it_faces_away(scene, heading):
    twist = baseline(scene).step(odometry=scene.odometry(5.0, 5.0, heading), goal=scene.line())
    assert twist.linear.x == 0.0
    assert abs(twist.angular.z) > 1.0


def test_the_speed_can_be_chosen(scene):
    twist = baseline(scene, speed=0.4).step(odometry=scene.odometry(5.0, 5.0), goal=scene.line())
    assert twist.linear.x == 0.4


def test_a_speed_beyond_the_robot_is_refused(scene):
    with pytest.raises(ValueError, match=r"speed is 1.5, expected at most the robot's 1.0 m/s"):
        baseline(scene, speed=1.5)


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan])
def test_a_speed_that_is_not_positive_is_refused(speed):
    with pytest.raises(ValueError, match="expected a positive number"):
        Config(speed=speed)
