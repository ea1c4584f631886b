"""The linear programs agree with exhaustive search."""

import itertools

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.crowd.half_planes import best_velocity

LIMIT = 1.8
FEASIBLE = 1e-7


def solve(normal, b, goal, hard=0):
    nx, ny, offsets = normal[:, 0].copy(), normal[:, 1].copy(), b.copy()
    return np.array(best_velocity(nx, ny, offsets, hard, len(b), LIMIT, goal[0], goal[1]))


def violations(normal, b, v):
    return b - normal @ v


def nearest_by_exhaustive_search(normal, b, goal):
    """The nearest of all points that can be the optimum: the goal, feet of perpendiculars, corners."""
    points = [goal, goal / np.linalg.norm(goal) * LIMIT]
    for n, c in zip(normal, b, strict=True):
        along = np.array([n[1], -n[0]])
        points.append(c * n + (along @ goal) * along)
        if abs(c) < LIMIT:
            half = np.sqrt(LIMIT**2 - c**2)
            points += [c * n + half * along, c * n - half * along]
    for i, j in itertools.combinations(range(len(b)), 2):
        if abs(np.linalg.det(normal[[i, j]])) > 1e-9:
            points.append(np.linalg.solve(normal[[i, j]], b[[i, j]]))
    inside = [p for p in points if np.linalg.norm(p) <= LIMIT + FEASIBLE and violations(normal, b, p).max() <= FEASIBLE]
    return min(inside, key=lambda p: np.linalg.norm(p - goal), default=None)


def least_worst_violation(normal, b, hard):
    """min max violation of the soft half-planes, over all corners of the problem in (v_x, v_y, delta).

    At the optimum three of the planes n . v + delta = b (hard ones without delta) and the cylinder |v| = LIMIT meet,
    or one plane and the cylinder touch.
    """
    soft = (np.arange(len(b)) >= hard).astype(float)
    planes = np.column_stack([normal, soft])
    corners = [(*(LIMIT * n), c - LIMIT) for n, c in zip(normal[hard:], b[hard:], strict=True)]
    for i, j in itertools.combinations(range(len(b)), 2):
        along = np.cross(planes[i], planes[j])
        flat = along[:2] @ along[:2]
        if flat > 1e-12:
            start = np.linalg.lstsq(planes[[i, j]], b[[i, j]], rcond=None)[0]
            middle, rest = -(start[:2] @ along[:2]) / flat, LIMIT**2 - start[:2] @ start[:2]
            if middle**2 + rest / flat >= 0:
                root = np.sqrt(middle**2 + rest / flat)
                corners += [start + (middle + root) * along, start + (middle - root) * along]
        for k in range(j):
            if k != i and abs(np.linalg.det(planes[[i, j, k]])) > 1e-12:
                corners.append(np.linalg.solve(planes[[i, j, k]], b[[i, j, k]]))
    corners = np.array(corners)
    lacking = (b - corners @ planes.T).max(axis=1)
    inside = (lacking <= FEASIBLE) & (np.hypot(corners[:, 0], corners[:, 1]) <= LIMIT + FEASIBLE)
    return corners[inside, 2].min()


def random_half_planes(seed, count, low, high):
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0, 2 * np.pi, count)
    goal = rng.uniform(-1.3, 1.3, 2)
    return np.column_stack([np.cos(angle), np.sin(angle)]), rng.uniform(low, high, count), goal


@settings(deadline=None, max_examples=150)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(1, 12))
def test_the_permitted_velocity_is_the_nearest_to_the_preferred_one(seed, count):
    normal, b, goal = random_half_planes(seed, count, -1.5, 0.3)
    expected = nearest_by_exhaustive_search(normal, b, goal)
    assume(expected is not None)
    # The search accepts points up to 1e-7 m/s outside; a sharp corner moves by more than that.
    assert np.linalg.norm(solve(normal, b, goal) - goal) == pytest.approx(np.linalg.norm(expected - goal), abs=1e-5)
    assert violations(normal, b, solve(normal, b, goal)).max() <= FEASIBLE


@settings(deadline=None, max_examples=100)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(3, 15))
def test_the_worst_violation_is_least_where_nothing_is_permitted(seed, count):
    normal, b, goal = random_half_planes(seed, count, -0.5, 2.5)
    assume(nearest_by_exhaustive_search(normal, b, goal) is None)
    v = solve(normal, b, goal)
    assert np.linalg.norm(v) <= LIMIT + 1e-9
    # The search accepts corners up to 1e-7 m/s outside.
    assert violations(normal, b, v).max() == pytest.approx(least_worst_violation(normal, b, 0), abs=1e-5)


@settings(deadline=None, max_examples=100)
@given(seed=st.integers(0, 2**32 - 1), hard=st.integers(1, 4), soft=st.integers(2, 10))
def test_walls_are_kept_whatever_the_crowd_wants(seed, hard, soft):
    normal, b, goal = random_half_planes(seed, hard + soft, -0.5, 2.5)
    b[:hard] = -np.abs(b[:hard]) * 0.3
    v = solve(normal, b, goal, hard)
    assert violations(normal, b, v)[:hard].max() <= FEASIBLE
    if nearest_by_exhaustive_search(normal, b, goal) is None:
        worst = violations(normal, b, v)[hard:].max()
        assert worst == pytest.approx(least_worst_violation(normal, b, hard), abs=1e-5)


@settings(deadline=None, max_examples=100)
@given(seed=st.integers(0, 2**32 - 1), count=st.integers(2, 15))
def test_the_order_of_half_planes_does_not_matter_to_the_last_bit(seed, count):
    normal, b, goal = random_half_planes(seed, count, -0.8, 1.5)
    shuffled = np.random.default_rng(seed).permutation(count)
    assert np.array_equal(solve(normal, b, goal), solve(normal[shuffled], b[shuffled], goal))


def test_nothing_in_the_way_gives_the_preferred_velocity():
    assert np.array_equal(solve(np.empty((0, 2)), np.empty(0), np.array([1.3, 0.2])), [1.3, 0.2])


def test_a_preferred_velocity_beyond_the_limit_is_shortened():
    assert solve(np.empty((0, 2)), np.empty(0), np.array([3.0, 4.0])) == pytest.approx([1.08, 1.44])


def test_two_opposite_half_planes_are_violated_alike_and_no_faster_than_need_be():
    normal, b = np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([1.0, 0.4])
    assert solve(normal, b, np.array([0.0, 1.3])) == pytest.approx([0.3, 0.0], abs=1e-12)
    assert solve(normal[::-1], b[::-1], np.array([0.0, 1.3])) == pytest.approx([0.3, 0.0], abs=1e-12)
