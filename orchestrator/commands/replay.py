"""`crowdcosim replay`: a log on Zenoh, at its pace."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console
from rich.progress import Progress

from orchestrator.errors import InputError
from orchestrator.log.publish import publish
from orchestrator.log.reader import read_log


def publish_log(path: Path, pace: float, endpoint: str, wait: float) -> None:
    """Publish every message of a log and show how far it is."""
    if not pace > 0:
        raise InputError(f"--realtime is {pace}, expected a positive number")
    if not wait >= 0:
        raise InputError(f"--wait is {wait}, expected zero or more")
    log = read_log(path)
    run = log.metadata.get("run", {}).get("scenario", path.stem)
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"publishing under {run}/COMPONENT/PORT at {endpoint}; Ctrl-C ends it")
    end = max((record.time for record in log.records), default=0) * 1e-9
    with Progress(console=console, transient=True) as progress:
        task = progress.add_task("simulated time", total=end or 1.0)
        sent = publish(
            log, run, pace=pace, endpoint=endpoint, wait=wait, at=lambda t: progress.update(task, completed=t * 1e-9)
        )
    console.print(f"{sent} messages, {end:g} s")
