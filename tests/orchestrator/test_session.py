"""A session steps a scenario by hand and leaves what `crowdcosim run` would have left."""

from __future__ import annotations

import math
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crowdcosim import Session
from crowdcosim.messages import Twist, Vector3
from orchestrator.episode import Result, run_episode
from orchestrator.errors import InputError, RunError
from orchestrator.log.reader import read_log
from orchestrator.log.rerun import evaluate, rerun
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation

SMALL: dict[str, Any] = {
    "extends": "corridor",
    "name": "small",
    "host": "inline",
    "crowd": {"config": {"count": 10}},
    "robots": {"robot": {"sensors": {"lidar": {"use": "lidar", "config": {"beams": 36}}}, "controller": None}},
    "end": {"time_limit": 3},
}
FORWARD = (1.0, 0.0)


def driven_by_baseline(tmp_path: Path, settings: tuple[str, ...] = ()) -> Result:
    """What `crowdcosim run` makes of the small scenario with the baseline, whose command is always the same."""
    simulation = Simulation(load(SMALL, ["robots.robot.controller.use=baseline", *settings]), logs=tmp_path)
    return run_episode(simulation, log=tmp_path / "run.mcap")


def drive(session: Session, command: Any = FORWARD) -> Result:
    while not session.over:
        session.step(command)
    assert session.result is not None
    return session.result


@pytest.fixture
def session(tmp_path: Path):
    with Session(SMALL, record=tmp_path) as session:
        yield session


def test_the_same_commands_leave_the_same_bytes_as_a_run(tmp_path) -> None:
    with Session(SMALL, {"reference": False}, record=tmp_path) as session:
        assert drive(session).data_hash == driven_by_baseline(tmp_path, ("reference=false",)).data_hash


def test_an_episode_alone_is_the_reference_of_the_next(tmp_path) -> None:
    arrive = ["end.time_limit=6", "robots.robot.goal.x=8"]
    with Session(SMALL, arrive, record=tmp_path, alone=True) as session:
        assert session.view.crowd is not None
        assert len(session.view.crowd.id) == 0
        drive(session)
        assert not list(tmp_path.glob("*.mcap"))  # as the reference run of `crowdcosim run`, it leaves no log
        session.reset()
        result = drive(session)
    run = driven_by_baseline(tmp_path, tuple(arrive))
    assert {m.name: m.value for m in result.metrics}["time_ratio"] is not None
    assert result.metrics == run.metrics
    assert result.data_hash == run.data_hash


def test_robots_with_controllers_drive_themselves_and_are_compared_with_a_run_alone(tmp_path) -> None:
    with Session(SMALL, ["robots.robot.controller.use=baseline"], record=tmp_path) as session:
        assert session.commanded == ()
        assert drive(session, None).data_hash == driven_by_baseline(tmp_path).data_hash


def test_the_same_with_components_in_processes_that_wait_for_us(tmp_path, monkeypatch) -> None:
    (tmp_path / "giddy.py").write_text(GIDDY)
    monkeypatch.chdir(tmp_path)
    settings = ["reference=false", "robots.robot.sensors.giddy.use=./giddy.py:Giddy"]
    elsewhere = [f"robots.robot.{part}.host=process" for part in ("drive", "sensors.giddy")]
    with Session(SMALL, [*settings, *elsewhere, "deadlines.step=0.5"], record=tmp_path) as session:
        first = session.view.robot
        session.step(FORWARD)
        stopped = session.stop()
        assert (stopped.outcome, stopped.ticks) == ("stopped", 2)  # the tick under way is carried out
        assert session.reset().robot == first
        time.sleep(0.6)  # longer than a component may be silent
        assert drive(session).data_hash == driven_by_baseline(tmp_path, tuple(settings)).data_hash
        session.reset()
        with pytest.raises(RunError, match="robot/giddy.*I feel sick"):
            drive(session, (0.0, 3.0))
        with pytest.raises(InputError, match="the episode has failed"):
            session.step(FORWARD)
        session.reset(seed=2)
        assert session.step(FORWARD).tick == 1


GIDDY = """
from crowdcosim import Sensor
from crowdcosim.messages import PoseStamped, RobotState

class Giddy(Sensor):
    def step(self, robot: RobotState) -> PoseStamped:
        if robot.angular_velocity > 2:
            raise RuntimeError("I feel sick")
        return PoseStamped()
"""


