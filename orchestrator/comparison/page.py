"""The page of a comparison: one HTML file that needs no network, and its figures as PNG and PDF."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from itertools import combinations
from pathlib import Path
from typing import Any

import polars as pl
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

from components.evaluator.metric import Metric
from components.evaluator.metrics import GROUPS
from orchestrator.comparison import published
from orchestrator.comparison.charts import RADAR, charts, colours, in_print, on_page
from orchestrator.comparison.claims import findings, judgeable
from orchestrator.comparison.data import Comparison, load
from orchestrator.comparison.statistics import Difference, Summary, difference, holm, summary

TESTED = (
    "time_ratio",
    "path_length_ratio",
    "colliding",
    "collision_rate",
    "collision_energy_rate",
    "near_collision_share",
)
"""Metrics whose differences between controllers are tested."""
TITLES = {
    "paper": "The paper's",
    "task": "Task",
    "motion": "Motion",
    "safety": "Safety",
    "comfort": "Comfort and company",
}
SCENARIOS_SHOWN = 60
"""With no more scenarios than these, each has a line."""


@dataclass(frozen=True, kw_only=True)
class Line:
    """One line of a table: a metric and a cell per controller."""

    metric: Metric
    cells: tuple[Summary | None, ...]
    published: tuple[float | None, ...] = ()
    """the paper's standard deviations"""


@dataclass(frozen=True, kw_only=True)
class Test:
    """Two controllers compared in one metric over the scenarios."""

    metric: Metric
    first: str
    second: str
    difference: Difference
    p: float
    """adjusted for the number of tests"""


def write_comparison(folder: Path) -> dict[str, Path]:
    """Write `report.html`, `summary.csv`, `claims.csv` and `figures/` into a sweep's folder; returns name -> file.

    Raises:
        InputError: if there are no results in it.
    """
    comparison = load(folder)
    figures = folder / "figures"
    figures.mkdir(exist_ok=True)
    for chart in charts(comparison):
        in_print(chart, comparison, figures)
    page, table = folder / "report.html", folder / "summary.csv"
    page.write_text(render(comparison), encoding="utf-8")
    summary_table(comparison).write_csv(table, float_precision=6)
    files = {"report": page, "summary": table, "figures": figures}
    if judgeable(comparison):
        files["claims"] = folder / "claims.csv"
        pl.DataFrame([asdict(finding) for finding in findings(comparison)]).write_csv(files["claims"])
    return files


def render(comparison: Comparison) -> str:
    """The page; equal tables give equal text."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    results = comparison.results
    return environment.get_template("page.html.jinja").render(
        suite=", ".join(dict.fromkeys(results["suite"].to_list())),
        comparison=comparison,
        colours=colours(comparison),
        facts=_facts(comparison),
        overview=_overview(comparison),
        seven={"all densities": _seven(comparison, "all")}
        | ({"low density": _seven(comparison.low, "low")} if comparison.crossed else {}),
        findings=findings(comparison) if judgeable(comparison) else [],
        charts={chart.name: chart for chart in charts(comparison)},
        drawn={chart.name: Markup(on_page(chart, comparison)) for chart in charts(comparison)},  # our own SVG
        rates=_rates(comparison),
        tests=_tests(comparison),
        groups={TITLES[group]: lines for group in TITLES if (lines := _lines(comparison, group))},
        timing=_timing(comparison),
        scenarios=_scenarios(comparison),
        failures=comparison.tables["failures"].to_dicts(),
        versions=_versions(comparison),
    )


def summary_table(comparison: Comparison) -> pl.DataFrame:
    """Mean, deviation and interval of every metric by controller, over all densities and at the lowest."""
    parts = {"all": comparison} | ({"low": comparison.low} if comparison.crossed else {})
    rows = []
    for density, part in parts.items():
        for metric in part.metrics:
            for controller in part.controllers:
                if found := summary(part.values(controller, metric.name)):
                    rows.append(
                        {
                            "density": density,
                            "metric": metric.name,
                            "unit": metric.unit,
                            "controller": controller,
                            "episodes": found.count,
                            "mean": found.mean,
                            "standard_deviation": found.deviation,
                            "ci_low": found.low,
                            "ci_high": found.high,
                            "paper_standard_deviation": published.DEVIATIONS[density]
                            .get(controller, {})
                            .get(metric.name),
                        }
                    )
    return pl.DataFrame(rows, infer_schema_length=None)


def _facts(comparison: Comparison) -> dict[str, str]:
    results = comparison.results
    arrived = results["arrived"].cast(pl.Float64).to_numpy().mean()
    return {
        "episodes": str(len(results)),
        "scenarios": str(results["scenario"].n_unique()),
        "controllers": str(len(comparison.controllers)),
        "arrived": f"{100 * arrived:.1f} %",
        "simulated": f"{sum(comparison.time(c) for c in comparison.controllers) / 3600:.1f} h",
        "failed": str(len(comparison.tables["failures"])),
    }


def _overview(comparison: Comparison) -> list[dict[str, Any]]:
    """One line per controller: what a reader wants to know first."""
    decisions = _decisions(comparison)
    lines = []
    for name in comparison.controllers:
        means = {m: summary(comparison.values(name, m)) for m in ("time_ratio", "colliding", "near_collision_share")}
        lines.append(
            {
                "controller": name,
                "arrival": comparison.arrival_rate(name),
                "f_c": comparison.collision_rate(name),
                "Q": comparison.collision_energy_rate(name),
                "decision": decisions.get(name),
                **means,
            }
        )
    return lines


def _seven(comparison: Comparison, density: str) -> tuple[list[Line], list[float]]:
    """The lines of the seven metrics, and the controllers' arrival rates in the same episodes."""
    known = {metric.name: metric for metric in comparison.metrics}
    lines = [
        Line(
            metric=known[name],
            cells=tuple(summary(comparison.values(c, name)) for c in comparison.controllers),
            published=tuple(published.DEVIATIONS[density].get(c, {}).get(name) for c in comparison.controllers),
        )
        for name in RADAR
        if name in known
    ]
    return lines, [comparison.arrival_rate(c) for c in comparison.controllers]


