"""Random numbers by key and counter follow their distributions, and depend on nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from scipy import stats

from components.sensors.random_numbers import bits, key_of, normal, uniform

N = 1_000_000


@njit
def draw(key, count, kind):
    numbers = np.empty(count)
    for k in range(count):
        numbers[k] = uniform(key, k) if kind == 0 else normal(key, k)
    return numbers


def test_the_bits_are_those_of_splitmix64():
    """First outputs of the reference implementation for the seed 1234567."""
    expected = [6457827717110365317, 3203168211198807973, 9817491932198370423, 4593380528125082431]
    assert [int(bits(np.uint64(1234567), k)) for k in range(4)] == expected


@pytest.mark.parametrize(("kind", "distribution"), [(0, stats.uniform()), (1, stats.norm())])
def test_a_million_numbers_follow_their_distribution(kind, distribution):
    numbers = draw(key_of(7), N, kind)
    # By chance, a p-value below 1e-4 comes once in 10,000 keys; this one is fixed.
    assert stats.kstest(numbers, distribution.cdf).pvalue > 1e-4
    assert abs(np.corrcoef(numbers[1:], numbers[:-1])[0, 1]) < 5 / np.sqrt(N)


def test_the_normal_distribution_has_its_tail():
    """Beyond the ziggurat's outermost edge, 3.654, there are 258 in a million."""
    numbers = np.abs(draw(key_of(11), 4 * N, 1))
    for edge in (3.0, 3.6541528853610088, 4.0, 4.5):
        expected = 8 * N * stats.norm.sf(edge)
        assert np.count_nonzero(numbers > edge) == pytest.approx(expected, abs=5 * np.sqrt(expected))


def test_streams_are_independent_of_each_other():
    streams = [draw(key_of(3, *stream), 100_000, 1) for stream in [(), (0,), (1,), (0, 0), (0, 1), (1, 0)]]
    correlations = np.corrcoef(streams) - np.eye(len(streams))
    assert np.all(np.abs(correlations) < 5 / np.sqrt(100_000))


def test_a_number_does_not_depend_on_what_is_drawn_before_it():
    key = key_of(5)
    forwards = [normal(key, k) for k in range(1000)]
    assert [normal(key, k) for k in reversed(range(1000))] == forwards[::-1]
