"""Writes `smoke.csv`, the scores of the smoke suite: `python tests/scores/regenerate.py`."""

from __future__ import annotations

import tempfile
from pathlib import Path

import polars as pl

from orchestrator.benchmark import sweep
from orchestrator.benchmark.journal import Journal
from orchestrator.benchmark.plan import plan
from orchestrator.benchmark.sweep import Where
from orchestrator.benchmark.tables import export, read
from orchestrator.scenario.controller_choice import controller_choices
from orchestrator.suites.catalogue import find_suite

FILE = Path(__file__).parent / "smoke.csv"
KEY = ("scenario", "controller")
SCORES = (
    "time",
    "path_length",
    "velocity_variation",
    "neighbour_velocity",
    "neighbour_reaction",
    "proximity",
    "colliding",
    "collision_rate",
    "collision_energy_rate",
    "near_collision_share",
)
LIMIT = 30.0
"""of each episode [s]: enough to see a change, and soon over"""


def scores() -> pl.DataFrame:
    """The smoke suite's scores by scenario and controller, rounded to what a table shows."""
    tasks = plan(find_suite("smoke"), controller_choices("baseline,dwa,rvo"), [f"end.time_limit={LIMIT}"], 1)
    with tempfile.TemporaryDirectory() as name, Journal(Path(name)) as journal:
        failed = [outcome["error"] for _, outcome in sweep.run(tasks, journal, Where()) if outcome["status"] != "done"]
        if failed:
            raise RuntimeError("\n".join(failed))
        export(journal, Path(name), "csv")
        results = read(Path(name))["results"]
    return results.select(*KEY, *(pl.col(score).cast(pl.Float64).round(4) for score in SCORES)).sort(KEY)


if __name__ == "__main__":
    scores().write_csv(FILE)
