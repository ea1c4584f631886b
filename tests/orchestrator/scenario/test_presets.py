"""Real devices by name: each file is a sensor that works, and a scenario changes what it likes."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import load
from orchestrator.scenario.shipped import list_devices

DEVICES = [device.name for device in list_devices()]


@pytest.mark.parametrize("name", DEVICES)
def test_every_shipped_device_is_a_sensor_that_needs_no_further_option(name: str) -> None:
    for robot in ("turtlebot2", "pepper", "qolo", "cuybot"):
        if name.startswith(robot.removesuffix("2")) or robot == "turtlebot2":
            settings = [f"robots.robot.model={robot}", f"robots.robot.sensors.device={{preset: {name}}}"]
            scenario = load("corridor", settings)
            assert load(scenario.resolved) == scenario


def test_a_scenario_changes_what_it_likes_and_keeps_the_rest() -> None:
    settings = ["robots.robot.sensors.lidar={preset: urg-04lx, config: {range_max: 4, mount: rear_lidar}, every: 3}"]
    spec = load("corridor", settings).component("robot/lidar")
    assert spec.use == "components.sensors.lidar:Lidar"
    assert (spec.every, spec.config["range_max"], spec.config["mount"]) == (3, 4.0, "rear_lidar")
    assert (spec.config["beams"], spec.config["rate"]) == (682, 10.0)
    assert [kind["kind"] for kind in spec.config["imperfections"]] == [
        "range_dependent",
        "mixed_pixels",
        "quantisation",
    ]
    assert "preset" not in spec.entry


def test_the_options_of_a_scenario_below_are_laid_over_the_device_too() -> None:
    settings = ["robots.robot.sensors.lidar.config.beams=90", "robots.robot.sensors.lidar.preset=ust-10lx"]
    config = load("corridor", settings).component("robot/lidar").config
    assert (config["beams"], config["range_min"]) == (90, 0.06)


def test_a_device_of_ones_own_is_a_file_that_may_extend_a_shipped_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.yaml").write_text("extends: hc-sr04\nconfig: {mounts: {count: 3, height: 0.2}}\n")
    config = load("corridor", ["robots.robot.sensors.sonar={preset: ./mine.yaml}"]).component("robot/sonar").config
    assert config["mounts"] == {"count": 3, "height": 0.2, "radius": None}
    assert config["range_max"] == 4.0


def test_a_device_that_is_not_there_is_one_problem_with_a_near_miss() -> None:
    with pytest.raises(ScenarioError) as caught:
        load("corridor", ["robots.robot.sensors.lidar={preset: utm-30l}"])
    message = str(caught.value)
    assert message.startswith("--set robots.robot.sensors.lidar={preset: utm-30l}: robots.robot.sensors.lidar.preset: ")
    assert "there is no device 'utm-30l' (did you mean 'utm-30lx'?); shipped: " in message
    assert len(message.splitlines()) == 1
