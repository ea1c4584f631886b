"""The robot's motion against closed forms."""

from __future__ import annotations

import math
from typing import Any

import pytest

DT = 0.1


def moving(scene: Any, speeds: list[float], headings: list[float] | None = None) -> list[Any]:
    """Frames of a robot with the given speed along its heading in each state."""
    x, frames = 0.0, []
    for k, v in enumerate(speeds):
        a = headings[k] if headings else 0.0
        x += v * DT if k else 0.0
        frames.append((scene.crowd(), (scene.robot((x, 5.0), (v * math.cos(a), v * math.sin(a)), heading=a),), ()))
    return frames


def test_constant_speed_has_neither_acceleration_nor_jerk(scene: Any) -> None:
    found = scene.judge(moving(scene, [0.7] * 31))
    assert found["speed"] == pytest.approx(0.7)
    assert (found["acceleration"], found["acceleration_max"]) == pytest.approx((0.0, 0.0))
    assert (found["jerk"], found["jerk_max"]) == pytest.approx((0.0, 0.0))


def test_constant_acceleration_is_found_whatever_the_heading(scene: Any) -> None:
    speeds = [0.2 * k * DT for k in range(41)]
    found = scene.judge(moving(scene, speeds, [0.3] * 41))
    assert (found["acceleration"], found["acceleration_max"]) == pytest.approx((0.2, 0.2))
    assert found["jerk_max"] == pytest.approx(0.0, abs=1e-9)
    assert found["speed"] == pytest.approx(0.2 * DT * 20.5)  # the mean of 1 ... 40


def test_a_quadratic_speed_has_constant_jerk(scene: Any) -> None:
    # The second difference of c t^2 / 2 is c dt^2, exactly.
    found = scene.judge(moving(scene, [0.5 * 0.3 * (k * DT) ** 2 for k in range(21)]))
    assert (found["jerk"], found["jerk_max"]) == pytest.approx((0.3, 0.3))


def test_a_stop_in_one_step_is_spread_over_that_step(scene: Any) -> None:
    found = scene.judge(moving(scene, [1.0] * 11 + [0.0] * 10))
    assert found["acceleration_max"] == pytest.approx(1.0 / DT)
    assert found["acceleration"] == pytest.approx(1.0 / DT / 20)
    assert found["jerk_max"] == pytest.approx(1.0 / DT**2)


def test_motion_energy_is_the_integral_of_speed_squared(scene: Any) -> None:
    assert scene.judge(moving(scene, [0.5] * 41))["motion_energy"] == pytest.approx(0.25 * 4.0)


def test_driving_backward_has_a_speed_too(scene: Any) -> None:
    assert scene.judge(moving(scene, [-0.2] * 11))["speed"] == pytest.approx(0.2)


def test_time_not_moving_is_the_time_of_neither_driving_nor_turning(scene: Any) -> None:
    crowd = scene.crowd()
    frames = [(crowd, (scene.robot((0, 5), (v, 0.0), angular_velocity=w),), ()) for v, w in [(1.0, 0.0)]]
    frames += [(crowd, (scene.robot((0, 5), (v, 0.0), angular_velocity=w),), ()) for v, w in [(0.005, 0.01)] * 7]
    frames += [(crowd, (scene.robot((0, 5), (v, 0.0), angular_velocity=w),), ()) for v, w in [(0.0, -0.5)] * 3]
    assert scene.judge(frames)["time_not_moving"] == pytest.approx(0.7)


def test_a_full_turn_across_the_seam_of_angles_is_two_pi(scene: Any) -> None:
    n = 40
    headings = [math.remainder(2 * math.pi * k / n, 2 * math.pi) for k in range(n + 1)]
    found = scene.judge(moving(scene, [0.5] * (n + 1), headings))
    assert found["heading_change"] == pytest.approx(2 * math.pi)
    assert found["path_irregularity"] == pytest.approx(2 * math.pi / (0.5 * n * DT))


def test_turning_there_and_back_counts_both_ways(scene: Any) -> None:
    assert scene.judge(moving(scene, [0.5] * 3, [0.0, 0.4, 0.0]))["heading_change"] == pytest.approx(0.8)


def test_who_does_not_move_has_no_irregularity_and_who_takes_one_step_no_jerk(scene: Any) -> None:
    assert scene.judge(moving(scene, [0.0] * 5))["path_irregularity"] == "the robot did not move"
    assert scene.judge(moving(scene, [0.0, 1.0]))["jerk"] == "the run has fewer than two steps"
