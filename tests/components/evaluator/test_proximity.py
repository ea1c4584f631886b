"""Closeness of people against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from crowdcosim.world import World


def test_a_person_2_m_away_all_the_time_gives_three_fifths(scene: Any) -> None:
    found = scene.judge(scene.drive(30, crowd=lambda t: scene.crowd([(t, 7.0), (t, 9.5)])))
    assert found["proximity"] == pytest.approx(0.6, rel=1e-12)


def test_a_person_in_the_robot_gives_1_and_nobody_within_5_m_gives_0(scene: Any) -> None:
    assert scene.judge(scene.drive(30, crowd=lambda t: scene.crowd([(t, 5.0)])))["proximity"] == 1.0
    assert scene.judge(scene.drive(30, crowd=lambda t: scene.crowd([(t + 20, 5.0)])))["proximity"] == 0.0


def test_passing_a_standing_person_gives_the_integral_of_the_hyperbola(scene: Any) -> None:
    # The robot drives from x = -4 to 4 past a person 2 m aside: d(t) = sqrt(x^2 + 4), its mean over x in closed form.
    h, a = 2.0, 4.0
    mean = (a * math.hypot(a, h) + h * h * math.asinh(a / h)) / (2 * a)
    frames = scene.drive(80, start=(6.0, 5.0), crowd=lambda _: scene.crowd([(10.0, 7.0)]))
    # Error of the trapezoidal rule: dt^2/12 (d'(T) - d'(0)) / T, with d' = +-a/hypot(a, h), over R.
    error = 0.1**2 / 12 * 2 * (a / math.hypot(a, h)) / 8.0 / 5.0
    assert scene.judge(frames)["proximity"] == pytest.approx(1 - mean / 5, abs=1.01 * error)


def test_half_the_time_step_changes_proximity_to_second_order_only(scene: Any) -> None:
    def proximity(dt: float) -> float:
        crowd = scene.crowd([(10.0, 7.0)])
        frames = scene.drive(round(8 / dt), dt=dt, start=(6.0, 5.0), crowd=lambda _: crowd)
        return float(scene.judge(frames, dt=dt)["proximity"])

    coarse, middle, fine = proximity(0.4), proximity(0.2), proximity(0.1)
    assert (coarse - middle) / (middle - fine) == pytest.approx(4.0, rel=0.01)


def test_people_beyond_5_m_count_as_5_m_away(scene: Any) -> None:
    # For half of the states nobody is there at all, for half somebody is in the robot; the step between counts half.
    frames = scene.drive(21, speed=0.0, crowd=lambda t: scene.crowd([(0.0, 5.0)] if t > 1.05 else []))
    assert scene.judge(frames)["proximity"] == pytest.approx(0.5, rel=1e-12)


def test_the_nearest_person_may_be_across_the_seam(scene: Any) -> None:
    world = World(size=(50.0, 10.0), periodic=(True, False))
    frames = scene.drive(10, speed=0.0, start=(0.5, 5.0), crowd=lambda _: scene.crowd([(49.5, 5.0)]))
    assert scene.judge(frames, world=world)["proximity"] == pytest.approx(0.8, rel=1e-12)
    assert scene.judge(frames)["proximity"] == 0.0


@settings(max_examples=50, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(seed=st.integers(0, 2**32), people=st.integers(1, 20), steps=st.integers(1, 30), size=st.floats(1e-3, 1e3))
def test_shares_lie_between_0_and_1(scene: Any, seed: int, people: int, steps: int, size: float) -> None:
    rng = np.random.default_rng(seed)
    touched = {k: [{"duration": 0.1}] for k in range(1, steps + 1) if rng.random() < 0.9}
    frames = scene.drive(steps, crowd=lambda _: scene.crowd(rng.uniform(-size, size, (people, 2))), touches=touched)
    found = scene.judge(frames)
    assert 0.0 <= found["proximity"] <= 1.0
    assert 0.0 <= found["colliding"] <= 1.0
