"""`crowdcosim export`: a log in another form."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

from rich.console import Console

from orchestrator.errors import InputError
from orchestrator.log.crowdbot import to_crowdbot
from orchestrator.log.reader import Log, read_log
from orchestrator.log.rosbag2 import to_rosbag2
from orchestrator.log.tables import to_tables
from orchestrator.scenario.problems import near_miss


def _rosbag2(log: Log, out: Path) -> list[Path]:
    to_rosbag2(log, out)
    return sorted(out.iterdir())


FORMS: dict[str, Callable[[Log, Path], list[Path]]] = {
    "rosbag2": _rosbag2,
    "csv": lambda log, out: to_tables(log, out, "csv"),
    "parquet": lambda log, out: to_tables(log, out, "parquet"),
    "crowdbot": to_crowdbot,
}


def print_export(path: Path, form: str, out: Path | None, as_json: bool) -> None:
    """Write the log in that form and print the files."""
    if form not in FORMS:
        raise InputError(f"there is no form '{form}'{near_miss(form, FORMS)}, expected {', '.join(FORMS)}")
    target = out or path.with_name(f"{path.stem}_{form}")
    written = [str(file) for file in FORMS[form](read_log(path), target)]
    if as_json:
        print(json.dumps({"log": str(path), "form": form, "files": written}))
        return
    console = Console(highlight=False, soft_wrap=True)
    for file in written:
        console.print(file)
