"""From a file to a scenario: what is in it, what `extends` and `--set` change, and that it can be stored and loaded."""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from crowdcosim.credentials import Admission
from crowdcosim.loading import load_class
from crowdcosim.robots import Pose
from crowdcosim.world import Wall
from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import Scenario, from_resolved, load
from orchestrator.wiring import Reference

Change = Callable[[str, str], str]


def test_a_file_becomes_a_scenario(folder: Path) -> None:
    scenario = load("base.yaml")
    assert (scenario.name, scenario.seed, scenario.period, scenario.last_tick) == ("base", 1, 100_000_000, 300)
    assert scenario.world.size == (50.0, 10.0)
    (robot,) = scenario.robots
    assert (robot.name, robot.number, robot.start) == ("robot", 1, Pose(x=5.0, y=5.0))
    assert robot.model.max_speed == 1.0


def test_components_come_in_canonical_order(folder: Path) -> None:
    scenario = load("base.yaml")
    assert [c.name for c in scenario.components] == ["crowd", "robot", "robot/lidar", "robot/controller", "evaluator"]
    assert [c.robot for c in scenario.components] == [None, "robot", "robot", "robot", None]
    assert scenario.component("robot/lidar").every == 2
    assert scenario.component("robot/controller").inputs == {"scan": Reference("robot/lidar")}


def test_a_component_has_all_its_options_and_a_class_that_loads(folder: Path) -> None:
    crowd = load("base.yaml").component("crowd")
    assert crowd.use == f"{folder / 'mine.py'}:People"
    assert load_class(crowd.use).__name__ == "People"
    options = {"count": 3, "speed": 1.3, "policy": "orca", "gait": {"stride": 0.7}, "sizes": [], "seat": None}
    assert crowd.config == options
    assert str(crowd.problem("is wrong", "config", "count")) == "base.yaml:8: crowd.config.count: is wrong"


def test_an_unknown_component_is_asked_for_in_vain(folder: Path) -> None:
    with pytest.raises(KeyError, match="did you mean 'crowd'"):
        load("base.yaml").component("crwd")


def test_the_time_step_is_exact(folder: Path) -> None:
    assert load("base.yaml", ["dt=1e-3"]).period == 1_000_000
    assert load("base.yaml", ["dt=0.033333333"]).period == 33_333_333
    assert load("base.yaml", ["dt=0.7", "end.time_limit=2.1"]).last_tick == 3  # 2.1 / 0.7 > 3 in binary
    assert load("base.yaml", ["dt=0.7", "end.time_limit=2.2"]).last_tick == 4


@pytest.mark.parametrize(
    ("boundary", "periodic", "stops_people"),
    [
        ("none", "[false, false]", []),
        ("robots", "[true, true]", [False] * 4),
        ("robots", "[false, false]", [False] * 4),
        ("all", "[false, false]", [True] * 4),
        ("all", "[true, false]", [True, False, True, False]),  # south, east, north, west
    ],
)
def test_the_boundary_is_four_walls(folder: Path, boundary: str, periodic: str, stops_people: list[bool]) -> None:
    world = load("base.yaml", [f"world.boundary={boundary}", f"world.periodic={periodic}"]).world
    assert [wall.stops_people for wall in world.walls] == stops_people
    corners = [(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)]
    assert [wall.start for wall in world.walls] == (corners if stops_people else [])


def test_further_walls_stand_before_the_boundary(folder: Path) -> None:
    world = load("base.yaml", ["world.walls=[{start: [20, 0], end: [20, 4]}]"]).world
    assert world.walls[0] == Wall(start=(20.0, 0.0), end=(20.0, 4.0), stops_people=True)
    assert len(world.walls) == 5


def test_hosts_are_those_of_the_component_or_the_scenario(folder: Path) -> None:
    scenario = load(
        "base.yaml", ["host=inline", "crowd.host=process", "robots.robot.controller={use: null, host: external}"]
    )
    hosts = {c.name: c.host for c in scenario.components}
    assert hosts["crowd"] == "process"
    assert hosts["robot/lidar"] == "inline"
    assert (hosts["robot/controller"], scenario.component("robot/controller").use) == ("external", None)


