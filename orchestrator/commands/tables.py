"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.table import Table

from components.evaluator.metrics import GROUPS, METRICS
from orchestrator.episode import Metric

IN_SHORT = {metric.name for metric in GROUPS["paper"]}
"""Metrics that are shown where there is little room: the paper's. Those of the user's own are too."""


def metrics_table(metrics: Sequence[Metric]) -> Table:
    """One row per metric of the paper or of the user's own, one column per robot; says how many more there are."""
    everything = metrics
    metrics = [m for m in everything if m.name in IN_SHORT or m.name not in {known.name for known in METRICS}]
    robots = list(dict.fromkeys(m.robot for m in metrics))
    known = {m.name: m for m in METRICS}
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, caption=_caption(everything, metrics), caption_justify="left")
    table.add_column("metric")
    table.add_column("")
    for robot in robots:
        table.add_column(robot, justify="right")
    table.add_column("unit")
    table.add_column("better")
    cells = {(m.robot, m.name): m for m in metrics}
    for name in dict.fromkeys(m.name for m in metrics):
        info = known.get(name)
        row = [cells.get((robot, name)) for robot in robots]
        unit = next(m.unit for m in row if m)
        table.add_row(
            info.symbol if info else name,
            info.description if info else "",
            *(_cell(m) for m in row),
            "" if unit == "1" else unit,
            {"higher": "↑", "lower": "↓"}.get(info.direction, "") if info else "",
        )
    return table


def _cell(metric: Metric | None) -> str:
    if metric is None:
        return ""
    return "–" if metric.value is None else f"{metric.value:.3f}"


def _caption(everything: Sequence[Metric], shown: Sequence[Metric]) -> str:
    """Why some metrics have no value, one line per reason, and how many are not shown."""
    reasons = dict.fromkeys(m.reason for m in shown if m.value is None)
    more = len({m.name for m in everything} - {m.name for m in shown})
    lines = [f"– {reason}" for reason in reasons]
    return "\n".join([*lines, f"{more} more: --json, or the report"] if more else lines)
