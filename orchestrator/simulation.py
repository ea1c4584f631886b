"""A scenario brought to life: components started where the scenario wants them, introduced, wired and configured."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from crowdcosim.bus import Bus, BusError
from crowdcosim.component import Component, ComponentError, Kind, Output, Ports, make, ports_with
from crowdcosim.host import FOREVER, ComponentHost, Source, blame
from crowdcosim.loading import load_class
from crowdcosim.messages import Goal, Header
from crowdcosim.robots import Robot
from crowdcosim.setup import Setup
from orchestrator.attach import awaited, invitation
from orchestrator.errors import InputError, RunError, WiringError
from orchestrator.latency import CommandInEffect, command_of, with_commands
from orchestrator.lockstep import Lockstep
from orchestrator.processes import Processes
from orchestrator.remote import Remote
from orchestrator.scenario.component_specs import ComponentSpec
from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import Scenario
from orchestrator.wiring import Graph, Member, connect

PRELOAD = ["numpy", "numba", "pydantic", "rosbags.typesys", "crowdcosim.node"]
"""What the launcher imports once for all components."""

GOAL_PORTS = Ports(kind="reactor", inputs=(), outputs=(Output(name="goal", type=Goal),))


class Simulation:
    """All components of a scenario, ready for `lockstep.reset`. Close it, whatever happens."""

    def __init__(
        self,
        scenario: Scenario,
        *,
        logs: Path,
        processes: Processes | None = None,
        status: Callable[[str], None] = lambda text: None,
        commanded: Collection[str] = (),
    ) -> None:
        """Start and connect everything.

        Args:
            logs: folder for what the components' processes print.
            processes: a launcher that is already warming up.
            status: told what is being waited for.
            commanded: inline components whose say comes from outside, in the midst of a tick.

        Raises:
            InputError: if the components do not fit the scenario or each other.
            RunError: if a component dies, refuses or keeps silent at start-up.
        """
        self.scenario = scenario
        self._specs = {spec.name: spec for spec in scenario.components}
        self._remote: Remote | None = None
        outside = [spec for spec in scenario.components if spec.host != "inline"]
        self._processes = (processes or Processes()) if outside else processes
        try:
            if outside:
                self._remote = self._start(outside, logs, status)
            self.graph = self._wire()
            self._hosts = {s.name: self._inline_host(s) for s in scenario.components if s.host == "inline"}
            self._hosts |= {command_of(s): self._command(s) for s in scenario.components if s.latency}
            if self._remote:
                self._remote.configure({spec.name: self._configuration(spec) for spec in outside})
                self._remote.connect()
        except BaseException:
            self.close(stop=False)
            raise
        self.goals = {robot.name: goal_of(robot) for robot in scenario.robots}
        """robot -> its goal"""
        self.lockstep = Lockstep(
            self.graph,
            period=scenario.period,
            constants={(f"{robot}/goal", "goal"): goal for robot, goal in self.goals.items()},
            inline=self._hosts,
            remote=self._remote,
            trusted=frozenset(s.name for s in scenario.components if s.host in ("inline", "process")),
            commanded=frozenset(commanded),
        )

    @property
    def inline(self) -> bool:
        """True if all components live in this process."""
        return self._remote is None

    def hosted(self, component: str) -> Component:
        """An inline component."""
        return self._hosts[component].component

    def reseed(self, seed: int) -> None:
        """From the next reset on, the scenario with another seed; all components must be inline."""
        assert self.inline, "components elsewhere have been told their seed for good"
        self.scenario = replace(self.scenario, seed=seed, resolved={**self.scenario.resolved, "seed": seed})
        for name, host in self._hosts.items():
            host.setup = replace(host.setup, seed=component_seed(seed, name))

    def setup(self, component: str) -> Setup:
        """What `component` is told at the start, but for what each episode adds."""
        spec = self._specs[component]
        return setup_of(self.scenario, component, spec.robot, spec.every)

    def close(self, *, stop: bool = True) -> None:
        """End all processes: told to leave first, unless the run has failed."""
        if self._remote:
            self._remote.stop() if stop else self._remote.close()
        if self._processes:
            self._processes.close()
        self._remote = self._processes = None

    def _start(self, outside: list[ComponentSpec], logs: Path, status: Callable[[str], None]) -> Remote:
        assert self._processes is not None
        try:
            bus = Bus.listen(admission=self.scenario.admission)
        except BusError as error:
            raise InputError(str(error)) from None
        logs.mkdir(parents=True, exist_ok=True)
        remote = Remote(
            bus,
            self._processes,
            self.scenario.name,
            [spec.name for spec in outside],
            logs=logs,
            start_deadline=self.scenario.deadlines.start,
            step_deadline=self.scenario.deadlines.step,
            status=status,
            awaited={spec.name: awaited(self.scenario.admission) for spec in outside if spec.host == "external"},
        )
        self._remote = remote
        address = {"endpoint": bus.endpoint, "run": self.scenario.name, **bus.identity}
        for spec in outside:
            log = remote.log_of(spec.name)
            if spec.host == "process":
                assert spec.use is not None
                self._processes.fork(spec.name, spec.use, log=log, **address)
            elif spec.host == "exec":
                variables = {f"CROWDCOSIM_{k.upper()}": v for k, v in (address | {"component": spec.name}).items()}
                self._processes.execute(
                    spec.name, spec.exec, folder=spec.cwd or Path.cwd(), environment=variables, log=log
                )
            else:
                status(invitation(self.scenario.name, spec.name, self.scenario.admission, bus.endpoint))
        return remote

    def _wire(self) -> Graph:
        told = self._remote.hello(self._options()) if self._remote else {}
        for name, ports in told.items():
            wanted = kind_of_place(self._specs[name])
            if ports.kind != wanted:
                raise ScenarioError([self._specs[name].problem(f"it is a {ports.kind}, expected a {wanted} here")])
        members = [
            Member(
                name=spec.name,
                robot=spec.robot,
                every=spec.every,
                ports=told[spec.name] if spec.name in told else ports_of_spec(spec),
                inputs=spec.inputs,
            )
            for spec in self.scenario.components
        ]
        return connected(self.scenario, members)

    def _options(self) -> dict[str, str]:
        """What our own processes are told before they say their ports, which may depend on it."""
        specs = [spec for spec in self.scenario.components if spec.host == "process"]
        return {spec.name: json.dumps({"config": dict(spec.config)}) for spec in specs}

    def _inline_host(self, spec: ComponentSpec) -> ComponentHost:
        assert spec.use is not None
        try:
            component = make(load_class(spec.use), spec.config)
        except (ComponentError, ValidationError) as error:
            raise InputError(f"component '{spec.name}': {error}") from None
        except Exception as error:
            raise RunError(spec.name, None, blame(error)) from error
        return ComponentHost(
            component, every=spec.every, wiring=self.graph.sources[spec.name], setup=self.setup(spec.name)
        )

    def _command(self, spec: ComponentSpec) -> ComponentHost:
        """What stands between a controller with a latency and the drive."""
        name = command_of(spec)
        (source,) = self.graph.sources[name]["twist"]
        latency: int | Callable[[], int]
        if spec.latency == "measured":
            latency = lambda: self.lockstep.computing_time(source.component, source.port)  # noqa: E731
        else:
            latency = round(spec.latency * 1e9)
        return ComponentHost(
            CommandInEffect(latency, period=self.scenario.period, every=spec.every),
            every=1,
            wiring=self.graph.sources[name],
            setup=setup_of(self.scenario, name, spec.robot, 1),
        )

    def _configuration(self, spec: ComponentSpec) -> str:
        sources = TypeAdapter(Mapping[str, tuple[Source, ...]]).dump_python(self.graph.sources[spec.name])
        body: dict[str, Any] = {
            "config": dict(spec.config),
            "every": spec.every,
            "inputs": sources,
            "setup": TypeAdapter(Setup).dump_python(self.setup(spec.name), mode="json"),
        }
        return json.dumps(body)


def ports_of_spec(spec: ComponentSpec) -> Ports:
    """What a component of a class that is known here takes and gives, with its options.

    Raises:
        ScenarioError: if its options lead to no ports.
    """
    assert spec.use is not None
    try:
        return ports_with(load_class(spec.use), spec.config)
    except ComponentError as error:
        raise ScenarioError([spec.problem(str(error), "config")]) from None


def kind_of_place(spec: ComponentSpec) -> Kind:
    """The kind that a component must be of where the scenario has it."""
    if spec.name == "evaluator":
        return "observer"
    return "mover" if spec.name in ("crowd", spec.robot) else "reactor"


def connected(scenario: Scenario, members: list[Member]) -> Graph:
    """The graph of a scenario's components, and one goal per robot, which the orchestrator says once at the start.

    Raises:
        ScenarioError: if they do not fit together, with the line of each component.
    """
    goals = [Member(name=f"{r.name}/goal", robot=r.name, every=FOREVER, ports=GOAL_PORTS) for r in scenario.robots]
    late = [spec for spec in scenario.components if spec.latency]
    try:
        graph = connect((*goals, *members))
        if not late:
            return graph
        return connect((*goals, *with_commands(members, late, graph)))
    except WiringError as error:
        raise ScenarioError(scenario.component(name).problem(text) for name, text in error.problems) from None


def goal_of(robot: Robot) -> Goal:
    """The robot's goal as a message."""
    return Goal(
        header=Header(frame_id="map"),
        robot=robot.name,
        position=(robot.goal.x, robot.goal.y),  # type: ignore[arg-type]
        direction=robot.goal.direction,  # type: ignore[arg-type]
        tolerance=robot.goal.tolerance,
    )


def setup_of(scenario: Scenario, component: str, robot: str | None, every: int) -> Setup:
    """What a component is told at the start, but for what each episode adds."""
    return Setup(
        component=component,
        period=scenario.period * every,
        seed=component_seed(scenario.seed, component),
        world=scenario.world,
        robots=scenario.robots,
        robot=robot,
    )


def component_seed(seed: int, component: str) -> int:
    """A component's own seed: the first 8 bytes, little-endian, of SHA-256 of `seed/component`."""
    return int.from_bytes(hashlib.sha256(f"{seed}/{component}".encode()).digest()[:8], "little")
