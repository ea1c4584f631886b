"""How a property of people is distributed: one value for all, one for each, a range, or a bell."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from statistics import NormalDist
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Discriminator, Tag

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Bell:
    """A normal distribution."""

    mean: float
    """in the unit of what is drawn"""
    deviation: float
    """standard deviation, in the same unit"""
    limits: tuple[float, float]
    """smaller and greater draws are set to these"""

    def __post_init__(self) -> None:
        if not self.deviation >= 0:
            raise ValueError(f"deviation is {self.deviation}, expected zero or a positive number")
        low, high = self.limits
        if not low <= self.mean <= high:
            raise ValueError(f"mean is {self.mean}, expected within limits ({low} to {high}), in ascending order")


@dataclass(frozen=True, kw_only=True)
class Normal:
    """Drawn from a bell: `{normal: {mean: 1.3, deviation: 0.2, limits: [0.8, 1.8]}}`."""

    normal: Bell
    """which one"""


@dataclass(frozen=True, kw_only=True)
class Uniform:
    """Drawn from a range: `{uniform: [0.8, 1.8]}`."""

    uniform: tuple[float, float]
    """least and greatest value"""

    def __post_init__(self) -> None:
        low, high = self.uniform
        if not low <= high:
            raise ValueError(f"uniform is {list(self.uniform)}, expected two numbers in ascending order")


def _form(value: Any) -> str | None:
    """Which of the forms somebody means, from what they wrote; None if it is none."""
    if isinstance(value, list | tuple):
        return "list"
    if isinstance(value, Mapping):
        return next((key for key in ("normal", "uniform") if key in value), None)
    return type(value).__name__.lower() if isinstance(value, Normal | Uniform) else "number"


Distribution = Annotated[
    Annotated[float, Tag("number")]
    | Annotated[tuple[float, ...], Tag("list")]
    | Annotated[Normal, Tag("normal")]
    | Annotated[Uniform, Tag("uniform")],
    Discriminator(
        _form,
        custom_error_type="distribution",
        custom_error_message="expected a number, a list with one for each person, `normal: ...` or `uniform: ...`",
    ),
]
"""a number for all, a list with one for each, or how to draw them"""


def bounds(distribution: Distribution) -> tuple[float, float]:
    """Nothing drawn is less or greater."""
    if isinstance(distribution, Normal):
        return distribution.normal.limits
    if isinstance(distribution, Uniform):
        return distribution.uniform
    if isinstance(distribution, tuple):
        return min(distribution), max(distribution)
    return distribution, distribution


def quantile(distribution: Normal | Uniform, share: float) -> float:
    """The value that is greater than a share of those drawn."""
    if isinstance(distribution, Uniform):
        low, high = distribution.uniform
        return low + (high - low) * share
    bell = distribution.normal
    low, high = bell.limits
    return min(max(bell.mean + bell.deviation * NormalDist().inv_cdf(share), low), high)


def require_positive(name: str, distribution: Distribution) -> None:
    """Refuse what is, or may be drawn as, zero, negative or not finite.

    Raises:
        ValueError: that begins with the name.
    """
    if distribution == ():
        raise ValueError(f"{name} is an empty list, expected a number for each person")
    low, high = bounds(distribution)
    if not (low > 0 and math.isfinite(high)):
        worst = high if low > 0 else low
        found = f"is {worst}" if isinstance(distribution, float | int) else f"may be {worst}"
        raise ValueError(f"{name} {found}, expected a positive number")


def draw(distribution: Distribution, rng: np.random.Generator, count: int, who: NDArray[np.int64]) -> Array:
    """Values of those of `count` people whose indices are in `who`.

    Everybody draws from `rng` whoever is asked for, so that people keep their luck when populations change.

    Raises:
        ValueError: if a list has not one value for each of them.
    """
    if isinstance(distribution, Normal):
        bell = distribution.normal
        return np.asarray(np.clip(rng.normal(bell.mean, bell.deviation, count), *bell.limits)[who])
    if isinstance(distribution, Uniform):
        return np.asarray(rng.uniform(*distribution.uniform, count)[who])
    if isinstance(distribution, tuple):
        if len(distribution) != len(who):
            raise ValueError(f"a list of {len(distribution)} values, expected one for each of {len(who)} people")
        return np.array(distribution, np.float64)
    return np.full(len(who), distribution, np.float64)