def test_what_it_shows_is_what_the_log_holds(session, tmp_path) -> None:
    views = [session.view]
    while not session.over:
        views.append(session.step((0.5, 0.3)))
    log = read_log(tmp_path / "episode_1.mcap")
    assert log.complete
    for (component, port), show in {
        ("robot/lidar", "scan"): lambda view: view.robot.sensors["lidar/scan"],
        ("robot/lidar", "agents"): lambda view: view.robot.sensors["lidar/agents"],
        ("robot/odometry", "odometry"): lambda view: view.robot.sensors["odometry"],
        ("robot", "state"): lambda view: view.robot.state,
        ("robot", "contacts"): lambda view: view.robot.contacts,
        ("crowd", "crowd"): lambda view: view.crowd,
    }.items():
        recorded = [message for _, message in log.outputs(component, port)]
        shown = [show(view) for view in views]
        assert shown[: len(recorded)] == recorded
        assert len(recorded) >= 30
    assert [view.time for view in views] == pytest.approx([0.1 * k for k in range(31)])
    assert evaluate(log).value.tolist() == [m.value or 0.0 for m in session.result.metrics]


def test_the_last_view_is_of_the_last_state(session) -> None:
    drive(session)
    stamp = session.view.robot.sensors["lidar/scan"].header.stamp
    assert session.view.time == 3.0
    assert (stamp.sec, stamp.nanosec) == (3, 0)


def test_a_slow_sensor_shows_its_last_word() -> None:
    with Session(SMALL, {"robots.robot.sensors.lidar.every": 3}) as session:
        stamps = [session.step(FORWARD).robot.sensors["lidar/scan"].header.stamp.nanosec for _ in range(5)]
    assert stamps == [0, 0, 300_000_000, 300_000_000, 300_000_000]


def test_two_robots_are_commanded_one_by_one() -> None:
    with Session("two_robots", {"crowd.config.count": 0}, commanded=["left", "right"]) as session:
        for _ in range(20):
            view = session.step({"left": (1.0, 0.0), "right": Twist(linear=Vector3(x=0.2))})
        speeds = {name: robot.state.velocity[0] for name, robot in view.robots.items()}
        assert speeds == pytest.approx({"left": 1.0, "right": 0.2})
        with pytest.raises(InputError, match="no command for right"):
            session.step({"left": (1.0, 0.0)})
        with pytest.raises(InputError, match="expected one for each of left, right"):
            session.step(FORWARD)
        with pytest.raises(InputError, match="there are 2 robots"):
            _ = view.robot


def test_one_robot_is_commanded_and_the_other_drives_itself() -> None:
    with Session("two_robots", {"crowd.config.count": 5}, commanded="left") as session:
        for _ in range(10):
            view = session.step((0.0, 0.0))
    assert view.robots["left"].state.position[0] == 5.0
    assert view.robots["right"].state.position[0] > 5.1


def test_seeds_scenarios_and_time_steps_can_be_changed(session) -> None:
    places = {seed: session.reset(seed=seed).crowd.position for seed in (1, 2, 1)}
    assert not np.array_equal(places[1], places[2])
    assert np.array_equal(session.view.crowd.position, Session(SMALL, seed=1).view.crowd.position)
    view = session.load(SMALL, {"crowd.config.count": 3}, dt=0.05)
    assert len(view.crowd.id) == 3
    assert session.step(FORWARD).time == 0.05


def test_it_keeps_pace_with_the_wall_clock() -> None:
    with Session(SMALL, real_time=4.0) as session:
        begin = time.monotonic()
        for _ in range(20):
            session.step(FORWARD)
        assert 0.5 <= time.monotonic() - begin < 5.0  # 2 s at four times real time, and what a busy machine adds


def test_the_time_between_two_steps_is_the_computing_time_of_the_controller(session) -> None:
    for _ in range(3):
        time.sleep(0.02)
        session.step(FORWARD)
    timing = session.stop().timing["robot/controller"]
    assert timing.steps == 3
    assert timing.median >= 0.02


