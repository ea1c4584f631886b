"""Which controller goes to which robot, as `--controller` says it."""

from __future__ import annotations

import pytest

from orchestrator.errors import InputError
from orchestrator.scenario.controller_choice import controller_settings
from orchestrator.scenario.scenario import load


def controllers(scenario: str, *texts: str) -> dict[str, str | None]:
    loaded = load(scenario, controller_settings(scenario, texts))
    return {spec.robot or "": spec.entry["use"] for spec in loaded.components if spec.name.endswith("/controller")}


def test_the_only_robot_needs_no_name() -> None:
    assert controllers("corridor", "rvo")["robot"] == controllers("corridor", "robot=rvo")["robot"]
    assert "RVO" in (controllers("corridor", "rvo")["robot"] or "")
    assert controllers("corridor")["robot"] == "dwa"


def test_of_several_robots_each_can_be_given_one() -> None:
    chosen = controllers("two_robots", "left=baseline", "right=dwa")
    assert "Baseline" in (chosen["left"] or "")
    assert "DWA" in (chosen["right"] or "")
    assert controllers("two_robots", "right=baseline")["left"] == "dwa"


@pytest.mark.parametrize(
    ("scenario", "texts", "words"),
    [
        ("two_robots", ["dwa"], "whose.*left, right"),
        ("two_robots", ["letf=dwa"], "did you mean 'left'"),
        ("corridor", ["dwa", "robot=rvo"], "twice"),
        ("corridor", ["dwaa"], "did you mean 'dwa'"),
        ("corridor", ["./nowhere.py:Mine"], "there is no file"),
    ],
)
def test_what_cannot_be_chosen_is_refused(scenario, texts, words) -> None:
    with pytest.raises(InputError, match=words):
        controller_settings(scenario, texts)
