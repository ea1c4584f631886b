"""`crowdcosim check` lets good components pass, and fails a bad one in the one examination that is about its fault."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
EXAMPLES = HERE.parent.parent / "examples"
RAW = (sys.executable, str(HERE / "raw_component.py"))

HELLO = "hello: protocol, ports and type hashes"
CONFIG = "an unknown key in the config is refused"
CONNECTS = "takes its config and connects"
FINITE = "finite outputs on every port, with the right tick"
RESET = "a reset and the same seed give the same bytes"
PROCESS = "a new process and the same seed give the same bytes"
STOP = "leaves with exit code 0 when told to stop"
LEAVES = "leaves when the orchestrator has gone in the middle of a step"
WRONG_TICK = "an input of the wrong tick is refused"
ALL = [HELLO, CONFIG, CONNECTS, FINITE, RESET, STOP, PROCESS, LEAVES, WRONG_TICK]


def failures(crowdcosim, *arguments: str) -> dict[str, str]:
    """What a component fails in, and how; the exit code agrees."""
    outcome = crowdcosim("check", "--json", "--deadline", "20", *arguments)
    assert outcome.stdout, outcome.stderr
    verdicts = outcome.json["verdicts"]
    failed = {v["name"]: v["detail"] for v in verdicts if not v["passed"]}
    assert (outcome.code, outcome.json["passed"]) == ((1, False) if failed else (0, True))
    names = [v["name"] for v in verdicts]
    assert names == [name for name in ALL if name in names]
    return failed


@pytest.mark.parametrize(
    "component",
    [
        ["components.controllers.baseline:Baseline"],
        ["--", sys.executable, str(EXAMPLES / "plain_controller.py")],
        ["--", *RAW],
    ],
    ids=["shipped", "plain", "raw"],
)
def test_good_components_pass_every_examination(crowdcosim, component) -> None:
    assert failures(crowdcosim, *component) == {}


def test_a_mover_passes_every_examination(crowdcosim) -> None:
    (crowdcosim.folder / "walker.py").write_text(
        """
from crowdcosim import Mover, Setup
from crowdcosim.messages import Crowd, RobotState


class Walker(Mover):
    def reset(self, setup: Setup) -> Crowd:
        self.x, self.dt = float(setup.rng().random()), setup.dt
        return self.crowd()

    def step(self, robots: tuple[RobotState, ...]) -> Crowd:
        self.x += self.dt / len(robots)
        return self.crowd()

    def crowd(self) -> Crowd:
        one = [1.0]
        return Crowd(
            id=[1], group=[0], position=[[self.x, 1.0]], velocity=[[1.0, 0.0]], heading=one, radius=one, stature=one,
            mass=one, gait_phase=one, gait_speed=one,
        )
"""
    )
    assert failures(crowdcosim, "./walker.py:Walker") == {}


@pytest.mark.parametrize(
    ("fault", "examination", "words"),
    [
        ("dies_before_hello", HELLO, ["exited with code 4"]),
        ("wrong_hash", HELLO, ["port 'twist'", "RIHS01_0000", "expected RIHS01_9c45", "another definition"]),
        ("wrong_protocol", HELLO, ["speaks protocol 99, expected 1"]),
        ("takes_any_config", CONFIG, ["took the option 'no_such_option' without a word"]),
        ("wrong_tick", FINITE, ["at tick 0", "output 'twist' is labelled tick 1", "expected tick 0"]),
        ("nan", FINITE, ["at tick 0", "output 'twist'", "Twist.linear.x is nan"]),
        ("clock", RESET, ["output 'twist' differs from the episode before"]),
        ("ignores_reset", RESET, ["output 'twist' differs from the episode before"]),
        ("process", PROCESS, ["output 'twist' differs from that of another process"]),
        ("exit_code", STOP, ["exited with code 3"]),
        ("ignores_stop", STOP, ["still runs 3 s later"]),
        ("stays_alone", LEAVES, ["still runs 3 s later"]),
        ("any_input", WRONG_TICK, ["at tick 0", "stepped on inputs of tick 7 when it was asked for tick 0"]),
    ],
)
def test_a_component_with_one_fault_fails_the_one_examination_that_is_about_it(
    crowdcosim, fault, examination, words
) -> None:
    failed = failures(crowdcosim, "--", *RAW, "--fault", fault)
    assert list(failed) == [examination]
    for word in words:
        assert word in failed[examination]


def test_a_component_that_hangs_fails_within_the_deadline(crowdcosim) -> None:
    outcome = crowdcosim("check", "--json", "--deadline", "2", "--", *RAW, "--fault", "hang", "--at", "5")
    (failed,) = [v for v in outcome.json["verdicts"] if not v["passed"]]
    assert failed["name"] == FINITE
    assert "at tick 5: has not answered for 2 s" in failed["detail"]


def test_a_python_controller_that_uses_the_random_module_is_found_out(crowdcosim) -> None:
    (crowdcosim.folder / "dice.py").write_text(
        """
import random

from crowdcosim import Controller
from crowdcosim.messages import Odometry, Twist, Vector3


class Dice(Controller):
    def step(self, odometry: Odometry) -> Twist:
        return Twist(linear=Vector3(x=random.random()))
"""
    )
    assert list(failures(crowdcosim, "./dice.py:Dice")) == [RESET]


def test_a_command_that_is_not_there_is_named(crowdcosim) -> None:
    failed = failures(crowdcosim, "--", "./no_such_controller")
    assert list(failed) == [HELLO]
    assert "cannot start ./no_such_controller" in failed[HELLO]


def test_a_config_that_the_component_does_not_take_is_shown(crowdcosim) -> None:
    failed = failures(crowdcosim, "--config", '{"speed": 1}', "--", *RAW)
    assert list(failed) == [CONNECTS]
    assert "there is no option speed" in failed[CONNECTS]
    assert '{"speed": 1}' in failed[CONNECTS]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--config", "speed", "x:Y"], ["--config is not JSON"]),
        (["x:Y", "--config", "{}"], ["expected options before the component", "check --config '{}' x:Y"]),
    ],
)
def test_what_cannot_be_checked_is_bad_input(crowdcosim, arguments, words) -> None:
    outcome = crowdcosim("check", *arguments)
    assert outcome.code == 2
    for word in words:
        assert word in outcome.stderr
