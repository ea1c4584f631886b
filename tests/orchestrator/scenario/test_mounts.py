"""Sensors sit where a scenario or their robot's file says, and the log says so too."""

from __future__ import annotations

import math

import numpy as np
import pytest

from crowdcosim.cdr import decode
from crowdcosim.messages import TFMessage
from crowdcosim.robots import Mount
from orchestrator.log.frames import static_records, transform
from orchestrator.scenario.mounts import sensor_frames
from orchestrator.scenario.scenario import load


def test_a_sensor_sits_at_the_mount_that_it_names() -> None:
    scenario = load("corridor", ["robots.robot.sensors.lidar.config.mount=rear_lidar"])
    model = scenario.robots[0].model
    assert sensor_frames(scenario.component("robot/lidar"), model) == {"robot/lidar": model.mounts["rear_lidar"]}
    assert sensor_frames(scenario.component("robot/odometry"), model) == {}
    assert sensor_frames(scenario.component("robot/controller"), model) == {}


def test_a_sensor_sits_at_the_place_that_the_scenario_gives_and_the_log_tells() -> None:
    scenario = load("corridor", ["robots.robot.sensors.lidar.config.mount={position: [0.1, 0, 0.2], yaw: 1}"])
    frames = sensor_frames(scenario.component("robot/lidar"), scenario.robots[0].model)
    assert frames == {"robot/lidar": Mount(position=(0.1, 0.0, 0.2), yaw=1.0)}
    (static,) = static_records(scenario)
    odom, lidar = decode(static.payload, TFMessage.TYPE).transforms
    assert odom.child_frame_id == "odom"
    assert (lidar.header.frame_id, lidar.child_frame_id) == ("robot/base_link", "robot/lidar")
    place, turn = lidar.transform.translation, lidar.transform.rotation
    assert (place.x, place.y, place.z) == (0.1, 0.0, 0.2)
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx((0.0, 0.0, math.sin(0.5), math.cos(0.5)))


def test_a_frame_is_turned_by_yaw_and_then_nods_by_pitch() -> None:
    """Ahead of it is (cos p cos y, cos p sin y, -sin p), to its left (-sin y, cos y, 0)."""
    yaw, pitch = 2.5, 0.3
    q = transform("base", "sensor", 0, (0.0, 0.0, 0.0), yaw, pitch).transform.rotation
    ahead = (1 - 2 * (q.y**2 + q.z**2), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y))
    left = (2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x**2 + q.z**2), 2 * (q.y * q.z + q.w * q.x))
    expected = (math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), -math.sin(pitch))
    np.testing.assert_allclose(ahead, expected, atol=1e-12)
    np.testing.assert_allclose(left, (-math.sin(yaw), math.cos(yaw), 0.0), atol=1e-12)
