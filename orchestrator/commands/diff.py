"""`crowdcosim diff`: where two logs begin to differ."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from orchestrator.log.diff import Difference, differences
from orchestrator.log.reader import read_log


def print_differences(a: Path, b: Path, as_json: bool) -> bool:
    """Print the first difference of each topic, the earliest first; True if there is none."""
    found = differences(read_log(a), read_log(b))
    if as_json:
        print(json.dumps({"logs": [str(a), str(b)], "equal": not found, "differences": [asdict(d) for d in found]}))
        return not found
    console = Console(highlight=False)
    if not found:
        console.print("[green]the logs hold the same data[/]")
        return True
    first = found[0]
    console.print(f"[yellow]they differ from {_when(first)} on, first in {first.topic}:[/] {first.what}")
    console.print(_table(found))
    return False


def _when(difference: Difference) -> str:
    tick = "" if difference.tick is None else f"tick {difference.tick} "
    return f"{tick}({difference.time * 1e-9:g} s)"


def _table(found: list[Difference]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("topic", "first difference", "what (first log, second log)"):
        table.add_column(name)
    table.add_column("messages that differ", justify="right")
    for d in found:
        table.add_row(d.topic, _when(d), d.what, f"{d.differing} of {d.messages}")
    return table
