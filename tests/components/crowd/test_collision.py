"""Times to collision against closed forms and against a march in small steps."""

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.crowd.collision import raise_to_disc, raise_to_wall

coordinate = st.floats(-4.0, 4.0, allow_subnormal=False)
speed = st.floats(-2.0, 2.0, allow_subnormal=False)


def disc_rate(x, y, u, w, R, vx, vy, *, skip=False):
    rate = np.zeros(1)
    raise_to_disc(x, y, u, w, R, np.array([vx]), np.array([vy]), skip, rate)
    return rate[0]


def wall_rate(ax, ay, bx, by, r, vx, vy, *, skip=False):
    rate = np.zeros(1)
    raise_to_wall(ax, ay, bx, by, r, np.array([vx]), np.array([vy]), skip, rate)
    return rate[0]


def distance_to_segment(ax, ay, bx, by, x, y):
    a, b, p = np.array([ax, ay]), np.array([bx, by]), np.array([x, y])
    u = b - a
    s = np.clip((p - a) @ u / (u @ u), 0, 1) if u @ u > 0 else 0.0
    return np.linalg.norm(p - a - s * u)


def test_two_head_on_meet_after_the_gap_over_the_closing_speed():
    assert 1 / disc_rate(5.0, 0.0, -1.0, 0.0, 0.6, 1.3, 0.0) == pytest.approx((5.0 - 0.6) / 2.3, rel=1e-14)


def test_two_at_right_angles_meet_where_pythagoras_says():
    # Both 3 m from the crossing at 1 m/s: sqrt(2) (3 - t) = 0.6.
    assert 1 / disc_rate(3.0, 3.0, 0.0, -1.0, 0.6, 1.0, 0.0) == pytest.approx(3 - 0.6 / math.sqrt(2), rel=1e-14)


def test_whoever_grazes_just_touches_at_the_closest_approach():
    assert 1 / disc_rate(4.0, 0.5, 0.0, 0.0, 0.5, 1.0, 0.0) == pytest.approx(4.0, rel=1e-14)
    assert disc_rate(4.0, 0.5001, 0.0, 0.0, 0.5, 1.0, 0.0) == 0.0


def test_whoever_walks_away_or_beside_never_collides():
    assert disc_rate(3.0, 0.0, 1.5, 0.0, 0.6, 1.3, 0.0) == 0.0
    assert disc_rate(3.0, 0.0, 1.3, 0.0, 0.6, 1.3, 0.0) == 0.0
    assert disc_rate(3.0, 0.0, 0.0, 0.0, 0.6, -1.3, 0.0) == 0.0


def test_those_who_overlap_collide_at_once_unless_they_part():
    assert disc_rate(0.5, 0.0, 0.0, 0.0, 0.6, 0.1, 0.0) == np.inf
    assert disc_rate(0.5, 0.0, 0.0, 0.0, 0.6, -0.1, 0.0) == 0.0
    assert disc_rate(0.5, 0.0, 0.0, 0.0, 0.6, 0.1, 0.0, skip=True) == 0.0
    assert wall_rate(0.2, -1, 0.2, 1, 0.3, 0.1, 0.0) == np.inf
    assert wall_rate(0.2, -1, 0.2, 1, 0.3, -0.1, 0.0) == 0.0
    assert wall_rate(0.2, -1, 0.2, 1, 0.3, 0.1, 0.0, skip=True) == 0.0


@settings(deadline=None, max_examples=300)
@given(x=coordinate, y=coordinate, u=speed, w=speed, vx=speed, vy=speed, R=st.sampled_from([0.3, 0.6]))
def test_at_the_time_of_the_collision_two_discs_touch_and_not_before(x, y, u, w, vx, vy, R):
    assume(math.hypot(x, y) > R + 1e-3)
    rate = disc_rate(x, y, u, w, R, vx, vy)
    wx, wy = vx - u, vy - w
    if rate > 1e-6:
        t = 1 / rate
        assert math.hypot(x - wx * t, y - wy * t) == pytest.approx(R, abs=1e-9 * (1 + t))
        before = np.linspace(0, t, 50)[:-1]
        assert (np.hypot(x - wx * before, y - wy * before) >= R - 1e-9).all()
    elif wx * wx + wy * wy > 1e-6:
        nearest = max((x * wx + y * wy) / (wx * wx + wy * wy), 0.0)
        assert math.hypot(x - wx * nearest, y - wy * nearest) >= R - 1e-9


@settings(deadline=None, max_examples=300)
@given(ax=coordinate, ay=coordinate, bx=coordinate, by=coordinate, vx=speed, vy=speed)
def test_at_the_time_of_the_collision_a_disc_touches_the_wall_and_not_before(ax, ay, bx, by, vx, vy):
    r = 0.3
    assume(distance_to_segment(ax, ay, bx, by, 0.0, 0.0) > r + 1e-3)
    # Shorter walls lose the direction of their normal to rounding.
    assume(math.hypot(bx - ax, by - ay) > 1e-3 or (ax == bx and ay == by))
    rate = wall_rate(ax, ay, bx, by, r, vx, vy)
    horizon = 1 / rate if rate > 0.05 else 20.0
    way = [distance_to_segment(ax, ay, bx, by, vx * t, vy * t) for t in np.linspace(0, horizon, 60)]
    assert min(way) >= r - 1e-7
    if rate > 0.05:
        assert way[-1] == pytest.approx(r, abs=1e-7)


def test_a_wall_is_met_at_its_straight_part_at_an_end_or_not_at_all():
    assert 1 / wall_rate(2.0, -1.0, 2.0, 1.0, 0.3, 1.0, 0.0) == pytest.approx(1.7)
    assert 1 / wall_rate(2.0, 0.3, 2.0, 1.0, 0.5, 1.0, 0.0) == pytest.approx(2.0 - 0.4)
    assert wall_rate(2.0, 0.4, 2.0, 1.0, 0.3, 1.0, 0.0) == 0.0
    assert 1 / wall_rate(2.0, 0.0, 3.0, 0.0, 0.3, 1.0, 0.0) == pytest.approx(1.7)
