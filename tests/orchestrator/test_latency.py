"""A robot that lives with its controller's latency gets each command when it is there, and not before."""

from __future__ import annotations

import time
from pathlib import Path

import pytest

from crowdcosim import Session
from crowdcosim.messages import Twist, Vector3
from crowdcosim.setup import Setup
from crowdcosim.world import World
from orchestrator.episode import Result, run_episode
from orchestrator.errors import InputError
from orchestrator.latency import CommandInEffect
from orchestrator.log.reader import read_log
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation

SETUP = Setup(component="robot/command", period=100, seed=1, world=World(size=(1.0, 1.0)), robot="robot")
SMALL = {
    "extends": "corridor",
    "name": "small",
    "host": "inline",
    "crowd": {"config": {"count": 0}},
    "robots": {"robot": {"sensors": {"lidar": None}, "goal": {"x": 8}, "controller": {"use": "baseline"}}},
    "reference": False,
    "end": {"time_limit": 10},
}


def speeds(latency, *, ticks: int = 8, every: int = 1) -> list[float]:
    """What the drive gets when tick k's decision is the speed k + 1; a tick takes 100 ns."""
    command = CommandInEffect(latency, period=100, every=every)
    command.reset(SETUP)
    return [command.step(Twist(linear=Vector3(x=float(k // every * every + 1)))).linear.x for k in range(ticks)]


def test_without_latency_a_command_takes_effect_at_once() -> None:
    assert speeds(0) == [1, 2, 3, 4, 5, 6, 7, 8]


def test_a_fixed_latency_is_a_dead_time() -> None:
    assert speeds(200) == [0, 0, 1, 2, 3, 4, 5, 6]


def test_a_step_gets_the_mean_of_the_commands_in_its_time() -> None:
    assert speeds(25) == pytest.approx([0.75, 1.75, 2.75, 3.75, 4.75, 5.75, 6.75, 7.75])
    assert speeds(130) == pytest.approx([0, 0.7, 1.7, 2.7, 3.7, 4.7, 5.7, 6.7])


def test_a_controller_that_decides_every_third_tick_is_late_with_each_decision_once() -> None:
    assert speeds(100, every=3) == [0, 1, 1, 1, 4, 4, 4, 7]


def test_a_controller_that_still_computes_misses_what_it_would_have_had_to_begin_meanwhile() -> None:
    # 250 ns each: begun at 0, 300, 600; there at 250, 550.
    assert speeds(lambda: 250) == pytest.approx([0, 0, 0.5, 1, 1, 0.5 * (1 + 4), 4, 4])
    # One slow decision, then quick ones: what was sensed at 100 and 200 is never acted on.
    times = iter([250, 0, 0, 0, 0, 0])
    assert speeds(lambda: next(times)) == pytest.approx([0, 0, 0.5, 4, 5, 6, 7, 8])


def test_a_new_episode_begins_with_nothing_under_way() -> None:
    command = CommandInEffect(100, period=100, every=1)
    for _ in range(2):
        command.reset(SETUP)
        assert command.step(Twist(linear=Vector3(x=1.0))).linear.x == 0.0
        assert command.step(Twist(linear=Vector3(x=2.0))).linear.x == 1.0


def run(tmp_path: Path, *settings: str) -> Result:
    simulation = Simulation(load(SMALL, settings), logs=tmp_path)
    result = run_episode(simulation, log=tmp_path / "run.mcap")
    simulation.close()
    return result


def test_who_starts_later_arrives_as_much_later(tmp_path) -> None:
    times = {late: run(tmp_path, f"robots.robot.controller.latency={late}").simulated_time for late in (0, 0.3, 0.7)}
    assert times[0.3] - times[0] == pytest.approx(0.3)
    assert times[0.7] - times[0] == pytest.approx(0.7)


def test_the_log_has_the_decision_and_what_the_drive_got(tmp_path) -> None:
    result = run(tmp_path, "robots.robot.controller.latency=0.2")
    log = read_log(tmp_path / "run.mcap")
    decided = [twist.linear.x for _, twist in log.outputs("robot/controller", "twist")]
    got = [twist.linear.x for _, twist in log.outputs("robot/command", "twist")]
    assert got == [0.0, 0.0, *decided[:-2]]
    assert decided[0] == 1.0
    assert result.repeatable
    assert log.metadata["run"]["repeatable"] == "true"


def test_a_fixed_latency_gives_the_same_bytes_again_and_in_another_process(tmp_path) -> None:
    late = ("robots.robot.controller.latency=0.25", "end.time_limit=2")
    first = run(tmp_path, *late)
    assert run(tmp_path, *late).data_hash == first.data_hash
    assert run(tmp_path, *late, "robots.robot.controller.host=process").data_hash == first.data_hash


def test_a_measured_latency_is_that_of_the_controller_and_said_to_be_not_repeatable(tmp_path) -> None:
    waits = {"robots.robot.controller": {"use": "baseline", "latency": "measured"}}
    with Session(SMALL, waits) as session:  # its own controller, which computes for microseconds
        assert session.step().robot.state.velocity[0] > 0.4
    (tmp_path / "slow.py").write_text(SLOW)
    result = run(
        tmp_path, f"robots.robot.controller.use={tmp_path}/slow.py:Slow", "robots.robot.controller.latency=measured"
    )
    assert not result.repeatable
    log = read_log(tmp_path / "run.mcap")
    assert log.metadata["run"]["repeatable"] == "false"
    got = [twist.linear.x for _, twist in log.outputs("robot/command", "twist")]
    assert got[0] == 0.0  # computing took longer than a time step
    assert 0.0 < sum(got[1:3]) < 2.0  # 0.12 s, or a little more on a busy machine
    assert got[-1] == 1.0


SLOW = """
import time
from crowdcosim import Controller
from crowdcosim.messages import Twist, Vector3

class Slow(Controller):
    said = 0
    def reset(self, setup):
        self.said = 0
    def step(self) -> Twist:
        if self.said == 0:
            time.sleep(0.12)
        self.said += 1
        return Twist(linear=Vector3(x=1.0))
"""


def test_computing_time_alone_never_changes_the_outcome(tmp_path) -> None:
    (tmp_path / "slow.py").write_text(SLOW)
    (tmp_path / "quick.py").write_text(SLOW.replace("0.12", "0"))
    slow, quick = (run(tmp_path, f"robots.robot.controller.use={tmp_path}/{n}.py:Slow") for n in ("slow", "quick"))
    assert slow.data_hash == quick.data_hash
    assert slow.timing["robot/controller"].max > 0.12 > quick.timing["robot/controller"].max


def test_who_commands_a_robot_by_hand_can_be_late_too() -> None:
    with Session(SMALL, {"robots.robot.controller": None}, commanded="robot") as session:
        assert session.step((1.0, 0.0)).robot.state.velocity[0] > 0.0
    with Session(SMALL, commanded="robot", latency="measured") as session:
        time.sleep(0.15)
        assert session.step((1.0, 0.0)).robot.state.velocity[0] == 0.0
        assert session.step((1.0, 0.0)).robot.state.velocity[0] > 0.0
        assert session.stop().repeatable is False


@pytest.mark.parametrize(
    ("latency", "words"), [("-1", "latency.*at least 0"), ("mesured", "did you mean 'measured'"), ("[1]", "latency")]
)
def test_a_wrong_latency_is_refused(latency, words) -> None:
    with pytest.raises(InputError, match=words):
        load(SMALL, [f"robots.robot.controller.latency={latency}"])


def test_only_controllers_have_a_latency() -> None:
    with pytest.raises(InputError, match=r"drive.latency: unknown key"):
        load(SMALL, ["robots.robot.drive.latency=1"])
