"""Where the search for a plan starts: candidates, who counts, which walls count."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.controllers.differential import Limits
from components.controllers.ego import Ego
from components.controllers.mpc import covered, free_box
from components.controllers.optimal_control import ALPHA, OMEGA, THETA, A, Shape, V, Weights, X, Y
from components.controllers.prediction import Horizon, Tracks, constant_velocity
from components.controllers.starting_plans import (
    LATER,
    Scales,
    best_start,
    carry_on,
    choose_discs,
    choose_planes,
    cost,
    crosses,
    negligible_gap,
    turn_and_go,
)
from components.controllers.surroundings import Discs, frozen
from crowdcosim.world import Wall, World

SEED = st.integers(0, 2**32 - 1)
SHAPE = Shape(stages=20, dt=0.2, discs=8, walls=2)
LIMITS = Limits(-0.2, 1.0, 5.0, math.pi, 10.0)
TIMES = 0.2 * np.arange(21)
NOBODY = Tracks(np.empty((21, 0, 2)), np.empty(0))
EGO = Ego(25.0, 5.0, 0.2, 0.5, 0.3)


def scales_of(bearing=0.0, segments=(), box=(-9e9, -9e9, 9e9, 9e9)) -> Scales:
    walls = np.array(segments, np.float64).reshape(-1, 2, 2)
    way = np.array([math.cos(bearing), math.sin(bearing)])
    return Scales(way, TIMES.copy(), np.array(box, np.float64), walls, 0.2, SHAPE, LIMITS, Weights())


def empty() -> np.ndarray:
    return np.zeros((21, 7))


def tracks(position, velocity, radius) -> Tracks:
    """People at constant velocity."""
    return Tracks(position + TIMES[:, None, None] * velocity, radius)


def crowd(rng, count) -> Tracks:
    return tracks(rng.uniform(-6, 6, (count, 2)), rng.normal(0, 1, (count, 2)), rng.uniform(0.4, 0.7, count))


def cheapest(ego, side, near, scales) -> np.ndarray:
    """The best of the candidates to the left (`side` 1) or right (-1)."""
    plans = [empty() for _ in range(20)]
    for i, plan in enumerate(plans):
        turn_and_go(ego, side * 0.26 * (1 + i // 4), (0.0, 0.35, 0.7, 1.0)[i % 4], scales, plan)
    return min(plans, key=lambda plan: cost(plan, near, scales, np.inf))


def standing(*position) -> Tracks:
    return tracks(np.array(position, np.float64), np.zeros((len(position), 2)), np.full(len(position), 0.577))


@settings(max_examples=50, deadline=None)
@given(seed=SEED)
def test_candidates_stay_within_the_limits(seed):
    rng = np.random.default_rng(seed)
    plan = empty()
    ego = Ego(0.0, 0.0, *rng.uniform([-3, -0.2, -3], [3, 1, 3]).tolist())
    turn_and_go(ego, rng.uniform(-3, 3), rng.uniform(0, 1), scales_of(), plan)
    assert np.abs(plan[:, OMEGA]).max() <= math.pi + 1e-12
    assert np.abs(plan[:, A]).max() <= 5.0
    assert np.abs(plan[:, ALPHA]).max() <= 10.0
    assert -0.2 - 1e-12 <= plan[:, V].min() <= plan[:, V].max() <= 1.0 + 1e-12


@pytest.mark.parametrize("heading", [-3.0, -1.3, 0.0, 0.9, 3.1])
def test_a_candidate_turns_the_shorter_way_and_then_goes(heading):
    plan = empty()
    turn_and_go(Ego(0.0, 0.0, 2.5, 0.0, 0.0), heading, 0.7, scales_of(), plan)
    # The error shrinks by 1 - TURN_GAIN dt per stage, or so, within 4 s.
    assert math.remainder(plan[-1, THETA] - heading, math.tau) == pytest.approx(0.0, abs=0.01)
    assert abs(plan[-1, THETA] - 2.5) <= math.pi
    assert plan[-1, V] == pytest.approx(0.7)


def test_a_plan_carried_on_at_once_is_itself():
    plan, again = empty(), empty()
    turn_and_go(EGO, 1.0, 0.9, scales_of(), plan)
    carry_on(EGO, plan, 0.0, scales_of(), again)
    np.testing.assert_allclose(again, plan, atol=1e-12)


def test_a_plan_carried_on_after_a_stage_is_its_rest():
    plan, rest = empty(), empty()
    turn_and_go(EGO, 1.0, 0.9, scales_of(), plan)
    x, y, theta, v, omega = plan[1, :5].tolist()
    carry_on(Ego(x, y, theta, v, omega), plan, 0.2, scales_of(), rest)
    np.testing.assert_allclose(rest[:-1, :2], plan[1:, :2] - plan[1, :2], atol=1e-12)
    np.testing.assert_allclose(rest[:-1, THETA:A], plan[1:, THETA:A], atol=1e-12)


def test_candidates_are_clipped_inside_the_walls():
    plan = empty()
    turn_and_go(Ego(0.0, 0.0, 1.2, 1.0, 0.0), 1.2, 1.0, scales_of(box=(-9.0, -1.0, 9.0, 0.5)), plan)
    assert plan[:, Y].max() == 0.5


def test_nobody_in_the_way_means_straight_ahead():
    plan = empty()
    best_start(
        Ego(0.0, 0.0, 0.0, 1.0, 0.0),
        empty(),
        0.1,
        NOBODY,
        scales_of(),
        plan,
    )
    np.testing.assert_allclose(plan[:, X], TIMES, atol=1e-12)
    np.testing.assert_allclose(plan[:, Y], 0.0, atol=1e-12)


def test_the_old_plan_is_kept_unless_another_is_clearly_better():
    ego, scales = Ego(0.0, 0.0, 0.0, 1.0, 0.0), scales_of()
    # Somebody a little to the left: to the right is better, but not by a fifth.
    near, plan = standing((2.5, 0.02)), empty()
    left, right = (cheapest(ego, side, near, scales) for side in (1.0, -1.0))
    assert 0.8 * cost(left, near, scales, np.inf) < cost(right, near, scales, np.inf) < cost(left, near, scales, np.inf)
    best_start(ego, left, 0.0, near, scales, plan)
    assert plan[-1, Y] == pytest.approx(left[-1, Y])
    # Two more on the left: now it is.
    best_start(ego, left, 0.0, standing((2.5, 0.02), (2.2, 0.6), (2.6, 1.1)), scales, plan)
    assert plan[-1, Y] < 0.0


@settings(max_examples=50, deadline=None)
@given(seed=SEED)
def test_the_start_costs_no_more_than_any_candidate_over_four_fifths(seed):
    rng = np.random.default_rng(seed)
    near, scales, plan, candidate = crowd(rng, 20), scales_of(rng.uniform(-3, 3)), empty(), empty()
    best = best_start(EGO, empty(), 0.1, near, scales, plan)
    assert cost(plan, near, scales, np.inf) == pytest.approx(best, rel=1e-12)
    bearing = math.atan2(scales.way[1], scales.way[0])
    for heading in np.linspace(-1.3, 1.3, 11):
        for speed in (0.0, 0.35, 0.7, 1.0):
            turn_and_go(EGO, bearing + heading, speed, scales, candidate)
            assert best <= cost(candidate, near, scales, np.inf) / 0.8 * (1 + 1e-9)


@settings(max_examples=50, deadline=None)
@given(seed=SEED)
def test_who_is_left_out_costs_nothing_that_counts(seed):
    rng = np.random.default_rng(seed)
    position, velocity = rng.uniform([0, 0], [50, 10], (200, 2)), rng.normal(0, 1, (200, 2))
    discs = Discs(frozen(position), frozen(velocity), frozen(np.full(200, 0.3)), 150)
    period, scales, plan = np.array([50.0, 10.0]), scales_of(), empty()
    turn_and_go(EGO, rng.uniform(-3, 3), 1.0, scales, plan)
    reach = 0.277 + negligible_gap(scales.weights)
    near, _ = constant_velocity(EGO, discs, period, Horizon(20, 0.2, 1.0, reach, 0.177))
    near = near._replace(radius=near.radius + 0.277)
    assert 0 < len(near.radius) < 200
    offset = position - (EGO.x, EGO.y)
    offset[:150] -= np.rint(offset[:150] / period) * period
    everybody = tracks(offset, velocity, np.full(200, 0.577))
    # Each of those left out costs nothing at all: it is beyond the cutoff at every stage.
    assert cost(plan, near, scales, np.inf) == pytest.approx(cost(plan, everybody, scales, np.inf), rel=1e-12)


@settings(max_examples=50, deadline=None)
@given(seed=SEED, most=st.integers(1, 10), count=st.integers(0, 30))
def test_the_discs_chosen_are_the_most_urgent(seed, most, count):
    rng = np.random.default_rng(seed)
    near, plan = crowd(rng, count), empty()
    turn_and_go(EGO, rng.uniform(-3, 3), 1.0, scales_of(), plan)
    radius, disc = np.full(most, np.nan), np.full((20, most, 2), np.nan)
    choose_discs(plan, near, 0.2, radius, disc)
    track = near.position[1:]
    clearance = np.hypot(*(plan[1:, None, :2] - track).T) - near.radius[:, None] + LATER * TIMES[1:]
    urgent = np.argsort(clearance.min(axis=1, initial=np.inf), kind="stable")[:most]
    np.testing.assert_array_equal(radius[: len(urgent)], near.radius[urgent])
    np.testing.assert_allclose(disc[:, : len(urgent)], track[:, urgent], atol=1e-12)
    # The rest is far away and has a size: fatrop divides by it.
    assert (radius[len(urgent) :] > 0).all()
    assert (disc[:, len(urgent) :] >= 100.0).all()


@settings(max_examples=50, deadline=None)
@given(seed=SEED, walls=st.integers(0, 5))
def test_half_planes_touch_the_nearest_walls_and_hold_the_plan(seed, walls):
    rng = np.random.default_rng(seed)
    segments, plan, plane = rng.uniform(-4, 4, (walls, 2, 2)), empty(), np.full((20, 3, 3), np.nan)
    scales = scales_of(segments=segments)
    turn_and_go(EGO, rng.uniform(-3, 3), 1.0, scales, plan)
    choose_planes(plan, scales, plane)
    a, b = segments[:, 0], segments[:, 1]
    for point, rows in zip(plan[1:, :2], plane, strict=True):
        t = np.clip(((point - a) * (b - a)).sum(1) / ((b - a) ** 2).sum(1), 0, 1)
        distance = np.sort(np.hypot(*(point - a - t[:, None] * (b - a)).T))[:3]
        gap = rows[:, :2] @ point - rows[:, 2]
        np.testing.assert_allclose(gap[: len(distance)], distance - scales.body, atol=1e-9)
        assert (gap[len(distance) :] >= 100.0).all()
        assert (np.hypot(*rows[: len(distance), :2].T) == pytest.approx(1.0)) or not len(distance)


@settings(max_examples=200, deadline=None)
@given(seed=SEED)
def test_a_way_crosses_a_wall_if_both_ends_are_on_opposite_sides(seed):
    a, b, p, q = np.random.default_rng(seed).uniform(-1, 1, (4, 2))
    s, t = np.linalg.solve(np.column_stack([b - a, p - q]), p - a)
    assume(min(abs(s), abs(t), abs(1 - s), abs(1 - t)) > 1e-9)
    assert crosses(*a, *b, np.array([p, q])) == (0 < s < 1 and 0 < t < 1)


def test_candidates_that_go_through_a_wall_are_never_taken():
    plan = empty()
    scales = scales_of(segments=[[(0.9, -30.0), (0.9, 30.0)]])
    best_start(
        Ego(0.0, 0.0, 0.0, 1.0, 0.0),
        empty(),
        0.1,
        NOBODY,
        scales,
        plan,
    )
    assert plan[:, X].max() < 0.9


def test_walls_along_whole_edges_bound_the_robot(scene):
    box, inner = free_box(scene.corridor, 0.2)
    np.testing.assert_allclose(box, [0.2, 0.2, 49.8, 9.8])
    assert len(inner) == 0
    box, inner = free_box(scene.open, 0.2)
    assert np.isinf(box).all()


def test_walls_with_a_gap_and_walls_within_bound_nothing():
    door = (Wall(start=(0.0, 0.0), end=(3.0, 0.0)), Wall(start=(4.0, 0.0), end=(8.0, 0.0)))
    pieces = (Wall(start=(5.0, 6.0), end=(0.0, 6.0)), Wall(start=(5.0, 6.0), end=(8.0, 6.0)))
    slanted = Wall(start=(0.0, 0.0), end=(0.5, 6.0))
    box, inner = free_box(World(size=(8.0, 6.0), walls=(*door, *pieces, slanted)), 0.2)
    np.testing.assert_allclose(box, [-np.inf, -np.inf, np.inf, 5.8])
    np.testing.assert_array_equal(inner, [[w.start, w.end] for w in (*door, slanted)])


@pytest.mark.parametrize(
    ("intervals", "whole"),
    [([], False), ([(0, 5)], True), ([(2, 5), (0, 2)], True), ([(0, 2), (2.1, 5)], False), ([(0, 4.9)], False)],
)
def test_intervals_cover_a_length_or_do_not(intervals, whole):
    assert covered(np.array(intervals, np.float64).reshape(-1, 2), 5.0) == whole
