"""A function as PythonRobotics writes them gets what it expects, and drives."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from components.controllers.python_robotics import NOBODY, Config, PythonRobotics
from crowdcosim import Session
from crowdcosim.component import ComponentError
from orchestrator.errors import RunError

EXAMPLES = Path(__file__).parents[3] / "examples"

SPY = """
class Config:
    def __init__(self):
        self.max_speed = 0.1
        self.max_yawrate = 0.1
        self.robot_radius = 0.1
        self.dt = 9.0
        self.to_goal_cost_gain = 0.15

config = Config()
calls = []

def control(x, config, goal, ob):
    calls.append((x, config, goal, ob))
    return [0.5, 0.1], [[x[0], x[1], x[2], 0.5, 0.1], [x[0] + 1.0, x[1], x[2], 0.5, 0.1]]

def silent(x, config, goal, ob):
    return [0.5, 0.1]
"""


@pytest.fixture
def spy(tmp_path: Path) -> Path:
    (tmp_path / "spy.py").write_text(SPY)
    return tmp_path / "spy.py"


def opened(function: str, positions: list[list[float]], **options) -> Session:
    crowd = {"count": None, "positions": positions, "flow": "1d-"} if positions else {"count": 0}
    controller = {"use": "python_robotics", "config": {"function": function} | options}
    return Session("corridor", {"crowd.config": crowd, "robots.robot.controller": controller, "reference": False})


def module_of(session: Session):
    controller = session._simulation.hosted("robot/controller")
    return controller._control.__globals__


def test_the_function_gets_state_goal_and_obstacles(spy) -> None:
    with opened(f"{spy}:control", [[8.0, 5.0], [49.0, 5.0], [30.0, 5.0]], wall_spacing=1.0) as session:
        session.step()  # a controller of its own has already decided what the next step will be
        (first, config, goal, ob), (second, *_) = module_of(session)["calls"]
    assert first == pytest.approx([5.0, 5.0, 0.0, 0.0, 0.0])
    assert second[3:] == pytest.approx([0.5, 0.1])
    assert goal == pytest.approx([55.0, 5.0])  # well beyond the line at 45
    assert config.to_goal_cost_gain == 0.15
    assert (config.max_speed, config.max_yawrate, config.dt) == pytest.approx((1.0, math.pi, 0.1))
    assert config.robot_radius == pytest.approx(0.177 + 0.3)
    people = ob[(ob[:, 1] == 5.0) & (ob[:, 0] != 0.0)]
    assert people == pytest.approx(np.array([[8.0, 5.0], [-1.0, 5.0]]))  # the second across the seam, the third too far
    walls = ob[np.isin(ob[:, 1], (0.0, 10.0))]
    assert {tuple(p) for p in walls.round(6).tolist()} >= {(float(x), y) for x in range(14) for y in (0.0, 10.0)}


def test_the_command_and_the_trajectory_come_out(spy, tmp_path) -> None:
    with opened(f"{spy}:control", []) as session:
        session.step()
        latest = session._simulation.lockstep.latest
        plan, twist = latest("robot/controller", "plan", 1), latest("robot/controller", "twist", 1)
    assert (twist.linear.x, twist.angular.z) == (0.5, 0.1)
    assert [(p.pose.position.x, p.pose.position.y) for p in plan.poses] == [(5.0, 5.0), (6.0, 5.0)]


def test_where_nothing_is_near_there_is_a_point_far_away(spy) -> None:
    with opened(f"{spy}:control", [], reach=2.0) as session:
        ((*_, ob),) = module_of(session)["calls"]
    assert np.array_equal(ob, NOBODY)


def test_the_example_dodges_most_of_those_whom_one_who_is_blind_runs_into() -> None:
    against = {"count": None, "positions": [[12.0, 5.0], [18.0, 5.1], [24.0, 4.9]], "flow": "1d-", "reactive": False}
    contacts = {}
    for name, controller in {
        "example": {"use": "python_robotics", "config": {"function": f"{EXAMPLES}/python_robotics.py:avoid"}},
        "blind": {"use": "baseline"},
    }.items():
        settings = {"crowd.config": against, "robots.robot.controller": controller, "robots.robot.goal.x": 17}
        with Session("corridor", settings | {"reference": False}, seed=3) as session:
            while not session.over:
                session.step()
            assert session.result.outcome == "goal"
            contacts[name] = {m.name: m.value for m in session.result.metrics}["collision_rate"]
    assert contacts["example"] < 0.5 * contacts["blind"]


def test_what_a_wrong_function_returns_is_said(spy) -> None:
    with pytest.raises(RunError, match=r"expected \[v, omega\] and a trajectory"):
        opened(f"{spy}:silent", [])


def test_a_function_that_is_not_there_is_refused(spy) -> None:
    with pytest.raises(ComponentError, match="has no 'contrl'"):
        PythonRobotics(Config(function=f"{spy}:contrl"))
    with pytest.raises(ComponentError, match="there is no file"):
        PythonRobotics(Config(function=f"{spy.parent}/nowhere.py:control"))
    with pytest.raises(ValueError, match=r"expected ./file.py:name"):
        Config(function="control")
