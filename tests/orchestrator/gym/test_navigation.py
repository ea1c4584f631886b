"""The environment is what Gymnasium expects, and its numbers are those of the scenario."""

from __future__ import annotations

import math
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

import crowdcosim.gym
from orchestrator.errors import InputError
from orchestrator.gym.navigation import Navigation
from orchestrator.log.reader import read_log

ID = "crowdcosim/Navigation-v0"
SMALL: dict[str, Any] = {
    "crowd.config.count": 5,
    "robots.robot.sensors.lidar.config.beams": 18,
    "robots.robot.goal.x": 7,
    "end.time_limit": 4,
}
FULL_AHEAD = np.array([1.0, 0.0], np.float32)

assert crowdcosim.gym


@pytest.fixture
def env():
    env = Navigation(settings=SMALL)
    yield env
    env.close()


def drive(env: Navigation, action: np.ndarray = FULL_AHEAD) -> list[tuple]:
    steps = []
    while not steps or not (steps[-1][2] or steps[-1][3]):
        steps.append(env.step(action))
    return steps


def test_gymnasiums_own_check_finds_nothing_to_say() -> None:
    env = gymnasium.make(f"crowdcosim.gym:{ID}", settings=SMALL, people=3, render_mode="rgb_array")
    check_env(env.unwrapped)  # pytest turns its warnings into errors
    env.close()


def test_the_same_seed_gives_the_same_episode_and_another_one_another() -> None:
    env = Navigation(settings=SMALL, people=5)

    def episode(seed: int | None) -> np.ndarray:
        first, _ = env.reset(seed=seed)
        return np.array([first["people"], *(step[0]["people"] for step in drive(env))])

    once, again, other, later = episode(1), episode(1), episode(2), episode(None)
    assert np.array_equal(once, again)
    assert not np.array_equal(once[0], other[0])
    assert not np.array_equal(later[0], other[0])  # without a seed, the next of the same sequence
    env.close()


def test_the_goal_is_seen_from_the_robot(env) -> None:
    observation, _ = env.reset(seed=1)
    assert observation["goal"] == pytest.approx([2.0, 1.0, 0.0])  # from x = 5 to x = 7, straight ahead
    observation = env.step(np.array([-1.0, 1.0]))[0]
    _, cos, sin = observation["goal"]
    assert math.atan2(sin, cos) == pytest.approx(-observation["odometry"][2], abs=1e-6)


def test_actions_are_the_robots_limits(env) -> None:
    env.reset(seed=1)
    for action, speed, turn_rate in (((1, 1), 1.0, math.pi), ((-1, -1), -0.2, -math.pi), ((-2 / 3, 0), 0.0, 0.0)):
        for _ in range(8):  # until it is as fast as that
            odometry = env.step(np.array(action, np.float32))[0]["odometry"]
        assert odometry[[3, 5]] == pytest.approx([speed, turn_rate], abs=1e-6)
        env.reset(seed=1)


def test_a_holonomic_robot_has_an_action_more() -> None:
    base = {"kind": "holonomic", "max_lateral_speed": 0.5}
    env = Navigation(settings=SMALL | {"robots.robot.model.base": base})
    assert env.action_space.shape == (3,)
    env.reset(seed=1)
    for _ in range(5):
        odometry = env.step(np.array([-2 / 3, 1.0, 0.0], np.float32))[0]["odometry"]
    assert odometry[3:] == pytest.approx([0.0, 0.5, 0.0], abs=1e-6)
    env.close()


def test_reaching_the_goal_terminates_with_outcome_and_metrics(env) -> None:
    env.reset(seed=1)
    *_, terminated, truncated, info = drive(env)[-1]
    assert (terminated, truncated) == (True, False)
    assert info["outcome"] == "goal"
    assert info["metrics"]["success"] == 1.0
    with pytest.raises(InputError, match="is over"):
        env.step(FULL_AHEAD)


def test_the_time_limit_truncates(env) -> None:
    env.reset(seed=1)
    steps = drive(env, np.array([-2 / 3, 0.0], np.float32))
    *_, terminated, truncated, info = steps[-1]
    assert (terminated, truncated) == (False, True)
    assert info["outcome"] == "time_limit"
    assert len(steps) == 40


def test_a_collision_terminates_where_the_scenario_says_so() -> None:
    ahead = {"crowd.config": {"count": None, "positions": [[6.5, 5.0]], "flow": "1d-", "reactive": False}}
    env = Navigation(
        settings=SMALL | ahead | {"end.collision": True, "robots.robot.goal.x": 40}, reward={"collision": -3}
    )
    env.reset(seed=1)
    *_, (_, reward, terminated, truncated, info) = drive(env)
    assert (reward, terminated, truncated) == (-3.0, True, False)
    assert info["outcome"] == "collision"
    assert info["contacts"] == 1
    env.close()


