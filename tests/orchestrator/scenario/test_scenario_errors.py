"""Every way to get a scenario wrong ends in one message with file, line, key, what was found and what was expected."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import load

Change = Callable[[str, str], str]


def error_of(reference: Any, *settings: str) -> str:
    with pytest.raises(ScenarioError) as caught:
        load(reference, settings)
    return str(caught.value)


def cases() -> Iterator[Any]:
    """(old lines, new lines, message) of each case in `wrong_scenarios.txt`."""
    for block in (Path(__file__).parent / "wrong_scenarios.txt").read_text().split("\n\n"):
        parts = {mark: [line[2:] for line in block.splitlines() if line.startswith(f"{mark} ")] for mark in "-+!"}
        if parts["!"]:
            old, new = ("".join(f"{line}\n" for line in parts[mark]) for mark in "-+")
            yield pytest.param(old, new, "\n".join(parts["!"]), id=parts["!"][0].removeprefix("s.yaml:"))


@pytest.mark.parametrize(("old", "new", "message"), [*cases()])
def test_one_fault_gives_one_message(changed: Change, folder: Path, old: str, new: str, message: str) -> None:
    assert error_of(changed(old, new)) == message.replace("{folder}", str(folder))


def test_two_robots_in_one_place_are_both_named(changed: Change) -> None:
    second = ["model: turtlebot2", "start: {x: 5.3, y: 5}", "goal: {x: 45, y: 5}", "drive: {use: ./mine.py:Drive}"]
    path = changed("robots:\n", "\n    ".join(["robots:\n  second:", *second]) + "\n")
    assert error_of(path) == (
        "s.yaml:17: robots.robot.start: the robot stands in 'second' (s.yaml:12): centres 0.3 m apart, "
        "expected at least 0.354 m"
    )
    assert len(load(path, ["robots.second.start.x=5.4"]).robots) == 2


def test_a_goal_without_robots_is_refused(folder: Path) -> None:
    assert error_of("base.yaml", "robots=null", "end.goal=any") == (
        "--set end.goal=any: end.goal: found 'any', expected none: there are no robots"
    )


def test_all_faults_are_reported_together_in_the_order_of_the_file(changed: Change) -> None:
    path = changed("  boundary: robots\ncrowd:\n  use: ./mine.py:People", "  bondary: robots\ncrowd:\n  use: croud")
    places = [line.split(": ")[:2] for line in error_of(path, "robots.robot.start.x=-1", "end.goal=some").splitlines()]
    assert places == [["--set end.goal=some", "end.goal"], ["s.yaml:4", "world.bondary"], ["s.yaml:6", "crowd.use"]]


def test_faults_of_components_and_places_are_reported_together(folder: Path) -> None:
    settings = ["crowd.config.count=x", "dt=1e-10", "robots.robot.model=turtle", "robots.robot.start.x=-1"]
    keys = [line.split(": ")[1] for line in error_of("base.yaml", *settings).splitlines()]
    assert keys == ["crowd.config.count", "dt", "robots.robot.model", "robots.robot.start"]


def test_a_fault_in_a_module_is_told_as_the_module_tells_it(changed: Change, folder: Path) -> None:
    (folder / "broken.py").write_text("import no_such_module\n")
    (folder / "leaving.py").write_text("raise SystemExit(3)\n")
    assert error_of(changed("use: ./mine.py:Driver", "use: ./broken.py:A")) == (
        f"s.yaml:18: robots.robot.controller.use: importing {folder}/broken.py failed: "
        "ModuleNotFoundError: No module named 'no_such_module'"
    )
    assert error_of(changed("use: ./mine.py:Driver", "use: ./leaving.py:A")) == (
        f"s.yaml:18: robots.robot.controller.use: importing {folder}/leaving.py failed: SystemExit: 3"
    )


def test_a_fault_in_a_robots_file_is_placed_there(changed: Change, folder: Path) -> None:
    (folder / "fast.yaml").write_text("extends: turtlebot2\n# fast\nmax_sped: 3\n")
    assert error_of(changed("model: turtlebot2", "model: fast.yaml")) == (
        "fast.yaml:3: robots.robot.model.max_sped: unknown key (did you mean 'max_speed'?)"
    )


def test_a_fault_in_a_base_is_placed_in_the_file_that_wrote_it(folder: Path) -> None:
    (folder / "s.yaml").write_text("extends: base.yaml\nseed: 2\n")
    (folder / "base.yaml").write_text((folder / "base.yaml").read_text().replace("dt: 0.1", "dt: -0.1"))
    assert error_of("s.yaml") == "base.yaml:1: dt: found -0.1, expected more than 0"


@pytest.mark.parametrize(
    ("extends", "problem"),
    [
        ("gone.yaml", "s.yaml:2: extends: there is no file gone.yaml"),
        ("[base.yaml,\n  basis.yaml]", "s.yaml:3: extends: there is no file basis.yaml"),
        ("coridor", "s.yaml:2: extends: there is no scenario 'coridor' (did you mean 'corridor'?); shipped: "),
        ("3", "s.yaml:2: extends: expected the name or path of a scenario, or a list"),
        ("./s.yaml", "s.yaml:2: extends: files extend each other in a loop: s.yaml -> s.yaml"),
        ("a.yaml", "b.yaml:1: extends: files extend each other in a loop: s.yaml -> a.yaml -> b.yaml -> s.yaml"),
    ],
)  # fmt: skip
def test_what_cannot_be_extended_is_placed(folder: Path, extends: str, problem: str) -> None:
    (folder / "a.yaml").write_text("extends: b.yaml\n")
    (folder / "b.yaml").write_text("extends: s.yaml\n")
    (folder / "s.yaml").write_text(f"# comment\nextends: {extends}\n")
    assert error_of("s.yaml").startswith(problem)


@pytest.mark.parametrize(
    ("reference", "problem"),
    [
        ("coridor", "coridor: there is no scenario 'coridor' (did you mean 'corridor'?); shipped: "),
        ("./gone.yaml", "./gone.yaml: there is no file gone.yaml"),
        ("coridor.yaml", "coridor.yaml: there is no file coridor.yaml (did you mean 'corridor'?)"),
        ("sub.yaml", "sub.yaml: there is no file sub.yaml"),
        ("x" * 300 + ".yaml", "x" * 300 + ".yaml: cannot read "),
        ("\0.yaml", "\0.yaml: there is no file \0.yaml"),
    ],
)
def test_a_scenario_that_is_not_there_is_named(folder: Path, reference: str, problem: str) -> None:
    (folder / "sub.yaml").mkdir()
    assert error_of(reference).startswith(problem)


@pytest.mark.parametrize(
    ("content", "problem"),
    [
        (b"", "s.yaml:1: found null, expected a mapping"),
        (b"- 1\n", "s.yaml:1: found [1], expected a mapping"),
        (b"dt: 1\nname: \xff\n", "s.yaml:2: found the byte 0xff, expected UTF-8"),
    ],
)
def test_a_file_that_is_no_scenario_is_refused(folder: Path, content: bytes, problem: str) -> None:
    (folder / "s.yaml").write_bytes(content)
    assert error_of("s.yaml") == problem


@pytest.mark.parametrize(
    ("setting", "problem"),
    [
        ("crwd.host=inline", "crwd: unknown key (did you mean 'crowd'?)"),
        ("crowd.config.count=many", "crowd.config.count: found 'many', expected a whole number"),
        ("seed.x=1", "seed: found a mapping, expected a whole number"),
        ("seed", "expected key.path=value, such as crowd.config.count=200"),
        ("=3", "expected key.path=value, such as crowd.config.count=200"),
        ("a..b=3", "expected key.path=value, such as crowd.config.count=200"),
        ("seed=[1", "seed: this is not YAML: while parsing a flow sequence, did not find expected ',' or ']'"),
        ("seed=.inf", "seed: found inf, expected a finite number"),
    ],
)
def test_a_wrong_setting_is_quoted(folder: Path, setting: str, problem: str) -> None:
    assert error_of("base.yaml", setting) == f"--set {setting}: {problem}"


def test_a_mapping_made_in_python_is_checked_as_a_file_is(folder: Path) -> None:
    assert error_of({"name": "x", "dt": 0.1, "world": {"size": (5, 5)}, "end": {"time_limt": 3}}) == (
        "scenario: end.time_limit: missing, expected a number [s]\n"
        "scenario: end.time_limt: unknown key (did you mean 'time_limit'?)"
    )


KEYS = [
    "name",
    "dt",
    "seed",
    "world",
    "size",
    "walls",
    "start",
    "end",
    "time_limit",
    "goal",
    "crowd",
    "robots",
    "robot",
]
KEYS += [
    "model",
    "drive",
    "use",
    "config",
    "count",
    "exec",
    "inputs",
    "sensors",
    "extends",
    "host",
    "x",
    "y",
    "direction",
]
WORDS = [
    "./mine.py:People",
    "./mine.py:Drive",
    "turtlebot2",
    "process",
    "all",
    "robots",
    "base.yaml",
    "corridor",
    "a.b",
]
SCALARS = st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from(WORDS) | st.text(max_size=5)
JUNK = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.sampled_from(KEYS) | st.text(max_size=3), inner, max_size=6)
    ),
    max_leaves=20,
)
QUICK = settings(max_examples=100, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])


@QUICK
@given(junk=JUNK)
def test_any_yaml_is_a_scenario_or_refused(folder: Path, junk: Any) -> None:
    (folder / "junk.yaml").write_text(yaml.dump(junk, allow_unicode=True), "utf-8", "surrogatepass")
    with contextlib.suppress(ScenarioError):
        load("junk.yaml")


@QUICK
@given(path=st.lists(st.sampled_from(KEYS), min_size=1, max_size=4), junk=JUNK)
def test_any_setting_is_taken_or_refused(folder: Path, path: list[str], junk: Any) -> None:
    with contextlib.suppress(ScenarioError):
        load("base.yaml", [f"{'.'.join(path)}={yaml.dump(junk, default_flow_style=True)}"])


@QUICK
@given(data=st.dictionaries(st.sampled_from(KEYS), JUNK))
def test_any_mapping_is_a_scenario_or_refused(folder: Path, data: dict[str, Any]) -> None:
    with contextlib.suppress(ScenarioError):
        load(data)
