"""How a run goes, on the terminal: simulated time, real-time factor, and when it will be over at the latest."""

from __future__ import annotations

import time
from types import TracebackType

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, SpinnerColumn, Task, TextColumn, TimeRemainingColumn
from rich.text import Text

from orchestrator.episode import Watcher

REDRAW = 0.1
"""The bar is told of new ticks this often [s]; more would cost the run."""


class _Factor(ProgressColumn):
    """Simulated over wall-clock time."""

    def render(self, task: Task) -> Text:
        factor = task.completed / task.elapsed if task.elapsed else 0.0
        return Text(f"{factor:5.1f}x real time", style="progress.percentage")


class RunProgress:
    """A progress bar as a context; silent where the output is no terminal."""

    def __init__(self, name: str, time_limit: float, console: Console) -> None:
        self._progress = Progress(
            SpinnerColumn(),
            TextColumn("[bold]{task.description}"),
            BarColumn(),
            TextColumn("{task.completed:6.1f} of at most {task.total:g} s"),
            _Factor(),
            TextColumn("ends in at most"),
            TimeRemainingColumn(),
            console=console,
            transient=True,
            disable=not console.is_terminal,
        )
        self._name = name
        self._total = time_limit
        self._console = console
        self._shown = 0.0
        self._told: set[str] = set()

    def __enter__(self) -> Watcher:
        self._progress.start()
        self._task = self._progress.add_task(self._name, total=self._total, start=False)
        return Watcher(status=self._status, ticked=self._ticked)

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._progress.stop()

    def _status(self, text: str) -> None:
        component, compiling, kernel = text.partition(": compiling ")
        if compiling:
            text = f"{component}: compiling its kernels, once on this machine"
            self._progress.update(self._task, description=f"{self._name}: compiling {kernel}")
        if text not in self._told:
            self._told.add(text)
            self._console.print(f"  {text}", style="dim", markup=False, highlight=False)

    def _ticked(self, time_ns: int) -> None:
        now = time.monotonic()
        if now - self._shown > REDRAW:
            if not self._shown:
                self._progress.start_task(self._task)
                self._progress.update(self._task, description=self._name)
            self._shown = now
            self._progress.update(self._task, completed=time_ns * 1e-9)
