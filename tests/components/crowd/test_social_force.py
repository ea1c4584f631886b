"""Social forces: the gradient, the closed forms, the laws."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.crowd.scene import Scene
from components.crowd.social_force import (
    ANTICIPATION,
    BEHIND,
    RELAXATION,
    REPULSION,
    REPULSION_LENGTH,
    SocialForce,
    repulsion,
    weight,
)
from components.crowd.walls import Walls

coordinate = st.floats(-4.0, 4.0, allow_subnormal=False)
speed = st.floats(-2.0, 2.0, allow_subnormal=False)


def accelerate(position, velocity=None, preferred=None, *, robots=(), walls=(), period=(0.0, 0.0)):
    position = np.asarray(position, np.float64)
    zero = np.zeros_like(position)
    return SocialForce().accelerate(
        Scene(
            position=position,
            velocity=zero if velocity is None else np.asarray(velocity, np.float64),
            preferred=zero if preferred is None else np.asarray(preferred, np.float64),
            radius=np.full(len(position), 0.3),
            robots=np.array(robots, np.float64).reshape(-1, 5),
            pushed_by_robots=np.ones(len(position), np.bool_),
            walls=Walls(np.array(walls, np.float64), np.asarray(period)),
            period=np.asarray(period, np.float64),
            max_speed=np.full(len(position), 1.8),
            max_acceleration=np.full(len(position), 5.0),
            stream=np.zeros(len(position), np.uint64),
            dt=0.1,
        )
    )


def potential(rx, ry, vx, vy):
    """V0 exp(-b / sigma) as the paper writes it, in extended precision."""
    rx, ry, vx, vy = (np.longdouble(x) for x in (rx, ry, vx, vy))
    qx, qy = rx - vx * ANTICIPATION, ry - vy * ANTICIPATION
    s = np.hypot(rx, ry) + np.hypot(qx, qy)
    b = np.sqrt(s**2 - (vx**2 + vy**2) * ANTICIPATION**2) / 2
    return REPULSION * np.exp(-b / REPULSION_LENGTH)


@settings(deadline=None, max_examples=300)
@given(rx=coordinate, ry=coordinate, vx=speed, vy=speed)
def test_the_repulsion_is_minus_the_gradient_of_the_potential(rx, ry, vx, vy):
    r, V = np.array([rx, ry]), ANTICIPATION * np.array([vx, vy])
    # The gradient exists off the segment from 0 to V only.
    on = np.clip(r @ V / (V @ V), 0, 1) if V @ V > 0 else 0.0
    assume(np.linalg.norm(r - on * V) > 0.05)
    h = 1e-6
    gx = (potential(rx + h, ry, vx, vy) - potential(rx - h, ry, vx, vy)) / (2 * h)
    gy = (potential(rx, ry + h, vx, vy) - potential(rx, ry - h, vx, vy)) / (2 * h)
    # Third derivatives of up to V0 / (sigma 0.05^2) times h^2 / 6.
    assert repulsion(rx, ry, vx, vy) == pytest.approx((-float(gx), -float(gy)), abs=1e-7)


@given(rx=coordinate, ry=coordinate, vx=speed, vy=speed)
@settings(deadline=None)
def test_the_repulsion_is_mutual(rx, ry, vx, vy):
    fx, fy = repulsion(rx, ry, vx, vy)
    assert repulsion(-rx, -ry, -vx, -vy) == (-fx, -fy)


@pytest.mark.parametrize("distance", [0.3, 0.6, 1.0, 2.0])
def test_two_who_stand_repel_each_other_exponentially(distance):
    # V = 0, so b = |R|: f = V0 / sigma exp(-|R| / sigma).
    a = accelerate([(0, 0), (distance, 0)])
    f = 2.1 / 0.3 * math.exp(-distance / 0.3)
    assert a == pytest.approx(np.array([(-f, 0), (f, 0)]), rel=1e-12)


@given(seed=st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=30)
def test_momentum_is_conserved_where_all_are_seen_fully(seed):
    rng = np.random.default_rng(seed)
    # Everybody stands, so nobody is behind; the forces depend on the distances alone.
    a = accelerate(rng.random((40, 2)) * (10, 10), period=(10, 10))
    assert a.sum(axis=0) == pytest.approx([0, 0], abs=1e-11)


def test_whoever_is_alone_relaxes_to_the_preferred_velocity():
    a = accelerate([(0, 0)], [(0.3, 0.1)], [(1.3, 0.0)])
    assert a == pytest.approx(np.array([((1.3 - 0.3) / RELAXATION, (0.0 - 0.1) / RELAXATION)]))


def test_a_wall_repels_exponentially():
    a = accelerate([(3.0, 0.4)], walls=[((0, 0), (10, 0))])
    assert a == pytest.approx(np.array([(0.0, 10 / 0.2 * math.exp(-0.4 / 0.2))]))


@pytest.mark.parametrize(("degrees", "expected"), [(0, 1.0), (99.9, 1.0), (-99.9, 1.0), (100.1, 0.5), (180, 0.5)])
def test_neighbours_more_than_100_degrees_off_the_way_count_half(degrees, expected):
    angle = math.radians(degrees)
    assert weight(-math.cos(angle), -math.sin(angle), 1.3, 0.0) == expected


def test_whoever_stands_is_repelled_fully_from_all_sides():
    assert weight(1.0, 0.0, 0.0, 0.0) == 1.0


def test_two_exactly_head_on_get_no_sideways_push():
    assert repulsion(2.0, 0.0, 2.0, 0.0) == (0.0, 0.0)
    assert np.isfinite(accelerate([(0, 0), (0, 0)])).all()


def test_a_robot_repels_as_a_person_does():
    pair = accelerate([(0, 0), (1.5, 0.2)], [(1.3, 0), (-1, 0)], [(1.3, 0), (-1, 0)])
    robot = accelerate([(0, 0)], [(1.3, 0)], [(1.3, 0)], robots=[(1.5, 0.2, -1, 0, 0.4)])
    assert robot[0] == pytest.approx(pair[0], abs=1e-14)


@given(seed=st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=30)
def test_the_sum_is_that_over_all_pairs_at_their_nearest_images(seed):
    rng = np.random.default_rng(seed)
    size = np.array([14.0, 10.0])
    n = 25
    p, v, w = rng.random((n, 2)) * size, rng.normal(0, 1, (n, 2)), rng.normal(0, 1, (n, 2))
    expected = (w - v) / RELAXATION
    for i in range(n):
        for j in range(n):
            r = p[i] - p[j]
            r -= np.round(r / size) * size
            if i != j and np.linalg.norm(r) <= 5.0:
                ahead = -(r @ v[i]) >= math.cos(math.radians(100)) * np.linalg.norm(r) * np.linalg.norm(v[i])
                f = np.array(repulsion(r[0], r[1], *(v[j] - v[i])))
                expected[i] += f if ahead else BEHIND * f
    assert accelerate(p, v, w, period=size) == pytest.approx(expected, abs=1e-10)


@given(seed=st.integers(0, 2**32 - 1))
@settings(deadline=None, max_examples=30)
def test_everybody_gets_the_same_whatever_the_order_of_the_list(seed):
    rng = np.random.default_rng(seed)
    p, v, w = rng.random((60, 2)) * (12, 10), rng.normal(0, 1, (60, 2)), rng.normal(0, 1, (60, 2))
    shuffled = rng.permutation(60)
    a = accelerate(p, v, w, period=(12, 10))
    assert np.array_equal(a[shuffled], accelerate(p[shuffled], v[shuffled], w[shuffled], period=(12, 10)))
