"""When a sensor reads, and when its messages arrive: rate, rate jitter, latency, and messages that never come.

Reading n is due at t_n = n / rate + N(0, jitter^2), reading 0 at the start. It is taken at the first step at or after
t_n, bears the time of that step, and at most one is taken per step. It arrives at N(delay, deviation^2) after that, not
before it was taken and not before an earlier reading, and is published at the first step at or after its arrival;
between arrivals the last message is repeated, with the time at which it was taken. Reading 0 is there from the start.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Annotated, Generic, Literal, TypeVar

from pydantic import Field

from components.sensors.imperfections import (
    Bias,
    Drift,
    Dropout,
    Gaussian,
    MixedPixels,
    Quantisation,
    RangeDependent,
    Spikes,
    require_not_negative,
    require_probability,
)
from components.sensors.random_numbers import key_of, normal, uniform
from crowdcosim.setup import Setup

T = TypeVar("T")

# Streams of random numbers, beside those of a sensor's signals.
_JITTER, _LATENCY, _LOSS = 101, 102, 103


@dataclass(frozen=True, kw_only=True)
class Latency:
    """Messages arrive N(delay, deviation^2) after they were taken, in their order."""

    kind: Literal["latency"]
    delay: float
    """[s]"""
    deviation: float = 0.0
    """[s]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "delay", "deviation")


@dataclass(frozen=True, kw_only=True)
class RateJitter:
    """Readings are due N(0, deviation^2) before or after their regular times."""

    kind: Literal["rate_jitter"]
    deviation: float
    """[s]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "deviation")


@dataclass(frozen=True, kw_only=True)
class MessageLoss:
    """A message in 1 / probability never arrives."""

    kind: Literal["message_loss"]
    probability: float

    def __post_init__(self) -> None:
        require_probability(self)


TimingKind = Annotated[Latency | RateJitter | MessageLoss, Field(discriminator="kind")]
BeamKind = Annotated[
    Gaussian
    | RangeDependent
    | Bias
    | Drift
    | Spikes
    | Quantisation
    | MixedPixels
    | Dropout
    | Latency
    | RateJitter
    | MessageLoss,
    Field(discriminator="kind"),
]
"""what may be wrong with readings that have neighbours, the beams of a scan or the pixels of a depth image"""


def require_rate(config: object) -> None:
    """Raise ValueError unless the attribute `rate` is None or positive."""
    rate = getattr(config, "rate", None)
    if rate is not None and not rate > 0.0:
        raise ValueError(f"rate is {rate}, expected a positive number")


class Delivery(Generic[T]):
    """The messages of one sensor during an episode."""

    def __init__(self, kinds: Iterable[object], rate: float | None, setup: Setup) -> None:
        """`kinds` may hold others, as of `components.sensors.imperfections`; `rate` None: a reading per step [Hz]."""
        timing = [kind for kind in kinds if isinstance(kind, Latency | RateJitter | MessageLoss)]
        self._latencies = [kind for kind in timing if isinstance(kind, Latency)]
        self._jitters = [kind for kind in timing if isinstance(kind, RateJitter)]
        self._losses = [kind for kind in timing if isinstance(kind, MessageLoss)]
        self._plain = not timing and rate is None
        self.period = setup.dt if rate is None else 1.0 / rate
        """between readings, nominally [s]"""
        self._interval = setup.period if rate is None else 1e9 / rate
        self._seed = setup.seed
        self._due = 0
        self._taken = 0
        self._underway: deque[tuple[float, T]] = deque()
        self._last_arrival = 0.0
        self._delivered: T | None = None

    def step(self, time: int, take: Callable[[], T]) -> T:
        """The message to publish at `time` [ns]; `take` makes a new one if a reading is due."""
        if self._plain:
            return take()
        if self._is_due(time):
            self._send(time, take())
        while self._underway and self._underway[0][0] <= time:
            self._delivered = self._underway.popleft()[1]
        assert self._delivered is not None
        return self._delivered

    def _is_due(self, time: int) -> bool:
        """True if at least one reading has become due; those after it count from the next step on."""
        before = self._due
        while self._time_of(self._due) <= time:
            self._due += 1
        return self._due > before

    def _time_of(self, number: int) -> float:
        time = number * self._interval
        if number > 0:
            for place, jitter in enumerate(self._jitters):
                time += 1e9 * jitter.deviation * normal(key_of(self._seed, _JITTER, place), number)
        return round(time)

    def _send(self, time: int, message: T) -> None:
        number, self._taken = self._taken, self._taken + 1
        if number == 0:
            self._delivered = message
            return
        if any(
            uniform(key_of(self._seed, _LOSS, place), number) < loss.probability
            for place, loss in enumerate(self._losses)
        ):
            return
        arrival = float(time)
        for place, latency in enumerate(self._latencies):
            delay = latency.delay + latency.deviation * normal(key_of(self._seed, _LATENCY, place), number)
            arrival += 1e9 * max(delay, 0.0)
        self._last_arrival = max(round(arrival), self._last_arrival)
        self._underway.append((self._last_arrival, message))
