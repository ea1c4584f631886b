"""A controller as the command line names it, put into a scenario in place of its own."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from crowdcosim.component import ComponentError
from orchestrator.errors import InputError
from orchestrator.scenario.problems import Place, ScenarioError, near_miss
from orchestrator.scenario.registry import component_class, import_string
from orchestrator.scenario.scenario import load
from orchestrator.scenario.yaml_tree import parse


@dataclass(frozen=True, kw_only=True)
class ControllerChoice:
    """One controller with its options."""

    label: str
    """what tables call it"""
    entry: Mapping[str, Any]
    """as a scenario would write it under `controller`; paths are absolute"""

    def settings(self, robots: Iterable[str]) -> list[str]:
        """`--set` values that put it in the place of these robots' controllers, options included."""
        text = json.dumps(dict(self.entry))
        keys = [f"robots.{robot}.controller" for robot in robots]
        return [setting for key in keys for setting in (f"{key}=null", f"{key}={text}")]

    def fingerprint(self) -> str:
        """SHA-256 of what it is: its entry, and its file where it is one of the user's."""
        digest = hashlib.sha256(json.dumps(dict(self.entry), sort_keys=True).encode())
        source = str(self.entry.get("use", "")).rpartition(":")[0]
        if source.endswith(".py"):
            digest.update(Path(source).read_bytes())
        return digest.hexdigest()


def controller_choice(text: str) -> ControllerChoice:
    """What `text` names: a shipped controller, `package.module:Class`, `./file.py:Class`, or `./file.yaml`.

    A YAML file holds what a scenario would write under `controller`, and gives its name as the label.

    Raises:
        InputError: if there is no such controller.
    """
    if text.endswith((".yaml", ".yml")):
        return _from_file(Path(text))
    try:
        use = import_string(text, "controller", Path.cwd())
        cls = component_class(use, "controller")
    except ComponentError as error:
        raise InputError(f"controller '{text}': {error}") from None
    return ControllerChoice(label=text if ":" not in text else cls.__name__, entry={"use": use})


def _from_file(path: Path) -> ControllerChoice:
    try:
        entry = parse(path.read_text("utf-8"), Place(str(path), 1)).plain()
    except (OSError, UnicodeDecodeError) as error:
        raise InputError(f"controller '{path}': cannot be read: {error}") from None
    except ScenarioError as error:
        raise InputError(str(error)) from None
    if not isinstance(entry, dict) or not ("use" in entry or "exec" in entry):
        raise InputError(f"controller '{path}': expected a mapping with `use` or `exec`, as under a robot's controller")
    folder = path.resolve().parent
    if "use" in entry:
        try:
            entry["use"] = import_string(str(entry["use"]), "controller", folder)
        except ComponentError as error:
            raise InputError(f"controller '{path}': {error}") from None
    else:
        entry["cwd"] = str(folder / entry.get("cwd", ""))
    return ControllerChoice(label=path.stem, entry=entry)


def controller_choices(text: str) -> tuple[ControllerChoice, ...]:
    """The controllers of a comma-separated list.

    Raises:
        InputError: if one is not there, or two have the same label.
    """
    choices = tuple(controller_choice(item.strip()) for item in text.split(",") if item.strip())
    labels = [choice.label for choice in choices]
    if not labels:
        raise InputError("--controllers is empty, expected names such as baseline,dwa,./mine.py:Mine")
    for label in labels:
        if labels.count(label) > 1:
            raise InputError(
                f"--controllers names '{label}' {labels.count(label)} times, expected different names: "
                "put one of them into a YAML file of its own (use: ..., config: ...)"
            )
    return choices


def controller_settings(scenario: str | Path, texts: Sequence[str]) -> list[str]:
    """`--set` values that put controllers into a scenario: `CONTROLLER` for the only robot, or `ROBOT=CONTROLLER`.

    Raises:
        InputError: if there is no such robot or controller, or it is not clear which robot is meant.
    """
    if not texts:
        return []
    robots = [robot.name for robot in load(scenario).robots]
    chosen: dict[str, ControllerChoice] = {}
    for text in texts:
        named = re.fullmatch(r"([A-Za-z][A-Za-z0-9_-]*)=(.*)", text)
        robot, controller = named.groups() if named else (robots[0] if len(robots) == 1 else "", text)
        if not robot:
            raise InputError(f"--controller {text}: whose? Expected ROBOT={text} with one of {', '.join(robots)}")
        if robot not in robots:
            known = f"{near_miss(robot, robots)}; robots: {', '.join(robots)}"
            raise InputError(f"--controller {text}: there is no robot '{robot}'{known}")
        if robot in chosen:
            raise InputError(f"--controller is given twice for {robot}, expected once")
        chosen[robot] = controller_choice(controller)
    return [setting for robot, choice in chosen.items() for setting in choice.settings([robot])]
