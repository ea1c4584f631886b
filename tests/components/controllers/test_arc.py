"""The closed-form clearance of arcs, against fine rollouts."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from components.controllers.arc import TOUCHING, clearance, obstacles_near
from components.controllers.ego import Ego
from components.controllers.surroundings import Discs, frozen

BODY = 0.2
FAR = 12.0
STEP = 2e-3
NO_DISCS = Discs(frozen(np.zeros((0, 2))), frozen(np.zeros((0, 2))), frozen(np.zeros(0)), 0)
NO_WALLS = frozen(np.zeros((0, 2, 2)))
NO_SEAM = frozen(np.zeros(2))
ORIGIN = Ego(0.0, 0.0, 0.0, 0.0, 0.0)

COORDINATE = st.floats(-4.0, 4.0)
# Straight, nearly straight, and tighter than the robot.
CURVATURE = st.one_of(st.just(0.0), st.floats(-1e-3, 1e-3), st.floats(-2.0, 2.0), st.floats(-60.0, 60.0))


def discs_at(*position, radius=0.3, people=None) -> Discs:
    n = len(position)
    return Discs(
        frozen(position), frozen(np.zeros((n, 2))), frozen(np.full(n, radius)), n if people is None else people
    )


def clear(curvature, discs=NO_DISCS, walls=NO_WALLS, ego=ORIGIN, period=NO_SEAM) -> float:
    return clearance(curvature, obstacles_near(ego, discs, walls, period, BODY, FAR))


def rollout(curvature, distance, contact) -> float:
    """Arc length of the first sample at which `distance` of the points (n, 2) is below `contact`."""
    length = min(FAR, math.tau / abs(curvature)) if curvature else FAR
    s = np.arange(0.0, length, STEP)
    half = curvature * s / 2
    chord = s * np.sinc(half / math.pi)
    below = distance(np.stack([chord * np.cos(half), chord * np.sin(half)], axis=1)) < contact
    return float(s[np.argmax(below)]) if below.any() else math.inf


def check_against_rollout(curvature, found, distance, contact):
    """Distances change by no more than the way driven, hence contact and rollout bracket each other."""
    found = found if found <= FAR else math.inf
    assert found <= rollout(curvature, distance, contact - STEP)
    assert found >= rollout(curvature, distance, contact + STEP) - STEP or found >= FAR - STEP


def to_point(p):
    return lambda points: np.hypot(*(points - p).T)


def to_segment(a, b):
    a, b = np.array(a), np.array(b)
    along = b - a

    def distance(points):
        t = np.clip((points - a) @ along / max(along @ along, 1e-300), 0.0, 1.0)
        return np.hypot(*(points - a - t[:, None] * along).T)

    return distance


@settings(max_examples=300, deadline=None)
@given(k=CURVATURE, x=COORDINATE, y=COORDINATE, radius=st.floats(0.0, 1.0))
def test_clearance_to_a_disc_is_that_of_a_fine_rollout(k, x, y, radius):
    contact = min(BODY + radius, math.hypot(x, y) - TOUCHING)
    assume(contact > STEP)
    check_against_rollout(k, clear(k, discs_at((x, y), radius=radius)), to_point((x, y)), contact)


@settings(max_examples=300, deadline=None)
@given(k=CURVATURE, ax=COORDINATE, ay=COORDINATE, bx=COORDINATE, by=COORDINATE)
def test_clearance_to_a_wall_is_that_of_a_fine_rollout(k, ax, ay, bx, by):
    distance = to_segment((ax, ay), (bx, by))
    contact = min(BODY, float(distance(np.zeros((1, 2)))[0]) - TOUCHING)
    assume(contact > STEP)
    found = clear(k, walls=frozen([[(ax, ay), (bx, by)]]))
    check_against_rollout(k, found, distance, contact)


def test_straight_at_a_disc_there_is_the_gap():
    assert clear(0.0, discs_at((2.0, 0.0))) == pytest.approx(1.5, abs=1e-14)


def test_straight_at_a_wall_there_is_the_gap():
    assert clear(0.0, walls=frozen([[(2.0, -1.0), (2.0, 1.0)]])) == pytest.approx(1.8, abs=1e-14)


def test_a_quarter_turn_into_a_wall_ahead():
    # Centre of the turn (0, 1); contact where x = sin(s) = 0.5.
    wall = frozen([[(0.5 + BODY, -3.0), (0.5 + BODY, 3.0)]])
    assert clear(1.0, walls=wall) == pytest.approx(math.asin(0.5), abs=1e-14)


def test_a_disc_behind_is_met_at_the_end_of_the_turn():
    # On the circle of radius 1 around (0, 1), a disc 90 degrees behind: contact at a chord of 0.5 before it.
    expected = 1.5 * math.pi - 2 * math.asin(0.25)
    assert clear(1.0, discs_at((-1.0, 1.0))) == pytest.approx(expected, abs=1e-13)


def test_a_disc_within_the_turn_is_never_met():
    assert clear(0.5, discs_at((0.0, 2.0))) == math.inf


def test_nothing_near_means_no_end():
    assert clear(0.3) == math.inf
    assert math.isnan(obstacles_near(ORIGIN, NO_DISCS, NO_WALLS, NO_SEAM, BODY, FAR).nearest_y)


@given(k=st.floats(-1e-6, 1e-6), x=st.floats(0.6, 4.0), y=st.floats(-0.4, 0.4))
def test_a_vanishing_curvature_is_a_straight_line(k, x, y):
    # The arc is off the line by k s^2 / 2 < 1e-5 m; contact at a slope of at least 0.6 turns that into 2e-5 m of way.
    assert clear(k, discs_at((x, y))) == pytest.approx(clear(0.0, discs_at((x, y))), abs=2e-5)


@given(depth=st.floats(0.0, 0.4), bearing=st.floats(-math.pi, math.pi), k=CURVATURE)
def test_a_robot_that_overlaps_may_leave_but_come_no_nearer(depth, bearing, k):
    assume(abs(math.cos(bearing)) > 1e-3)
    distance = 0.5 - depth
    found = clear(k, discs_at((distance * math.cos(bearing), distance * math.sin(bearing))))
    if math.cos(bearing) > 0:
        # It may close the gap that counts as touching, at a slope of at least cos(bearing).
        assert found < 2 * TOUCHING / math.cos(bearing)
    else:
        assert found > 1e-4


def test_a_robot_pressed_against_a_wall_may_slide_along_it():
    walls = frozen([[(-5.0, -0.1), (5.0, -0.1)]])
    assert clear(0.0, walls=walls) > FAR
    assert clear(0.5, walls=walls) > 5.0
    assert clear(-0.5, walls=walls) < 1e-3


@given(heading=st.floats(-math.pi, math.pi), x=st.floats(-40, 40), y=st.floats(-40, 40), k=CURVATURE)
def test_only_the_view_from_the_robot_counts(heading, x, y, k):
    seen = np.array([(1.5, 0.4), (0.3, -2.0), (-2.0, 0.5)])
    cos, sin = math.cos(heading), math.sin(heading)
    placed = seen @ [[cos, sin], [-sin, cos]] + (x, y)
    found = clear(k, discs_at(*placed[:2]), frozen([placed[1:]]), Ego(x, y, heading, 0.0, 0.0))
    expected = clear(k, discs_at(*seen[:2]), frozen([seen[1:]]))
    if min(found, expected) < FAR:
        # Coordinates of 40 m carry 1e-14 m of rounding, which a grazing contact magnifies to its square root.
        assert found == pytest.approx(expected, abs=1e-6)


def test_people_are_met_across_the_seam_and_robots_are_not():
    period = frozen([50.0, 10.0])
    ego = Ego(49.0, 5.0, 0.0, 0.0, 0.0)
    assert clear(0.0, discs_at((1.0, 5.0)), ego=ego, period=period) == pytest.approx(1.5)
    assert clear(0.0, discs_at((1.0, 5.0))._replace(people=0), ego=ego, period=period) == math.inf
    wall = frozen([[(0.5, 0.0), (0.5, 10.0)]])
    assert clear(0.0, walls=wall, ego=ego, period=period) == math.inf


def test_obstacles_beyond_reach_are_left_out():
    near = obstacles_near(ORIGIN, discs_at((3.0, 0.0), (3.6, 0.0)), NO_WALLS, NO_SEAM, BODY, 3.0)
    assert len(near.discs) == 1
