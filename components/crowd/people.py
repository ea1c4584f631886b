"""Who walks there: preferred speeds, statures and masses of the people of one episode, drawn with the seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

STATURE = np.array([[1.759, 0.070], [1.618, 0.065]])
"""median and standard deviation of men's and women's body height [m]"""
BODY_MASS_INDEX = 25.0
"""median [kg/m2]; a choice between the mean of adults of the world, 24, and of richer countries, 26 to 28"""
BODY_MASS_SPREAD = 0.15
"""standard deviation of the logarithm of the body mass index: two of three adults within 21.5 and 29 kg/m2"""


@dataclass(frozen=True, kw_only=True)
class Bodies:
    """The bodies of N adults."""

    stature: Array
    """(N,) body height [m]"""
    mass: Array
    """(N,) body mass [kg]"""


def draw_bodies(rng: np.random.Generator, count: int) -> Bodies:
    """Adults, half of them men: normal statures, log-normal body mass indices."""
    median, deviation = STATURE[rng.integers(0, 2, count)].T
    stature = rng.normal(median, deviation)
    index = rng.lognormal(np.log(BODY_MASS_INDEX), BODY_MASS_SPREAD, count)
    return Bodies(stature=stature, mass=index * stature**2)


def draw_speeds(
    rng: np.random.Generator, count: int, mean: float, deviation: float, least: float, greatest: float
) -> Array:
    """(count,) preferred speeds [m/s]: normal, clipped to least..greatest, as the benchmark asks."""
    return np.clip(rng.normal(mean, deviation, count), least, greatest)
