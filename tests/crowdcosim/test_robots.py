"""What a robot's file may say."""

from __future__ import annotations

import math

import pytest
from pydantic import TypeAdapter

from crowdcosim.robots import Differential, Holonomic, Mount, RobotModel
from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import load
from orchestrator.scenario.shipped import list_robots

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


@pytest.mark.parametrize(
    ("base", "message"),
    [
        ("{kind: tracked}", r"base: found kind 'tracked', expected 'differential' or 'holonomic' or 'car'"),
        ("{kind: cra, wheelbase: 1}", r"did you mean 'car'"),
        ("{kind: holonomic}", "base.max_lateral_speed: missing, expected a number"),
        ("{kind: holonomic, max_lateral_speed: 0}", "max_lateral_speed is 0.0, expected a positive number"),
        ("{kind: car, wheelbase: 0.5, max_steering_angle: 0.5}", "base.max_steering_rate: missing"),
        ("{kind: car, wheelbas: 0.5}", r"base.wheelbas: unknown key \(did you mean 'wheelbase'\?\)"),
        ("{kind: car, wheelbase: 1, max_steering_rate: 1, max_steering_angle: 1.6}", "max_steering_angle is 1.6"),
        ("{kind: differential, track: -0.2}", "track is -0.2, expected a positive number"),
        ("{kind: differential, track: wide}", "base.track: found 'wide', expected a number"),
        ("differential", "base: found 'differential', expected a mapping"),
        ("[1]", "expected a mapping"),
    ],
)
def test_an_impossible_base_is_refused(base: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        load("corridor", [f"robots.robot.model.base={base}"])


def test_a_base_without_its_kind_is_refused() -> None:
    corridor = load("corridor").resolved
    robot = corridor["robots"]["robot"]
    model = robot["model"] | {"base": {"wheelbase": 1.0}}
    with pytest.raises(ScenarioError, match=r"base: key 'kind' is missing"):
        load(corridor | {"robots": {"robot": robot | {"model": model}}})


def test_a_base_of_another_kind_replaces_the_one_below() -> None:
    (robot,) = load("corridor", ["robots.robot.model.base={kind: holonomic, max_lateral_speed: 1}"]).robots
    assert robot.model.base == Holonomic(max_lateral_speed=1.0)


def test_a_base_of_the_same_kind_keeps_what_is_not_changed() -> None:
    (robot,) = load("corridor", ["robots.robot.model.base.track=0.3"]).robots
    assert robot.model.base == Differential(wheel_radius=0.035, track=0.3)


def test_robots_of_every_kind_survive_the_way_to_another_process() -> None:
    adapter = TypeAdapter(RobotModel)
    for name in ROBOTS:
        model = load("corridor", [f"robots.robot.model={name}"]).robots[0].model
        assert adapter.validate_python(adapter.dump_python(model, mode="json")) == model
