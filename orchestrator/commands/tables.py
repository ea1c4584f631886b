"""Tables for the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich import box
from rich.table import Table

from components.evaluator.metrics import METRICS
from orchestrator.episode import Metric


def metrics_table(metrics: Sequence[Metric]) -> Table:
    """One row per metric, one column per robot."""
    robots = list(dict.fromkeys(m.robot for m in metrics))
    known = {m.name: m for m in METRICS}
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False, caption=_reasons(metrics), caption_justify="left")
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


def _reasons(metrics: Sequence[Metric]) -> str:
    """Why some metrics have no value, one line per reason."""
    reasons = dict.fromkeys(m.reason for m in metrics if m.value is None)
    return "\n".join(f"– {reason}" for reason in reasons)
