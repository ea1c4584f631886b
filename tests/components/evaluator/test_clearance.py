"""Gaps, near collisions, zones and time to collision against closed forms. The robot's radius is 0.2, people's 0.3."""

from __future__ import annotations

from typing import Any

import pytest

REACH = 0.5
"""sum of the two radii [m]"""


def beside(scene: Any, gaps: list[float | None], touches: Any = None) -> dict[str, Any]:
    """A standing robot with one person at the given gap in each state after the first; None: nobody."""
    frames = []
    for k, gap in enumerate([gaps[0], *gaps]):
        crowd = scene.crowd([] if gap is None else [(10.0, 5.0 + REACH + gap)])
        frames.append((crowd, (scene.robot((10.0, 5.0)),), (scene.contacts(*(touches or {}).get(k, ())),)))
    return scene.judge(frames)


def test_the_least_and_the_mean_gap_are_from_disc_to_disc(scene: Any) -> None:
    found = beside(scene, [1.0, 0.5, 1.5, 2.0])
    assert found["clearance_min"] == pytest.approx(0.5)
    assert found["clearance_mean"] == pytest.approx(1.25)


def test_overlapping_discs_have_no_negative_gap(scene: Any) -> None:
    found = beside(scene, [-0.3, 1.0])
    assert (found["clearance_min"], found["clearance_mean"]) == (0.0, pytest.approx(0.5))


def test_two_spells_within_half_a_metre_are_two_near_collisions(scene: Any) -> None:
    found = beside(scene, [1.0, 0.4, 0.3, 1.0, 0.49, 1.0, 1.0, 1.0, 1.0, 1.0])
    assert found["near_collisions"] == 2.0
    assert found["near_collision_rate"] == pytest.approx(2.0)  # in one second
    assert found["near_collision_share"] == pytest.approx(0.3)


def test_a_touch_is_no_near_collision_and_parts_two(scene: Any) -> None:
    touch = {"duration": 0.0}
    found = beside(scene, [0.3, 0.0, 0.3, 1.0], touches={2: [touch]})
    assert found["near_collisions"] == 2.0
    assert found["near_collision_share"] == pytest.approx(0.5)


def test_a_touch_that_only_the_contacts_know_of_is_one_too(scene: Any) -> None:
    # Discs may just miss what the walking body reaches.
    assert beside(scene, [0.1, 0.1], touches={1: [{}], 2: [{"duration": 0.1}]})["near_collisions"] == 0.0


def test_danger_and_zones_are_shares_of_time(scene: Any) -> None:
    found = beside(scene, [0.1, 0.3, 0.6, 1.1, 1.3, 3.5, 3.7, 9.0, 0.0, 0.44])
    assert found["danger"] == pytest.approx(0.2)
    assert found["intimate_share"] == pytest.approx(0.4)
    assert found["personal_share"] == pytest.approx(0.2)
    assert found["social_share"] == pytest.approx(0.2)


def test_where_nobody_is_no_zone_is_entered(scene: Any) -> None:
    found = beside(scene, [None, None, 0.1, None])
    assert found["intimate_share"] == pytest.approx(0.25)
    assert found["clearance_mean"] == pytest.approx(0.1)


@pytest.mark.parametrize(("gap", "speed"), [(3.0, 1.0), (3.0, -0.5), (0.6, 0.2)])
def test_head_on_time_to_collision_is_gap_over_closing_speed(scene: Any, gap: float, speed: float) -> None:
    """A robot at 1 m/s and a person at `speed` towards it (negative: walking away, more slowly)."""
    crowd = scene.crowd([(10.0 + REACH + gap, 5.0)], [(-speed, 0.0)])
    frames = [(crowd, (scene.robot((10.0, 5.0), (1.0, 0.0)),), (scene.contacts(),))] * 3
    found = scene.judge(frames)
    expected = gap / (1.0 + speed)
    assert found["time_to_collision_min"] == pytest.approx(expected)
    assert found["imminent_collision_share"] == float(expected < 1.5)


def test_who_passes_by_or_walks_away_is_on_no_collision_course(scene: Any) -> None:
    crowd = scene.crowd([(12.0, 5.0 + REACH + 0.01), (8.0, 5.0)], [(0.0, 0.0), (-1.0, 0.0)])
    frames = [(crowd, (scene.robot((10.0, 5.0), (1.0, 0.0)),), (scene.contacts(),))] * 3
    assert scene.judge(frames)["time_to_collision_min"] == "nobody was on a collision course"


def test_a_grazing_course_touches_where_pythagoras_says(scene: Any) -> None:
    # Person 0.3 m aside: discs touch when the way along is 0.4 m, since 0.3^2 + 0.4^2 = 0.5^2.
    crowd = scene.crowd([(12.4, 5.3)])
    frames = [(crowd, (scene.robot((10.0, 5.0), (1.0, 0.0)),), (scene.contacts(),))] * 2
    assert scene.judge(frames)["time_to_collision_min"] == pytest.approx(2.0)
