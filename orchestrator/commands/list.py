"""`crowdcosim list`: what is shipped."""

from __future__ import annotations

import json

from rich import box
from rich.console import Console
from rich.table import Table

from orchestrator.scenario.shipped import Entry, list_components, list_devices, list_robots, list_scenarios, list_suites


def print_list(as_json: bool) -> None:
    """Print the shipped scenarios, robots, devices and components."""
    groups: dict[str, list[Entry]] = {
        "scenarios": list_scenarios(),
        "suites": list_suites(),
        "robots": list_robots(),
        "devices": list_devices(),
    } | list_components()
    if as_json:
        print(json.dumps({name: [entry._asdict() for entry in entries] for name, entries in groups.items()}))
        return
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for name in ("", "name", "what it is"):
        table.add_column(name)
    for group, entries in groups.items():
        for i, entry in enumerate(entries):
            table.add_row(
                f"[bold]{group}[/]" if i == 0 else "", entry.name, entry.description, end_section=i == len(entries) - 1
            )
    Console(highlight=False).print(table)
