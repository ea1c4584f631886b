"""What is wrong with a sensor's readings: kinds of error that a scenario lists, each applied to what the last one left.

`r` is a reading and r' what becomes of it; N is the normal and U the uniform distribution. All errors are drawn by the
component's seed, the kind's place in the list, the time of the reading and the number of the sample, so that they do
not depend on threads, on who else draws, or on how often somebody looks. What is no measurement (infinite) stays so.
The kinds that concern the time of whole messages are in `components.sensors.timing`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.random_numbers import key_of, normal, uniform

Readings = NDArray[np.float64]
"""(K, n): K instruments, each with a bias of its own (a LiDAR is one, a gyroscope three), of n samples each"""
Stage = Callable[[Readings, int], None]
"""changes readings in place; they were taken at that time [ns]"""


class Signal(NamedTuple):
    """What a kind of error must know about the readings that it is applied to."""

    instruments: int = 1
    """K"""
    closed: bool = False
    """the last sample of an instrument is beside its first, as in a scan all around"""
    period: float = 0.0
    """between readings, nominally [s]"""


@dataclass(frozen=True, kw_only=True)
class Gaussian:
    """r' = r + N(0, deviation^2), anew for every sample."""

    kind: Literal["gaussian"]
    deviation: float
    """[unit of the reading]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "deviation")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        return lambda r, time: add_noise(r, key_of(key, time), self.deviation, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class RangeDependent:
    """r' = r + N(0, (deviation + per_metre r + per_square_metre r^2)^2), anew for every sample."""

    kind: Literal["range_dependent"]
    deviation: float = 0.0
    """at range 0 [m]"""
    per_metre: float = 0.0
    """grows with the range by [m/m]"""
    per_square_metre: float = 0.0
    """grows with the square of the range, as that of a stereo camera does, by [m/m2]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "deviation", "per_metre", "per_square_metre")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        return lambda r, time: add_noise(r, key_of(key, time), self.deviation, self.per_metre, self.per_square_metre)


@dataclass(frozen=True, kw_only=True)
class White:
    """r' = r + N(0, density^2 / T), T since the last reading: the integral over time does not depend on the rate."""

    kind: Literal["white"]
    density: float
    """[unit of the reading / sqrt(Hz)]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "density")

    def deviation(self, period: float) -> float:
        """Standard deviation of readings so far apart [s]."""
        return self.density / math.sqrt(period)

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        elapsed = _Elapsed(signal.period)

        def apply(r: Readings, time: int) -> None:
            add_noise(r, key_of(key, time), self.deviation(elapsed(time) or signal.period), 0.0, 0.0)

        return apply


@dataclass(frozen=True, kw_only=True)
class Bias:
    """r' = r + offset + N(0, deviation^2), drawn once per episode and instrument."""

    kind: Literal["bias"]
    offset: float = 0.0
    """[unit of the reading]"""
    deviation: float = 0.0
    """[unit of the reading]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "deviation")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        bias = np.full((signal.instruments, 1), self.offset)
        add_noise(bias, key, self.deviation, 0.0, 0.0)
        return lambda r, time: _add(r, bias)


@dataclass(frozen=True, kw_only=True)
class Drift:
    """r' = r + b, where b begins at 0 and walks at random: over the time T its variance grows by density^2 T.

    With a correlation time tau the walk is drawn back to 0, db = -b dt / tau + density dW (Gauss-Markov), and b's
    deviation tends to density sqrt(tau / 2). Both are exact for any T, so that steps of any size drift alike.
    """

    kind: Literal["drift"]
    density: float
    """[unit of the reading / sqrt(s)]"""
    correlation_time: float = 0.0
    """tau; 0: never drawn back [s]"""

    def __post_init__(self) -> None:
        require_not_negative(self, "density", "correlation_time")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        elapsed = _Elapsed(0.0)
        bias = np.zeros((signal.instruments, 1))

        def apply(r: Readings, time: int) -> None:
            seconds, tau = elapsed(time), self.correlation_time
            if tau > 0.0:
                bias[:] *= math.exp(-seconds / tau)
                seconds = -0.5 * tau * math.expm1(-2.0 * seconds / tau)
            add_noise(bias, key_of(key, time), self.density * math.sqrt(seconds), 0.0, 0.0)
            _add(r, bias)

        return apply


@dataclass(frozen=True, kw_only=True)
class Spikes:
    """r' = r + U(-amplitude, amplitude) for a sample in 1 / probability."""

    kind: Literal["spikes"]
    probability: float = 0.01
    """that of the simulator of "Crowd against the machine", if left out"""
    amplitude: float
    """[unit of the reading]"""

    def __post_init__(self) -> None:
        require_probability(self)
        require_not_negative(self, "amplitude")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        return lambda r, time: _add_spikes(r, key_of(key, time), self.probability, self.amplitude)


