"""The phase of the walk: published figures, limits."""

import numpy as np
import pytest

from components.crowd.gait import walk
from crowdcosim.gait import AT_REST, LONGEST_CYCLE, phase_rate


def step(velocity, heading, pace, phase, dt=0.1):
    columns = (np.asarray(x, np.float64) for x in (velocity, heading, pace, phase))
    return walk(*columns, np.full(len(velocity), 1.75), dt)


def test_a_cycle_of_somebody_of_average_height_takes_what_was_published():
    # H = 1.75 m, v = 1.34 m/s: stride 1.50 m, period 1.12 s, 107 steps per minute (given to three digits).
    rate = phase_rate(1.34, 1.75)
    assert 1 / rate == pytest.approx(1.12, abs=5e-3)
    assert 1.34 / rate == pytest.approx(1.50, abs=5e-3)
    assert 2 * 60 * rate == pytest.approx(107, abs=0.5)


def test_in_a_jam_steps_get_short_and_not_slow():
    assert phase_rate(0.2, 1.75) == phase_rate(0.4, 1.75) == 1 / LONGEST_CYCLE


def test_whoever_is_at_rest_neither_steps_nor_turns():
    heading, pace, phase = step([(0.0, 0.5 * AT_REST)], [2.0], [0.0], [0.3])
    assert heading == [2.0]
    assert phase == [0.3]
    assert pace < AT_REST


def test_the_body_faces_the_way_it_goes():
    heading, _, _ = step([(0.0, -1.0), (-1.0, 0.0)], [0.0, 0.0], [1.0, 1.0], [0.0, 0.0])
    assert heading == pytest.approx([-np.pi / 2, np.pi])


def test_the_phase_stays_below_one_and_covers_the_distance_walked():
    heading, pace, phase = np.zeros(1), np.full(1, 1.34), np.zeros(1)
    cycles = 0.0
    for _ in range(100):
        before = phase
        heading, pace, phase = walk(np.array([[1.34, 0.0]]), heading, pace, phase, np.array([1.75]), 0.1)
        assert 0 <= phase < 1
        cycles += (phase - before)[0] % 1.0
    assert cycles == pytest.approx(10 * phase_rate(1.34, 1.75), abs=1e-12)


def test_the_pace_follows_the_speed_whatever_the_time_step():
    _, coarse, _ = step([(1.0, 0.0)], [0.0], [0.0], [0.0], dt=0.2)
    _, half, _ = step([(1.0, 0.0)], [0.0], [0.0], [0.0], dt=0.1)
    _, fine, _ = step([(1.0, 0.0)], [0.0], half, [0.0], dt=0.1)
    assert coarse == pytest.approx(fine, abs=1e-15)
