"""Encoders count what the wheels roll, and their odometry is as good as the counts and the slip allow."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from components.sensors.encoders import Config, WheelEncoders
from crowdcosim.component import ports_of
from crowdcosim.messages import EncoderTicks, Odometry
from crowdcosim.robots import Differential, Holonomic
from crowdcosim.world import World

KOBUKI = 52 * 49.5833
RADIUS, TRACK = 0.035, 0.230
TICK = 2 * math.pi * RADIUS / KOBUKI


@pytest.fixture(scope="session")
def encoders(setup):
    def build(seed=1, base=Differential(wheel_radius=RADIUS, track=TRACK), **options):  # noqa: B008
        given = setup(World(size=(50.0, 50.0)), seed=seed)
        me = dataclasses.replace(given.own_robot, model=dataclasses.replace(given.own_robot.model, base=base))
        sensor = WheelEncoders(Config(ticks_per_turn=KOBUKI, **options))
        sensor.reset(dataclasses.replace(given, robots=(me, *given.robots[1:])))
        return sensor

    return build


@pytest.fixture(scope="session")
def drive(robot):
    """The states of an arc of length `way` that turns by `turn`, in `steps` steps of together 4 s."""

    def states(way, turn, steps):
        x, y, heading = 20.0, 20.0, 0.7
        for k in range(steps + 1):
            half = 0.5 * turn * k / steps
            chord = way * k / steps * np.sinc(half / math.pi)
            yield robot(
                x + chord * math.cos(heading + half),
                y + chord * math.sin(heading + half),
                heading + 2 * half,
                nanoseconds=round(4e9 * k / steps),
            )

    return states


def last(sensor, states):
    for state in states:
        output = sensor.step(state)
    return state, output


def test_ports_are_those_that_scenarios_wire():
    assert [(o.name, o.type) for o in ports_of(WheelEncoders).outputs] == [
        ("ticks", EncoderTicks),
        ("odometry", Odometry),
    ]


def test_a_kobuki_counts_the_published_ticks_per_millimetre(encoders, drive):
    """52 ticks per turn of the encoder, gears of 49.5833: 11.72 ticks/mm on wheels of 35 mm."""
    _, output = last(encoders(), drive(1.0, 0.0, 10))
    assert output.ticks.wheel == ("left", "right")
    np.testing.assert_allclose(output.ticks.ticks, [11_720, 11_720], rtol=1e-3)
    np.testing.assert_allclose(output.ticks.ticks_per_turn, KOBUKI)
    assert output.ticks.header.frame_id == "robot1/base_link"


def test_backwards_counts_down_and_turning_on_the_spot_counts_apart(encoders, drive):
    _, output = last(encoders(), drive(-1.0, 0.0, 7))
    assert (output.ticks.ticks <= -11_710).all()
    _, output = last(encoders(), drive(0.0, 2 * math.pi, 20))
    np.testing.assert_allclose(output.ticks.ticks, np.array([-0.5, 0.5]) * 2 * math.pi * TRACK / TICK, atol=1.0)


@pytest.mark.parametrize(("way", "turn"), [(3.0, 0.0), (3.0, 2.5), (-2.0, -1.0), (0.0, 5.0)])
@pytest.mark.parametrize("steps", [5, 400])
def test_without_slip_the_pose_is_right_but_for_the_counts(encoders, drive, way, turn, steps):
    """Counts do not add up errors: each wheel's way is known to a tick at any time, the heading to tick / track * 2."""
    state, output = last(encoders(), drive(way, turn, steps))
    pose = output.odometry.pose.pose
    heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    assert abs(math.remainder(heading - state.heading, 2 * math.pi)) <= 2 * TICK / TRACK
    error = math.hypot(pose.position.x - state.position[0], pose.position.y - state.position[1])
    assert error <= 2 * TICK + abs(way) * 2 * TICK / TRACK


def test_the_twist_is_that_of_the_counts(encoders, drive):
    _, output = last(encoders(), drive(2.0, 1.0, 40))
    twist = output.odometry.twist.twist
    assert twist.linear.x == pytest.approx(0.5, abs=TICK / 0.1)
    assert twist.angular.z == pytest.approx(0.25, abs=2 * TICK / TRACK / 0.1)
    _, output = last(encoders(), drive(-2.0, 0.0, 40))
    assert output.odometry.twist.twist.linear.x == pytest.approx(-0.5, abs=TICK / 0.1)


@pytest.mark.parametrize("steps", [4, 20])
def test_slip_has_the_stated_variance_whatever_the_step_and_the_covariance_says_so(encoders, drive, steps):
    """Straight on for 2 m: the variance of the way is alpha_3 * 2 m, that of the heading alpha_2 * 2 m."""
    noise, runs = {"way_by_way": 0.002, "turn_by_way": 0.003}, 200
    ways, headings = [], []
    for seed in range(runs):
        _, output = last(encoders(seed=seed, **noise), drive(2.0, 0.0, steps))
        rolled = output.ticks.ticks * TICK
        ways.append(rolled.mean() - 2.0)
        headings.append((rolled[1] - rolled[0]) / TRACK)
    assert np.var(ways) == pytest.approx(0.004, rel=5 * math.sqrt(2 / runs))
    assert np.var(headings) == pytest.approx(0.006, rel=5 * math.sqrt(2 / runs))
    covariance = output.odometry.pose.covariance.reshape(6, 6)
    assert covariance[5, 5] == pytest.approx(0.006, rel=0.01)


@pytest.mark.parametrize("base", [Holonomic(max_lateral_speed=1.0), Differential()])
def test_a_base_without_two_known_wheels_is_refused(encoders, base):
    with pytest.raises(ValueError, match="expected a differential one with wheel_radius and track"):
        encoders(base=base)


def test_options_without_meaning_are_refused():
    with pytest.raises(ValueError, match="ticks_per_turn is 0.0, expected"):
        Config(ticks_per_turn=0.0)
    with pytest.raises(ValueError, match="way_by_way is -1.0, expected"):
        Config(ticks_per_turn=1.0, way_by_way=-1.0)


def test_asked_again_at_the_same_time_it_says_the_same(encoders, drive):
    sensor = encoders(way_by_way=0.01)
    state, output = last(sensor, drive(1.0, 0.3, 5))
    assert sensor.step(state) == output
