"""The examples run as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


def test_the_robot_takes_the_place_of_a_recorded_person(crowdcosim) -> None:
    told = crowdcosim("tracks", str(EXAMPLES / "replay.yaml"), "--replace", "3", "--json")
    assert told.code == 0, told.stderr
    assert (told.json["start"]["x"], told.json["goal"]["x"]) == (9.0, 9.44)
    places = [f"robots.robot.{part}.{key}={value}" for part in told.json for key, value in told.json[part].items()]
    settings = [part for setting in ("reference=false", *places) for part in ("--set", setting)]
    outcome = crowdcosim("run", str(EXAMPLES / "replay.yaml"), *settings, "--host", "inline", "--out", "out", "--json")
    assert outcome.code == 0, outcome.stderr
    assert outcome.json["outcome"] == "goal", outcome.json


@pytest.mark.parametrize("name", ["my_controller", "plain_controller", "python_robotics"])
def test_the_example_runs(crowdcosim, name) -> None:
    settings = ["end.time_limit=2", "crowd.config.count=10", "reference=false"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    outcome = crowdcosim(
        "run", str(EXAMPLES / f"{name}.yaml"), *arguments, "--host", "inline", "--out", "out", "--json"
    )
    assert outcome.code == 0, outcome.stderr
    assert outcome.json["ticks"] == 20