def _lines(comparison: Comparison, group: str) -> list[Line]:
    return [
        Line(metric=metric, cells=tuple(summary(comparison.values(c, metric.name)) for c in comparison.controllers))
        for metric in comparison.metrics
        if metric in GROUPS[group]
    ]


def _rates(comparison: Comparison) -> list[dict[str, Any]]:
    """f_c and Q over all episodes, beside the paper's and the arrival rate."""
    return [
        {
            "controller": name,
            "arrival": comparison.arrival_rate(name),
            "collisions": len(comparison.energies(name)) if not comparison.tables["collisions"].is_empty() else 0,
            "hours": comparison.time(name) / 3600,
            "f_c": comparison.collision_rate(name),
            "f_c_paper": published.COLLISION_RATE.get(name),
            "Q": comparison.collision_energy_rate(name),
            "Q_paper": published.COLLISION_ENERGY_RATE.get(name),
        }
        for name in comparison.controllers
    ]


def _tests(comparison: Comparison) -> list[Test]:
    known = {metric.name: metric for metric in comparison.metrics}
    found = []
    for name in TESTED:
        for first, second in combinations(comparison.controllers, 2):
            if name in known and (d := difference(*comparison.pairs(first, second, name))):
                found.append((known[name], first, second, d))
    adjusted = holm([d.p for *_, d in found])
    return [
        Test(metric=metric, first=first, second=second, difference=d, p=p)
        for (metric, first, second, d), p in zip(found, adjusted, strict=True)
    ]


def _decisions(comparison: Comparison) -> dict[str, float]:
    """Controller -> mean computing time per decision [s]."""
    timing = comparison.tables["timing"]
    if timing.is_empty():
        return {}
    own = timing.filter(pl.col("component").str.ends_with("/controller"))
    return {str(name): float(rows["mean"].to_numpy().mean()) for (name,), rows in own.group_by("controller")}


def _timing(comparison: Comparison) -> list[dict[str, Any]]:
    """Per controller: its decisions, what else takes time, and the episodes."""
    timing = comparison.tables["timing"]
    lines: list[dict[str, Any]] = []
    if timing.is_empty():
        return lines
    for name in comparison.controllers:
        rows = timing.filter(pl.col("controller") == name)
        own = rows.filter(pl.col("component").str.ends_with("/controller"))
        episodes = rows.unique(["scenario", "seed"])
        work = rows.group_by("component").agg((pl.col("mean") * pl.col("steps")).sum().alias("work")).sort("component")
        total = work["work"].to_numpy().sum()
        lines.append(
            {
                "controller": name,
                "mean": own["mean"].to_numpy().mean(),
                "p99": own["p99"].to_numpy().max(),
                "max": own["max"].to_numpy().max(),
                "episode": episodes["episode_wall_time"].to_numpy().mean(),
                "memory": episodes["worker_peak_memory"].to_numpy().max() / 2**20,
                "shares": [(c, w / total) for c, w in work.sort("work", descending=True).iter_rows()],
            }
        )
    return lines


def _scenarios(comparison: Comparison) -> list[dict[str, Any]]:
    """A line per scenario of a suite that is not the paper's: time and collisions of each controller."""
    names = list(dict.fromkeys(comparison.results["scenario"].to_list()))
    if comparison.crossed or len(names) > SCENARIOS_SHOWN:
        return []
    lines = []
    for name in names:
        rows = comparison.results.filter(pl.col("scenario") == name)
        part = Comparison(results=rows, tables=comparison.tables)
        cells = [
            {
                "arrival": part.arrival_rate(c),
                "time": summary(part.values(c, "time")),
                "colliding": summary(part.values(c, "colliding")),
            }
            if c in part.controllers
            else None
            for c in comparison.controllers
        ]
        lines.append({"scenario": name, "cells": cells})
    return lines


def _versions(comparison: Comparison) -> Sequence[tuple[str, str]]:
    results = comparison.results
    commits = ", ".join(dict.fromkeys(str(c) for c in results["commit"].to_list() if c))
    versions = ", ".join(dict.fromkeys(str(v) for v in results["versions"].to_list()))
    platforms = comparison.tables["timing"]
    machine = ", ".join(dict.fromkeys(platforms["platform"].to_list())) if not platforms.is_empty() else ""
    return [("commit", commits or "an installed package"), ("versions", versions), ("platform", machine)]
