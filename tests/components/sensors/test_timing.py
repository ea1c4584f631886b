"""Readings are taken at their rate and arrive after their latency, in order."""

from __future__ import annotations

import numpy as np
import pytest

from components.sensors.timing import Delivery, Latency, MessageLoss, RateJitter
from crowdcosim.setup import Setup
from crowdcosim.world import World


@pytest.fixture
def published():
    """When what is published at each step was taken [s]; the message is the time itself."""

    def run(*kinds, rate=None, dt=0.1, steps=20, seed=1):
        period = round(dt * 1e9)
        setup = Setup(component="robot/sensor", period=period, seed=seed, world=World(size=(1.0, 1.0)))
        delivery = Delivery(kinds, rate, setup)
        times = []
        for k in range(steps):
            now = k * period
            times.append(delivery.step(now, lambda now=now: now) * 1e-9)
        return np.array(times)

    return run


def test_without_timing_every_step_is_told_at_once(published):
    np.testing.assert_allclose(published(), 0.1 * np.arange(20))


@pytest.mark.parametrize(
    ("rate", "dt", "expected"),
    [
        (5.0, 0.1, [0.0, 0.0, 0.2, 0.2, 0.4, 0.4, 0.6]),
        (40.0, 0.1, [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6]),
        # Due at 0.16, 0.32, 0.48 s: taken at the first step that is not before.
        (6.25, 0.1, [0.0, 0.0, 0.2, 0.2, 0.4, 0.5, 0.5]),
    ],
)
def test_readings_come_at_their_rate_but_at_most_one_per_step(published, rate, dt, expected):
    np.testing.assert_allclose(published(rate=rate, dt=dt, steps=7), expected)


@pytest.mark.parametrize("dt", [0.01, 0.02, 0.1])
def test_the_mean_rate_does_not_depend_on_the_step(published, dt):
    times = np.unique(published(rate=6.25, dt=dt, steps=round(16 / dt)))
    assert len(times) == 100


@pytest.mark.parametrize(
    ("delay", "expected"),
    [
        (0.0, [0.0, 0.1, 0.2, 0.3]),
        (0.1, [0.0, 0.0, 0.1, 0.2]),
        (0.15, [0.0, 0.0, 0.0, 0.1]),
        (0.3, [0.0, 0.0, 0.0, 0.0]),
    ],
)
def test_latency_holds_the_last_message_until_the_next_arrives(published, delay, expected):
    np.testing.assert_allclose(published(Latency(kind="latency", delay=delay), steps=4), expected)


def test_the_mean_age_of_messages_is_the_latency(published):
    times = published(Latency(kind="latency", delay=0.2, deviation=0.03), dt=0.005, steps=20_000)
    age = 0.005 * np.arange(20_000) - times
    # Nobody overtakes: with messages every 5 ms and 30 ms of deviation the age is that of the latest of several.
    assert np.all(np.diff(times) >= 0.0)
    assert 0.2 < age[100:].mean() < 0.2 + 3 * 0.03
    regular = published(Latency(kind="latency", delay=0.2, deviation=0.03), dt=0.005, rate=2.0, steps=20_000)
    arrivals = 0.005 * (1 + np.flatnonzero(np.diff(regular) > 0.0)) - regular[1:][np.diff(regular) > 0.0]
    assert arrivals.mean() == pytest.approx(0.2 + 0.0025, abs=5 * 0.03 / np.sqrt(len(arrivals)))
    assert arrivals.std() == pytest.approx(0.03, rel=0.3)


def test_jitter_moves_readings_about_their_regular_times(published):
    times = np.unique(published(RateJitter(kind="rate_jitter", deviation=0.02), rate=5.0, dt=0.001, steps=100_000))
    offsets = times - 0.2 * np.arange(len(times))
    assert len(times) == pytest.approx(500, abs=1)
    assert offsets.mean() == pytest.approx(0.0005, abs=5 * 0.02 / np.sqrt(500))
    assert offsets.std() == pytest.approx(0.02, rel=0.2)


def test_lost_messages_never_arrive(published):
    times = np.unique(published(MessageLoss(kind="message_loss", probability=0.3), steps=10_000))
    assert len(times) == pytest.approx(7000, abs=5 * np.sqrt(10_000 * 0.3 * 0.7))
    assert times[0] == 0.0


def test_the_first_reading_is_there_from_the_start_whatever_happens(published):
    times = published(Latency(kind="latency", delay=60.0), MessageLoss(kind="message_loss", probability=1.0))
    assert not times.any()


def test_the_same_seed_gives_the_same_times(published):
    kinds = (
        RateJitter(kind="rate_jitter", deviation=0.05),
        Latency(kind="latency", delay=0.1, deviation=0.1),
        MessageLoss(kind="message_loss", probability=0.2),
    )
    np.testing.assert_array_equal(published(*kinds, steps=500), published(*kinds, steps=500))
    assert not np.array_equal(published(*kinds, steps=500), published(*kinds, steps=500, seed=2))


@pytest.mark.parametrize(
    ("cls", "options"),
    [
        (Latency, {"kind": "latency", "delay": -0.1}),
        (RateJitter, {"kind": "rate_jitter", "deviation": -0.1}),
        (MessageLoss, {"kind": "message_loss", "probability": 2.0}),
    ],
)
def test_options_without_meaning_are_refused(cls, options):
    with pytest.raises(ValueError, match=r"is .*, expected"):
        cls(**options)