def test_the_reward_is_the_weighted_sum_of_its_terms_and_metrics() -> None:
    weights = {"progress": 2.0, "time": -1.0, "arrival": 5.0, "success": 10.0, "path_length": -0.5}
    env = Navigation(settings=SMALL, reward=weights)
    env.reset(seed=1)
    steps = drive(env)
    metrics = steps[-1][4]["metrics"]
    total = sum(step[1] for step in steps)
    overshoot = 7.0 - env.session.view.robot.state.position[0]  # beyond the line, the nearest point of it is behind
    way = 2.0 - abs(overshoot)
    assert total == pytest.approx(
        2 * way - 0.1 * len(steps) + 5 + 10 * metrics["success"] - 0.5 * metrics["path_length"]
    )
    env.close()


def test_two_robots_one_driven_and_one_that_drives_itself() -> None:
    env = Navigation("two_robots", {"crowd.config.count": 2, "end.time_limit": 2}, robot="right")
    env.reset(seed=1)
    steps = drive(env)
    assert steps[-1][3]
    assert env.session.view.robots["left"].state.position[0] > 5.5
    env.close()


def test_the_nearest_people_are_seen_from_the_robot() -> None:
    positions = [[7.0, 5.0], [5.0, 6.0], [30.0, 5.0]]
    env = Navigation(settings=SMALL | {"crowd.config": {"count": None, "positions": positions}}, people=2)
    observation, _ = env.reset(seed=1)
    assert observation["people"] == pytest.approx(np.array([[0, 1, 0, 0, 0.3], [2, 0, 0, 0, 0.3]]))
    env.close()


def test_what_is_observed_can_be_chosen() -> None:
    env = Navigation(settings=SMALL, observe=["odometry"])
    assert list(env.reset(seed=1)[0]) == ["odometry", "goal"]
    env.close()


def test_episodes_are_recorded_one_by_one(tmp_path) -> None:
    env = Navigation(settings=SMALL, record=tmp_path)
    for seed in (1, 2):
        env.reset(seed=seed)
        drive(env)
    env.close()
    assert [read_log(tmp_path / f"episode_{n}.mcap").metadata["outcome"]["reason"] for n in (1, 2)] == ["goal", "goal"]


def test_a_picture_shows_the_robot_where_it_is() -> None:
    env = Navigation(settings=SMALL, render_mode="rgb_array")
    env.reset(seed=1)
    picture = env.render()
    height, width, _ = picture.shape
    assert env.metadata["render_fps"] == 10
    assert width / height == pytest.approx(5, rel=0.1)  # the corridor is 50 m by 10 m
    red = (picture[:, :, 0].astype(int) - picture[:, :, 2]) > 100
    rows, columns = np.nonzero(red)
    assert columns.mean() == pytest.approx(8 + 5.0 * (width - 16) / 50, abs=2)
    assert rows.mean() == pytest.approx(height / 2, abs=2)
    env.close()


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_it_can_be_vectorised(mode) -> None:
    envs = gymnasium.make_vec(ID, num_envs=2, vectorization_mode=mode, settings=SMALL)
    first, _ = envs.reset(seed=[1, 2])
    assert first["lidar/scan"].shape == (2, 18)
    single = Navigation(settings=SMALL)
    assert np.array_equal(first["lidar/scan"][1], single.reset(seed=2)[0]["lidar/scan"])
    for _ in range(30):
        _, reward, terminated, _, info = envs.step(np.tile(FULL_AHEAD, (2, 1)))
        if terminated.any():
            break
    assert terminated.any()
    assert info["outcome"][int(terminated.argmax())] == "goal"
    assert np.isfinite(reward).all()
    single.close()
    envs.close()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"scenario": "coridor"}, "did you mean 'corridor'"),
        ({"scenario": "two_robots"}, "there are 2 robots, expected robot= one of left, right"),
        ({"reward": {"progres": 1.0}}, "did you mean 'progress'"),
        ({"reward": {"progress": math.nan}}, "expected a finite number"),
        ({"observe": ["lidar/scn"]}, "did you mean 'lidar/scan'"),
        ({"observe": ["lidar/agents"]}, "BeamAgents, which has no known bounds"),
        ({"render_mode": "human"}, "render_mode is 'human'"),
        ({"people": -1}, "people is -1"),
    ],
)
def test_what_cannot_be_made_is_refused_with_a_reason(arguments, words) -> None:
    with pytest.raises(InputError, match=words):
        Navigation(**arguments)
