"""Odometry: exact by default; with noise its errors have the stated variances, whatever the step size."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from components.sensors.odometry import Config, Odometer
from crowdcosim.component import ports_of
from crowdcosim.message import check_finite
from crowdcosim.messages import Odometry
from crowdcosim.world import World

OPEN = World(size=(50.0, 50.0))
NOISY = {"turn_by_turn": 0.002, "turn_by_way": 0.001, "way_by_way": 0.0015, "way_by_turn": 0.0005}


@pytest.fixture(scope="session")
def odometer(setup):
    def build(seed=1, world=OPEN, **options):
        sensor = Odometer(Config(**options))
        sensor.reset(setup(world, seed=seed))
        return sensor

    return build


@pytest.fixture(scope="session")
def drive(robot):
    """The states of an arc of length `way` that turns by `turn`, in `steps` steps of together 4 s."""

    def states(way, turn, steps, start=(20.0, 20.0, 0.7)):
        x, y, heading = start
        for k in range(steps + 1):
            part = k / steps
            half = 0.5 * turn * part
            chord = way * part * np.sinc(half / math.pi)
            yield robot(
                x + chord * math.cos(heading + half),
                y + chord * math.sin(heading + half),
                heading + 2 * half,
                nanoseconds=round(4e9 * part),
            )

    return states


def pose_of(odometry):
    pose = odometry.pose.pose
    heading = 2 * math.atan2(pose.orientation.z, pose.orientation.w)
    return np.array([pose.position.x, pose.position.y, heading])


def planar(covariance):
    return covariance.reshape(6, 6)[np.ix_([0, 1, 5], [0, 1, 5])]


def errors_along(odometry, state):
    """(3,) error ahead, to the left, and in heading, seen from the true pose."""
    x, y, heading = pose_of(odometry) - (*state.position, state.heading)
    cos, sin = math.cos(state.heading), math.sin(state.heading)
    return np.array([cos * x + sin * y, cos * y - sin * x, math.remainder(heading, 2 * math.pi)])


def test_ports_are_those_that_scenarios_wire():
    ports = ports_of(Odometer)
    assert [port.name for port in ports.inputs] == ["robot"]
    assert [(port.name, port.type) for port in ports.outputs] == [("odometry", Odometry)]


@pytest.mark.parametrize("option", list(NOISY))
def test_negative_variances_are_refused(option):
    with pytest.raises(ValueError, match=f"{option} is -0.1, expected zero or more"):
        Config(**{option: -0.1})


def test_frames_follow_rep_105(odometer, robot):
    odometry = odometer().step(robot(1.0, 2.0, nanoseconds=2_500_000_000))
    assert (odometry.header.frame_id, odometry.child_frame_id) == ("odom", "robot1/base_link")
    assert (odometry.header.stamp.sec, odometry.header.stamp.nanosec) == (2, 500_000_000)


@given(x=st.floats(-60, 60), y=st.floats(-60, 60), heading=st.floats(-3.14, 3.14))
def test_exact_by_default_and_aligned_with_the_map(odometer, robot, x, y, heading):
    sensor = odometer()
    sensor.step(robot(0.0, 0.0))
    odometry = sensor.step(robot(x, y, heading, nanoseconds=100_000_000))
    assert pose_of(odometry)[:2].tolist() == [x, y]
    assert pose_of(odometry)[2] == pytest.approx(heading, abs=1e-14)
    assert not odometry.pose.covariance.any()
    assert not odometry.twist.covariance.any()


def test_twist_is_in_the_robots_own_frame(odometer, robot):
    odometry = odometer().step(robot(1.0, 2.0, math.pi / 2, velocity=(-0.2, 0.8), turn_rate=0.3))
    assert odometry.twist.twist.linear.x == pytest.approx(0.8)
    assert odometry.twist.twist.linear.y == pytest.approx(0.2)
    assert odometry.twist.twist.angular.z == 0.3


def test_odometry_starts_at_the_true_pose_and_does_not_drift_at_rest(odometer, robot):
    sensor = odometer(**NOISY)
    for tick in range(10):
        odometry = sensor.step(robot(1.0, 2.0, 0.5, nanoseconds=tick * 100_000_000))
        assert pose_of(odometry) == pytest.approx([1.0, 2.0, 0.5], abs=1e-15)
        assert not odometry.pose.covariance.any()
        assert not odometry.twist.covariance.any()


@pytest.mark.parametrize("steps", [1, 3, 40])
def test_stated_covariance_of_a_straight_way_is_that_of_a_random_walk(odometer, drive, steps):
    """Integrated Brownian motion: variance a D of the heading, a D^3 / 3 sideways, covariance a D^2 / 2."""
    sensor = odometer(turn_by_way=1e-9, way_by_way=2e-9)  # so small that the estimate is as good as straight
    for state in drive(4.0, 0.0, steps, start=(20.0, 20.0, 0.0)):
        odometry = sensor.step(state)
    D, a, b = 4.0, 1e-9, 2e-9
    expected = [[b * D, 0.0, 0.0], [0.0, a * D**3 / 3, a * D**2 / 2], [0.0, a * D**2 / 2, a * D]]
    # Second order: the estimated heading is off by some 1e-4 rad.
    np.testing.assert_allclose(planar(odometry.pose.covariance), expected, rtol=1e-3, atol=1e-11)
    check_finite(odometry)


def test_stated_covariance_of_an_arc_does_not_depend_on_the_step_size(odometer, drive):
    found = []
    for steps in (10, 40, 160):
        sensor = odometer(**{name: 1e-12 * value for name, value in NOISY.items()})
        for state in drive(4.0, 2.0, steps):
            odometry = sensor.step(state)
        found.append(planar(odometry.pose.covariance))
    # Within a step the noise acts along and across its chord, not its arc: relative error turn^2 / 12 per step.
    scale = np.sqrt(np.outer(*[np.diag(found[-1])] * 2))
    assert np.abs(found[0] - found[-1]).max() < 0.2**2 / 12 * scale.max()
    assert np.abs(found[1] - found[-1]).max() < 0.05**2 / 12 * scale.max()


@pytest.mark.parametrize("steps", [1, 10])
def test_errors_have_the_stated_variances_whatever_the_step_size(odometer, drive, steps):
    """Each sample variance of n is within 5 sqrt(2 / n) of the true one, but for one seed in a million."""
    n, D = 1000, 2.0
    states = list(drive(D, 0.0, steps))
    errors = []
    for seed in range(n):
        sensor = odometer(seed=seed, turn_by_way=0.001, way_by_way=0.0015)
        for state in states:
            odometry = sensor.step(state)
        errors.append(errors_along(odometry, states[-1]))
    expected = [0.0015 * D, 0.001 * D**3 / 3, 0.001 * D]
    # The mean is that of n samples; second order in the heading's error, 0.05 rad, shortens the way by 0.1%.
    assert np.all(np.abs(np.mean(errors, axis=0)) < 5 * np.sqrt(np.array(expected) / n) + 0.002)
    assert np.var(errors, axis=0) == pytest.approx(expected, rel=5 * math.sqrt(2 / n) + 0.01)


def test_a_turn_on_the_spot_is_uncertain_in_heading_and_way(odometer, drive):
    n, turn = 1000, 1.5
    states = list(drive(0.0, turn, 5))
    errors = []
    for seed in range(n):
        sensor = odometer(seed=seed, turn_by_turn=0.002, way_by_turn=0.0005)
        for state in states:
            odometry = sensor.step(state)
        errors.append(errors_along(odometry, states[-1]))
    total = np.var(errors, axis=0)
    assert total[2] == pytest.approx(0.002 * turn, rel=5 * math.sqrt(2 / n))
    assert total[0] + total[1] == pytest.approx(0.0005 * turn, rel=5 * math.sqrt(2 / n))


def test_the_stated_covariance_is_consistent_with_the_errors(odometer, drive):
    """e' P^-1 e of n runs adds up to chi squared of 3 n degrees of freedom: mean 3, deviation sqrt(6 / n)."""
    n = 1000
    states = list(drive(3.0, -2.0, 12))
    total = 0.0
    for seed in range(n):
        sensor = odometer(seed=seed, **NOISY)
        for state in states:
            odometry = sensor.step(state)
        error = pose_of(odometry) - (*states[-1].position, states[-1].heading)
        error[2] = math.remainder(error[2], 2 * math.pi)
        total += error @ np.linalg.solve(planar(odometry.pose.covariance), error)
    # 3% for the linearisation about an estimate that is 0.1 rad off.
    assert total / n == pytest.approx(3.0, abs=5 * math.sqrt(6 / n) + 0.09)


