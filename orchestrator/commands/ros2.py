"""`crowdcosim ros2`: a scenario that ROS 2 nodes drive."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from orchestrator.commands.tables import metrics_table
from orchestrator.errors import InputError
from orchestrator.scenario.scenario import load
from orchestrator.session import Session


def serve_ros2(
    scenario: str,
    *,
    settings: list[str],
    endpoint: str,
    domain: int,
    robots: list[str] | None,
    real_time: float | None,
    first: float,
    wait: float,
    out: Path | None,
    as_json: bool,
) -> None:
    """Run one episode with commands from ROS 2 and print what became of it."""
    for name, value in (("--realtime", real_time), ("--first", first), ("--wait", wait)):
        if value is not None and not value > 0:
            raise InputError(f"{name} is {value}, expected a positive number")
    if not 0 <= domain <= 232:
        raise InputError(f"--domain is {domain}, expected a ROS_DOMAIN_ID from 0 to 232")
    try:
        from orchestrator.ros2.gateway import Gateway, Waiting
        from orchestrator.ros2.node import Ros2Node
    except ModuleNotFoundError as error:
        raise InputError(f"ROS 2 needs {error.name}: pip install 'crowdcosim[ros2]'") from None

    console = Console(highlight=False, soft_wrap=True, stderr=as_json)
    commanded = robots or [robot.name for robot in load(scenario, settings).robots]
    if not commanded:
        raise InputError(f"{scenario} has no robots: there is nothing for ROS 2 to drive")
    with Session(scenario, settings, commanded=commanded, real_time=real_time, record=out) as session:
        node = Ros2Node(endpoint, domain=domain)
        try:
            role = "the router" if node.is_router else "a client of the router"
            console.print(f"{role} at {endpoint}, domain {domain}; {', '.join(commanded)} waits for commands")
            Gateway(session, node).run(None if real_time else Waiting(first=first, next=wait))
        finally:
            node.close()
        result = session.result
    assert result is not None
    if as_json:
        print(json.dumps(asdict(result)))
        return
    console.print(f"{result.outcome} after {result.simulated_time:g} s")
    console.print(metrics_table(result.metrics))
