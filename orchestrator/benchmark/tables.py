"""The tables of a sweep, as files: results, collisions and paths are the same bytes however many workers ran it.

All that the wall clock has a hand in is in a table of its own, `timing`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, Literal, get_args

import polars as pl

from orchestrator.benchmark.journal import Journal
from orchestrator.errors import InputError

Format = Literal["csv", "parquet"]
TABLES = ("results", "collisions", "paths", "timing", "failures")

Row = dict[str, Any]
Episode = tuple[dict[str, Any], dict[str, Any]]
"""(task, outcome), as the journal has them"""


def export(journal: Journal, folder: Path, form: Format) -> dict[str, Path]:
    """Write all tables of a journal into `folder`, over earlier ones; returns table -> file."""
    episodes = list(journal.episodes())
    done = [(task, outcome) for task, outcome in episodes if outcome["status"] == "done"]
    failed = [(task, outcome) for task, outcome in episodes if outcome["status"] != "done"]
    made: dict[str, Callable[[list[Episode]], Iterable[Row]]] = {
        "results": _results,
        "collisions": _collisions,
        "paths": _paths,
        "timing": _timing,
    }
    tables = {name: _frame(rows(done)) for name, rows in made.items()}
    tables["failures"] = _frame({**_key(task), "error": outcome["error"]} for task, outcome in failed)
    files = {}
    for name, table in tables.items():
        for other in get_args(Format):
            (folder / f"{name}.{other}").unlink(missing_ok=True)
        if table.width:
            files[name] = folder / f"{name}.{form}"
            table.write_csv(files[name]) if form == "csv" else table.write_parquet(files[name])
    return files


def read(folder: Path) -> dict[str, pl.DataFrame]:
    """The tables in `folder`, of either format; those that are not there are empty.

    Raises:
        InputError: if there are no results.
    """
    tables = {}
    for name in TABLES:
        table = pl.DataFrame()
        if (folder / f"{name}.parquet").is_file():
            table = pl.read_parquet(folder / f"{name}.parquet")
        elif (folder / f"{name}.csv").is_file():
            table = pl.read_csv(folder / f"{name}.csv", infer_schema_length=None)
        tables[name] = table
    if tables["results"].is_empty():
        raise InputError(f"{folder} holds no results: expected results.csv or results.parquet from `crowdcosim bench`")
    return tables


def _frame(rows: Iterable[Row]) -> pl.DataFrame:
    return pl.DataFrame(list(rows), infer_schema_length=None)


def _key(task: Row) -> Row:
    return {"scenario": task["scenario"], "controller": task["controller"], "seed": task["seed"]}


def _results(episodes: list[Episode]) -> Iterable[Row]:
    names = dict.fromkeys(metric["name"] for _, outcome in episodes for metric in outcome["metrics"])
    for task, outcome in episodes:
        values: dict[str, dict[str, Any]] = {robot: {} for robot in outcome["paths"]}
        for metric in outcome["metrics"]:
            values[metric["robot"]][metric["name"]] = metric["value"]
        for robot, metrics in values.items():
            yield {
                "suite": task["suite"],
                **_key(task),
                "robot": robot,
                **outcome["factors"],
                "outcome": outcome["outcome"],
                "arrived": robot in outcome["arrived"],
                "simulated_time": outcome["simulated_time"],
                **{name: metrics.get(name) for name in names},
                "scenario_hash": task["scenario_hash"],
                "controller_hash": task["controller_hash"],
                "commit": outcome["versions"]["git_commit"],
                "versions": " ".join(
                    f"{name}={version}"
                    for name, version in outcome["versions"].items()
                    if name not in ("git_commit", "platform")
                ),
            }


def _collisions(episodes: list[Episode]) -> Iterable[Row]:
    names = ("time", "agent", "body_part", "approach_speed", "energy", "x", "y")
    for task, outcome in episodes:
        for robot, collisions in outcome["collisions"].items():
            for collision in collisions:
                yield {**_key(task), "robot": robot, **dict(zip(names, collision, strict=True))}


def _paths(episodes: list[Episode]) -> Iterable[Row]:
    for task, outcome in episodes:
        for robot, points in outcome["paths"].items():
            for time, x, y in points:
                yield {**_key(task), "robot": robot, "time": time, "x": x, "y": y}


def _timing(episodes: list[Episode]) -> Iterable[Row]:
    """One row per episode and component that steps."""
    for task, outcome in episodes:
        for component, timing in outcome["timing"].items():
            yield {
                **_key(task),
                "component": component,
                **timing,
                "episode_wall_time": outcome["wall_time"],
                "worker_peak_memory": outcome["peak_memory"],
                "platform": outcome["versions"]["platform"],
            }
