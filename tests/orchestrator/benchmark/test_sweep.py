"""The parts of a sweep: what is planned, what is kept, what is refused, what comes out as tables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import polars as pl
import pytest
from typer.testing import CliRunner

from orchestrator.benchmark import sweep
from orchestrator.benchmark.journal import Journal
from orchestrator.benchmark.plan import Task, plan, scenario_hash
from orchestrator.benchmark.sweep import remaining
from orchestrator.benchmark.tables import export, read
from orchestrator.cli import app
from orchestrator.errors import InputError
from orchestrator.log.provenance import versions
from orchestrator.scenario.controller_choice import controller_choice, controller_choices
from orchestrator.scenario.scenario import load
from orchestrator.suites.catalogue import find_suite

TASK = Task(
    suite="suite",
    scenario="one",
    scenario_hash="s",
    controller="dwa",
    controller_hash="c",
    seed=1,
    resolved={},
    settings=(),
)


def outcome(**changes: Any) -> dict[str, Any]:
    metric = {"robot": "robot", "name": "time", "value": 1.5, "unit": "s", "reason": ""}
    return {
        "status": "done",
        "factors": {"flow": "1d+", "people": 3},
        "outcome": "goal",
        "arrived": ["robot"],
        "ticks": 15,
        "simulated_time": 1.5,
        "metrics": [metric, metric | {"name": "path_length_ratio", "value": None, "reason": "no way"}],
        "collisions": {"robot": [[0.3, 7, 2, 1.0, 5.2, 1.0, 2.0]]},
        "paths": {"robot": [[0.0, 1.0, 2.0], [0.5, 1.5, 2.0]]},
        "versions": versions(),
        "wall_time": 0.1,
        "timing": {"crowd": {"steps": 15, "mean": 1e-4, "median": 1e-4, "p99": 2e-4, "max": 3e-4}},
        "peak_memory": 10**8,
    } | changes


def test_a_plan_has_every_controller_in_every_scenario_with_every_seed() -> None:
    tasks = plan(find_suite("smoke"), controller_choices("baseline,rvo"), [], 2)
    assert len(tasks) == len({task.key for task in tasks}) == 10 * 2 * 2
    first = tasks[0]
    loaded = load(first.resolved, first.settings)
    assert loaded.component("robot/controller").use == "components.controllers.baseline:Baseline"
    assert {component.host for component in loaded.components} == {"inline"}
    assert (loaded.seed, load(tasks[1].resolved, tasks[1].settings).seed) == (first.seed, first.seed + 1)


def test_the_hash_of_a_scenario_is_that_of_all_but_controller_host_and_seed() -> None:
    base = load("corridor")
    same = load("corridor", ["seed=9", "host=inline", "robots.robot.controller={use: rvo}"])
    other = load("corridor", ["crowd.config.count=101"])
    assert scenario_hash(base.resolved) == scenario_hash(same.resolved) != scenario_hash(other.resolved)


def test_a_controller_replaces_that_of_the_scenario_with_its_options() -> None:
    scenario = load("corridor", ["robots.robot.controller.config.horizon=2.5"])
    chosen = load(scenario.resolved, controller_choice("dwa").settings(["robot"]))
    assert chosen.component("robot/controller").config == load("corridor").component("robot/controller").config


def test_a_controller_of_a_file_brings_its_options_and_its_name(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("")
    (tmp_path / "slow.yaml").write_text("use: baseline\nconfig: {speed: 0.5}\n")
    choice = controller_choice(str(tmp_path / "slow.yaml"))
    assert choice.label == "slow"
    scenario = load("corridor", choice.settings(["robot"]))
    assert scenario.component("robot/controller").config["speed"] == 0.5
    (tmp_path / "own.yaml").write_text("use: ./mine.py:Mine\n")
    assert controller_choice(str(tmp_path / "own.yaml")).entry["use"] == f"{tmp_path}/mine.py:Mine"


@pytest.mark.parametrize(
    ("text", "message"),
    [("- 1", "expected a mapping"), ("a: [", "not YAML"), ("use: dwaa", "did you mean 'dwa'"), ("{}", "`use` or")],
)
def test_a_file_that_is_no_controller_is_refused(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "wrong.yaml").write_text(text)
    with pytest.raises(InputError, match=message):
        controller_choice(str(tmp_path / "wrong.yaml"))


def test_a_users_controller_is_another_when_its_file_has_changed(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    code = "from crowdcosim import Controller\nfrom crowdcosim.messages import Goal, Twist\n"
    code += "class Mine(Controller):\n    def step(self, goal: Goal) -> Twist:\n        return Twist()\n"
    file.write_text(code)
    before = controller_choice(f"{file}:Mine")
    file.write_text(code + "\n")
    assert before.label == "Mine"
    assert controller_choice(f"{file}:Mine").fingerprint() != controller_choice("dwa").fingerprint()
    fingerprint = before.fingerprint()
    file.write_text(code)
    assert before.fingerprint() != fingerprint


def test_what_is_done_is_not_done_again_and_what_failed_is(tmp_path: Path) -> None:
    other = replace(TASK, controller="rvo")
    with Journal(tmp_path) as journal:
        journal.write(TASK, outcome())
        journal.write(other, {"status": "failed", "error": "no luck"})
    with Journal(tmp_path) as journal:
        assert remaining((TASK, other), journal, tmp_path) == [other]


@pytest.mark.parametrize("change", [{"scenario_hash": "t"}, {"controller_hash": "d"}])
def test_results_of_another_scenario_or_controller_are_never_mixed(tmp_path: Path, change: dict[str, str]) -> None:
    with Journal(tmp_path) as journal:
        journal.write(TASK, outcome())
        with pytest.raises(InputError, match="results of another scenario 'one' or controller 'dwa'"):
            remaining((replace(TASK, **change),), journal, tmp_path)


def test_results_of_other_versions_are_never_mixed(tmp_path: Path) -> None:
    with Journal(tmp_path) as journal:
        journal.write(TASK, outcome(versions=versions() | {"numpy": "1.0"}))
        with pytest.raises(InputError, match="made with numpy 1.0, this is"):
            remaining((TASK,), journal, tmp_path)


def test_two_sweeps_at_once_in_a_folder_are_refused(tmp_path: Path) -> None:
    with Journal(tmp_path), pytest.raises(InputError, match="is another sweep at work there"):
        Journal(tmp_path)


def test_tables_hold_the_metrics_by_name_and_nothing_where_there_is_no_value(tmp_path: Path) -> None:
    with Journal(tmp_path) as journal:
        journal.write(TASK, outcome())
        journal.write(replace(TASK, scenario="two"), {"status": "failed", "error": "no luck"})
        files = export(journal, tmp_path, "csv")
    tables = read(tmp_path)
    (row,) = tables["results"].to_dicts()
    assert (row["time"], row["path_length_ratio"], row["arrived"], row["people"]) == (1.5, None, True, 3)
    assert row["versions"].startswith("crowdcosim=")
    assert tables["collisions"].row(0) == ("one", "dwa", 1, "robot", 0.3, 7, 2, 1.0, 5.2, 1.0, 2.0)
    assert tables["paths"]["x"].to_list() == [1.0, 1.5]
    assert tables["failures"].row(0) == ("two", "dwa", 1, "no luck")
    assert set(files) == set(tables)


def test_a_parquet_table_holds_what_a_csv_table_holds(tmp_path: Path) -> None:
    with Journal(tmp_path) as journal:
        journal.write(TASK, outcome())
        export(journal, tmp_path, "csv")
        csv = read(tmp_path)
        export(journal, tmp_path, "parquet")
    assert not list(tmp_path.glob("*.csv"))
    for name, table in read(tmp_path).items():
        assert table.write_csv() == csv[name].write_csv()


def test_a_folder_without_results_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="holds no results"):
        read(tmp_path)


def test_a_sweep_of_nothing_starts_no_worker(tmp_path: Path) -> None:
    with Journal(tmp_path) as journal:
        assert list(sweep.run((), journal, sweep.Where(cluster="tcp://nobody:1"))) == []
        assert pl.DataFrame(list(journal.episodes())).is_empty()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["smok"], "did you mean 'smoke'?"),
        (["smoke", "-c", "dwaa"], "did you mean 'dwa'?"),
        (["smoke", "-c", "dwa,dwa"], "names 'dwa' 2 times"),
        (["smoke", "-c", ","], "--controllers is empty"),
        (["smoke", "-j", "0"], "--workers is 0"),
        (["smoke", "--timeout", "-1"], "--timeout is -1"),
        (["smoke", "--set", "crowd.config.cuont=3"], "did you mean 'count'?"),
    ],
)
def test_a_wrong_option_is_refused_before_anything_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], message: str
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = CliRunner().invoke(app, ["bench", *arguments, "--json"])
    assert outcome.exit_code == 2
    assert message in outcome.output
    assert not list(tmp_path.iterdir())
