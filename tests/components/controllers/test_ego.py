"""What a controller knows of its robot and of the way to the goal."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.controllers.ego import command, ego_of, heading_error, turn, way_to

ANGLE = st.floats(-math.pi, math.pi)


@given(heading=ANGLE)
def test_heading_is_read_from_the_quaternion(scene, heading):
    ego = ego_of(scene.odometry(1.0, 2.0, heading, 0.5, -0.3))
    # Half an ulp in cosine and sine moves the angle by a few ulp.
    assert abs(math.remainder(ego.heading - heading, math.tau)) < 1e-15 * 8
    assert (ego.x, ego.y, ego.speed, ego.turn_rate) == (1.0, 2.0, 0.5, -0.3)


def test_a_robot_that_faces_x_has_heading_zero_exactly(scene):
    assert ego_of(scene.odometry(5.0, 5.0)).heading == 0.0


@pytest.mark.parametrize("x", [5.0, 44.9, 45.0, 45.2])
def test_a_line_lies_infinitely_far_ahead_even_for_a_robot_beyond_it(scene, x):
    way = way_to(scene.line(), ego_of(scene.odometry(x, 3.0)))
    assert way == (1.0, 0.0, 0.0)


def test_a_disc_is_a_point_until_it_is_entered(scene):
    assert way_to(scene.disc(8.0, 9.0), ego_of(scene.odometry(5.0, 5.0))) == (3.0, 4.0, 1.0)
    assert way_to(scene.disc(5.2, 5.2), ego_of(scene.odometry(5.0, 5.0))) is None


@given(a=st.floats(-20, 20), b=st.floats(-20, 20))
def test_heading_errors_are_the_shorter_way_round(a, b):
    error = heading_error(a, b)
    assert abs(error) <= math.pi
    assert math.cos(error) == pytest.approx(math.cos(a - b), abs=1e-12)
    assert math.sin(error) == pytest.approx(math.sin(a - b), abs=1e-12)


def test_turning_closes_the_error_within_the_limit():
    assert turn(0.25, 3.0) == 0.5
    assert turn(3.0, 1.5) == 1.5
    assert turn(-3.0, 1.5) == -1.5


def test_a_command_is_forward_and_counter_clockwise():
    twist = command(0.7, -0.2)
    assert (twist.linear.x, twist.linear.y, twist.angular.x, twist.angular.z) == (0.7, 0.0, 0.0, -0.2)
