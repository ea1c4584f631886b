"""Runs a component again on what a log recorded of the others."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from crowdcosim.component import ComponentError, Output, Ports, ValidationError, make, ports_of
from crowdcosim.host import FOREVER, ComponentHost, Source, blame
from crowdcosim.loading import load_class
from crowdcosim.message import Message
from crowdcosim.messages import MESSAGES, Metrics
from orchestrator.errors import InputError, RunError, WiringError
from orchestrator.log.reader import Log
from orchestrator.scenario.component_specs import ComponentSpec
from orchestrator.scenario.scenario import Scenario, from_resolved
from orchestrator.simulation import kind_of_place, setup_of
from orchestrator.wiring import Member, connect


class Recorded:
    """The outputs of a log by the tick that they hold."""

    def __init__(self, log: Log, period: int) -> None:
        self._log = log
        self._period = period
        self._outputs: dict[tuple[str, str], dict[int, Any]] = {}

    def read(self, source: Source, tick: int) -> Message:
        """The message of a source that holds `tick`.

        Raises:
            InputError: if the log does not have it.
        """
        message = self.find(source.component, source.port, tick)
        if message is None:
            raise InputError(f"{self._log.path} holds no message of {source.component}.{source.port} for tick {tick}")
        return message

    def find(self, component: str, port: str, tick: int) -> Message | None:
        """The message of an output that holds `tick`, None if the log does not have it."""
        place = (component, port)
        if place not in self._outputs:
            self._outputs[place] = {t // self._period: m for t, m in self._log.outputs(*place)}
        return self._outputs[place].get(tick)


@dataclass(frozen=True, kw_only=True)
class Step:
    """One output of a component that was run again."""

    tick: int
    """that the output holds"""
    port: str
    recorded: Message | None
    """None if the log has none for this tick"""
    again: Message


def evaluate(log: Log) -> Metrics:
    """The metrics of a log, computed again by the evaluator of its scenario.

    Raises:
        InputError: if the log has no scenario, no evaluator, or is incomplete.
    """
    scenario = from_resolved(log.scenario())
    spec = _component(log, scenario, "evaluator")
    last, host = _ticks(log), _host(log, scenario, spec, None, None)
    recorded = Recorded(log, scenario.period)
    host.reset(alone=False, reference=_reference(log))
    for tick in range(0, last, spec.every):
        host.step(tick, recorded.read)
    metrics = host.finish(last, recorded.read)["metrics"]
    assert isinstance(metrics, Metrics)
    return metrics


def rerun(
    log: Log, component: str, *, use: str | None = None, config: Mapping[str, Any] | None = None
) -> Iterator[Step]:
    """Everything that a component gives when it gets again what it got in the run.

    Args:
        log: of the run
        component: its name in the scenario, such as `robot/controller`; no observer
        use: another class in its place
        config: other options in the place of its own

    Raises:
        InputError: if the log has no such component, or what it got is not in the log.
        RunError: if the component fails.
    """
    scenario = from_resolved(log.scenario())
    spec = _component(log, scenario, component)
    last, host = _ticks(log), _host(log, scenario, spec, use, config)
    if host.ports.kind == "observer":
        raise InputError(f"'{component}' observes: `crowdcosim evaluate` runs it again")
    recorded = Recorded(log, scenario.period)
    try:
        for tick, outputs in _life(host, last, recorded, _reference(log)):
            for port, again in outputs.items():
                yield Step(tick=tick, port=port, recorded=recorded.find(component, port, tick), again=again)
    except InputError:
        raise
    except Exception as error:  # whatever the component raises
        raise RunError(component, None, blame(error)) from error


def _life(
    host: ComponentHost, last: int, recorded: Recorded, reference: Any
) -> Iterator[tuple[int, dict[str, Message]]]:
    """All outputs of an episode, each with the tick that it holds."""
    yield 0, host.reset(alone=False, reference=reference)
    for tick in range(0, last, host.every):
        yield host.output_label(tick), host.step(tick, recorded.read)


def _ticks(log: Log) -> int:
    ticks = log.metadata.get("outcome", {}).get("ticks")
    if ticks is None or not log.complete:
        raise InputError(f"{log.path} was cut off: this needs a complete run")
    return int(ticks)


def _reference(log: Log) -> Any:
    return json.loads(log.attachments["reference.json"])


def _host(
    log: Log, scenario: Scenario, spec: ComponentSpec, use: str | None, config: Mapping[str, Any] | None
) -> ComponentHost:
    if use is None and spec.use is None:
        raise InputError(f"component '{spec.name}' is not in Python: only those that are can be run again")
    try:
        component = make(load_class(use or spec.use or ""), spec.config if config is None else config)
    except (ComponentError, ValidationError) as error:
        raise InputError(f"component '{spec.name}': {error}") from None
    return ComponentHost(
        component,
        every=spec.every,
        wiring=log.wiring()[spec.name] if use is None else _rewired(log, scenario, spec, ports_of(type(component))),
        setup=setup_of(scenario, spec.name, spec.robot, spec.every),
    )


def _rewired(log: Log, scenario: Scenario, spec: ComponentSpec, ports: Ports) -> Mapping[str, tuple[Source, ...]]:
    """The sources of a component with other ports in the place of `spec`, among what the log holds."""
    given: dict[str, list[Output]] = {}
    for topic, (component, port) in log.places.items():
        if component and component != spec.name and log.types[topic] in MESSAGES:
            given.setdefault(component, []).append(Output(name=port, type=MESSAGES[log.types[topic]]))
    specs = {s.name: s for s in scenario.components}
    others = tuple(
        Member(
            name=name,
            robot=specs[name].robot if name in specs else name.partition("/")[0],
            every=specs[name].every if name in specs else FOREVER,
            ports=Ports(kind=kind_of_place(specs[name]) if name in specs else "reactor", inputs=(), outputs=tuple(out)),
        )
        for name, out in given.items()
    )
    inputs = {name: r for name, r in spec.inputs.items() if name in {port.name for port in ports.inputs}}
    subject = Member(name=spec.name, robot=spec.robot, every=spec.every, ports=ports, inputs=inputs)
    try:
        return connect((*others, subject)).sources[spec.name]
    except WiringError as error:
        raise InputError("; ".join(f"'{name}' {text}" for name, text in error.problems)) from None


def _component(log: Log, scenario: Scenario, name: str) -> ComponentSpec:
    try:
        spec = scenario.component(name)
    except KeyError as error:
        names = ", ".join(spec.name for spec in scenario.components)
        raise InputError(f"{log.path} has {error.args[0]}; it has {names}") from None
    return spec
