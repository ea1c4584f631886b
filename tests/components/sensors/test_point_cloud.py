"""A point cloud has the scan's points, as a ROS reader decodes them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.sensors.lidar import Config, Lidar
from components.sensors.point_cloud import PointCloud
from crowdcosim.messages import BeamAgents, PointField
from crowdcosim.world import Wall, World

NUMPY = {PointField.FLOAT32: "<f4", PointField.UINT32: "<u4", PointField.UINT8: "u1"}


def decoded(cloud):
    layout = {
        "names": [field.name for field in cloud.fields],
        "formats": [NUMPY[field.datatype] for field in cloud.fields],
        "offsets": [field.offset for field in cloud.fields],
        "itemsize": cloud.point_step,
    }
    assert len(cloud.data) == cloud.row_step * cloud.height == cloud.point_step * cloud.width
    return np.frombuffer(cloud.data.tobytes(), np.dtype(layout))


@pytest.mark.parametrize("clockwise", [False, True])
def test_points_are_where_the_beams_end_and_say_who_is_there(setup, robot, people, clockwise):
    world = World(size=(20.0, 20.0), walls=(Wall(start=(0.0, 8.0), end=(20.0, 8.0)),))
    lidar = Lidar(Config(clockwise=clockwise))
    lidar.reset(setup(world))
    scan, agents = lidar.step(robot(5.0, 5.0, math.pi / 2), people((6.0, 5.0)), ())
    cloud = PointCloud().step(scan, agents)
    assert cloud.header == scan.header
    assert [field.name for field in cloud.fields][:3] == ["x", "y", "z"]
    points = decoded(cloud)
    assert len(points) == np.isfinite(scan.ranges).sum() > 100
    wall = points[points["kind"] == BeamAgents.WALL]
    np.testing.assert_allclose(wall["x"], 3.0, atol=1e-5)
    legs = points[points["kind"] == BeamAgents.PERSON]
    assert set(legs["agent"].tolist()) == {101}
    assert set(legs["body_part"].tolist()) == {BeamAgents.LOWER_LEGS}
    np.testing.assert_allclose(np.column_stack([legs["x"], legs["y"]]), [(0.0, -1.0)] * len(legs), atol=0.2)
    assert not points["z"].any()


def test_an_empty_scan_is_an_empty_cloud(setup, robot, people):
    lidar = Lidar(Config())
    lidar.reset(setup(World(size=(20.0, 20.0))))
    cloud = PointCloud().step(*lidar.step(robot(5.0, 5.0), people(), ()))
    assert (cloud.width, len(cloud.data)) == (0, 0)
