"""The journal of a sweep: what became of each episode, kept so that it survives any end of the sweep."""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterator
from pathlib import Path
from types import TracebackType
from typing import Any

from orchestrator.benchmark.plan import Task
from orchestrator.errors import InputError

FILE = "journal.sqlite"


class Journal:
    """One row per episode, in a SQLite file; a row is there as a whole or not at all."""

    def __init__(self, folder: Path) -> None:
        """Open the journal in `folder`, or begin one.

        Raises:
            InputError: if another sweep has it open, or it cannot be written.
        """
        self._path = folder / FILE
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._database = sqlite3.connect(self._path, isolation_level=None, timeout=1.0)
            self._database.execute("PRAGMA locking_mode = EXCLUSIVE")
            self._database.execute("PRAGMA journal_mode = WAL")
            self._database.execute("BEGIN EXCLUSIVE")
            self._database.execute(
                "CREATE TABLE IF NOT EXISTS episodes "
                "(key TEXT PRIMARY KEY, fingerprint TEXT NOT NULL, task TEXT NOT NULL, outcome TEXT NOT NULL)"
            )
            self._database.execute("COMMIT")
        except sqlite3.OperationalError as error:
            raise InputError(f"cannot open {self._path}: {error}; is another sweep at work there?") from None
        except (OSError, sqlite3.DatabaseError) as error:
            raise InputError(f"cannot write {self._path}: {error}") from None

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._database.close()

    def write(self, task: Task, outcome: dict[str, Any]) -> None:
        """Keep what became of a task, in place of what became of it before."""
        about = {"suite": task.suite, "scenario": task.scenario, "controller": task.controller, "seed": task.seed}
        about |= {"scenario_hash": task.scenario_hash, "controller_hash": task.controller_hash}
        row = (task.key, task.fingerprint, json.dumps(about), json.dumps(outcome))
        self._database.execute("INSERT OR REPLACE INTO episodes VALUES (?, ?, ?, ?)", row)

    def fingerprints(self) -> dict[str, str]:
        """Key -> fingerprint of every episode that came to its end."""
        query = "SELECT key, fingerprint FROM episodes WHERE json_extract(outcome, '$.status') = 'done'"
        return dict(self._database.execute(query))

    def episodes(self) -> Iterator[tuple[dict[str, Any], dict[str, Any]]]:
        """(task, outcome) of every episode, in the order of their keys."""
        for task, outcome in self._database.execute("SELECT task, outcome FROM episodes ORDER BY key"):
            yield json.loads(task), json.loads(outcome)
