"""An IMU measures what its base does, gravity, and where it sits on it; its noise does not depend on the step."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.sensors.imperfections import Bias, Drift, Gaussian, White
from components.sensors.imu import GRAVITY, Config, InertialUnit
from components.sensors.timing import Latency
from crowdcosim.messages import RobotState
from crowdcosim.robots import Mount
from crowdcosim.world import World


@pytest.fixture
def imu(setup):
    def build(seed=1, **options):
        sensor = InertialUnit(Config(**options))
        sensor.reset(setup(World(size=(50.0, 50.0)), seed=seed))
        return sensor

    return build


def circle(robot, radius=2.0, rate=0.5, dt=0.01, steps=200):
    """States of a base that drives on a circle, counter-clockwise."""
    for k in range(steps + 1):
        angle = rate * dt * k
        velocity = (-radius * rate * math.sin(angle), radius * rate * math.cos(angle))
        yield robot(
            20 + radius * math.cos(angle),
            20 + radius * math.sin(angle),
            angle + math.pi / 2,
            velocity=velocity,
            turn_rate=rate,
            nanoseconds=round(k * dt * 1e9),
        )


def readings(sensor, states):
    messages = [sensor.step(state) for state in states]
    rates = np.array([(m.angular_velocity.x, m.angular_velocity.y, m.angular_velocity.z) for m in messages])
    forces = np.array([(m.linear_acceleration.x, m.linear_acceleration.y, m.linear_acceleration.z) for m in messages])
    return rates, forces


def test_at_rest_it_feels_gravity_only_and_tells_no_orientation(imu, robot):
    message = imu().step(robot(5.0, 5.0, 1.0))
    assert message.linear_acceleration.z == GRAVITY
    assert message.linear_acceleration.x == message.linear_acceleration.y == message.angular_velocity.z == 0.0
    assert message.orientation_covariance[0] == -1.0
    assert message.header.frame_id == "robot1/sensor"


def test_on_a_circle_it_feels_the_turn_and_the_pull_to_the_centre(imu, robot):
    """Turn rate w, and w^2 r to the left."""
    rates, forces = readings(imu(), circle(robot))
    np.testing.assert_allclose(rates[1:], [[0.0, 0.0, 0.5]] * 200, atol=1e-9)
    np.testing.assert_allclose(forces[1:], [[0.0, 0.5**2 * 2.0, GRAVITY]] * 200, atol=1e-5)


@pytest.mark.parametrize(
    ("position", "yaw", "expected"),
    [
        ((0.3, 0.0, 0.1), 0.0, (-(0.5**2) * 0.3, 0.5)),
        ((0.0, 0.4, 0.1), 0.0, (0.0, 0.5**2 * 1.6)),
        ((0.0, 0.0, 0.1), math.pi / 2, (0.5, 0.0)),
    ],
    ids=["ahead", "nearer to the centre", "turned to the left"],
)
def test_it_feels_where_it_sits(imu, robot, position, yaw, expected):
    _, forces = readings(imu(mount=Mount(position=position, yaw=yaw)), circle(robot))
    np.testing.assert_allclose(forces[1:, :2], [expected] * 200, atol=1e-5)


def test_speeding_up_is_felt_ahead_and_spinning_up_beside_the_centre(imu, robot):
    states = [
        robot(5.0, 5.0, math.pi / 2, velocity=(0.0, 0.1 * k), turn_rate=0.0, nanoseconds=k * 100_000_000)
        for k in range(5)
    ]
    _, forces = readings(imu(), states)
    np.testing.assert_allclose(forces[1:], [[1.0, 0.0, GRAVITY]] * 4, atol=1e-9)
    spinning = [robot(5.0, 5.0, 0.0, turn_rate=0.2 * k, nanoseconds=k * 100_000_000) for k in range(5)]
    _, forces = readings(imu(mount=Mount(position=(0.5, 0.0, 0.0))), spinning)
    np.testing.assert_allclose(forces[1:, 1], 2.0 * 0.5, atol=1e-9)


@pytest.mark.parametrize("rate", [None, 25.0, 10.0])
def test_readings_add_up_to_the_change_of_velocity_at_any_rate(imu, robot, rate):
    """Over 2 s on the circle: means over the time between readings lose nothing."""
    sensor, turn, stamp = imu(rate=rate), 0.0, 0.0
    for state in circle(robot):
        message = sensor.step(state)
        now = message.header.stamp.sec + message.header.stamp.nanosec * 1e-9
        turn += message.angular_velocity.z * (now - stamp)
        stamp = now
    assert turn == pytest.approx(0.5 * stamp)


@pytest.mark.parametrize("dt", [0.01, 0.1])
def test_white_noise_of_a_data_sheet_gives_the_same_angle_at_any_step(imu, robot, dt):
    """Angle random walk: after 1 s each axis has the deviation density; the covariance tells density^2 / dt."""
    density, runs = 0.01, 80
    angles = []
    for seed in range(runs):
        sensor = imu(seed=seed, gyroscope=(White(kind="white", density=density),))
        still = [robot(5.0, 5.0, nanoseconds=round(k * dt * 1e9)) for k in range(round(1 / dt) + 1)]
        rates, _ = readings(sensor, still)
        angles.append(rates[1:].sum(axis=0) * dt)
    assert np.std(angles) == pytest.approx(density, rel=5 / math.sqrt(2 * 3 * runs))
    covariance = sensor.step(robot(5.0, 5.0, nanoseconds=round(1e9 + dt * 1e9))).angular_velocity_covariance
    np.testing.assert_allclose(covariance.reshape(3, 3), density**2 / dt * np.eye(3))


def test_errors_of_the_two_instruments_are_their_own(imu, robot):
    sensor = imu(
        gyroscope=(Bias(kind="bias", deviation=0.1),),
        accelerometer=(Bias(kind="bias", deviation=0.1), Gaussian(kind="gaussian", deviation=0.02)),
    )
    rates, forces = readings(sensor, [robot(5.0, 5.0, nanoseconds=k * 100_000_000) for k in range(50)])
    assert len(np.unique(rates, axis=0)) == 1
    assert len(set(rates[0].tolist())) == 3
    assert forces.std(axis=0) == pytest.approx(0.02, rel=0.5)
    assert not np.allclose(rates[0], forces.mean(axis=0) - (0, 0, GRAVITY), atol=0.01)
    message = sensor.step(robot(5.0, 5.0, nanoseconds=5_000_000_000))
    np.testing.assert_allclose(message.linear_acceleration_covariance.reshape(3, 3), 0.02**2 * np.eye(3))


def test_late_messages_bear_the_time_at_which_they_were_taken(imu, robot):
    sensor = imu(imperfections=(Latency(kind="latency", delay=0.1),))
    stamps = [sensor.step(robot(5.0, 5.0, nanoseconds=k * 100_000_000)).header.stamp.nanosec for k in range(4)]
    assert stamps == [0, 0, 100_000_000, 200_000_000]


def test_compiling_leaves_no_trace(imu):
    assert imu().step(RobotState()) == imu().step(RobotState())


def test_asked_again_at_the_same_time_it_still_answers(imu, robot):
    sensor = imu(gyroscope=(White(kind="white", density=0.01), Drift(kind="drift", density=0.01)))
    state = robot(5.0, 5.0, nanoseconds=100_000_000)
    assert np.isfinite([sensor.step(state).angular_velocity.z for _ in range(3)]).all()
