"""A sweep: what is not in the journal yet is run, and every outcome is written down as it comes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from orchestrator.benchmark import pools
from orchestrator.benchmark.journal import Journal
from orchestrator.benchmark.plan import Task
from orchestrator.benchmark.worker import Outcome
from orchestrator.errors import InputError
from orchestrator.log.provenance import versions


@dataclass(frozen=True, kw_only=True)
class Where:
    """Where episodes run."""

    workers: int = field(default_factory=lambda: _cores())
    """processes of this machine; by default one per core that we may use"""
    cluster: str | None = None
    """address of a Dask scheduler, whose workers run the episodes instead"""
    timeout: float = 600.0
    """longest time for an episode on this machine, wall clock [s]"""

    def __post_init__(self) -> None:
        if self.workers < 1:
            raise ValueError(f"workers is {self.workers}, expected at least 1")
        if not self.timeout > 0:
            raise ValueError(f"timeout is {self.timeout:g}, expected a positive number of seconds")


def remaining(tasks: Sequence[Task], journal: Journal, folder: Path) -> list[Task]:
    """The tasks that have not come to their end yet; those that failed are tried again.

    Raises:
        InputError: if the journal holds results of other scenarios, controllers or versions of the same names.
    """
    done = journal.fingerprints()
    for task in tasks:
        if done.get(task.key, task.fingerprint) != task.fingerprint:
            raise InputError(
                f"{folder} holds results of another scenario '{task.scenario}' or controller '{task.controller}' than "
                "those of today; choose another --out, or remove the folder"
            )
    if done:
        _check_versions(journal, folder)
    return [task for task in tasks if task.key not in done]


def run(tasks: Sequence[Task], journal: Journal, where: Where) -> Iterator[tuple[Task, Outcome]]:
    """Run the tasks; yields each when its outcome is in the journal."""
    if not tasks:
        return
    outcomes = (
        pools.cluster(tasks, where.cluster) if where.cluster else pools.local(tasks, where.workers, where.timeout)
    )
    for task, outcome in outcomes:
        journal.write(task, outcome)
        yield task, outcome


def _check_versions(journal: Journal, folder: Path) -> None:
    """Results of different code or packages do not belong into one table; where they were made does not matter."""
    for _, outcome in journal.episodes():
        before = outcome.get("versions", {})
        for name, now in versions().items():
            if name != "platform" and before.get(name, now) != now:
                raise InputError(
                    f"{folder} holds results made with {name} {before[name]}, this is {now}: they do not belong into "
                    "one table; choose another --out, or remove the folder"
                )


def _cores() -> int:
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
