"""A run that cannot begin or cannot go on ends with one clear message, a readable log and no process left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import time
from pathlib import Path

import pytest

HERE = Path(__file__).parent
FAULTY = f"{HERE / 'faulty.py'}:Faulty"
RAW = HERE / "raw_component.py"


def controller(fault: str, extra: str = "") -> str:
    return f"""
robots:
  robot:
    controller: {{use: "{FAULTY}", config: {{fault: {fault}}}{extra}}}
"""


def raw(fault: str, python: str) -> str:
    command = f'["{python}", "{RAW}", "--fault", "{fault}", "--at", "50"]'
    return f"""
robots:
  robot:
    controller: {{exec: {command}}}
deadlines: {{step: 2}}
"""


def log_of(crowdcosim, folder="out"):
    outcome = crowdcosim("inspect", folder, "--json")
    assert outcome.code == 0, outcome.stderr
    return outcome.json


# --- before t = 0 ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("crowd: {config: {cuont: 10}}", ["small.yaml:3", "crowd.config.cuont", "did you mean 'count'?"]),
        ("crowd: {config: {count: many}}", ["small.yaml:3", "crowd.config.count", "'many'", "expected"]),
        ("crowd: {config: {count: -1}}", ["small.yaml:3", "count", "-1", "expected"]),
        ("robots: {robot: {controller: {use: dwaa}}}", ["small.yaml:3", "dwaa", "did you mean 'dwa'?"]),
        ("robots: {robot: {controller: {use: ./gone.py:Mine}}}", ["small.yaml:3", "gone.py"]),
        (f"robots: {{robot: {{controller: {{use: '{HERE}/faulty.py:NotAComponent'}}}}}}", ["small.yaml:3", "subclass"]),
        ("robots: {robot: {controller: {exec: [no-such-program]}}}", ["small.yaml:3", "no-such-program"]),
        (
            "robots: {robot: {sensors: {odometry: null}, controller: {use: dwa}}}",
            ["small.yaml:3", "robots.robot.controller", "input 'odometry' is not connected"],
        ),
        ("dt: 0", ["small.yaml:3", "dt", "0"]),
        ("seed: 1\nseed: 2", ["small.yaml:4", "seed"]),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_bad_scenarios_are_refused_with_file_line_and_key(crowdcosim, scenario, text, words) -> None:
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 2
    assert "Traceback" not in outcome.stderr
    for word in words:
        assert word in outcome.stderr
    assert not (crowdcosim.folder / "out" / "episode.mcap").exists()


def test_a_scenario_that_is_not_there_is_refused(crowdcosim) -> None:
    outcome = crowdcosim("run", "coridor")
    assert outcome.code == 2
    assert "did you mean 'corridor'?" in outcome.stderr


def test_two_robots_in_one_place_are_refused(crowdcosim, scenario) -> None:
    second = """
robots:
  second:
    model: turtlebot2
    start: {x: 5.1, y: 5}
    goal: {x: 45, y: 5, direction: [1, 0]}
    drive: {use: kinematic}
    controller: {use: baseline}
    sensors: {odometry: {use: odometry}}
"""
    outcome = crowdcosim("run", scenario(second))
    assert outcome.code == 2
    assert "robots.second.start" in outcome.stderr
    assert "small.yaml:7" in outcome.stderr


def test_a_loop_in_the_wiring_is_refused(crowdcosim, scenario) -> None:
    (crowdcosim.folder / "loop.py").write_text(
        """
from crowdcosim import Controller, Sensor
from crowdcosim.messages import LaserScan, Twist

class Seer(Sensor):
    def step(self, twist: Twist) -> LaserScan: ...

class Doer(Controller):
    def step(self, scan: LaserScan) -> Twist: ...
"""
    )
    text = """
robots:
  robot:
    sensors: {seer: {use: ./loop.py:Seer}}
    controller: {use: ./loop.py:Doer}
