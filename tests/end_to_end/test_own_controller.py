"""A controller of one's own, from the command line: written, tested, and put in place of another."""

from __future__ import annotations

import subprocess
import sys

from orchestrator.log.reader import read_log


def test_a_new_controller_works_at_once_and_its_test_passes(crowdcosim) -> None:
    outcome = crowdcosim("new", "controller", "polite_driver", "--out", "mine", "--json")
    assert outcome.code == 0, outcome.stderr
    folder = crowdcosim.folder / "mine"
    assert {path.name for path in folder.iterdir()} == set(map(_name, outcome.json.values()))
    tests = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-W", "error", "-p", "no:cacheprovider", outcome.json["test"]],
        cwd=crowdcosim.folder,
        env=crowdcosim.environment,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert tests.returncode == 0, tests.stdout
    assert "3 passed" in tests.stdout
    again = crowdcosim("new", "controller", "polite_driver", "--out", "mine")
    assert again.code == 2
    assert "already" in again.stderr
    assert crowdcosim("new", "controller", "9lives").code == 2


def test_a_controller_takes_the_place_of_the_scenarios_own(crowdcosim, scenario) -> None:
    crowdcosim("new", "controller", "mine")
    path = scenario("robots: {robot: {sensors: {lidar: {use: lidar, config: {beams: 60}}}}}\nreference: false")
    options = ["--host", "inline", "--set", "end.time_limit=2", "--set", "robots.robot.controller.config.speed=0.4"]
    outcome = crowdcosim("run", path, "--controller", "./mine.py:Mine", "--out", "out", "--json", *options)
    assert outcome.code == 0, outcome.stdout
    log = read_log(crowdcosim.folder / "out" / "episode.mcap")
    assert log.scenario()["robots"]["robot"]["controller"]["use"] == f"{crowdcosim.folder}/mine.py:Mine"
    speeds = [twist.linear.x for _, twist in log.outputs("robot/controller", "twist")]
    assert 0.0 < max(speeds) <= 0.4


def _name(path: str) -> str:
    return path.rpartition("/")[2]
