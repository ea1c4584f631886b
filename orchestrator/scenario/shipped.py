"""The scenarios, robots and components that come with crowdcosim, with a line about each."""

from __future__ import annotations

import ast
import importlib.util
from itertools import takewhile
from pathlib import Path
from typing import NamedTuple

import orchestrator
from orchestrator.scenario.problems import Place, ScenarioError
from orchestrator.scenario.registry import SHIPPED
from orchestrator.scenario.yaml_tree import parse


class Entry(NamedTuple):
    """One line of `crowdcosim list`."""

    name: str
    """what a scenario or the command line calls it"""
    description: str


def scenarios_folder() -> Path:
    """Where the shipped scenarios are: beside the package in a checkout, within it in an installed wheel."""
    package = Path(orchestrator.__file__).parent
    installed = package / "scenarios"
    return installed if installed.is_dir() else package.parent / "scenarios"


def robots_folder() -> Path:
    return scenarios_folder() / "robots"


def devices_folder() -> Path:
    return scenarios_folder() / "devices"


def names_in(folder: Path) -> list[str]:
    """The names of a folder's YAML files, subfolders included: `corridor`, `paper/one`."""
    return sorted(path.relative_to(folder).with_suffix("").as_posix() for path in folder.rglob("*.yaml"))


def scenario_names() -> list[str]:
    """Every shipped scenario, those of suites too: `corridor`, `paper/rvo05-reactive_1d+_050`."""
    return [name for name in names_in(scenarios_folder()) if not name.startswith(("robots/", "devices/"))]


def suite_names() -> list[str]:
    """The shipped suites: the folders of scenarios."""
    return sorted({name.rpartition("/")[0] for name in scenario_names() if "/" in name})


def list_scenarios() -> list[Entry]:
    """Every shipped scenario that is in no suite, with its `description`."""
    alone = [name for name in scenario_names() if "/" not in name]
    return [Entry(name, _description(scenarios_folder() / f"{name}.yaml")) for name in alone]


def list_suites() -> list[Entry]:
    """Every shipped suite, with the number of its scenarios and the name of the first."""
    names = scenario_names()
    members = {suite: [name for name in names if name.startswith(f"{suite}/")] for suite in suite_names()}
    return [Entry(suite, f"{len(m)} scenarios: {m[0]}, ...") for suite, m in members.items()]


def list_robots() -> list[Entry]:
    """Every shipped robot model, with the first sentence of the comment that opens its file."""
    return [Entry(name, _opening_comment(robots_folder() / f"{name}.yaml")) for name in names_in(robots_folder())]


def list_devices() -> list[Entry]:
    """Every shipped device, a sensor's `preset`, with the first sentence of the comment that opens its file."""
    return [Entry(name, _opening_comment(devices_folder() / f"{name}.yaml")) for name in names_in(devices_folder())]


def list_components() -> dict[str, list[Entry]]:
    """Every shipped component by family, with its class's first line; nothing is imported for it."""
    return {
        family: [Entry(name, _docstring(use)) for name, use in sorted(members.items())]
        for family, members in SHIPPED.items()
    }


def _description(path: Path) -> str:
    try:
        node = parse(path.read_text("utf-8"), Place(str(path), 1)).child("description")
    except (OSError, UnicodeDecodeError, ScenarioError):
        return "(cannot be read)"
    return " ".join(str(node.value).split()) if node else ""


def _opening_comment(path: Path) -> str:
    lines = takewhile(lambda line: line.startswith("#"), path.read_text("utf-8").splitlines())
    comment = " ".join(line.removeprefix("#").strip() for line in lines)
    return comment.partition(". ")[0].removesuffix(".") + "." if comment else ""


def _docstring(use: str) -> str:
    module, _, name = use.partition(":")
    spec = importlib.util.find_spec(module)
    if spec is None or spec.origin is None:
        return "(not installed)"
    tree = ast.parse(Path(spec.origin).read_text("utf-8"))
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef) and node.name == name]
    return (ast.get_docstring(classes[0]) or "").partition("\n")[0] if classes else "(not installed)"
