"""People's speed and turning near the robot, against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from crowdcosim.world import World

NEAR, FAR = (20.0, 5.5), (20.0, 9.0)


def standing(scene: Any, crowd: Any, steps: int = 10, **options: Any) -> Any:
    return scene.judge(scene.drive(steps, speed=0.0, start=(20.0, 5.0), crowd=crowd), **options)


def test_a_neighbour_at_half_speed_among_two_gives_two_thirds(scene: Any) -> None:
    found = standing(scene, lambda _: scene.crowd([NEAR, FAR], [(0.5, 0.0), (0.0, 1.0)]))
    assert found["neighbour_velocity"] == pytest.approx(0.5 / 0.75, rel=1e-12)


def test_if_all_walk_and_turn_alike_both_metrics_are_1(scene: Any) -> None:
    found = standing(scene, lambda t: scene.crowd([NEAR, FAR], np.ones((2, 2)), [0.3 * t, 1.0 - 0.3 * t]))
    assert found["neighbour_velocity"] == pytest.approx(1.0, rel=1e-12)
    assert found["neighbour_reaction"] == pytest.approx(1.0, rel=1e-12)


@pytest.mark.parametrize("dt", [0.02, 0.1, 0.5])
def test_a_neighbour_that_turns_thrice_as_fast_as_the_other_gives_two_thirds_at_any_time_step(
    scene: Any, dt: float
) -> None:
    def crowd(t: float) -> Any:
        return scene.crowd([NEAR, FAR], np.ones((2, 2)), [0.9 * t, -0.3 * t])

    frames = scene.drive(round(5 / dt), dt=dt, speed=0.0, start=(20.0, 5.0), crowd=crowd)
    assert scene.judge(frames, dt=dt)["neighbour_reaction"] == pytest.approx(0.6 / 0.9, rel=1e-9)


def test_headings_are_compared_the_short_way_round(scene: Any) -> None:
    def crowd(t: float) -> Any:
        headings = np.array([math.pi - 0.5 + 2.0 * t, 2.0 * t])
        return scene.crowd([NEAR, FAR], np.ones((2, 2)), (headings + math.pi) % (2 * math.pi) - math.pi)

    # The neighbour's heading jumps from pi to -pi on the way; both turn at the same rate.
    assert standing(scene, crowd)["neighbour_reaction"] == pytest.approx(1.0, rel=1e-12)


def test_neighbours_are_people_up_to_1_m_away_centre_to_centre(scene: Any) -> None:
    velocity = [(2.0, 0.0), (1.0, 0.0), (0.0, 0.0)]
    found = standing(scene, lambda _: scene.crowd([(20.0, 6.0), (21.001, 5.0), FAR], velocity))
    assert found["neighbour_velocity"] == pytest.approx(2.0, rel=1e-12)


def test_neighbours_are_found_across_the_seam(scene: Any) -> None:
    world = World(size=(50.0, 10.0), periodic=(True, True))
    crowd = scene.crowd([(49.9, 9.9), (25.0, 5.0)], [(0.5, 0.0), (1.5, 0.0)])
    frames = scene.drive(5, speed=0.0, start=(0.2, 0.1), crowd=lambda _: crowd)
    assert scene.judge(frames, world=world)["neighbour_velocity"] == pytest.approx(0.5, rel=1e-12)
    assert scene.judge(frames)["neighbour_velocity"] == "nobody came within 1 m of the robot"


def test_each_person_counts_once_per_step(scene: Any) -> None:
    # One neighbour at speed 1 in all of 4 steps, a second one at speed 2 in the last one only: (4 x 1 + 1 x 2) / 5.
    def crowd(t: float) -> Any:
        second = (20.0, 4.5) if t > 0.35 else FAR
        return scene.crowd([NEAR, second], [(1.0, 0.0), (2.0, 0.0)])

    assert standing(scene, crowd, steps=4)["neighbour_velocity"] == pytest.approx(6 / 5 / 1.5, rel=1e-12)


def test_without_a_neighbour_there_is_no_value(scene: Any) -> None:
    found = standing(scene, lambda t: scene.crowd([FAR], [(1.0, 0.0)], [t]))
    assert found["neighbour_velocity"] == found["neighbour_reaction"] == "nobody came within 1 m of the robot"


def test_neighbours_that_walk_straight_give_no_reaction(scene: Any) -> None:
    found = standing(scene, lambda t: scene.crowd([NEAR, FAR], np.ones((2, 2)), [0.0, t]))
    assert found["neighbour_velocity"] == pytest.approx(1.0)
    assert found["neighbour_reaction"] == "nobody within 1 m of the robot turned"


def test_a_crowd_that_stands_has_no_velocity_to_compare_with(scene: Any) -> None:
    assert standing(scene, lambda _: scene.crowd([NEAR, FAR]))["neighbour_velocity"] == "nobody moved"


@pytest.mark.parametrize(
    ("alone", "reason"), [(True, "this is the reference run, without people"), (False, "there were no people")]
)
def test_without_people_nothing_is_said_about_them(scene: Any, alone: bool, reason: str) -> None:
    found = scene.judge(scene.drive(10), alone=alone)
    about_people = ("neighbour_velocity", "neighbour_reaction", "proximity", "colliding", "collision_rate")
    assert [found[name] for name in (*about_people, "collision_energy_rate")] == [reason] * 6


def test_people_who_come_and_go_are_told_apart_by_their_ids(scene: Any) -> None:
    # Person 1 leaves, person 3 comes, and 2 changes rows; 2 turns by 0.1 in the step and 3 has not turned yet.
    before = scene.crowd([NEAR, FAR], np.ones((2, 2)), [2.0, 1.0], ids=[1, 2])
    after = scene.crowd([NEAR, FAR], np.ones((2, 2)), [1.1, -3.0], ids=[2, 3])
    robot, contacts = scene.robot((20.0, 5.0)), scene.contacts()
    found = scene.judge([(c, (robot,), (contacts,)) for c in (before, after)])
    assert found["neighbour_reaction"] == pytest.approx(1.0, rel=1e-12)
    assert found["neighbour_velocity"] == pytest.approx(1.0, rel=1e-12)


def test_headings_that_differ_by_rounding_only_are_no_turning(scene: Any) -> None:
    frames = [
        (scene.crowd([(0.5, 5.0), (9.0, 5.0)], [(1.0, 0.0)] * 2, [1e-15 * k, 0.1 * k]), (scene.robot((0.0, 5.0)),), ())
        for k in range(10)
    ]
    assert scene.judge(frames)["neighbour_reaction"] == "nobody within 1 m of the robot turned"
