"""The JSON Schema accepts what the loader accepts, refuses what an editor can know to be wrong, and explains itself."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import yaml

from orchestrator.scenario.registry import SHIPPED
from orchestrator.scenario.scenario import load
from orchestrator.scenario.schema import schema
from orchestrator.scenario.shipped import scenario_names, scenarios_folder


@pytest.fixture(scope="module")
def whole() -> dict[str, Any]:
    return schema()


@pytest.fixture(scope="module")
def validator(whole: dict[str, Any]) -> Any:
    jsonschema = pytest.importorskip("jsonschema")
    jsonschema.Draft202012Validator.check_schema(whole)
    return jsonschema.Draft202012Validator(whole)


def test_the_schema_is_json_and_says_what_it_is(whole: dict[str, Any]) -> None:
    assert json.loads(json.dumps(whole)) == whole
    assert whole["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert whole["$id"].startswith("urn:")


def test_every_reference_leads_somewhere(whole: dict[str, Any]) -> None:
    def references(part: Any) -> list[str]:
        if isinstance(part, list):
            return [r for item in part for r in references(item)]
        if isinstance(part, dict):
            own = [part["$ref"]] if isinstance(part.get("$ref"), str) else []
            return own + [r for value in part.values() for r in references(value)]
        return []

    found = set(references(whole))
    assert found
    assert {reference.removeprefix("#/$defs/") for reference in found} <= set(whole["$defs"])


def test_keys_are_described_with_their_units(whole: dict[str, Any]) -> None:
    assert whole["$defs"]["scenario"]["properties"]["dt"]["description"] == "time step, whole nanoseconds [s]"
    assert whole["$defs"]["RobotModel"]["properties"]["max_speed"]["description"] == "forward speed limit [m/s]"


def test_the_options_of_every_shipped_component_are_known_and_described(whole: dict[str, Any]) -> None:
    for family, members in SHIPPED.items():
        for name in members:
            config = whole["$defs"][f"{family}.{name}"]
            assert config["additionalProperties"] is False
            assert all(p.get("description") for p in config["properties"].values()), f"{family}.{name}"


@pytest.mark.parametrize("name", [name for name in scenario_names() if not name.startswith("paper")])
def test_shipped_scenarios_satisfy_the_schema(validator: Any, name: str) -> None:
    text = (scenarios_folder() / f"{name}.yaml").read_text("utf-8")
    validator.validate(yaml.safe_load(text))
    validator.validate(load(name).resolved)


def test_the_tests_own_scenario_satisfies_the_schema(validator: Any, folder: Path) -> None:
    validator.validate(yaml.safe_load((folder / "base.yaml").read_text()))


SMALL = {"dt": 0.1, "world": {"size": [5, 5]}, "end": {"time_limit": 1}}
DRIVEN = {"start": {"x": 1, "y": 1}, "goal": {"x": 4, "y": 4}, "drive": {"use": "kinematic"}}


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"dt": 0}, ["dt"]),
        ({"dt": None}, ["dt"]),
        ({"colour": 1}, []),
        ({"world": {}}, ["world"]),
        ({"world": {"size": [1, 2], "boundary": "robot"}}, ["world", "boundary"]),
        ({"crowd": {"use": "crowd", "config": {"cuont": 3}}}, ["crowd"]),
        ({"crowd": {"use": "dwa"}}, ["crowd"]),
        ({"robots": {"no name": DRIVEN | {"model": "turtlebot2"}}}, ["robots"]),
        ({"robots": {"robot": DRIVEN | {"model": "turtlebot"}}}, ["robots", "robot", "model"]),
        ({"robots": {"robot": DRIVEN | {"model": {"radius": 1}}}}, ["robots", "robot", "model"]),
        ({"robots": {"robot": DRIVEN}}, ["robots", "robot"]),
        ({"extends": "corridor", "world": {"sizes": [5, 5]}}, ["world"]),
        ({"extends": "coridor"}, ["extends"]),
    ],
)
def test_what_an_editor_can_know_to_be_wrong_is_refused(validator: Any, change: Any, path: list[str]) -> None:
    assert not list(validator.iter_errors(SMALL))
    errors = list(validator.iter_errors(SMALL | change))
    assert errors
    assert path in [list(error.absolute_path)[: len(path)] for error in errors]


@pytest.mark.parametrize(
    "data",
    [
        {"extends": "corridor"},
        {"extends": ["corridor", "./mine.yaml"], "seed": 3, "evaluator": None},
        {"extends": "corridor", "robots": {"robot": {"controller": {"use": "rvo"}, "model": {"max_speed": 0.5}}}},
        {"extends": "corridor", "crowd": {"config": {"count": 3}}, "world": {"periodic": None}},
        SMALL | {"crowd": {"use": "./mine.py:People", "config": {"anything": 1}}},
        SMALL | {"crowd": {"exec": ["./people", "--fast"], "cwd": "bin"}},
        SMALL | {"robots": {"robot": DRIVEN | {"model": {"extends": "turtlebot2", "max_speed": 0.5}}}},
        SMALL | {"robots": {"robot": DRIVEN | {"model": "./mine.yaml"}}},
    ],
)
def test_what_may_be_right_is_accepted(validator: Any, data: Any) -> None:
    validator.validate(data)