def test_stopping_gives_metrics_and_a_complete_log(session, tmp_path) -> None:
    for _ in range(7):
        session.step(FORWARD)
    result = session.stop()
    assert session.over
    assert (result.outcome, result.ticks) == ("stopped", 7)
    assert {m.name: m.value for m in result.metrics}["path_length"] == pytest.approx(0.6, abs=0.1)
    assert session.stop() is result
    log = read_log(tmp_path / "episode_1.mcap")
    assert log.complete
    assert log.metadata["outcome"]["reason"] == "stopped"


def test_each_episode_has_a_log_of_its_own(session, tmp_path) -> None:
    session.step(FORWARD)
    session.reset()
    session.reset(seed=2)
    session.step(FORWARD)
    session.step(FORWARD)
    session.reset()
    session.close()
    # An episode without a step leaves none without a step leaves none


def test_of_its_log_every_component_but_the_one_who_commands_can_be_run_again(session, tmp_path) -> None:
    drive(session)
    log = read_log(tmp_path / "episode_1.mcap")
    assert all(step.again == step.recorded for step in rerun(log, "robot/lidar"))
    with pytest.raises(RunError, match="robots that a Session commands"):
        list(rerun(log, "robot/controller"))


def test_an_error_in_the_users_loop_leaves_a_readable_log_that_says_so(tmp_path) -> None:
    with pytest.raises(ZeroDivisionError), Session(SMALL, record=tmp_path) as session:
        session.step(FORWARD)
        _ = 1 / 0
    outcome = read_log(tmp_path / "episode_1.mcap").metadata["outcome"]
    assert outcome["reason"] == "failed"
    assert outcome["error"] == "division by zero"


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ((math.nan, 0.0), "expected finite numbers"),
        ((1.0, math.inf), "expected finite numbers"),
        (Twist(angular=Vector3(z=math.nan)), "expected finite numbers"),
        ((1.0,), "expected a Twist, or forward speed"),
        ("fast", "expected a Twist, or forward speed"),
        (1.0, "expected a Twist, or forward speed"),
        (None, "no command for robot"),
        ({"robto": FORWARD}, "did you mean 'robot'"),
    ],
)
def test_a_wrong_command_is_refused_and_the_episode_goes_on(session, command, words) -> None:
    with pytest.raises(InputError, match=words):
        session.step(command)
    assert session.step(np.array([1.0, 0.0])).tick == 1


def test_a_holonomic_robot_is_commanded_sideways_too() -> None:
    base = {"kind": "holonomic", "max_lateral_speed": 0.5}
    with Session(SMALL, {"robots.robot.model.base": base, "robots.robot.drive": {"use": "kinematic"}}) as session:
        for _ in range(5):
            view = session.step((0.2, 0.4, 0.0))
    assert view.robot.state.velocity == pytest.approx([0.2, 0.4])


def test_the_end_of_an_episode_is_the_end(session) -> None:
    drive(session)
    with pytest.raises(InputError, match=r"is over \(time_limit\): begin another with reset"):
        session.step(FORWARD)
    session.close()
    with pytest.raises(InputError, match="closed"):
        session.reset()
    session.close()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"scenario": "coridor"}, "did you mean 'corridor'"),
        ({"commanded": "robto"}, "did you mean 'robot'"),
        ({"settings": {"crowd.config.cuont": 3}}, "did you mean 'count'"),
        ({"dt": -1.0}, "dt"),
        ({"seed": -1}, "seed"),
        ({"latency": 0.1}, "no robot is commanded"),
    ],
)
def test_what_cannot_be_opened_is_refused_with_a_reason(arguments, words) -> None:
    with pytest.raises(InputError, match=words):
        Session(**arguments)


def test_a_command_for_a_robot_that_drives_itself_is_refused() -> None:
    session = Session(SMALL, ["robots.robot.controller.use=baseline"])
    with session, pytest.raises(InputError, match="expected none"):
        session.step(FORWARD)


def test_a_component_that_fails_ends_the_episode(tmp_path, monkeypatch) -> None:
    (tmp_path / "giddy.py").write_text(GIDDY)
    monkeypatch.chdir(tmp_path)
    with Session(SMALL, {"robots.robot.sensors.giddy": {"use": "./giddy.py:Giddy"}}) as session:
        with pytest.raises(RunError, match="robot/giddy.*I feel sick"):
            drive(session, (0.0, 3.0))
        with pytest.raises(InputError, match="the episode has failed"):
            session.step(FORWARD)
        assert session.reset().tick == 0