def test_the_twist_adds_up_to_the_drifting_pose(odometer, robot):
    """Straight at 1 m/s along x: the sum of the turn rates is the heading, that of the speeds is the way."""
    sensor = odometer(**NOISY)
    way = heading = 0.0
    for k in range(40):
        odometry = sensor.step(robot(20.0 + 0.1 * k, 20.0, velocity=(1.0, 0.0), nanoseconds=k * 100_000_000))
        if k:
            way += 0.1 * odometry.twist.twist.linear.x
            heading += 0.1 * odometry.twist.twist.angular.z
            variance = odometry.twist.covariance.reshape(6, 6)
            assert variance[0, 0] == pytest.approx(0.0015 * 0.1 / 0.1**2)
            assert variance[5, 5] == pytest.approx(0.001 * 0.1 / 0.1**2)
    assert pose_of(odometry)[2] == pytest.approx(heading, abs=1e-12)
    # The path curves with the heading's error.
    assert math.hypot(*(pose_of(odometry)[:2] - 20.0)) == pytest.approx(way, rel=0.02)


def test_a_robot_that_wraps_around_does_not_jump(odometer, robot):
    sensor = odometer(world=World(size=(50.0, 10.0), periodic=(True, False)), way_by_way=1e-12)
    sensor.step(robot(49.95, 5.0))
    odometry = sensor.step(robot(0.05, 5.0, nanoseconds=100_000_000))
    assert pose_of(odometry) == pytest.approx([50.05, 5.0, 0.0], abs=1e-5)


@settings(max_examples=10)
@given(seed=st.integers(0, 2**64 - 1))
def test_the_same_seed_gives_the_same_drift(odometer, drive, seed):
    def run(number):
        sensor = odometer(seed=number, **NOISY)
        return [sensor.step(state) for state in drive(3.0, 1.0, 10)]

    assert run(seed) == run(seed)
    assert run(seed) != run((seed + 1) % 2**64)


def test_an_episode_begins_without_the_drift_of_the_last(setup, odometer, drive):
    sensor = odometer(**NOISY)
    first = [sensor.step(state) for state in drive(3.0, 1.0, 10)]
    sensor.reset(setup(OPEN))
    assert [sensor.step(state) for state in drive(3.0, 1.0, 10)] == first


def test_asked_again_at_the_same_time_it_says_the_same(odometer, drive):
    sensor = odometer(**NOISY)
    for state in drive(1.0, 0.3, 5):
        odometry = sensor.step(state)
    assert sensor.step(state) == odometry
