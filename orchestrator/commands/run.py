"""`crowdcosim run`: one episode, with progress, a table, a log and a report."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

from rich.console import Console

from orchestrator.commands.tables import metrics_table
from orchestrator.episode import Result, run_episode
from orchestrator.errors import InputError, RunError
from orchestrator.processes import Processes
from orchestrator.progress import RunProgress
from orchestrator.report.page import write_report
from orchestrator.scenario.controller_choice import controller_settings
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation


def run_scenario(
    scenario: str,
    *,
    controllers: list[str],
    settings: list[str],
    out: Path,
    real_time: float | None,
    listen: str | None,
    record: bool,
    as_json: bool,
    quiet: bool,
    processes: Processes | None,
    began: float,
) -> None:
    """Run one episode and print what became of it."""
    if real_time is not None and not real_time > 0:
        raise InputError(f"--realtime is {real_time:g}, expected a positive number of simulated seconds per second")
    if listen is not None:
        settings = [*settings, f"attach.listen={listen}"]
    loaded = load(scenario, [*controller_settings(scenario, controllers), *settings])
    if record:
        _claim(out)
    console = Console(stderr=True, quiet=quiet)
    log = out / "episode.mcap" if record else None
    with RunProgress(loaded.name, loaded.ending.time_limit, console) as watcher:
        try:
            simulation = Simulation(loaded, logs=out / "logs", processes=processes, status=watcher.status)
            try:
                result = run_episode(simulation, log=log, real_time=real_time, began=began, watcher=watcher)
            except BaseException:
                simulation.close(stop=False)
                raise
            simulation.close()
        except RunError as error:
            if log and log.exists():
                console.print(f"  [dim]log up to there: {log}[/dim]", highlight=False)
            raise error
    report = _finish(result, out, record)
    if as_json:
        print(json.dumps(result.as_dict() | {"report": str(report) if report else None}))
    elif not quiet:
        _show(result, report)


def _claim(out: Path) -> None:
    """Make the run's folder; an earlier run in it is never overwritten."""
    if (out / "episode.mcap").exists():
        raise InputError(f"{out} already holds a run; choose another --out, or remove it first")
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot make the folder {out}: {error.strerror}") from None


def _finish(result: Result, out: Path, record: bool) -> Path | None:
    """Result and report beside the log; what the components printed stays only if they printed something."""
    _drop_empty_logs(out / "logs")
    if not record:
        return None
    (out / "result.json").write_text(json.dumps(result.as_dict(), indent=1) + "\n")
    report = out / "report.html"
    write_report(out / "episode.mcap", report)
    return report


def _drop_empty_logs(logs: Path) -> None:
    if logs.is_dir():
        for path in logs.iterdir():
            if path.stat().st_size == 0:
                path.unlink()
        if not any(logs.iterdir()):
            shutil.rmtree(logs)
            if logs.parent.is_dir() and not any(logs.parent.iterdir()):
                logs.parent.rmdir()


def _show(result: Result, report: Path | None) -> None:
    console = Console(highlight=False)
    ends = {"goal": "reached the goal", "time_limit": "hit the time limit", "collision": "ended by a collision"}
    console.print(
        f"[bold]{result.scenario}[/] seed {result.seed}: {ends[result.outcome]} after "
        f"[bold]{result.simulated_time:.1f} s[/] ({result.ticks} ticks; {result.ticks_per_second:.0f} ticks/s, "
        f"{result.real_time_factor:.0f}x real time; started in {result.start_up_time:.1f} s)"
    )
    console.print(metrics_table(result.metrics))
    if not result.repeatable:
        console.print("[yellow]not repeatable: a controller's latency was measured[/]")
    if result.log:
        console.print(f"log     {result.log}\nreport  {report}\nhash    {result.data_hash}", soft_wrap=True)
