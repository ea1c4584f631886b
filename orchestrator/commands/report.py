"""`crowdcosim report`: the page of a sweep, or of one episode."""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from orchestrator.errors import InputError
from orchestrator.report.page import write_report


def print_report(folder: Path, as_json: bool) -> None:
    """Write the report of what is in the folder, and say where it is."""
    if any((folder / f"results.{form}").is_file() for form in ("csv", "parquet")):
        from orchestrator.comparison.page import write_comparison

        files = write_comparison(folder)
    elif (folder / "episode.mcap").is_file():
        files = {"report": folder / "report.html"}
        write_report(folder / "episode.mcap", files["report"])
    else:
        raise InputError(
            f"{folder} holds neither the results of a sweep (results.csv or results.parquet) nor the log of an episode "
            "(episode.mcap)"
        )
    if as_json:
        print(json.dumps({name: str(file) for name, file in files.items()}))
        return
    console = Console(highlight=False, soft_wrap=True)
    for name, file in files.items():
        console.print(f"{name:8}{file}", markup=False)
