"""What comes with crowdcosim: it loads, it says what it is, and a wrong name finds the right one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import orchestrator
from crowdcosim.component import ComponentError, config_adapter
from orchestrator.scenario.registry import SHIPPED, Family, component_class, import_string
from orchestrator.scenario.scenario import load
from orchestrator.scenario.shipped import list_components, list_robots, list_scenarios, scenario_names, scenarios_folder


@pytest.mark.parametrize("name", [name for name in scenario_names() if not name.startswith("paper/")])
def test_shipped_scenarios_load(name: str) -> None:
    scenario = load(name)
    assert load(scenario.resolved) == scenario
    assert scenario.description


@pytest.mark.parametrize(("family", "name"), [(f, n) for f, members in SHIPPED.items() for n in members])
def test_short_names_stand_for_components_whose_options_have_a_schema(family: Family, name: str) -> None:
    cls = component_class(import_string(name, family, Path()), family)
    assert config_adapter(cls).json_schema()["type"] == "object"


def test_everything_listed_has_a_description() -> None:
    entries = [*list_scenarios(), *list_robots(), *(e for family in list_components().values() for e in family)]
    assert {"corridor", "two_robots", "turtlebot2", "crowd", "dwa", "paper"} <= {entry.name for entry in entries}
    assert [entry for entry in entries if not entry.description or entry.description.startswith("(")] == []


def test_a_list_imports_no_component() -> None:
    program = (
        "import sys; from orchestrator.scenario.shipped import list_components as l; l(); print('numba' in sys.modules)"
    )
    assert subprocess.check_output([sys.executable, "-c", program], text=True).strip() == "False"


def test_an_installed_wheel_holds_its_scenarios_in_the_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checkout = Path(orchestrator.__file__).parent.parent
    assert scenarios_folder() == checkout / "scenarios"
    package = tmp_path / "orchestrator"
    (package / "scenarios").mkdir(parents=True)
    monkeypatch.setattr(orchestrator, "__file__", str(package / "__init__.py"))
    assert scenarios_folder() == package / "scenarios"


def test_the_default_experiment_is_the_papers_corridor() -> None:
    scenario = load("corridor")
    assert scenario.world.size == (50.0, 10.0)
    assert scenario.world.periodic == (True, True)
    assert [wall.stops_people for wall in scenario.world.walls] == [False] * 4
    assert (scenario.period, scenario.last_tick) == (100_000_000, 1800)
    (robot,) = scenario.robots
    assert robot.goal.x - robot.start.x == 40.0
    crowd = scenario.component("crowd").config
    assert (crowd["policy"], crowd["flow"], crowd["count"], crowd["reactive"]) == ("orca", "1d-", 100, True)


def test_two_robots_have_controllers_of_their_own() -> None:
    scenario = load("two_robots")
    assert [(r.name, r.number) for r in scenario.robots] == [("left", 1), ("right", 2)]
    controllers = [c.use for c in scenario.components if c.name.endswith("/controller")]
    assert len(set(controllers)) == 2


@pytest.mark.parametrize(
    ("use", "message"),
    [
        ("dw", r"there is no controller 'dw' \(did you mean 'dwa'\?\)"),
        ("lidar", "'lidar' is a sensor, expected a controller: baseline, dwa"),
        ("", "there is no controller ''; shipped"),
        ("mine.py", "expected the class too: 'mine.py:Class'"),
    ],
)
def test_a_name_that_is_not_on_the_list_is_refused(use: str, message: str) -> None:
    with pytest.raises(ComponentError, match=message):
        import_string(use, "controller", Path())


@pytest.mark.parametrize("use", [":", "a:", ":b", "a b:c", "..:x", "\udc80:x", "x" * 300 + ".py:A"])
def test_a_string_that_names_no_module_is_refused(use: str) -> None:
    with pytest.raises(ComponentError):
        component_class(import_string(use, "controller", Path()), "controller")
