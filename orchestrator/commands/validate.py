"""`crowdcosim validate`: everything about a scenario that can be checked without running it."""

from __future__ import annotations

import json

from rich.console import Console

from orchestrator.scenario.controller_choice import controller_settings
from orchestrator.scenario.scenario import Scenario, load
from orchestrator.simulation import connected, ports_of_spec
from orchestrator.wiring import Graph, Member


def print_validation(scenario: str, controllers: list[str], settings: list[str], as_json: bool) -> None:
    """Print how the components of a scenario are connected, or fail with what is wrong."""
    loaded = load(scenario, [*controller_settings(scenario, controllers), *settings])
    unknown = [spec.name for spec in loaded.components if spec.use is None]
    graph = None if unknown else wire(loaded)
    if as_json:
        connections = _connections(graph) if graph else {}
        print(json.dumps({"valid": True, "scenario": loaded.name, "unknown_ports": unknown, "wiring": connections}))
        return
    console = Console(highlight=False, soft_wrap=True)
    console.print(f"[bold]{loaded.name}[/] is valid: {len(loaded.components)} components, {len(loaded.robots)} robots")
    for component, inputs in (_connections(graph) if graph else {}).items():
        for port, sources in inputs.items():
            console.print(f"  {component}.{port} [dim]<-[/] {', '.join(sources) or '[dim]nothing[/]'}")
    if unknown:
        console.print(f"  wiring not checked: only at the start will {', '.join(unknown)} say their ports")


def wire(scenario: Scenario) -> Graph:
    """The graph of a scenario whose components are all Python.

    Raises:
        ScenarioError: if they do not fit together.
    """
    members = [
        Member(
            name=spec.name,
            robot=spec.robot,
            every=spec.every,
            ports=ports_of_spec(spec),
            inputs=spec.inputs,
        )
        for spec in scenario.components
    ]
    return connected(scenario, members)


def _connections(graph: Graph) -> dict[str, dict[str, list[str]]]:
    return {
        component: {port: [f"{s.component}.{s.port}" for s in sources] for port, sources in ports.items()}
        for component, ports in graph.sources.items()
        if ports
    }
