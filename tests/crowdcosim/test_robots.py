"""What a robot's file may say."""

from __future__ import annotations

import math

import pytest

from crowdcosim.robots import Mount
from orchestrator.problems import ScenarioError
from orchestrator.scenario import load
from orchestrator.shipped import list_robots

ROBOTS = [robot.name for robot in list_robots()]


@pytest.mark.parametrize("name", ROBOTS)
def test_every_shipped_robot_carries_sensors_within_its_body(name: str) -> None:
    (robot,) = load("corridor", [f"robots.robot.model={name}"]).robots
    model = robot.model
    assert {"camera"} < set(model.mounts)
    assert any(mount.endswith("lidar") for mount in model.mounts)
    for mount in model.mounts.values():
        x, y, z = mount.position
        assert math.hypot(x, y) <= model.radius
        assert 0.0 < z <= model.height


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"position": (0.0, 0.0, -0.1)}, r"position is \(0.0, 0.0, -0.1\), expected a height"),
        ({"position": (0.0, 0.0, math.nan)}, "expected a height"),
        ({"position": (0.0, 0.0, 0.1), "pitch": 2.0}, "pitch is 2.0, expected from -pi/2"),
    ],
)
def test_an_impossible_mount_is_refused(fields: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        Mount(**fields)  # type: ignore[arg-type]


def test_a_scenario_moves_one_mount_and_adds_another() -> None:
    changes = ["robots.robot.model.mounts.camera.pitch=0.2", "robots.robot.model.mounts.mast={position: [0, 0, 1]}"]
    (robot,) = load("corridor", changes).robots
    assert robot.model.mounts["camera"].pitch == 0.2
    assert robot.model.mounts["camera"].position == load("corridor").robots[0].model.mounts["camera"].position
    assert robot.model.mounts["mast"] == Mount(position=(0.0, 0.0, 1.0))


def test_a_mount_without_a_place_is_named() -> None:
    with pytest.raises(ScenarioError, match=r"robots\.robot\.model\.mounts\.mast\.position: missing"):
        load("corridor", ["robots.robot.model.mounts.mast={yaw: 1}"])