@dataclass(frozen=True, kw_only=True)
class Quantisation:
    """r' is the multiple of `step` that is nearest to r."""

    kind: Literal["quantisation"]
    step: float
    """[unit of the reading]"""

    def __post_init__(self) -> None:
        if not self.step > 0.0:
            raise ValueError(f"step is {self.step}, expected a positive number")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        def apply(r: Readings, time: int) -> None:
            np.multiply(np.rint(r / self.step), self.step, out=r)

        return apply


@dataclass(frozen=True, kw_only=True)
class MixedPixels:
    """Where neighbouring samples jump, one of the two, by lot, may be U(r_k, r_k+1): it sees both surfaces.

    Two neighbours jump if they differ by more than `jump`; then it happens with `probability`. Of a surface and nothing
    behind it, only the surface returns an echo, so that nothing mixes.
    """

    kind: Literal["mixed_pixels"]
    probability: float = 0.3
    """per jump"""
    jump: float = 0.1
    """least difference between two surfaces [m]"""

    def __post_init__(self) -> None:
        require_probability(self)
        require_not_negative(self, "jump")

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        return lambda r, time: _mix(r, key_of(key, time), self.probability, self.jump, signal.closed)


@dataclass(frozen=True, kw_only=True)
class Dropout:
    """A sample in 1 / probability is lost: no echo, infinite."""

    kind: Literal["dropout"]
    probability: float

    def __post_init__(self) -> None:
        require_probability(self)

    def begin(self, key: np.uint64, signal: Signal) -> Stage:
        return lambda r, time: _drop(r, key_of(key, time), self.probability)


class Chain:
    """The errors of one signal at work during an episode, in the order of the list."""

    def __init__(self, kinds: Iterable[object], signal: Signal, seed: int, *stream: int) -> None:
        """Begin with each kind that has a method `begin(key, signal)`, which those of `components.sensors.timing` lack.

        `stream` tells apart the signals of one sensor.
        """
        self._stages = [
            kind.begin(key_of(seed, *stream, place), signal)
            for place, kind in enumerate(kinds)
            if hasattr(kind, "begin")
        ]

    def __bool__(self) -> bool:
        """False if it changes nothing."""
        return bool(self._stages)

    def apply(self, readings: Readings, time: int) -> None:
        """Change readings (K, n) in place; `time`: when they were taken [ns]."""
        for stage in self._stages:
            stage(readings, time)


class _Elapsed:
    """Time since it was last asked [s]."""

    def __init__(self, first: float) -> None:
        self._answer = first
        self._last: int | None = None

    def __call__(self, time: int) -> float:
        if self._last is not None:
            self._answer = (time - self._last) * 1e-9
        self._last = time
        return self._answer


def require_not_negative(kind: object, *names: str) -> None:
    """Raise ValueError unless these attributes are zero or more."""
    for name in names:
        if not getattr(kind, name) >= 0.0:
            raise ValueError(f"{name} is {getattr(kind, name)}, expected zero or more")


def require_probability(kind: object, name: str = "probability") -> None:
    """Raise ValueError unless the attribute is a probability."""
    if not 0.0 <= getattr(kind, name) <= 1.0:
        raise ValueError(f"{name} is {getattr(kind, name)}, expected from 0 to 1")


@njit(cache=True, nogil=True)
def add_noise(readings: Readings, key: np.uint64, constant: float, linear: float, square: float) -> None:
    """Add N(0, (constant + linear r + square r^2)^2) to each reading r of (K, n), in place."""
    flat = readings.reshape(-1)
    for k in range(len(flat)):
        r = flat[k]
        if math.isfinite(r):
            flat[k] = r + (constant + r * (linear + r * square)) * normal(key, k)


@njit(cache=True, nogil=True)
def _add(readings: Readings, bias: Readings) -> None:
    for i in range(len(readings)):
        for k in range(readings.shape[1]):
            readings[i, k] += bias[i, 0]


@njit(cache=True, nogil=True)
def _add_spikes(readings: Readings, key: np.uint64, probability: float, amplitude: float) -> None:
    flat = readings.reshape(-1)
    for k in range(len(flat)):
        if uniform(key, 2 * k) < probability:
            flat[k] += amplitude * (2.0 * uniform(key, 2 * k + 1) - 1.0)


@njit(cache=True, nogil=True)
def _mix(readings: Readings, key: np.uint64, probability: float, jump: float, closed: bool) -> None:
    count = readings.shape[1]
    for i in range(len(readings)):
        first = previous = readings[i, 0]
        for k in range(count if closed else count - 1):
            here, after = previous, first if k + 1 == count else readings[i, k + 1]
            previous = after  # as measured, whatever becomes of it
            counter = 3 * (i * count + k)
            if not (math.isfinite(here) and math.isfinite(after)) or abs(after - here) <= jump:
                continue
            if uniform(key, counter) < probability:
                which = k if uniform(key, counter + 1) < 0.5 else (k + 1) % count
                readings[i, which] = here + uniform(key, counter + 2) * (after - here)


@njit(cache=True, nogil=True)
def _drop(readings: Readings, key: np.uint64, probability: float) -> None:
    flat = readings.reshape(-1)
    for k in range(len(flat)):
        if uniform(key, k) < probability:
            flat[k] = np.inf
