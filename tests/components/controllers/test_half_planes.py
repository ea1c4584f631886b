"""The linear programs, against a general optimiser."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize

from components.controllers.half_planes import best_velocity

MAX_SPEED = 1.2
SEEDS = range(60)
# What SLSQP is asked for; its constraints hold to about the same.
TOLERANCE = 1e-10
AGREE = 1e-6


def random_planes(rng, count, low, high):
    angle, b = rng.uniform(-math.pi, math.pi, count), rng.uniform(low, high, count)
    return np.column_stack([np.cos(angle), np.sin(angle), b])


def trespass(planes, v):
    return planes[:, :2] @ v - planes[:, 2]


def solve(planes, hard, preferred):
    return np.array(best_velocity(planes, hard, MAX_SPEED, *preferred))


def within_speed(v):
    return MAX_SPEED**2 - v[0] ** 2 - v[1] ** 2


def with_level(planes, slope):
    return np.column_stack([-planes[:, :2], np.full(len(planes), slope)])


@pytest.mark.parametrize("seed", SEEDS)
def test_the_nearest_velocity_is_that_of_a_general_optimiser(seed):
    rng = np.random.default_rng(seed)
    # Standing obeys them all.
    planes, preferred = random_planes(rng, 9, 0.0, 0.8), rng.uniform(-1.5, 1.5, 2)
    oracle = minimize(
        lambda v: (v - preferred) @ (v - preferred),
        np.zeros(2),
        method="SLSQP",
        jac=lambda v: 2 * (v - preferred),
        constraints=[
            {"type": "ineq", "fun": lambda v: -trespass(planes, v), "jac": lambda _: -planes[:, :2]},
            {"type": "ineq", "fun": within_speed, "jac": lambda v: -2 * v},
        ],
        options={"ftol": TOLERANCE, "maxiter": 200},
    )
    assert oracle.success
    # The objective is flat at its least value along the active edges, so compare values, not velocities.
    found = solve(planes, 0, preferred)
    assert math.dist(found, preferred) == pytest.approx(math.dist(oracle.x, preferred), abs=AGREE)
    assert trespass(planes, found).max() <= 1e-12


@pytest.mark.parametrize("seed", SEEDS)
def test_the_least_wrong_velocity_is_that_of_a_general_optimiser(seed):
    rng = np.random.default_rng(1000 + seed)
    hard, soft = random_planes(rng, 3, 0.0, 0.8), random_planes(rng, 6, -1.5, -0.3)
    preferred = rng.uniform(-1.0, 1.0, 2)
    # Variables: velocity, and the trespass on the worst of the soft half-planes.
    oracle = minimize(
        lambda q: q[2],
        np.array([0.0, 0.0, trespass(soft, np.zeros(2)).max()]),
        method="SLSQP",
        jac=lambda _: np.array([0.0, 0.0, 1.0]),
        constraints=[
            {"type": "ineq", "fun": lambda q: q[2] - trespass(soft, q[:2]), "jac": lambda _: with_level(soft, 1.0)},
            {"type": "ineq", "fun": lambda q: -trespass(hard, q[:2]), "jac": lambda _: with_level(hard, 0.0)},
            {"type": "ineq", "fun": within_speed, "jac": lambda q: np.array([-2 * q[0], -2 * q[1], 0.0])},
        ],
        options={"ftol": TOLERANCE, "maxiter": 200},
    )
    assert oracle.success
    assert oracle.x[2] > 0
    found = solve(np.concatenate([hard, soft]), 3, preferred)
    assert trespass(soft, found).max() == pytest.approx(oracle.x[2], abs=AGREE)
    assert trespass(hard, found).max() <= 1e-12


@settings(max_examples=300, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), walls=st.integers(0, 4), people=st.integers(0, 8))
def test_walls_hold_and_the_speed_is_kept_whatever_the_people_do(seed, walls, people):
    rng = np.random.default_rng(seed)
    planes = np.concatenate([random_planes(rng, walls, 0.0, 0.5), random_planes(rng, people, -2.0, 1.0)])
    planes[:walls, 2] *= rng.random(walls) < 0.7  # some walls are touched
    found = solve(planes, walls, rng.uniform(-1.5, 1.5, 2))
    # A bound on the rounding of products of numbers up to 2 whose divisor may be as small as 1e-3.
    assert (trespass(planes[:walls], found) <= 1e-12).all()
    assert np.hypot(*found) <= MAX_SPEED * (1 + 1e-12)


def test_without_half_planes_the_preferred_velocity_is_taken():
    assert tuple(solve(np.zeros((0, 3)), 0, (0.3, -0.4))) == (0.3, -0.4)


def test_a_preferred_velocity_that_is_too_fast_is_shortened():
    assert solve(np.zeros((0, 3)), 0, (3.0, 4.0)) == pytest.approx((0.72, 0.96))


def test_the_preferred_velocity_is_projected_onto_a_half_plane():
    assert solve(np.array([[1.0, 0.0, 0.25]]), 0, (1.0, 0.5)) == pytest.approx((0.25, 0.5))


def test_opposite_demands_are_met_half_way():
    planes = np.array([[1.0, 0.0, -0.5], [-1.0, 0.0, -0.3]])
    # v_x <= -0.5 and v_x >= 0.3: trespass 0.4 on either.
    assert solve(planes, 0, (1.0, 0.0))[0] == pytest.approx(-0.1)


def test_equal_demands_that_are_too_much_are_met_as_far_as_the_speed_goes():
    planes = np.array([[1.0, 0.0, -2.0], [1.0, 0.0, -2.0], [1.0, 0.0, -3.0]])
    assert solve(planes, 0, (1.0, 0.0)) == pytest.approx((-MAX_SPEED, 0.0))
