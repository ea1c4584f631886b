"""Densities, personal space and social force against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from components.evaluator.look import look, personal_space, social_force, time_to_touch
from crowdcosim.world import World


def around(scene: Any, position: Any, velocity: Any = None, heading: Any = None, robot: Any = None) -> dict[str, Any]:
    crowd = scene.crowd(position, velocity, heading)
    return scene.judge([(crowd, (robot or scene.robot((25.0, 5.0)),), (scene.contacts(),))] * 3)


def test_local_density_is_people_per_area_of_the_circle(scene: Any) -> None:
    found = around(scene, [(25.0, 7.4), (25.0, 7.6), (29.9, 5.0), (34.9, 5.0), (36.0, 5.0)])
    expected = {
        "density_2_5m": 1 / (math.pi * 6.25),
        "density_5m": 3 / (math.pi * 25),
        "density_10m": 4 / (math.pi * 100),
    }
    assert {name: found[name] for name in expected} == pytest.approx(expected)


def test_the_closest_persons_speed_is_that_of_the_nearest_centre(scene: Any) -> None:
    assert around(scene, [(25.0, 6.0), (25.0, 7.0)], [(0.3, 0.4), (9.0, 0.0)])["closest_person_speed"] == pytest.approx(
        0.5
    )


def test_a_standing_persons_space_is_half_a_metre_wide_ahead_and_a_quarter_behind() -> None:
    assert personal_space(0.0, 0.0, 1.0, 0.0) == 1.0
    assert personal_space(0.5, 0.0, 0.0, 0.0) == pytest.approx(math.exp(-0.5))
    assert personal_space(-0.25, 0.0, 0.0, 0.0) == pytest.approx(math.exp(-0.5))
    assert personal_space(0.0, 1 / 3, 0.0, 0.0) == pytest.approx(math.exp(-0.5))


def test_a_walking_persons_space_reaches_two_seconds_ahead() -> None:
    v = 1.3
    ahead = personal_space(0.0, 2 * v, math.pi / 2, v)
    assert ahead == pytest.approx(math.exp(-0.5))
    assert personal_space(0.0, -v, math.pi / 2, v) == pytest.approx(math.exp(-0.5))


def test_the_robot_intrudes_as_deep_as_into_the_most_intruded(scene: Any) -> None:
    found = around(scene, [(24.5, 5.0), (25.0, 7.0)], heading=[0.0, 0.0])
    assert found["personal_space_intrusion"] == pytest.approx(math.exp(-0.5))


def test_between_two_who_do_not_move_the_force_is_exponential_in_their_distance(scene: Any) -> None:
    # D = e, theta = 0: f = A exp(-d / gamma), on either.
    assert social_force(1.0, 0.0, 0.0, 0.0) == pytest.approx(4.5 * math.exp(-1 / 0.35))
    found = around(scene, [(25.0, 6.0)])
    assert found["social_work"] == pytest.approx(2 * 4.5 * math.exp(-1 / 0.35))


def test_head_on_the_force_reaches_farther() -> None:
    # |D| = lambda v + 1 along e: B = gamma (lambda v + 1).
    assert social_force(2.0, 0.0, 1.0, 0.0) == pytest.approx(4.5 * math.exp(-2 / (0.35 * 3)))


def test_beside_a_walker_the_force_is_that_of_the_published_formula() -> None:
    x, y, vx = 0.0, 1.0, 1.0
    D = (2.0 * vx, 1.0)
    b, theta = 0.35 * math.hypot(*D), math.atan2(1.0, 0.0) - math.atan2(D[1], D[0])
    along = math.exp(-1 / b - (3 * b * theta) ** 2)
    aside = math.exp(-1 / b - (2 * b * theta) ** 2)
    assert social_force(x, y, vx, 0.0) == pytest.approx(4.5 * math.hypot(along, aside))


@given(*[st.floats(-3, 3) for _ in range(4)])
def test_what_either_does_to_the_other_is_as_strong(x: float, y: float, vx: float, vy: float) -> None:
    # The angle's sign of the one is that of the other at the edge of 180 degrees only.
    assert social_force(x, y, vx, vy) == pytest.approx(social_force(-x, -y, -vx, -vy), rel=1e-9, abs=1e-12)


@given(*[st.floats(-5, 5) for _ in range(4)], st.floats(0.1, 1.0))
def test_at_the_time_to_touch_the_distance_is_the_reach(x: float, y: float, vx: float, vy: float, reach: float) -> None:
    t = time_to_touch(x, y, vx, vy, reach)
    if 0 < t < 1e3:
        assert math.hypot(x + vx * t, y + vy * t) == pytest.approx(reach, abs=1e-6)
        before = 0.999 * t
        assert math.hypot(x + vx * before, y + vy * before) >= reach - 1e-9
    elif t == 0:
        assert math.hypot(x, y) <= reach
    else:
        times = np.linspace(0, 20, 400)
        # It may come as near as rounding of the root allows.
        assert np.hypot(x + vx * times, y + vy * times).min() >= reach - 1e-6


def test_a_look_across_the_seam_equals_one_in_the_open(scene: Any) -> None:
    period = World(size=(50.0, 10.0), periodic=(True, True)).period
    position = np.array([(49.5, 9.6), (1.0, 0.5)])
    shifted = np.array([(-0.5, -0.4), (1.0, 0.5)])
    velocity, heading, radius = np.array([(1.0, 0.5), (-1.0, 0.2)]), np.array([0.2, 3.0]), np.array([0.3, 0.25])
    robot = (0.2, 0.1, 0.8, -0.1, 0.2)
    wrapped = look(robot, position, velocity, heading, radius, period)
    plain = look(robot, shifted, velocity, heading, radius, np.zeros(2))
    assert wrapped.distance == pytest.approx(plain.distance)
    assert wrapped[1:5] == pytest.approx(plain[1:5])
    assert wrapped.within == plain.within
    assert wrapped[6:] == pytest.approx(plain[6:])
