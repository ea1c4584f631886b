"""Time, path and smoothness against closed forms."""

from __future__ import annotations

import math
from typing import Any

import pytest

from crowdcosim.world import World

ALONE = {"robot": {"success": 1.0, "time": 40.0, "path_length": 40.0, "velocity_variation": 2.0}}


def test_a_robot_at_1_m_per_s_needs_40_s_for_40_m(scene: Any) -> None:
    found = scene.judge(scene.drive(500), goal=40.0)
    assert found["time"] == 40.0
    assert found["success"] == 1.0
    assert found["path_length"] == pytest.approx(40.0, rel=1e-12)  # rounding of 400 sums


def test_nothing_counts_once_the_robot_has_arrived(scene: Any) -> None:
    frames = scene.drive(50, crowd=lambda t: scene.crowd([(3.0, 5.0)], [(1.0 + t, 0.0)], [0.1 * t]))
    assert scene.judge(frames, goal=1.95) == scene.judge(frames[:21], goal=1.95)


def test_a_run_to_the_time_limit_has_its_length_as_time_and_no_success(scene: Any) -> None:
    found = scene.judge(scene.drive(1800, speed=0.1), goal=40.0)
    assert (found["time"], found["success"]) == (180.0, 0.0)
    assert found["path_length"] == pytest.approx(18.0, rel=1e-12)


def test_the_path_of_a_detour_is_longer_than_the_way(scene: Any) -> None:
    frames = [(scene.crowd(), (scene.robot(p),), (scene.contacts(),)) for p in ((0, 0), (3, 4), (6, 0))]
    assert scene.judge(frames)["path_length"] == 10.0


def test_the_path_goes_on_across_the_seam(scene: Any) -> None:
    world = World(size=(50.0, 10.0), periodic=(True, False))
    frames = [(scene.crowd(), (scene.robot((x, 5.0)),), (scene.contacts(),)) for x in (49.5, 0.5)]
    assert scene.judge(frames, world=world)["path_length"] == pytest.approx(1.0, rel=1e-12)


def test_velocity_at_constant_speed_does_not_vary(scene: Any) -> None:
    assert scene.judge(scene.drive(100))["velocity_variation"] == 0.0


@pytest.mark.parametrize("steps", [10, 40, 1000])
def test_variation_of_a_start_and_a_stop_is_twice_the_speed_at_any_time_step(scene: Any, steps: int) -> None:
    speeds = [math.sin(math.pi * k / steps) for k in range(steps + 1)]
    frames = [(scene.crowd(), (scene.robot((0, 0), (v, 0.0)),), (scene.contacts(),)) for v in speeds]
    assert scene.judge(frames, dt=2 / steps)["velocity_variation"] == pytest.approx(2.0, rel=1e-12)


def test_variation_counts_turn_rate_with_a_lever_of_1_m(scene: Any) -> None:
    frames = [
        (scene.crowd(), (scene.robot((0, 0), angular_velocity=w),), (scene.contacts(),)) for w in (0.0, 0.5, -0.5, 0.0)
    ]
    assert scene.judge(frames)["velocity_variation"] == pytest.approx(2.0, rel=1e-12)


def test_driving_a_circle_steadily_does_not_vary_the_velocity(scene: Any) -> None:
    frames = [
        (
            scene.crowd(),
            (scene.robot((0, 0), (math.cos(h), math.sin(h)), heading=h, angular_velocity=1.0),),
            (scene.contacts(),),
        )
        for h in (0.1 * k for k in range(63))
    ]
    assert scene.judge(frames)["velocity_variation"] == pytest.approx(0.0, abs=1e-13)  # rounding of sin and cos


def test_driving_backward_is_a_change_of_velocity(scene: Any) -> None:
    frames = [
        (scene.crowd(), (scene.robot((0, 0), (0.0, v), heading=math.pi / 2),), (scene.contacts(),)) for v in (1.0, -0.2)
    ]
    assert scene.judge(frames)["velocity_variation"] == pytest.approx(1.2, rel=1e-12)


def test_ratios_are_alone_over_in_the_crowd(scene: Any) -> None:
    frames = scene.drive(800, speed=0.5)
    frames[7] = (frames[7][0], (scene.robot((0.35, 5.0), (1.5, 0.0)),), frames[7][2])  # varies by 1 up, 1 down
    found = scene.judge(frames, goal=40.0, reference=ALONE)
    assert found["time_ratio"] == 0.5
    assert found["path_length_ratio"] == pytest.approx(1.0, rel=1e-12)
    assert found["velocity_variation_ratio"] == pytest.approx(1.0, rel=1e-12)


def test_a_crowd_that_changes_nothing_gives_ratios_of_1(scene: Any) -> None:
    frames = scene.drive(400)
    frames[0] = (frames[0][0], (scene.robot((0.0, 5.0)),), frames[0][2])  # starts from rest
    alone = scene.metrics(frames, goal=40.0, alone=True)
    reference = {"robot": {n: float(v) for n, v, ok in zip(alone.name, alone.value, alone.valid, strict=True) if ok}}
    found = scene.judge(frames, goal=40.0, reference=reference)
    assert found["time_ratio"] == found["path_length_ratio"] == found["velocity_variation_ratio"] == 1.0


def test_at_the_time_limit_only_the_time_ratio_has_a_value(scene: Any) -> None:
    found = scene.judge(scene.drive(1800, speed=0.1), goal=40.0, reference=ALONE)
    assert found["time_ratio"] == pytest.approx(40 / 180, rel=1e-12)
    assert found["path_length_ratio"] == found["velocity_variation_ratio"] == "the robot did not reach its goal"


RATIOS = ("time_ratio", "path_length_ratio", "velocity_variation_ratio")


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({}, "there is no reference run without people to compare with"),
        ({"reference": {"other": {}}}, "there is no reference run without people to compare with"),
        ({"alone": True}, "this is the reference run itself"),
        ({"reference": {"robot": {"success": 0.0, "time": 180.0}}}, "the robot alone did not reach its goal"),
        ({"reference": {"robot": {}}}, "the reference run has no 'success'"),
    ],
)
def test_ratios_without_a_reference_have_no_value(scene: Any, options: dict[str, Any], reason: str) -> None:
    found = scene.judge(scene.drive(20), goal=1.0, **options)
    assert [found[name] for name in RATIOS] == [reason] * 3


def test_a_reference_that_lacks_a_metric_is_named(scene: Any) -> None:
    found = scene.judge(scene.drive(20), goal=1.0, reference={"robot": {"success": 1.0}})
    assert [found[name] for name in RATIOS] == [
        f"the reference run has no '{name}'" for name in ("time", "path_length", "velocity_variation")
    ]


def test_variation_that_is_0_in_the_crowd_has_no_ratio(scene: Any) -> None:
    found = scene.judge(scene.drive(20), goal=1.0, reference=ALONE)
    assert found["velocity_variation_ratio"] == "'velocity_variation' is 0 in the crowd"


def test_a_robot_that_starts_at_its_goal_has_arrived_in_no_time(scene: Any) -> None:
    crowd = scene.crowd([(1.0, 5.0)])
    found = scene.judge(scene.drive(20, crowd=lambda _: crowd), goal=0.0, reference=ALONE)
    assert (found["time"], found["success"], found["path_length"]) == (0.0, 1.0, 0.0)
    for name in ("time_ratio", "proximity", "colliding", "collision_rate", "collision_energy_rate"):
        assert found[name] == "the run has no duration: the robot starts at its goal"
