"""`crowdcosim rerun`: one component again, on what a log recorded of the others."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import asdict, dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.table import Table

from crowdcosim.component import ComponentError
from orchestrator.commands.check import json_object
from orchestrator.errors import InputError
from orchestrator.log.diff import field_difference
from orchestrator.log.reader import read_log
from orchestrator.log.rerun import Step, rerun
from orchestrator.scenario.registry import Family, import_string


@dataclass(frozen=True, kw_only=True)
class Comparison:
    """The outputs of one port, then and now."""

    port: str
    messages: int
    differing: int
    first_tick: int | None
    """at which they differ"""
    what: str | None
    """the field, and both values"""


def print_rerun(path: Path, component: str, use: str | None, config: str | None, as_json: bool) -> bool:
    """Print port by port whether the outputs are those of the run; True if they are."""
    steps = rerun(
        read_log(path),
        component,
        use=None if use is None else _import_string(use, component),
        config=None if config is None else json_object(config),
    )
    compared = _compared(list(steps))
    equal = not any(c.differing for c in compared)
    if as_json:
        found = [asdict(c) for c in compared]
        print(json.dumps({"log": str(path), "component": component, "equal": equal, "ports": found}))
        return equal
    console = Console(highlight=False)
    console.print(_table(compared))
    console.print("[green]the same as in the run[/]" if equal else "[yellow]not the same as in the run[/]")
    return equal


def _import_string(use: str, component: str) -> str:
    try:
        return import_string(use, _family(component), Path.cwd())
    except ComponentError as error:
        raise InputError(str(error)) from None


def _family(component: str) -> Family:
    """The family whose short names fit a component of that name."""
    _, _, part = component.partition("/")
    if part:
        return "controller" if part == "controller" else "sensor"
    return "crowd" if component == "crowd" else "drive"


def _compared(steps: list[Step]) -> list[Comparison]:
    messages: Counter[str] = Counter()
    differing: Counter[str] = Counter()
    first: dict[str, tuple[int, str]] = {}
    for step in steps:
        messages[step.port] += 1
        what = "not in the log" if step.recorded is None else field_difference(step.recorded, step.again)
        if what is not None:
            differing[step.port] += 1
            first.setdefault(step.port, (step.tick, what))
    return [
        Comparison(
            port=port,
            messages=count,
            differing=differing[port],
            first_tick=first[port][0] if port in first else None,
            what=first[port][1] if port in first else None,
        )
        for port, count in messages.items()
    ]


def _table(compared: list[Comparison]) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("port")
    for name in ("messages", "differ", "first tick"):
        table.add_column(name, justify="right")
    table.add_column("what (in the run, now)")
    for c in compared:
        tick = "" if c.first_tick is None else str(c.first_tick)
        table.add_row(c.port, str(c.messages), str(c.differing), tick, c.what or "")
    return table
