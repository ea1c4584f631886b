"""Candidates lie where the fan says, random ones are uniform, and the cheapest one wins."""

import math

import numpy as np
import pytest

from components.crowd.cells import sort_into_cells
from components.crowd.sampling import GLOBAL, RandomSampling, RegularSampling, next_streams, towards_best, uniform
from components.crowd.surroundings import Surveyor, in_order
from tests.components.crowd.crowds import scene


def around(now, relaxation_time=0.0):
    cells = sort_into_cells(now.position, now.period, 2.5)
    return Surveyor(reach=5.0, relaxation_time=relaxation_time).surroundings(
        now, cells, in_order(cells, now.velocity, now.radius), np.arange(len(now.position))
    )


def candidates(sampling, **motion):
    """(K, 2) candidates of one person."""
    now = scene([(0, 0)], **{key: [value] for key, value in motion.items()})
    return sampling.candidates(around(now))[:, 0].T


def test_a_regular_fan_has_equal_steps_of_length_and_angle_from_right_to_left():
    fan = RegularSampling(sampling="regular", speeds=2, angles=3, angle_deg=180.0)
    expected = [(0, -0.65), (0.65, 0), (0, 0.65), (0, -1.3), (1.3, 0), (0, 1.3)]
    assert candidates(fan, velocity=(1.0, 0), preferred=(0, 1.3)) == pytest.approx(np.array(expected), abs=1e-12)


def test_whoever_stands_looks_to_the_preferred_velocity():
    fan = RegularSampling(sampling="regular", speeds=1, angles=3)
    assert candidates(fan, velocity=(0.05, 0), preferred=(0, 1.3))[1] == pytest.approx((0, 1.3))


def test_a_full_circle_does_not_try_its_seam_twice():
    fan = RegularSampling(sampling="regular", direction="x", radius="max_speed", angle_deg=360.0, speeds=1, angles=4)
    expected = 1.8 * np.array([(-1, 0), (0, -1), (1, 0), (0, 1)])
    assert candidates(fan) == pytest.approx(expected, abs=1e-12)


def test_the_global_search_tries_361_velocities_up_to_the_maximum_speed():
    found = candidates(GLOBAL)
    assert len(found) == 361
    assert found[0].tolist() == [0, 0]
    assert np.unique(np.hypot(*found.T).round(9)) == pytest.approx(np.arange(11) * 0.18)


def test_what_a_step_can_change_lies_about_the_own_velocity():
    fan = RandomSampling(sampling="random", samples=500, base="velocity", radius="max_acceleration", angle_deg=360.0)
    found = candidates(fan, velocity=(1.0, 0.2)) - (1.0, 0.2)
    assert np.hypot(*found.T).max() <= 0.5


def test_random_candidates_are_uniform_in_length_and_angle():
    fan = RandomSampling(sampling="random", samples=20_000, angle_deg=180.0, direction="x", radius="max_speed")
    found = candidates(fan)
    length, angle = np.hypot(*found.T) / 1.8, np.arctan2(found[:, 1], found[:, 0]) / math.pi + 0.5
    for share in (length, angle):
        # 2,000 a bin: standard deviation 45.
        assert np.histogram(share, 10, (0, 1))[0] == pytest.approx([2000] * 10, abs=200)
    assert abs(np.corrcoef(length, angle)[0, 1]) < 0.03


def test_random_numbers_differ_between_people_and_steps():
    streams = np.random.default_rng(0).integers(0, 2**64, 100, np.uint64)
    steps = [streams]
    for _ in range(20):
        steps.append(next_streams(steps[-1]))
    draws = [uniform(s, k) for s in np.concatenate(steps) for k in range(5)]
    assert len(set(draws)) == len(draws)
    assert min(draws) >= 0
    assert max(draws) < 1
    assert np.mean(draws) == pytest.approx(0.5, abs=0.01)


def test_the_first_of_the_cheapest_wins_and_is_reached_within_the_relaxation_time():
    now = scene([(0, 0)], [(0.2, 0)])
    tried = np.array([[[0.0, 1.0, 0.0]], [[0.0, 0.0, 1.0]]])
    assert pytest.approx(np.array([(8.0, 0.0)])) == towards_best(around(now), tried, np.array([[2.0, 1.0, 1.0]])).T
    slow = around(now, relaxation_time=0.5)
    assert pytest.approx(np.array([(1.6, 0.0)])) == towards_best(slow, tried, np.array([[2.0, 1.0, 1.0]])).T


def test_where_everything_is_forbidden_people_want_to_stop():
    now = scene([(0, 0)], [(0.2, 0)])
    tried = np.array([[[1.0]], [[1.0]]])
    assert pytest.approx(np.array([(-2.0, 0.0)])) == towards_best(around(now), tried, np.array([[np.inf]])).T


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"angle_deg": 0}, "angle_deg is 0"),
        ({"angle_deg": 400}, "angle_deg is 400"),
        ({"speeds": 0}, "speeds is 0, expected at least 1"),
        ({"speeds": 1, "include_base": True}, "speeds is 1, expected at least 2"),
        ({"angles": 1}, "angles is 1, expected at least 2"),
    ],
)
def test_fans_that_make_no_sense_are_refused(options, message):
    with pytest.raises(ValueError, match=message):
        RegularSampling(sampling="regular", **options)
    with pytest.raises(ValueError, match="samples is 0"):
        RandomSampling(sampling="random", samples=0)
