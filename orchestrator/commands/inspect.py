"""`crowdcosim inspect`: what is in a log."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from crowdcosim.cdr import decode
from crowdcosim.messages import Metrics
from orchestrator.commands.tables import metrics_table
from orchestrator.episode import Metric, rows_of
from orchestrator.log.reader import Log, Topic, read_log


def print_summary(path: Path, as_json: bool) -> None:
    """Print topics, rates, duration, outcome, metrics and data hash."""
    log = read_log(path)
    topics, metrics, data_hash = log.topics(), recorded_metrics(log), log.data_hash()
    outcome = dict(log.metadata.get("outcome", {}))
    duration = max((t.last for t in topics), default=0) * 1e-9
    intact = outcome.get("data_hash", data_hash) == data_hash
    if as_json:
        summary = {
            "log": str(path),
            "complete": log.complete,
            "duration": duration,
            "run": log.metadata.get("run", {}),
            "outcome": outcome,
            "data_hash": data_hash,
            "intact": intact,
            "topics": [asdict(t) | {"rate": t.rate} for t in topics],
            "metrics": [asdict(m) for m in metrics],
        }
        print(json.dumps(summary))
        return
    console = Console(highlight=False)
    run = log.metadata.get("run", {})
    console.print(f"[bold]{run.get('scenario', path.name)}[/] seed {run.get('seed', '?')}, {duration:.1f} s simulated")
    console.print(
        f"outcome {outcome.get('reason', 'unknown')}" + (f": {outcome['error']}" if "error" in outcome else "")
    )
    console.print(_topics_table(topics))
    if metrics:
        console.print(metrics_table(metrics))
    console.print(f"hash    {data_hash}" + ("" if intact else "  [red]differs from the hash that the run gave[/]"))
    if run.get("repeatable") == "false":
        console.print("[yellow]not repeatable: a controller's latency was measured[/]")
    if not log.complete:
        console.print("[yellow]this log was cut off; it shows what was complete[/]")


def recorded_metrics(log: Log) -> tuple[Metric, ...]:
    """The verdict that a log holds, if the run came to its end."""
    found = [r for r in log.records if log.types[r.topic] == Metrics.TYPE]
    return rows_of(decode(found[-1].payload, Metrics.TYPE)) if found else ()


def _topics_table(topics: list[Topic]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("topic", "type"):
        table.add_column(name)
    for name in ("messages", "rate"):
        table.add_column(name, justify="right")
    for topic in topics:
        rate = f"{topic.rate:.4g} Hz" if topic.rate else ""
        table.add_row(topic.name, topic.type, str(topic.count), rate)
    return table
