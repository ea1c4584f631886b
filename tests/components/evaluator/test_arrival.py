"""Success, and what weighs it."""

from __future__ import annotations

from typing import Any

import pytest

ALONE = {"robot": {"success": 1.0, "time": 4.0, "path_length": 4.0}}


def test_a_robot_that_takes_twice_the_time_of_the_robot_alone_has_half_the_score(scene: Any) -> None:
    found = scene.judge(scene.drive(80, speed=0.5), goal=3.99, reference=ALONE)
    assert (found["success"], found["timeout"], found["goal_distance"]) == (1.0, 0.0, 0.0)
    assert found["time_weighted_success"] == pytest.approx(4.0 / 8.0)
    assert found["path_weighted_success"] == pytest.approx(1.0)


def test_a_robot_that_is_faster_than_alone_has_the_full_score(scene: Any) -> None:
    assert scene.judge(scene.drive(20, speed=2.0), goal=3.99, reference=ALONE)["time_weighted_success"] == 1.0


def test_a_detour_costs_path_weighted_success(scene: Any) -> None:
    # Zigzag at 45 degrees: sqrt(2) times the way.
    frames = [(scene.crowd(), (scene.robot((0.1 * k, 5.0 + 0.1 * (k % 2))),), ()) for k in range(41)]
    found = scene.judge(frames, goal=3.99, reference=ALONE)
    assert found["path_weighted_success"] == pytest.approx(2**-0.5)


def test_without_arrival_all_is_0_and_the_rest_of_the_way_is_known(scene: Any) -> None:
    found = scene.judge(scene.drive(30), goal=4.0, reference=ALONE)
    assert [found[n] for n in ("success", "path_weighted_success", "time_weighted_success")] == [0.0, 0.0, 0.0]
    assert found["timeout"] == 1.0
    assert found["goal_distance"] == pytest.approx(1.0)


def test_without_a_run_alone_success_cannot_be_weighed(scene: Any) -> None:
    found = scene.judge(scene.drive(50), goal=4.0)
    assert "no reference run" in str(found["path_weighted_success"])
    assert "no reference run" in str(found["time_weighted_success"])
