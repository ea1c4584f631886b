"""Random numbers by key and counter: the same in whatever order, and on however many threads, they are drawn.

The bits of (key, counter) are those of SplitMix64 (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
generators", figure 2) at the state key + counter * gamma. The normal distribution is the ziggurat of Marsaglia and
Tsang 2000 with 256 layers, exact in its tail too; what a rejection needs beyond the first 64 bits is drawn from these.
Differs from the papers: the ziggurat takes its layer, sign and position from separate bits (Doornik 2005).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_GAMMA = np.uint64(0x9E3779B97F4A7C15)
_MIX_1, _MIX_2 = np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB)
_30, _27, _31, _11, _8, _1 = (np.uint64(n) for n in (30, 27, 31, 11, 8, 1))
_LAYER = np.uint64(255)
_TO_UNIT = 2.0**-53

# The ziggurat's outermost edge and the area of each layer (Marsaglia and Tsang 2000, section 2).
_EDGE, _AREA = 3.6541528853610088, 0.00492867323399


def _layers() -> tuple[np.ndarray, np.ndarray]:
    """(257,) right edges of the layers, from the base, and the density there."""
    x = np.zeros(257)
    x[0], x[1] = _AREA * math.exp(0.5 * _EDGE**2), _EDGE
    for i in range(2, 256):
        x[i] = math.sqrt(-2.0 * math.log(_AREA / x[i - 1] + math.exp(-0.5 * x[i - 1] ** 2)))
    return x, np.exp(-0.5 * x**2)


_X, _DENSITY = _layers()


@njit(cache=True, nogil=True)
def bits(key: np.uint64, counter: int) -> np.uint64:
    """64 random bits."""
    z = key + (np.uint64(counter) + _1) * _GAMMA
    z = (z ^ (z >> _30)) * _MIX_1
    z = (z ^ (z >> _27)) * _MIX_2
    return z ^ (z >> _31)


@njit(cache=True, nogil=True)
def uniform(key: np.uint64, counter: int) -> float:
    """Uniform in [0, 1)."""
    return float(bits(key, counter) >> _11) * _TO_UNIT


@njit(cache=True, nogil=True)
def normal(key: np.uint64, counter: int) -> float:
    """Standard normal."""
    while True:
        drawn = bits(key, counter)
        layer = int(drawn & _LAYER)
        sign = 1.0 - 2.0 * float((drawn >> _8) & _1)
        x = float(drawn >> _11) * _TO_UNIT * _X[layer]
        if x < _X[layer + 1]:
            return sign * x
        if layer == 0:
            return sign * _tail(drawn)
        low, high = _DENSITY[layer], _DENSITY[layer + 1]
        if low + uniform(drawn, 0) * (high - low) < math.exp(-0.5 * x * x):
            return sign * x
        key, counter = drawn, 1


@njit(cache=True, nogil=True)
def _tail(key: np.uint64) -> float:
    """Normal beyond the outermost edge (Marsaglia 1964)."""
    counter = 0
    while True:
        x = -math.log(1.0 - uniform(key, counter)) / _EDGE
        if -2.0 * math.log(1.0 - uniform(key, counter + 1)) > x * x:
            return _EDGE + x
        counter += 2


def key_of(seed: int, *stream: int) -> np.uint64:
    """The key of one stream of random numbers; other numbers give independent ones."""
    key = np.uint64(seed)
    for number in stream:
        key = np.uint64(bits(key, number))
    return key
