"""What the paper claims of its three controllers, held against a sweep: it holds or it does not, with the numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np

from orchestrator.comparison.data import Comparison
from orchestrator.comparison.statistics import likeness

B, D, R = "baseline", "dwa", "rvo"
NAMES = {B: "Baseline", D: "DWA", R: "RVO"}

EQUAL = 0.005
"""values this near to 1 count as 1: what two or three printed digits cannot tell"""
MUCH = 0.1
""""much slower": T/Tcr is lower by at least this"""
NO_COLLISION = 0.95
"""Colliding is "about 1" from here"""
SAME = 0.05
""""hardly depends": the controllers' means are within this"""
ALIKE = 0.15
"""energy distributions look alike up to this Kolmogorov-Smirnov distance"""


@dataclass(frozen=True, kw_only=True)
class Finding:
    """One statement of the paper, and what became of it."""

    number: int
    """of the claim in docs/benchmark.md"""
    text: str
    holds: bool
    numbers: str


def judgeable(comparison: Comparison) -> bool:
    """True if the sweep has the paper's three controllers and scenarios at several densities."""
    return comparison.crossed and {B, D, R} <= set(comparison.controllers)


def findings(comparison: Comparison) -> list[Finding]:
    """Every claim's statements, in their order."""
    claims = (_path, _variation, _time, _colliding, _neighbours, _proximity, _collisions)
    return [finding for claim in claims for finding in claim(comparison)]


def _path(c: Comparison) -> Iterator[Finding]:
    for where, part in _densities(c):
        mean = _means(part, "path_length_ratio")
        straight = abs(mean[B] - 1) <= EQUAL
        yield Finding(number=1, text=f"L/Lcr of Baseline is 1 {where}", holds=straight, numbers=f"{mean[B]:.3f}")
        yield _order(1, "L/Lcr", where, mean, (B, R, D))


def _variation(c: Comparison) -> Iterator[Finding]:
    for where, part in _densities(c):
        mean = _means(part, "velocity_variation_ratio")
        text = f"J/Jcr: DWA varies its speed least, relative to the robot alone, {where}"
        yield Finding(number=2, text=text, holds=mean[D] > max(mean[B], mean[R]), numbers=_listed(mean))
        absolute = _means(part, "velocity_variation")
        text = f"the same in absolute terms, J [m/s], {where}"
        yield Finding(number=2, text=text, holds=absolute[D] < min(absolute[B], absolute[R]), numbers=_listed(absolute))


def _time(c: Comparison) -> Iterator[Finding]:
    low, high = _means(c.low, "time_ratio"), _means(c.high, "time_ratio")
    for where, part in _densities(c):
        mean = _means(part, "time_ratio")
        text = f"T/Tcr: Baseline is the fastest {where}"
        yield Finding(number=3, text=text, holds=mean[B] > max(mean[R], mean[D]), numbers=_listed(mean))
    for name in (R, D):
        text = f"{NAMES[name]} is much slower at the highest density than at the lowest"
        numbers = f"T/Tcr {high[name]:.3f} against {low[name]:.3f}"
        yield Finding(number=3, text=text, holds=low[name] - high[name] >= MUCH, numbers=numbers)


def _colliding(c: Comparison) -> Iterator[Finding]:
    low, every = _means(c.low, "colliding"), _means(c, "colliding")
    text = "Colliding is about 1 for all at low density"
    yield Finding(number=4, text=text, holds=min(low.values()) >= NO_COLLISION, numbers=_listed(low))
    text = "Baseline has the lowest Colliding over all densities"
    yield Finding(number=4, text=text, holds=every[B] < min(every[D], every[R]), numbers=_listed(every))
    yield _order(4, "Colliding", "over all densities", every, (R, D))


def _neighbours(c: Comparison) -> Iterator[Finding]:
    turn, slow = _means(c.high, "neighbour_reaction"), _means(c.high, "neighbour_velocity")
    text = "at the highest density people near the robot turn rather than slow down (NBR reac. < NBR vel.)"
    numbers = f"NBR reac. {_listed(turn)}; NBR vel. {_listed(slow)}"
    yield Finding(number=5, text=text, holds=all(turn[n] < slow[n] for n in NAMES), numbers=numbers)
    turn = _means(c.low, "neighbour_reaction")
    text = "at low density DWA makes people near the robot turn most (lowest NBR reac.)"
    yield Finding(number=5, text=text, holds=turn[D] < min(turn[B], turn[R]), numbers=_listed(turn))


def _proximity(c: Comparison) -> Iterator[Finding]:
    low, high = _means(c.low, "proximity"), _means(c.high, "proximity")
    text = "Prox. is higher at the highest density than at the lowest, for each controller"
    numbers = f"{_listed(high)}; at low density {_listed(low)}"
    yield Finding(number=6, text=text, holds=all(high[n] > low[n] for n in NAMES), numbers=numbers)
    every = _means(c, "proximity")
    spread = max(every.values()) - min(every.values())
    text = "Prox. hardly depends on the controller"
    yield Finding(number=6, text=text, holds=spread <= SAME, numbers=f"{_listed(every)}: within {spread:.3f}")


def _collisions(c: Comparison) -> Iterator[Finding]:
    for symbol, rates in (
        ("f_c [1/s]", {n: c.collision_rate(n) for n in NAMES}),
        ("Q [J/s]", {n: c.collision_energy_rate(n) for n in NAMES}),
    ):
        yield _order(7, symbol, "over all episodes, worst first", rates, (B, D, R))
    counts = {n: float(len(c.energies(n))) for n in NAMES}
    text = "DWA has the most collisions in total"
    numbers = ", ".join(f"{NAMES[n]} {counts[n]:.0f} in {c.time(n) / 3600:.1f} h" for n in NAMES)
    yield Finding(number=7, text=text, holds=counts[D] > max(counts[B], counts[R]), numbers=numbers)
    if min(counts.values()) > 0:
        distance = {(m, n): likeness(c.energies(m), c.energies(n)) for m, n in combinations(NAMES, 2)}
        text = f"the distributions of dE look alike (Kolmogorov-Smirnov distance at most {ALIKE:g})"
        numbers = ", ".join(f"{NAMES[m]}-{NAMES[n]} {d:.2f}" for (m, n), d in distance.items())
        yield Finding(number=7, text=text, holds=max(distance.values()) <= ALIKE, numbers=numbers)


def _densities(c: Comparison) -> Sequence[tuple[str, Comparison]]:
    return (("over all densities", c), ("at low density", c.low))


def _means(c: Comparison, metric: str) -> dict[str, float]:
    means = {}
    for name in NAMES:
        values = c.values(name, metric)
        means[name] = float(values.mean()) if len(values) else float(np.nan)
    return means


def _order(number: int, symbol: str, where: str, mean: dict[str, float], order: Sequence[str]) -> Finding:
    text = f"{symbol}: {' > '.join(NAMES[name] for name in order)} {where}"
    holds = all(mean[first] > mean[second] for first, second in pairwise(order))
    return Finding(number=number, text=text, holds=holds, numbers=_listed({name: mean[name] for name in order}))


def _listed(mean: dict[str, float]) -> str:
    return ", ".join(f"{NAMES[name]} {value:.3f}" for name, value in mean.items())
