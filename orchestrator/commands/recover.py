"""`crowdcosim recover`: a complete log of one that was cut off."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from orchestrator.log.recover import recover


def print_recovery(source: Path, target: Path, as_json: bool) -> None:
    """Write the recovered log and print what it holds."""
    saved = recover(source, target)
    if as_json:
        print(json.dumps({"log": str(target), **asdict(saved)}))
        return
    console = Console(highlight=False, soft_wrap=True)
    if saved.complete:
        console.print(f"{source} was not cut off")
    console.print(f"{saved.messages} messages, up to {saved.until * 1e-9:g} s, in {target}")
