"""`crowdcosim bench`: sweeps that are stopped, fail, move to a cluster, and still give the same rows."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import polars as pl
import pytest

from orchestrator.benchmark import worker
from orchestrator.benchmark.journal import Journal
from orchestrator.benchmark.plan import plan
from orchestrator.benchmark.tables import export
from orchestrator.scenario.controller_choice import controller_choices
from orchestrator.suites.catalogue import find_suite

HERE = Path(__file__).parent
DATA = ("results.csv", "collisions.csv", "paths.csv")
"""tables that do not know who made them, and how fast"""

CONTROLLERS = """
import os, time
from crowdcosim import Controller
from crowdcosim.messages import Odometry, Twist, Vector3

class Slow(Controller):
    '''Takes its time.'''
    def step(self, odometry: Odometry) -> Twist:
        time.sleep(0.02)
        return Twist(linear=Vector3(x=0.5))

class Wrong(Controller):
    '''Does not know what to do at 5.5 m.'''
    def step(self, odometry: Odometry) -> Twist:
        if odometry.pose.pose.position.x > 5.5:
            raise RuntimeError("lost")
        return Twist(linear=Vector3(x=0.5))

class Deadly(Controller):
    '''Takes its process with it.'''
    def step(self, odometry: Odometry) -> Twist:
        os._exit(7)

class Endless(Controller):
    '''Never answers.'''
    def step(self, odometry: Odometry) -> Twist:
        time.sleep(1000.0)
"""


@pytest.fixture
def suite(tmp_path: Path) -> Path:
    """Three scenarios of two seconds."""
    folder = tmp_path / "suite"
    folder.mkdir()
    for number in range(3):
        text = f"extends: {HERE / 'small.yaml'}\nseed: {number}\nend: {{time_limit: 2}}\n"
        text += "crowd: {config: {count: 200, reactive: false}}\n"  # so that there are collisions
        (folder / f"s{number}.yaml").write_text(text)
    (tmp_path / "mine.py").write_text(CONTROLLERS)
    return folder


def data(folder: Path) -> dict[str, bytes]:
    return {name: (folder / name).read_bytes() for name in DATA if (folder / name).exists()}


def in_this_process(suite: Path, controllers: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, bytes]:
    """The tables of a sweep that has no workers at all."""
    monkeypatch.chdir(suite.parent)
    with Journal(folder) as journal:
        for task in plan(find_suite(str(suite)), controller_choices(controllers), [], 1):
            journal.write(task, worker.run(task))
        export(journal, folder, "csv")
    return data(folder)


@pytest.mark.slow
def test_rows_do_not_depend_on_workers_or_on_where_a_sweep_was_stopped(
    crowdcosim: Any, suite: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = in_this_process(suite, "baseline,./mine.py:Slow", crowdcosim.folder / "whole", monkeypatch)
    command = ("bench", str(suite), "--controllers", "baseline,./mine.py:Slow", "-j", "2", "--out", "killed")
    killed = crowdcosim.start(*command)
    journal = crowdcosim.folder / "killed" / "journal.sqlite-wal"
    until = time.monotonic() + 90
    while killed.poll() is None and time.monotonic() < until:
        if journal.exists() and journal.stat().st_size > 20_000:  # something is written, and not yet all
            break
        time.sleep(0.01)
    os.kill(killed.pid, signal.SIGKILL)
    killed.communicate()
    assert crowdcosim.left() == []  # the workers ended with it

    resumed = crowdcosim(*command, "--json")
    assert resumed.code == 0, resumed.stderr
    assert (resumed.json["episodes"], resumed.json["failed"]) == (6, 0)
    assert 0 < resumed.json["run_now"] < 6
    assert set(whole) == set(DATA)
    assert data(crowdcosim.folder / "killed") == whole


@pytest.mark.slow
def test_an_episode_that_fails_is_told_of_and_the_rest_go_on(crowdcosim: Any, suite: Path) -> None:
    controllers = "baseline,./mine.py:Wrong,./mine.py:Deadly,./mine.py:Endless"
    outcome = crowdcosim(
        "bench", str(suite / "s0.yaml"), "--controllers", controllers, "--timeout", "8", "--out", "out", "--json"
    )
    assert outcome.code == 1
    assert (outcome.json["episodes"], outcome.json["failed"]) == (4, 3)
    failures = dict(pl.read_csv(crowdcosim.folder / "out/failures.csv").select("controller", "error").iter_rows())
    assert "'robot/controller' at tick" in failures["Wrong"] and "lost" in failures["Wrong"]
    assert failures["Deadly"] == "its worker died with exit code 7"
    assert "longer than 8 s" in failures["Endless"]
    assert pl.read_csv(crowdcosim.folder / "out/results.csv")["controller"].to_list() == ["baseline"]
    assert "failed s0, Wrong, seed 0: component 'robot/controller'" in outcome.stderr


@pytest.fixture
def scheduler(tmp_path: Path) -> Iterator[str]:
    """The address of a Dask scheduler with two workers, each a process of its own."""
    file = tmp_path / "scheduler.json"
    dask = [sys.executable, "-m", "distributed.cli.dask_scheduler", "--scheduler-file", str(file), "--port", "0"]
    work = [sys.executable, "-m", "distributed.cli.dask_worker", "--scheduler-file", str(file), "--nthreads", "2"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "cwd": tmp_path}
    processes = [subprocess.Popen([*dask, "--host", "127.0.0.1", "--no-dashboard"], **quiet)]  # type: ignore[call-overload]
    try:
        until = time.monotonic() + 60
        while not file.exists() and time.monotonic() < until:
            time.sleep(0.05)
        processes += [subprocess.Popen([*work, "--no-dashboard"], **quiet) for _ in range(2)]  # type: ignore[call-overload]
        address = json.loads(file.read_text())["address"]
        wait = "import sys, distributed as d; d.Client(sys.argv[1]).wait_for_workers(2, timeout=60)"
        subprocess.run([sys.executable, "-W", "ignore", "-c", wait, address], check=True, timeout=90)
        yield address
    finally:
        for process in reversed(processes):
            process.terminate()
        for process in processes:
            process.wait(20)


@pytest.mark.slow
def test_a_dask_cluster_gives_the_same_rows(
    crowdcosim: Any, suite: Path, scheduler: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    here = in_this_process(suite, "baseline,./mine.py:Wrong", crowdcosim.folder / "here", monkeypatch)
    command = ("bench", str(suite), "--controllers", "baseline,./mine.py:Wrong", "--json")
    there = crowdcosim(*command, "--out", "there", "--cluster", scheduler)
    assert there.code == 1, there.stderr
    assert there.json["failed"] == 3
    assert data(crowdcosim.folder / "there") == here
    failures = [(crowdcosim.folder / name / "failures.csv").read_text() for name in ("here", "there")]
    assert failures[0] == failures[1]
