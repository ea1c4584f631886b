"""Following people: the filter's gain, who is who, newcomers and those who are gone."""

from __future__ import annotations

import numpy as np
import pytest

from components.controllers.tracker import AGILITY, NEWCOMER, PATIENCE, Tracker

DT = 0.1
UNKNOWN = np.inf


def see(tracker, position, deviation=0.05, velocity=None, velocity_deviation=UNKNOWN, radius=0.3):
    position = np.array(position, np.float64).reshape(-1, 2)
    n = len(position)
    velocity = np.zeros((n, 2)) if velocity is None else np.array(velocity, np.float64)
    tracker.correct(position, np.full(n, deviation), velocity, np.full(n, velocity_deviation), np.full(n, radius))


def test_one_filter_is_the_textbooks_with_its_matrices_written_out():
    tracker, rng = Tracker(), np.random.default_rng(1)
    F = np.eye(4) + DT * np.eye(4, k=2)
    q = np.array([[DT**3 / 3, DT**2 / 2], [DT**2 / 2, DT]])
    Q, H, R = AGILITY * np.kron(q, np.eye(2)), np.eye(2, 4), 0.05**2 * np.eye(2)
    z = np.array([3.0, 1.0])
    see(tracker, z)
    x, P = np.array([*z, 0.0, 0.0]), np.diag([0.05**2] * 2 + [NEWCOMER**2] * 2)
    for k in range(20):
        z = np.array([3.0 + 0.12 * k, 1.0]) + rng.normal(0, 0.05, 2)
        tracker.predict(DT)
        see(tracker, z)
        x, P = F @ x, F @ P @ F.T + Q
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + R)
        x, P = x + K @ (z - H @ x), P - K @ H @ P
        np.testing.assert_allclose(tracker.position, [x[:2]], atol=1e-12)
        np.testing.assert_allclose(tracker.velocity, [x[2:]], atol=1e-12)


def test_it_learns_velocities_of_people_who_cross_in_any_order_of_detection():
    rng = np.random.default_rng(2)
    start, velocity = rng.uniform(-5, 5, (12, 2)), rng.normal(0, 1.3, (12, 2))
    tracker = Tracker()
    for k in range(40):
        tracker.predict(DT)
        order = rng.permutation(12)
        see(tracker, (start + k * DT * velocity)[order], deviation=0.01)
    assert len(tracker.position) == 12
    end = start + 39 * DT * velocity
    who = [int(np.argmin(np.hypot(*(end - p).T))) for p in tracker.position]
    assert sorted(who) == list(range(12))
    np.testing.assert_allclose(tracker.velocity, velocity[who], atol=0.15)


def test_a_known_velocity_is_believed_as_far_as_it_is_certain():
    exact, vague = Tracker(), Tracker()
    for tracker, deviation in ((exact, 0.01), (vague, 10.0)):
        see(tracker, [(0.0, 0.0)])
        tracker.predict(DT)
        see(tracker, [(0.0, 0.0)], velocity=[(1.0, 0.0)], velocity_deviation=deviation)
    assert exact.velocity[0, 0] == pytest.approx(1.0, abs=0.01)
    assert abs(vague.velocity[0, 0]) < 0.1


def test_who_is_not_seen_walks_on_for_a_while_and_is_forgotten():
    tracker = Tracker()
    see(tracker, [(0.0, 0.0)], velocity=[(1.0, 0.0)], velocity_deviation=0.01)
    for _ in range(round(PATIENCE / DT)):
        tracker.predict(DT)
        see(tracker, [])
    np.testing.assert_allclose(tracker.position, [(PATIENCE, 0.0)], atol=1e-12)
    for _ in range(2):
        tracker.predict(DT)
    assert len(tracker.position) == 0


def test_a_detection_far_from_everybody_is_somebody_else():
    tracker = Tracker()
    see(tracker, [(0.0, 0.0)])
    tracker.predict(DT)
    see(tracker, [(3.0, 0.0)])
    np.testing.assert_allclose(tracker.position, [(0.0, 0.0), (3.0, 0.0)])
