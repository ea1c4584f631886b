"""The variants of the authors' code."""

from __future__ import annotations

from typing import Any

import pytest


def robot_at(scene: Any, places: list[tuple[float, float, float]]) -> dict[str, Any]:
    frames = [(scene.crowd([(1.0, 9.0)]), (scene.robot((x, y), heading=a),), ()) for x, y, a in places]
    return scene.judge(frames)


def test_a_straight_line_at_constant_speed_has_no_second_difference(scene: Any) -> None:
    places = [(0.1 * k, 5.0 + 0.05 * k, 0.4) for k in range(20)]
    assert robot_at(scene, places)["velocity_variation_authors"] == pytest.approx(0.0, abs=1e-9)


def test_a_stop_counts_the_last_step_and_a_kink_in_degrees(scene: Any) -> None:
    stop = [(0.1 * min(k, 5), 5.0, 0.0) for k in range(10)]
    assert robot_at(scene, stop)["velocity_variation_authors"] == pytest.approx(0.1)
    turn = [(0.0, 5.0, 0.0), (0.0, 5.0, 0.0), (0.0, 5.0, 0.1), (0.0, 5.0, 0.1)]
    assert robot_at(scene, turn)["velocity_variation_authors"] == pytest.approx(2 * 5.729578, rel=1e-6)


def test_the_heading_goes_on_beyond_180_degrees(scene: Any) -> None:
    places = [(0.0, 5.0, 3.0 + 0.1 * k - (6.283185307179586 if k > 1 else 0.0)) for k in range(5)]
    assert robot_at(scene, places)["velocity_variation_authors"] == pytest.approx(0.0, abs=1e-9)


def test_a_teleport_is_no_motion(scene: Any) -> None:
    places = [(0.1 * k + (20.0 if k >= 5 else 0.0), 5.0, 0.0) for k in range(10)]
    # The step of the teleport counts as standing: down from 0.1 m and up again.
    assert robot_at(scene, places)["velocity_variation_authors"] == pytest.approx(0.2)


def test_the_ratio_is_that_of_the_robot_alone_over_that_in_the_crowd(scene: Any) -> None:
    alone = {"robot": {"success": 1.0, "velocity_variation_authors": 0.05}}
    frames = [(scene.crowd([(1.0, 9.0)]), (scene.robot((0.125 * k, 5.0)),), ()) for k in range(10)]
    found = scene.judge(frames, goal=0.99, reference=alone)
    assert found["velocity_variation_ratio_authors"] == "nothing varied in the crowd"
    frames = [(scene.crowd([(1.0, 9.0)]), (scene.robot((0.1 * k + 0.1 * (k > 2), 5.0)),), ()) for k in range(10)]
    found = scene.judge(frames, goal=0.79, reference=alone)
    assert found["velocity_variation_ratio_authors"] == pytest.approx(0.05 / 0.2)


def test_neighbours_are_those_within_two_metres(scene: Any) -> None:
    crowd = scene.crowd([(10.0, 6.5), (30.0, 5.0)], [(0.5, 0.0), (1.5, 0.0)])
    frames = [(crowd, (scene.robot((10.0, 5.0)),), ())] * 5
    found = scene.judge(frames)
    assert found["neighbour_velocity_authors"] == pytest.approx(0.5)
    assert found["neighbour_velocity"] == "nobody came within 1 m of the robot"
    assert found["neighbour_reaction_authors"] == "nobody within 2 m of the robot turned"
