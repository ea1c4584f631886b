"""The tables of a sweep as what a comparison of controllers asks of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
import polars as pl
from numpy.typing import NDArray

from components.evaluator.metric import Metric
from components.evaluator.metrics import METRICS
from orchestrator.benchmark.tables import read
from orchestrator.errors import InputError

Floats = NDArray[np.float64]

EPISODE = ["scenario", "controller", "seed", "robot"]
"""what makes a row of the results one of a kind"""
FACTORS = ("policy", "flow", "people", "reactive")


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """All episodes of a sweep, or those at some densities, by controller."""

    results: pl.DataFrame
    """one row per episode and robot"""
    tables: Mapping[str, pl.DataFrame]
    """collisions, paths, timing, failures; may be empty"""

    @cached_property
    def controllers(self) -> tuple[str, ...]:
        """In alphabetical order."""
        return tuple(sorted(self.results["controller"].unique().to_list()))

    @cached_property
    def metrics(self) -> tuple[Metric, ...]:
        """The known metrics that have a value in some episode, in their order."""
        return tuple(m for m in METRICS if m.name in self.results.columns and self.results[m.name].count())

    def of(self, controller: str) -> pl.DataFrame:
        """A controller's rows."""
        return self.results.filter(pl.col("controller") == controller)

    def values(self, controller: str, metric: str) -> Floats:
        """(n,) a metric's values in the episodes that have one."""
        if metric not in self.results.columns:
            return np.empty(0)
        return self.of(controller)[metric].cast(pl.Float64).drop_nulls().to_numpy().astype(np.float64)

    def pairs(self, first: str, second: str, metric: str) -> tuple[Floats, Floats]:
        """(n,) and (n,) a metric's values of two controllers in the same scenarios, where both have one."""
        key = ["scenario", "seed", "robot"]
        columns = [*key, pl.col(metric).cast(pl.Float64)]
        both = self.of(first).select(columns).join(self.of(second).select(columns), on=key, suffix="_2")
        both = both.drop_nulls().sort(key)
        return both[metric].to_numpy(), both[f"{metric}_2"].to_numpy()

    def arrival_rate(self, controller: str) -> float:
        """Share of episodes in which the robot reached its goal."""
        return float(self.of(controller)["arrived"].cast(pl.Float64).to_numpy().mean())

    def time(self, controller: str) -> float:
        """Simulated time of all episodes until the robots arrived [s]."""
        return float(self.of(controller)["time"].cast(pl.Float64).to_numpy().sum())

    def energies(self, controller: str) -> Floats:
        """(N_c,) energy of each collision with a person [J]."""
        return self.collisions(controller)["energy"].to_numpy() if self._any_collision else np.empty(0)

    def collisions(self, controller: str) -> pl.DataFrame:
        """One row per collision of these episodes."""
        table = self.tables["collisions"].filter(pl.col("controller") == controller)
        return table.join(self.of(controller).select(EPISODE), on=EPISODE, how="semi")

    def collision_rate(self, controller: str) -> float:
        """f_c over all episodes: collisions over time [1/s]."""
        return len(self.energies(controller)) / self.time(controller)

    def collision_energy_rate(self, controller: str) -> float:
        """Q over all episodes: energy over time [J/s]."""
        return float(self.energies(controller).sum()) / self.time(controller)

    @property
    def _any_collision(self) -> bool:
        return not self.tables["collisions"].is_empty()

    @cached_property
    def crossed(self) -> bool:
        """True if the scenarios are behaviours by densities by flows, as the paper's are."""
        if not set(FACTORS) <= set(self.results.columns):
            return False
        factors = self.results.select(*FACTORS)
        return factors.drop_nulls().height == factors.height and all(factors[f].n_unique() > 1 for f in FACTORS[1:3])

    @cached_property
    def low(self) -> Comparison:
        """The episodes at the lowest density."""
        return self._only(pl.col("people") == self.results["people"].min())

    @cached_property
    def high(self) -> Comparison:
        """The episodes at the highest density."""
        return self._only(pl.col("people") == self.results["people"].max())

    def _only(self, which: pl.Expr) -> Comparison:
        return Comparison(results=self.results.filter(which), tables=self.tables)


def behaviour(policy: str, time_horizon: float | None, reactive: bool) -> str:
    """A crowd's behaviour in few words; ORCA's planes are the paper's RVO."""
    name = {"orca": "RVO", "social_force": "social forces"}.get(policy, policy)
    horizon = f" {time_horizon:g} s" if time_horizon else ""
    return f"{name}{horizon}, {'reactive' if reactive else 'not reactive'}"


def load(folder: Path) -> Comparison:
    """The comparison of a sweep's folder.

    Raises:
        InputError: if there are no results, or they lack what the evaluator always gives.
    """
    tables = read(folder)
    results = tables.pop("results")
    for column in ("time", "arrived", "controller", "scenario"):
        if column not in results.columns:
            raise InputError(f"the results in {folder} have no column '{column}': they are not those of a bench")
    # A CSV column without any value says nothing about its type.
    names = [metric.name for metric in METRICS if metric.name in results.columns]
    results = results.with_columns(pl.col(names).cast(pl.Float64)).sort(EPISODE)
    if "policy" in results.columns:
        named = [
            behaviour(str(p), h, bool(r)) if p is not None else None
            for p, h, r in results.select("policy", "time_horizon", "reactive").iter_rows()
        ]
        results = results.with_columns(pl.Series("behaviour", named, dtype=pl.String))
    return Comparison(results=results, tables=tables)
