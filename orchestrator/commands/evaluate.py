"""`crowdcosim evaluate`: the metrics of a log, computed again."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from orchestrator.commands.inspect import recorded_metrics
from orchestrator.commands.tables import metrics_table
from orchestrator.episode import rows_of
from orchestrator.log.reader import read_log
from orchestrator.log.rerun import evaluate


def print_evaluation(path: Path, as_json: bool) -> None:
    """Print the metrics and whether they equal those in the log."""
    log = read_log(path)
    metrics = rows_of(evaluate(log))
    equal = metrics == recorded_metrics(log)
    if as_json:
        print(json.dumps({"log": str(path), "metrics": [asdict(m) for m in metrics], "equal_to_run": equal}))
        return
    console = Console(highlight=False)
    console.print(metrics_table(metrics))
    console.print("equal to the metrics of the run" if equal else "[yellow]differ from the metrics of the run[/]")
