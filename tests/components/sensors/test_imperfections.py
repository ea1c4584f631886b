"""Each kind of error has the statistics of its formula, whatever the step size where that is meant."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.sensors.imperfections import (
    Bias,
    Chain,
    Drift,
    Dropout,
    Gaussian,
    MixedPixels,
    Quantisation,
    RangeDependent,
    Signal,
    Spikes,
    White,
)

SAMPLES = 200_000


def errors(kind, true, *, time=0, seed=1, signal=None):
    """What the kind does to readings that truly are `true`, (K, n)."""
    readings = np.array(true, np.float64)
    Chain([kind], signal or Signal(instruments=len(readings)), seed).apply(readings, time)
    with np.errstate(invalid="ignore"):  # inf - inf
        return readings - true


def assert_normal(sample, sigma):
    """Mean and deviation are within 5 standard errors."""
    assert abs(sample.mean()) < 5 * sigma / math.sqrt(sample.size)
    assert abs(sample.std() - sigma) < 5 * sigma / math.sqrt(2 * sample.size)


def test_gaussian():
    assert_normal(errors(Gaussian(kind="gaussian", deviation=0.02), np.full((1, SAMPLES), 3.0)), 0.02)


@pytest.mark.parametrize("r", [0.5, 3.0, 20.0])
def test_range_dependent(r):
    kind = RangeDependent(kind="range_dependent", deviation=0.01, per_metre=0.005, per_square_metre=0.002)
    assert_normal(errors(kind, np.full((1, SAMPLES), r)), 0.01 + 0.005 * r + 0.002 * r * r)


def test_bias_is_one_number_per_instrument_and_episode():
    kind = Bias(kind="bias", offset=0.5, deviation=0.1)
    chain = Chain([kind], Signal(instruments=20_000), 1)
    first, second = np.zeros((20_000, 3)), np.zeros((20_000, 3))
    chain.apply(first, 0)
    chain.apply(second, 100_000_000)
    assert (first == second).all() and (first == first[:, :1]).all()
    assert_normal(first[:, 0] - 0.5, 0.1)
    assert not np.array_equal(errors(kind, first * 0.0, seed=2), first)


@pytest.mark.parametrize("steps", [1, 10, 100])
@pytest.mark.parametrize("tau", [0.0, 3.0])
def test_drift_over_a_time_does_not_depend_on_the_number_of_steps(steps, tau):
    """After 5 s: density sqrt(5), or density sqrt(tau / 2 (1 - exp(-2 5 / tau)))."""
    walkers, density = 20_000, 0.3
    chain = Chain([Drift(kind="drift", density=density, correlation_time=tau)], Signal(instruments=walkers), 1)
    for k in range(steps + 1):
        readings = np.zeros((walkers, 1))
        chain.apply(readings, round(k * 5e9 / steps))
        assert k or not readings.any()
    expected = density * math.sqrt(0.5 * tau * (1 - math.exp(-10.0 / tau)) if tau else 5.0)
    assert_normal(readings, expected)


@pytest.mark.parametrize("steps", [1, 10, 100])
def test_the_integral_of_white_noise_does_not_depend_on_the_number_of_steps(steps):
    """Over 5 s: density sqrt(5)."""
    instruments, density = 20_000, 0.3
    chain = Chain([White(kind="white", density=density)], Signal(instruments=instruments, period=5 / steps), 1)
    integral = np.zeros((instruments, 1))
    for k in range(steps):
        readings = np.zeros((instruments, 1))
        chain.apply(readings, round(k * 5e9 / steps))
        integral += readings * 5 / steps
    assert_normal(integral, density * math.sqrt(5))


def test_spikes():
    spikes = errors(Spikes(kind="spikes", amplitude=0.6), np.full((1, SAMPLES), 3.0))
    hit = spikes != 0.0
    assert np.count_nonzero(hit) == pytest.approx(0.01 * SAMPLES, abs=5 * math.sqrt(0.01 * SAMPLES))
    assert np.abs(spikes).max() <= 0.6
    sigma = 0.6 / math.sqrt(3)  # of a uniform distribution
    assert abs(spikes[hit].mean()) < 5 * sigma / math.sqrt(hit.sum())
    assert spikes[hit].std() == pytest.approx(sigma, rel=0.1)


def test_quantisation_rounds_to_the_nearest_multiple():
    true = np.linspace(0.0, 2.0, SAMPLES)[None]
    error = errors(Quantisation(kind="quantisation", step=0.03), true)
    assert np.abs(error).max() <= 0.015 + 1e-12
    assert error.std() == pytest.approx(0.03 / math.sqrt(12), rel=1e-2)
    steps = (true + error) / 0.03
    np.testing.assert_allclose(steps, np.rint(steps), atol=1e-9)


def test_mixed_pixels_lie_between_the_surfaces_at_jumps_and_nowhere_else():
    """Surfaces of two samples each, at 1 and 3 m: one jump every second sample."""
    true = np.tile([1.0, 1.0, 3.0, 3.0], SAMPLES // 4)[None]
    error = errors(MixedPixels(kind="mixed_pixels"), true, signal=Signal(closed=True))
    mixed = error != 0.0
    jumps = SAMPLES / 2
    assert np.count_nonzero(mixed) == pytest.approx(0.3 * jumps, abs=5 * math.sqrt(0.3 * jumps))
    readings = (true + error)[mixed]
    assert ((readings > 1.0) & (readings < 3.0)).all()
    assert readings.mean() == pytest.approx(2.0, abs=5 * (2 / math.sqrt(12)) / math.sqrt(len(readings)))
    assert np.count_nonzero(mixed & (true == 1.0)) == pytest.approx(0.15 * jumps, abs=5 * math.sqrt(0.15 * jumps))


@pytest.mark.parametrize(
    "true",
    [[1.0, 1.09, 1.05, 1.0], [1.0, np.inf, 1.0, np.inf]],
    ids=["one surface", "nothing behind the surface"],
)
def test_nothing_mixes_where_there_are_not_two_surfaces(true):
    readings = np.array([true])
    Chain([MixedPixels(kind="mixed_pixels", probability=1.0)], Signal(closed=True), 1).apply(readings, 0)
    assert readings.tolist() == [true]


def test_the_last_sample_is_beside_the_first_only_in_a_closed_scan():
    kind = MixedPixels(kind="mixed_pixels", probability=1.0)
    true = np.array([[5.0] + [1.0] * 50 + [1.0]])
    open_scans = [errors(kind, true, time=t, signal=Signal()) for t in range(50)]
    closed_scans = [errors(kind, true, time=t, signal=Signal(closed=True)) for t in range(50)]
    assert not any(error[0, -1] for error in open_scans)
    assert any(error[0, -1] for error in closed_scans)


def test_dropout():
    error = errors(Dropout(kind="dropout", probability=0.02), np.full((1, SAMPLES), 3.0))
    assert set(error.ravel().tolist()) == {0.0, np.inf}
    assert np.count_nonzero(error) == pytest.approx(0.02 * SAMPLES, abs=5 * math.sqrt(0.02 * SAMPLES))


@pytest.mark.parametrize(
    "kind",
    [
        Gaussian(kind="gaussian", deviation=1.0),
        RangeDependent(kind="range_dependent", per_metre=0.1),
        Bias(kind="bias", offset=1.0),
        Spikes(kind="spikes", probability=1.0, amplitude=1.0),
        Quantisation(kind="quantisation", step=0.1),
    ],
    ids=lambda kind: kind.kind,
)
def test_no_measurement_stays_none(kind):
    readings = np.full((1, 100), np.inf)
    Chain([kind], Signal(), 1).apply(readings, 0)
    assert (readings == np.inf).all()


def test_kinds_apply_in_the_order_of_the_list():
    bias, steps = Bias(kind="bias", offset=0.4), Quantisation(kind="quantisation", step=1.0)
    for kinds, expected in (([bias, steps], 3.0), ([steps, bias], 2.4)):
        readings = np.array([[2.3]])
        Chain(kinds, Signal(), 1).apply(readings, 0)
        assert readings[0, 0] == pytest.approx(expected)


def test_errors_depend_on_seed_time_and_place_and_on_nothing_else():
    noise, true = Gaussian(kind="gaussian", deviation=1.0), np.zeros((1, 1000))
    alike = errors(noise, true, time=5, seed=3)
    np.testing.assert_array_equal(errors(noise, true, time=5, seed=3), alike)
    twice = np.zeros((1, 1000))
    Chain([noise, noise], Signal(), 3).apply(twice, 5)
    others = [errors(noise, true, time=6, seed=3), errors(noise, true, time=5, seed=4), twice - alike]
    for other in others:
        assert abs(np.corrcoef(other[0], alike[0])[0, 1]) < 5 / math.sqrt(1000)


@pytest.mark.parametrize(
    ("cls", "options"),
    [
        (Gaussian, {"kind": "gaussian", "deviation": -0.1}),
        (RangeDependent, {"kind": "range_dependent", "per_metre": math.nan}),
        (White, {"kind": "white", "density": -1.0}),
        (Bias, {"kind": "bias", "deviation": -1.0}),
        (Drift, {"kind": "drift", "density": 1.0, "correlation_time": -1.0}),
        (Spikes, {"kind": "spikes", "probability": 1.1, "amplitude": 1.0}),
        (Quantisation, {"kind": "quantisation", "step": 0.0}),
        (MixedPixels, {"kind": "mixed_pixels", "jump": -1.0}),
        (Dropout, {"kind": "dropout", "probability": -0.1}),
    ],
)
def test_options_without_meaning_are_refused(cls, options):
    with pytest.raises(ValueError, match=r"is .*, expected"):
        cls(**options)
