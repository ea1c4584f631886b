"""An episode ends when its scenario says so, and for the reason that it says."""

import numpy as np
import pytest

from crowdcosim.messages import Contacts, Goal, RobotState
from orchestrator.ending import Referee
from orchestrator.scenario.file import Ending

LINE = Goal(robot="a", position=np.array([45.0, 5.0]), direction=np.array([1.0, 0.0]))
DISC = Goal(robot="b", position=np.array([10.0, 5.0]), tolerance=0.5)
GOALS = {"a": LINE, "b": DISC}


def at(x: float, y: float = 5.0) -> RobotState:
    return RobotState(position=np.array([x, y]))


def contact(kind: int) -> Contacts:
    one = np.ones(1)
    two = np.ones((1, 2))
    return Contacts(
        kind=[kind],
        agent=[1],
        body_part=[0],
        robot_part=[Contacts.FRONT],
        striker=[Contacts.BY_ROBOT],
        position=two,
        normal=two,
        relative_velocity=two,
        approach_speed=one,
        robot_closing_speed=one,
        reflected_mass=one,
        energy=one,
        duration=one,
    )


@pytest.mark.parametrize(
    ("goal", "a", "b", "reason"),
    [
        ("all", 45.0, 10.4, "goal"),
        ("all", 45.0, 10.6, None),
        ("all", 44.99, 10.0, None),
        ("any", 44.0, 10.0, "goal"),
        ("any", 44.0, 11.0, None),
        ("none", 46.0, 10.0, None),
    ],
)
def test_robots_arrive_by_crossing_a_line_or_entering_a_disc(goal, a, b, reason) -> None:
    referee = Referee(Ending(time_limit=10.0, goal=goal), GOALS, last_tick=100)
    assert referee.reason(5, {"a": at(a, 9.0), "b": at(b)}, {}) == reason


def test_who_has_arrived_stays_arrived() -> None:
    referee = Referee(Ending(time_limit=10.0), GOALS, last_tick=100)
    assert referee.reason(1, {"a": at(0), "b": at(10)}, {}) is None
    assert referee.arrived == {"b"}
    assert referee.reason(2, {"a": at(45), "b": at(20)}, {}) == "goal"


def test_a_collision_with_a_person_ends_it_only_if_asked_to() -> None:
    states, touched = {"a": at(0), "b": at(0)}, {"a": contact(Contacts.PERSON)}
    assert Referee(Ending(time_limit=1.0, collision=True), GOALS, 10).reason(1, states, touched) == "collision"
    assert Referee(Ending(time_limit=1.0), GOALS, 10).reason(1, states, touched) is None
    wall = {"a": contact(Contacts.WALL)}
    assert Referee(Ending(time_limit=1.0, collision=True), GOALS, 10).reason(1, states, wall) is None


def test_the_time_limit_ends_it_at_the_last_tick_but_arriving_then_counts() -> None:
    referee = Referee(Ending(time_limit=1.0), GOALS, last_tick=10)
    assert referee.reason(9, {"a": at(0), "b": at(0)}, {}) is None
    assert referee.reason(10, {"a": at(0), "b": at(0)}, {}) == "time_limit"
    assert referee.reason(10, {"a": at(45), "b": at(10)}, {}) == "goal"


def test_without_robots_only_time_ends_it() -> None:
    referee = Referee(Ending(time_limit=1.0, goal="none"), {}, last_tick=10)
    assert referee.reason(9, {}, {}) is None
    assert referee.reason(10, {}, {}) == "time_limit"
