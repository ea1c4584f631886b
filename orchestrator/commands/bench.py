"""`crowdcosim bench`: every controller in every scenario of a suite."""

from __future__ import annotations

import json
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import polars as pl
from rich import box
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn
from rich.table import Table

from components.evaluator.metrics import METRICS, PAPER
from orchestrator.benchmark import sweep
from orchestrator.benchmark.journal import Journal
from orchestrator.benchmark.plan import Task, plan
from orchestrator.benchmark.sweep import Where
from orchestrator.benchmark.tables import Format, export, read
from orchestrator.scenario.controller_choice import controller_choices
from orchestrator.suites.catalogue import find_suite

ARROWS = {"higher": "↑", "lower": "↓"}
TELL_EVERY = 10.0
"""so often the progress is said where the output is no terminal [s]"""


def run_bench(
    suite: str,
    *,
    controllers: str,
    settings: Sequence[str],
    seeds: int,
    out: Path,
    form: Format,
    where: Where,
    as_json: bool,
    quiet: bool,
) -> bool:
    """Run what is not in `out` yet, write the tables, and say what came out; False if an episode failed."""
    console = Console(stderr=True, quiet=quiet, highlight=False, soft_wrap=True)
    tasks = plan(find_suite(suite), controller_choices(controllers), settings, seeds)
    began = time.monotonic()
    with Journal(out) as journal:
        todo = sweep.remaining(tasks, journal, out)
        if len(todo) < len(tasks):
            console.print(f"{len(tasks) - len(todo)} of {len(tasks)} episodes were done before", style="dim")
        failed = 0
        try:
            failed = _run(todo, journal, where, console)
        finally:
            files = export(journal, out, form)
    about = {
        "suite": suite,
        "episodes": len(tasks),
        "run_now": len(todo),
        "failed": failed,
        "wall_time": time.monotonic() - began,
        "files": {name: str(file) for name, file in files.items()},
    }
    if as_json:
        print(json.dumps(about))
    elif not quiet:
        _show(out, about)
    return failed == 0


def _run(todo: Sequence[Task], journal: Journal, where: Where, console: Console) -> int:
    failed = 0
    with _Progress(len(todo), console) as progress:
        for done, (task, outcome) in enumerate(sweep.run(todo, journal, where), 1):
            if outcome["status"] != "done":
                failed += 1
                about = f"{task.scenario}, {task.controller}, seed {task.seed}"
                console.print(f"[red]failed[/] {about}: ", end="")
                console.print(outcome["error"], markup=False)
            progress.advance(done, failed)
    return failed


class _Progress:
    """Episodes done, failed, and when it will be over: a bar on a terminal, else a line now and then."""

    def __init__(self, total: int, console: Console) -> None:
        self._total, self._console = total, console
        self._began = self._told = time.monotonic()
        self._bar = Progress(
            TextColumn("episodes"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("[red]{task.fields[failed]}[/]"),
            TimeElapsedColumn(),
            TextColumn("[dim]ends in[/]"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._task = self._bar.add_task("", total=total, failed="")

    def __enter__(self) -> _Progress:
        self._bar.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._bar.stop()

    def advance(self, done: int, failed: int) -> None:
        """So many are done now, so many of them failed."""
        self._bar.update(self._task, completed=done, failed=f"{failed} failed" if failed else "")
        now = time.monotonic()
        if not self._console.is_terminal and now - self._told > TELL_EVERY:
            self._told = now
            left = (now - self._began) / done * (self._total - done)
            self._console.print(f"{done} of {self._total} episodes done, {failed} failed, {left:.0f} s left")


def _show(out: Path, about: dict[str, Any]) -> None:
    console = Console(highlight=False)
    console.print(
        f"[bold]{about['suite']}[/]: {about['episodes']} episodes, {about['run_now']} of them run now in "
        f"{about['wall_time']:.0f} s" + (f", [red]{about['failed']} failed[/]" if about["failed"] else "")
    )
    if "results" in about["files"]:
        console.print(_means(read(out)["results"]))
        console.print(
            f"tables  {about['files']['results']} and beside it\nreport  crowdcosim report {out}", soft_wrap=True
        )


def _means(results: pl.DataFrame) -> Table:
    """Means by controller: arrivals, the paper's metrics, f_c and Q."""
    shown = [metric for metric in METRICS if metric in PAPER or metric.symbol in ("f_c", "Q")]
    shown = [metric for metric in shown if metric.name in results.columns]
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    table.add_column("mean over episodes")
    groups = {str(name): rows for (name,), rows in results.group_by("controller", maintain_order=True)}
    for name in groups:
        table.add_column(name, justify="right")
    table.add_column("unit")
    table.add_column("better")
    table.add_row("episodes", *(str(len(rows)) for rows in groups.values()))
    table.add_row("arrived", *(_shown(rows["arrived"]) for rows in groups.values()), "", ARROWS["higher"])
    for metric in shown:
        cells = (_shown(rows[metric.name]) for rows in groups.values())
        table.add_row(
            metric.symbol, *cells, "" if metric.unit == "1" else metric.unit, ARROWS.get(metric.direction, "")
        )
    return table


def _shown(values: pl.Series) -> str:
    numbers = values.cast(pl.Float64).drop_nulls().to_numpy()
    return f"{numbers.mean():.3f}" if len(numbers) else "–"