def test_a_command_line_runs_in_the_folder_of_its_file(
    changed: Change, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = folder / "mine.sh"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    path = changed("use: ./mine.py:Driver", "exec: [./mine.sh, --fast]")
    (folder / "else").mkdir()
    monkeypatch.chdir(folder / "else")
    controller = load(f"../{path}").component("robot/controller")
    assert (controller.host, controller.exec, controller.cwd) == ("exec", ("./mine.sh", "--fast"), folder)


def test_crowd_controller_and_evaluator_may_be_left_out(folder: Path) -> None:
    scenario = load("base.yaml", ["crowd=null", "evaluator=null", "robots.robot.controller=null"])
    assert [c.name for c in scenario.components] == ["robot", "robot/lidar"]


def test_without_robots_nobody_has_to_reach_a_goal(folder: Path) -> None:
    assert load("base.yaml", ["robots=null"]).ending.goal == "none"


def test_settings_are_yaml_and_the_last_wins(folder: Path) -> None:
    scenario = load(
        "base.yaml", ["seed=1", "seed=7", "crowd.config={speed: 1e-1, gait: {stride: 0.5}}", "description=a=b"]
    )
    assert (scenario.seed, scenario.description) == (7, "a=b")
    assert scenario.component("crowd").config["count"] == 3
    assert scenario.component("crowd").config["speed"] == 0.1
    assert scenario.component("crowd").config["gait"] == {"stride": 0.5}


def test_a_setting_over_a_robots_name_changes_one_value_of_it(folder: Path) -> None:
    model = load("base.yaml", ["robots.robot.model.max_speed=0.5"]).robots[0].model
    assert (model.max_speed, model.radius) == (0.5, 0.177)


def test_a_robot_may_be_a_file_or_given_in_full(folder: Path) -> None:
    (folder / "fast.yaml").write_text("extends: turtlebot2\nmax_speed: 3\n")
    assert load("base.yaml", ["robots.robot.model=./fast.yaml"]).robots[0].model.max_speed == 3.0
    limits = "max_speed: 2, max_acceleration: 1, max_angular_velocity: 1, max_angular_acceleration: 1"
    full = f"{{radius: 1, height: 1, mass: 1, {limits}}}"
    (folder / "s.yaml").write_text((folder / "base.yaml").read_text().replace("turtlebot2", full))
    assert load("s.yaml").robots[0].model.max_speed == 2.0


def test_extending_merges_mappings_replaces_lists_and_deletes_with_null(folder: Path) -> None:
    (folder / "s.yaml").write_text(
        "extends: base.yaml\nworld: {size: [60, 12]}\nevaluator: null\ncrowd: {config: {speed: 2}}\n"
    )
    scenario = load("s.yaml")
    assert scenario.name == "s"
    assert scenario.world.size == (60.0, 12.0)
    assert len(scenario.world.walls) == 4
    assert scenario.component("crowd").config["count"] == 3
    assert scenario.component("crowd").config["speed"] == 2.0
    assert [c.name for c in scenario.components] == ["crowd", "robot", "robot/lidar", "robot/controller"]


def test_of_several_bases_the_later_wins_and_the_file_itself_last(folder: Path) -> None:
    (folder / "a.yaml").write_text("seed: 2\ndescription: not inherited\nend: {time_limit: 40}\n")
    (folder / "b.yaml").write_text("seed: 3\nend: {collision: true}\n")
    (folder / "s.yaml").write_text("extends: [base.yaml, a.yaml, b.yaml]\nend: {goal: any}\n")
    scenario = load("s.yaml")
    assert (scenario.seed, scenario.description) == (3, "")
    assert (scenario.ending.time_limit, scenario.ending.collision, scenario.ending.goal) == (40.0, True, "any")


def test_paths_are_relative_to_the_file_that_wrote_them(folder: Path) -> None:
    (folder / "sub").mkdir()
    (folder / "sub" / "s.yaml").write_text("extends: ../base.yaml\nseed: 5\n")
    assert load("sub/s.yaml").component("crowd").use == f"{folder / 'mine.py'}:People"


@pytest.mark.parametrize("settings", [[], ["crowd.config.seat=0.4", "host=inline"], ["robots=null", "evaluator=null"]])
def test_a_resolved_scenario_loads_again_in_any_folder(
    folder: Path, tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, settings: list[str]
) -> None:
    scenario = load("base.yaml", settings)
    stored = json.loads(json.dumps(scenario.resolved))
    monkeypatch.chdir(tmp_path_factory.mktemp("elsewhere"))
    assert load(stored) == scenario
    assert from_resolved(stored) == scenario
    assert load(stored).resolved == scenario.resolved


def test_a_logs_scenario_loads_without_its_components(folder: Path) -> None:
    scenario = load("base.yaml", ["robots.robot.controller={use: null, exec: [sh]}"])
    stored = json.loads(json.dumps(scenario.resolved).replace("mine.py", "gone.py").replace('"sh"', '"gone"'))
    again = from_resolved(stored)
    assert again.component("crowd").config == scenario.component("crowd").config
    assert again.component("robot/controller").exec == ("gone",)
    with pytest.raises(ScenarioError, match="there is no program 'gone'"):
        load(stored)


def test_a_resolved_scenario_keeps_short_names_and_holds_its_robots(folder: Path) -> None:
    resolved = load("base.yaml", ["robots.robot.controller={use: baseline, inputs: null}"]).resolved
    assert resolved["robots"]["robot"]["controller"]["use"] == "baseline"
    assert resolved["robots"]["robot"]["model"]["radius"] == 0.177
    assert resolved["deadlines"] == {"start": 60.0, "step": 10.0}


def test_who_may_attach_is_said_with_paths_relative_to_the_file_and_never_stored(folder: Path) -> None:
    (folder / "office").mkdir()
    (folder / "office" / "open.yaml").write_text(
        "extends: ../base.yaml\n"
        "attach: {listen: 'tls/0.0.0.0:7450', certificate: ./server.pem, key: ../server.key, users: /etc/users.txt}\n"
    )
    scenario = load("office/open.yaml", ["attach.authority=./ca.pem"])
    assert scenario.admission == Admission(
        listen="tls/0.0.0.0:7450",
        certificate=folder / "office" / "server.pem",
        key=folder / "server.key",
        authority=Path.cwd() / "ca.pem",
        users=Path("/etc/users.txt"),
    )
    assert "attach" not in scenario.resolved
    assert "server" not in json.dumps(scenario.resolved)
    assert load("base.yaml").admission is None


def test_a_mapping_may_extend_a_shipped_scenario(folder: Path) -> None:
    everything = {"crowd": None, "evaluator": None, "robots": {"robot": None}}
    scenario = load({"name": "mine", "extends": "corridor", "end": {"goal": "none"}} | everything)
    assert isinstance(scenario, Scenario)
    assert (scenario.name, scenario.components) == ("mine", ())


def test_reading_a_scenario_loads_neither_numba_nor_zenoh() -> None:
    heavy = {"numba", "zenoh", "pymunk", "matplotlib"}
    program = f"import sys, orchestrator.scenario.scenario; print({heavy} & set(sys.modules))"
    assert subprocess.check_output([sys.executable, "-c", program], text=True).strip() == "set()"


def test_naming_another_component_drops_the_options_of_the_one_that_was_there() -> None:
    changed = load(
        "corridor", ["robots.robot.sensors.lidar.config.beams=90", "robots.robot.sensors.lidar.use=odometry"]
    )
    assert "beams" not in changed.component("robot/lidar").config


def test_a_command_takes_the_place_of_a_shipped_component() -> None:
    changed = load("corridor", ["robots.robot.controller.exec=[sh, -c, 'true']"])
    assert changed.component("robot/controller").host == "exec"
