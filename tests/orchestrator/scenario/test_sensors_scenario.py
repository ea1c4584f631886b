"""The shipped scenario with all kinds of sensors runs, and each tells something of its kind."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crowdcosim import Session
from crowdcosim.messages import (
    BeamAgents,
    Detections,
    EncoderTicks,
    Imu,
    LaserScan,
    Odometry,
    PointCloud2,
    Ranges,
)


def test_every_kind_of_sensor_tells_what_it_sees() -> None:
    """After 2 s; the robot sets off at 1 m/s along x."""
    with Session("sensors", {"end.time_limit": 2.0}) as session:
        for _ in range(19):
            session.step()
        view = session.view
        told, state = view.robot.sensors, view.robot.state
    kinds = {
        "front/scan": LaserScan,
        "front/agents": BeamAgents,
        "rear/scan": LaserScan,
        "rear/agents": BeamAgents,
        "points/point_cloud2": PointCloud2,
        "sonar/ranges": Ranges,
        "sonar/agents": BeamAgents,
        "encoders/ticks": EncoderTicks,
        "encoders/odometry": Odometry,
        "imu": Imu,
        "people/detections": Detections,
        "odometry": Odometry,
    }
    assert {name: type(message) for name, message in told.items()} == kinds
    assert np.isfinite(told["front/scan"].ranges).sum() == told["points/point_cloud2"].width > 50
    assert len(told["sonar/ranges"].ranges) == 12
    assert len(told["people/detections"].track) > 3
    assert told["people/detections"].header.stamp != state.header.stamp  # it is 0.1 s late
    way = told["encoders/ticks"].ticks.mean() / told["encoders/ticks"].ticks_per_turn[0] * 2 * math.pi * 0.035
    assert way == pytest.approx(state.position[0] - 5.0, abs=0.2)
    assert told["imu"].linear_acceleration.z == pytest.approx(9.8, abs=0.6)  # its bias has a deviation of 0.16


def test_a_late_sensor_that_is_asked_every_second_tick_tells_what_it_took_a_step_of_its_own_before() -> None:
    """Asked at 0, 0.2, 0.4 s; each message is 0.1 s under way and held until the next but one tick."""
    lidar = {"use": "lidar", "every": 2, "config": {"imperfections": [{"kind": "latency", "delay": 0.1}]}}
    settings = {"robots.robot.sensors.lidar": lidar, "crowd.config.count": 5, "end.time_limit": 1.0}
    with Session("corridor", settings) as session:
        stamps = [session.view.robot.sensors["lidar/scan"].header.stamp.nanosec]
        for _ in range(6):
            stamps.append(session.step().robot.sensors["lidar/scan"].header.stamp.nanosec)
    assert stamps == [0, 0, 0, 0, 200_000_000, 200_000_000, 400_000_000]
