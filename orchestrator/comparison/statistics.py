"""Means with confidence intervals, and paired tests over scenarios."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Floats = NDArray[np.float64]

CONFIDENCE = 0.95
RESAMPLES = 2000


@dataclass(frozen=True, kw_only=True)
class Summary:
    """A metric over the episodes of a controller."""

    count: int
    """episodes that have a value"""
    mean: float
    deviation: float
    """standard deviation of the sample, 0 of one value"""
    low: float
    """of the confidence interval of the mean"""
    high: float


@dataclass(frozen=True, kw_only=True)
class Difference:
    """A metric of one controller minus that of another, scenario by scenario."""

    count: int
    """scenarios in which both have a value"""
    mean: float
    low: float
    """of the confidence interval of the mean"""
    high: float
    p: float
    """of Wilcoxon's signed-rank test, two-sided; 1 if all differences are 0"""


def summary(values: Floats) -> Summary | None:
    """Mean, deviation and interval of a sample (n,); None of nothing."""
    if not len(values):
        return None
    low, high = interval(values)
    deviation = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Summary(count=len(values), mean=float(values.mean()), deviation=deviation, low=low, high=high)


def difference(first: Floats, second: Floats) -> Difference | None:
    """First minus second, paired (n,); None with fewer than two pairs."""
    if len(first) < 2:
        return None
    d = first - second
    low, high = interval(d)
    p = float(stats.wilcoxon(first, second).pvalue) if np.any(d != 0) else 1.0
    return Difference(count=len(d), mean=float(d.mean()), low=low, high=high, p=p)


def interval(values: Floats) -> tuple[float, float]:
    """Confidence interval of the mean of a sample (n,) by the percentile bootstrap, the same every time.

    Efron and Tibshirani 1993, "An introduction to the bootstrap", chapter 13.
    """
    if len(values) < 2 or np.all(values == values[0]):
        return float(values[0]), float(values[0])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = stats.bootstrap(
            (values,),
            np.mean,
            n_resamples=RESAMPLES,
            confidence_level=CONFIDENCE,
            method="percentile",
            rng=np.random.default_rng(0),
        )
    return float(found.confidence_interval.low), float(found.confidence_interval.high)


def holm(p: list[float]) -> list[float]:
    """p values of several tests, adjusted so that one of them is falsely found in 1 of 20 cases at most.

    Holm 1979, "A simple sequentially rejective multiple test procedure".
    """
    order = np.argsort(p, kind="stable")
    adjusted, worst = [0.0] * len(p), 0.0
    for rank, i in enumerate(order.tolist()):
        worst = max(worst, min(1.0, (len(p) - rank) * p[i]))
        adjusted[i] = worst
    return adjusted


def likeness(first: Floats, second: Floats) -> float:
    """Kolmogorov-Smirnov distance of two samples: 0 alike, 1 apart."""
    return float(stats.ks_2samp(first, second).statistic)
