"""What a sweep has to run: one task per scenario, controller and seed."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from orchestrator.scenario.controller_choice import ControllerChoice
from orchestrator.scenario.scenario import Scenario, load
from orchestrator.suites.catalogue import Suite


@dataclass(frozen=True, kw_only=True)
class Task:
    """One episode of a sweep, as plain data that any worker understands."""

    suite: str
    scenario: str
    scenario_hash: str
    """SHA-256 of the scenario but for its controllers, hosts and seed"""
    controller: str
    """label"""
    controller_hash: str
    seed: int
    resolved: Mapping[str, Any]
    """the scenario as `Scenario.resolved` has it"""
    settings: tuple[str, ...]
    """laid over it"""

    @property
    def key(self) -> str:
        """What it is called in the journal; no two tasks of a sweep have the same."""
        return f"{self.scenario} {self.controller} {self.seed}"

    @property
    def fingerprint(self) -> str:
        """What its result depends on, besides our own code."""
        return f"{self.scenario_hash} {self.controller_hash}"


def plan(
    suite: Suite, controllers: Sequence[ControllerChoice], settings: Sequence[str], seeds: int
) -> tuple[Task, ...]:
    """Every controller in every scenario, with the scenario's seed s and those after it up to s + `seeds` - 1.

    Raises:
        ScenarioError: if a scenario is wrong, or a controller does not fit into the first of them.
    """
    scenarios = [load(str(file), settings) for file in suite.files]
    for choice in controllers:
        load(scenarios[0].resolved, choice.settings(_robots(scenarios[0])))
    fingerprints = {choice.label: choice.fingerprint() for choice in controllers}
    return tuple(
        Task(
            suite=suite.name,
            scenario=scenario.name,
            scenario_hash=scenario_hash(scenario.resolved),
            controller=choice.label,
            controller_hash=fingerprints[choice.label],
            seed=scenario.seed + further,
            resolved=scenario.resolved,
            settings=("host=inline", f"seed={scenario.seed + further}", *choice.settings(_robots(scenario))),
        )
        for scenario in scenarios
        for choice in controllers
        for further in range(seeds)
    )


def scenario_hash(resolved: Mapping[str, Any]) -> str:
    """SHA-256 of a resolved scenario, but for its controllers, hosts and seed."""
    rest = _without(resolved, ("controller", "host", "seed"))
    return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def _without(value: Any, keys: tuple[str, ...]) -> Any:
    if isinstance(value, Mapping):
        return {key: _without(item, keys) for key, item in value.items() if key not in keys}
    return value


def _robots(scenario: Scenario) -> Iterator[str]:
    return (robot.name for robot in scenario.robots)