"""
    outcome = crowdcosim("run", scenario(text))
    assert outcome.code == 2
    assert "loop within one tick" in outcome.stderr
    assert "robot/seer" in outcome.stderr
    assert "robot/controller" in outcome.stderr


def test_an_earlier_run_is_not_overwritten(crowdcosim, scenario) -> None:
    path = scenario("end: {time_limit: 0.5}")
    assert crowdcosim("run", path, "--host", "inline", "--out", "out").code == 0
    outcome = crowdcosim("run", path, "--host", "inline", "--out", "out")
    assert outcome.code == 2
    assert "already holds a run" in outcome.stderr


# --- at start-up -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("init", ["component 'robot/controller'", "no camera found"]),
        ("reset", ["component 'robot/controller'", "no map found", "faulty.py"]),
        ("exit_at_start", ["component 'robot/controller'", "exited with code 3", "I cannot live here"]),
    ],
)
def test_a_component_that_dies_at_start_is_named(crowdcosim, scenario, fault, words) -> None:
    outcome = crowdcosim("run", scenario(controller(fault)), "--out", "out")
    assert outcome.code == 1, outcome.stderr
    assert "Traceback" not in outcome.stderr
    for word in words:
        assert word in outcome.stderr


def test_a_component_that_hangs_at_start_is_named_within_the_deadline(crowdcosim, scenario) -> None:
    text = controller("hang_at_reset") + "deadlines: {start: 6}\n"
    begin = time.monotonic()
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 1
    assert "component 'robot/controller'" in outcome.stderr
    assert "6 s" in outcome.stderr
    assert time.monotonic() - begin < 30


def test_a_command_that_exits_at_once_is_named(crowdcosim, scenario) -> None:
    text = 'robots: {robot: {controller: {exec: [sh, -c, "echo no licence >&2; exit 5"]}}}'
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 1
    assert "exited with code 5" in outcome.stderr
    assert "no licence" in outcome.stderr


def test_an_external_component_that_never_attaches_is_named(crowdcosim, scenario) -> None:
    text = "robots: {robot: {controller: {host: external}}}\ndeadlines: {start: 4}\n"
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 1
    assert "component 'robot/controller': has not attached within 4 s" in outcome.stderr
    assert "--component robot/controller" in outcome.stderr  # how to attach it


# --- at tick 50 --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("raise", ["the wheels came off", "faulty.py"]),
        ("exit", ["exited with code 7", "goodbye, cruel world"]),
        ("kill", ["killed by SIGKILL"]),
        ("hang", ["has not answered for 2 s"]),
        ("nan", ["Twist.linear.x is nan"]),
    ],
)
@pytest.mark.parametrize("host", ["process", "inline"])
def test_a_component_that_fails_at_tick_50_is_named_and_the_log_goes_up_to_there(
    crowdcosim, scenario, fault, words, host
) -> None:
    if host == "inline" and fault in ("exit", "kill", "hang"):
        pytest.skip("takes the orchestrator with it: that is what processes are for")
    text = controller(fault, f", host: {host}") + "deadlines: {step: 2}\n"
    outcome = crowdcosim("run", scenario(text), "--out", "out")
    assert outcome.code == 1, outcome.stderr
    assert "component 'robot/controller' at tick 50" in outcome.stderr
    for word in words:
        assert word in outcome.stderr
    log = log_of(crowdcosim)
    assert log["complete"]
    assert log["outcome"]["reason"] == "failed"
    assert log["outcome"]["ticks"] == "50"
    assert log["duration"] == pytest.approx(5.0)


@pytest.mark.parametrize(
    ("fault", "words"),
    [
        ("wrong_tick", ["tick 51", "expected"]),
        ("nan", ["Twist.linear.x is nan"]),
        ("malformed", ["are not a geometry_msgs/msg/Twist"]),
        ("hang", ["has not answered for 2 s"]),
        ("die", ["exited with code"]),
    ],
)
def test_a_command_that_breaks_the_protocol_at_tick_50_is_named(crowdcosim, scenario, fault, words) -> None:
    import sys

    outcome = crowdcosim("run", scenario(raw(fault, sys.executable)), "--out", "out")
    assert outcome.code == 1, outcome.stderr
    assert "component 'robot/controller' at tick 50" in outcome.stderr
    for word in words:
        assert word in outcome.stderr
    assert log_of(crowdcosim)["duration"] == pytest.approx(5.0)


def test_json_carries_the_error_too(crowdcosim, scenario) -> None:
    outcome = crowdcosim("run", scenario(controller("raise", ", host: inline")), "--out", "out", "--json")
    assert outcome.code == 1
    assert outcome.json["error"]["component"] == "robot/controller"
    assert outcome.json["error"]["tick"] == 50


# --- ended from outside ------------------------------------------------------------------------------------------


def running(process: subprocess.Popen[str], folder: Path) -> None:
    """Wait until the run writes its log."""
    until = time.monotonic() + 60
    while not (folder / "out" / "episode.mcap").exists():
        assert process.poll() is None, process.communicate()
        assert time.monotonic() < until
        time.sleep(0.05)
    time.sleep(1.0)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGKILL], ids=lambda n: n.name)
def test_an_orchestrator_that_is_ended_leaves_no_process_and_a_log(crowdcosim, scenario, number) -> None:
    path = scenario("end: {time_limit: 1000, goal: none}\nreference: false")
    with crowdcosim.start("run", path, "--out", "out", "--realtime", "20") as process:
        running(process, crowdcosim.folder)
        assert len(crowdcosim.running()) > 5
        os.kill(process.pid, number)
        _, stderr = process.communicate(timeout=20)
    assert crowdcosim.left() == []
    if number == signal.SIGKILL:
        return
    assert process.returncode == 130
    assert "interrupted" in stderr
    assert log_of(crowdcosim)["complete"]
