"""Collisions: share of time, rate and energy."""

from __future__ import annotations

from typing import Any

import pytest

from crowdcosim.messages import Contacts

RATES = ("colliding", "collision_rate", "collision_energy_rate")


def rates(scene: Any, steps: int, touches: Any, **options: Any) -> list[Any]:
    frames = scene.drive(steps, crowd=lambda t: scene.crowd([(t, 9.0)]), touches=touches)
    found = scene.judge(frames, **options)
    return [found[name] for name in RATES]


def test_without_a_collision_the_score_is_1_and_the_rates_are_0(scene: Any) -> None:
    assert rates(scene, 100, {}) == [1.0, 0.0, 0.0]


def test_one_touch_of_two_steps_in_10_s(scene: Any) -> None:
    touches = {40: [{"duration": 0.0, "energy": 6.0}], 41: [{"duration": 0.1, "energy": 6.0}]}
    assert rates(scene, 100, touches) == pytest.approx([0.98, 0.1, 0.6], rel=1e-12)


def test_two_people_at_once_are_two_collisions_in_one_time(scene: Any) -> None:
    assert rates(scene, 10, {4: [{"energy": 1.0}, {"energy": 2.5}]}) == pytest.approx([0.9, 2.0, 3.5], rel=1e-12)


def test_a_second_person_joins_a_touch_that_lasts(scene: Any) -> None:
    touches = {4: [{"energy": 1.0}], 5: [{"energy": 1.0, "duration": 0.1}, {"energy": 2.0}]}
    assert rates(scene, 10, touches) == pytest.approx([0.8, 2.0, 3.0], rel=1e-12)


def test_touching_the_same_person_again_is_a_new_collision(scene: Any) -> None:
    assert rates(scene, 10, {2: [{}], 8: [{}]}) == pytest.approx([0.8, 2.0, 0.0], rel=1e-12)


@pytest.mark.parametrize("kind", [Contacts.WALL, Contacts.ROBOT])
def test_walls_and_robots_are_not_people(scene: Any, kind: int) -> None:
    assert rates(scene, 10, {4: [{"kind": kind, "energy": 9.0}]}) == [1.0, 0.0, 0.0]


def test_a_touch_of_a_wall_and_a_person_counts_the_person_only(scene: Any) -> None:
    touches = {4: [{"kind": Contacts.WALL, "energy": 9.0}, {"energy": 1.0}]}
    assert rates(scene, 10, touches) == pytest.approx([0.9, 1.0, 1.0], rel=1e-12)


def test_in_touch_all_the_time_the_score_is_0(scene: Any) -> None:
    assert rates(scene, 7, {k: [{"duration": 0.1 * (k - 1)}] for k in range(1, 8)})[0] == 0.0


def test_contacts_after_arrival_do_not_count(scene: Any) -> None:
    touches = {10: [{"energy": 1.0}], 11: [{"energy": 1.0}], 12: [{"energy": 1.0, "duration": 0.1}]}
    assert rates(scene, 30, touches, goal=0.95) == pytest.approx([0.9, 1.0, 1.0], rel=1e-12)


def test_time_in_touch_does_not_depend_on_the_time_step(scene: Any) -> None:
    for n in (1, 2, 5):  # in touch from 3 s to 5 s of 10 s
        dt = 0.1 / n
        begin, end = 30 * n, 50 * n
        touches = {k: [{"duration": (k - begin - 1) * dt, "energy": 2.0}] for k in range(begin + 1, end + 1)}
        frames = scene.drive(100 * n, dt=dt, crowd=lambda t: scene.crowd([(t, 9.0)]), touches=touches)
        found = scene.judge(frames, dt=dt)
        assert [found[name] for name in RATES] == pytest.approx([0.8, 0.1, 0.2], rel=1e-12)


def test_without_a_report_of_contacts_nothing_is_said_about_collisions(scene: Any) -> None:
    frames = [(crowd, robots, ()) for crowd, robots, _ in scene.drive(5, crowd=lambda t: scene.crowd([(t, 9.0)]))]
    found = scene.judge(frames)
    assert all("nobody reports the robot's contacts" in found[name] for name in RATES)
