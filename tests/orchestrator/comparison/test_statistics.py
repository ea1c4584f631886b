"""Means, intervals and tests against closed forms and published values."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.comparison.statistics import difference, holm, interval, likeness, summary


def test_mean_and_deviation_are_those_of_a_sample() -> None:
    found = summary(np.array([1.0, 2.0, 3.0, 4.0]))
    assert found is not None
    assert (found.count, found.mean) == (4, 2.5)
    assert found.deviation == pytest.approx((5 / 3) ** 0.5)
    assert found.low < 2.5 < found.high


def test_nothing_and_one_value() -> None:
    assert summary(np.empty(0)) is None
    one = summary(np.array([0.7]))
    assert one is not None
    assert (one.deviation, one.low, one.high) == (0.0, 0.7, 0.7)


def test_the_interval_of_a_large_normal_sample_is_that_of_the_normal_distribution() -> None:
    values = np.random.default_rng(3).normal(5.0, 2.0, 400)
    error = values.std() / np.sqrt(400)
    # 2000 resamples know a 2.5% quantile to about 0.06 standard errors; 4 times that.
    assert interval(values) == pytest.approx(
        (values.mean() - 1.96 * error, values.mean() + 1.96 * error), abs=0.24 * error
    )


def test_the_same_sample_has_the_same_interval() -> None:
    values = np.random.default_rng(3).random(20)
    assert interval(values) == interval(values)


def test_a_shift_of_every_scenario_is_found_and_no_shift_is_not() -> None:
    base = np.random.default_rng(4).random(30)
    shifted = difference(base + 0.1, base)
    assert shifted is not None
    assert (shifted.mean, shifted.low, shifted.high) == pytest.approx((0.1, 0.1, 0.1))
    assert shifted.p < 1e-4
    same = difference(base, base)
    assert same is not None
    assert (same.mean, same.p) == (0.0, 1.0)


def test_wilcoxon_of_all_positive_small_samples_is_exact() -> None:
    # All n differences of one sign and different size: p = 2 / 2^n.
    found = difference(np.array([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]), np.zeros(6))
    assert found is not None
    assert found.p == pytest.approx(2 / 2**6)


def test_one_pair_proves_nothing() -> None:
    assert difference(np.array([1.0]), np.array([2.0])) is None


def test_holm_multiplies_the_least_by_the_number_of_tests() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert holm([0.9, 0.8]) == [1.0, 1.0]
    assert holm([]) == []


def test_likeness_is_the_largest_gap_between_the_distributions() -> None:
    assert likeness(np.array([1.0, 2.0]), np.array([1.0, 2.0])) == 0.0
    assert likeness(np.array([1.0, 2.0]), np.array([3.0, 4.0])) == 1.0
    assert likeness(np.array([1.0, 2.0, 3.0, 4.0]), np.array([3.0, 4.0])) == 0.5
