"""The graph of a scenario: which output feeds which input, and in what order the components of a tick can run."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from typing import NamedTuple

from crowdcosim.component import Input, Ports
from crowdcosim.host import Source
from orchestrator.errors import WiringError


class Reference(NamedTuple):
    """`component.port` as a scenario writes it; the port may be left out where there is only one."""

    component: str
    port: str | None = None

    def __str__(self) -> str:
        return f"{self.component}.{self.port}" if self.port else self.component


@dataclass(frozen=True, kw_only=True)
class Member:
    """One component as the graph sees it."""

    name: str
    robot: str | None
    every: int
    ports: Ports
    inputs: Mapping[str, Reference] = field(default_factory=dict)
    """explicit connections by input port"""


@dataclass(frozen=True, kw_only=True)
class Graph:
    """A scenario's components, connected."""

    members: Mapping[str, Member]
    """by name, in the scenario's order"""
    sources: Mapping[str, Mapping[str, tuple[Source, ...]]]
    """component -> input port -> its sources"""
    order: tuple[str, ...]
    """every component after all whose outputs of the same tick it reads; movers and observers last"""

    def after(self, some: Collection[str]) -> frozenset[str]:
        """`some`, all that wait for them within a tick, directly or not, and the movers and observers."""
        found = set(some)
        for name in self.order:
            if self.members[name].ports.kind != "reactor" or any(
                s.component in found and not s.mover for port in self.sources[name].values() for s in port
            ):
                found.add(name)
        return frozenset(found)


def connect(members: tuple[Member, ...]) -> Graph:
    """Connect every input port: as the scenario says, else to the only source of its type, own robot's first.

    Raises:
        WiringError: with every input that is unconnected, ambiguous or of another type, and every loop.
    """
    by_name = {member.name: member for member in members}
    problems: list[tuple[str, str]] = []
    sources: dict[str, dict[str, tuple[Source, ...]]] = {}
    for member in members:
        sources[member.name] = {}
        for name in member.inputs:
            if name not in {port.name for port in member.ports.inputs}:
                known = ", ".join(port.name for port in member.ports.inputs) or "none"
                problems.append((member.name, f"has no input '{name}' to connect; its inputs: {known}"))
        for port in member.ports.inputs:
            try:
                sources[member.name][port.name] = _sources(member, port, by_name)
            except ValueError as error:
                problems.append((member.name, str(error)))
    if problems:
        raise WiringError(problems)
    return Graph(members=by_name, sources=sources, order=_order(by_name, sources))


def _sources(member: Member, port: Input, members: Mapping[str, Member]) -> tuple[Source, ...]:
    if port.name in member.inputs:
        return (_explicit(port, member.inputs[port.name], members),)
    others = [m for m in members.values() if m.name != member.name]
    if port.many:
        # A sensor of a robot asks for the others: its own robot's body is none of them.
        own = member.robot if member.robot != member.name else None
        return tuple(
            source
            for m in others
            for source in _offers(m, port)
            if own is None or m.robot != own or m.ports.kind != "mover"
        )
    near = [s for m in others if m.robot is not None and m.robot == member.robot for s in _offers(m, port)]
    found = near or [s for m in others if m.robot is None or member.robot is None for s in _offers(m, port)]
    named = [s for s in found if port.name in (s.port, s.component.rpartition("/")[2])]
    if len(found) > 1 and len(named) == 1:
        found = named
    if len(found) > 1 and not port.optional:
        choices = ", ".join(f"{s.component}.{s.port}" for s in found)
        raise ValueError(
            f"input '{port.name}' ({port.type.__name__}) has several sources: {choices}; "
            f"choose one: `inputs: {{{port.name}: {found[0].component}.{found[0].port}}}`"
        )
    if not found and not port.optional:
        raise ValueError(
            f"input '{port.name}' is not connected: no component of the scenario gives a {port.type.__name__}"
            + (" to it" if member.robot else "")
            + "; add one, or name it under `inputs:`"
        )
    return tuple(found) if len(found) == 1 else ()


def _offers(member: Member, port: Input) -> list[Source]:
    return [_source(member, output.name) for output in member.ports.outputs if output.type is port.type]


def _source(member: Member, port: str) -> Source:
    return Source(component=member.name, port=port, every=member.every, mover=member.ports.kind == "mover")


def _explicit(port: Input, reference: Reference, members: Mapping[str, Member]) -> Source:
    where = f"input '{port.name}' from '{reference}'"
    if reference.component not in members:
        raise ValueError(f"{where}: there is no component '{reference.component}'; there are {', '.join(members)}")
    source = members[reference.component]
    outputs = {output.name: output for output in source.ports.outputs}
    if reference.port is None:
        fitting = [o for o in outputs.values() if o.type is port.type]
        if len(fitting) != 1:
            raise ValueError(
                f"{where}: it has {len(fitting)} outputs of type {port.type.__name__}; "
                f"write {reference.component}.PORT with one of {', '.join(outputs) or 'none'}"
            )
        return _source(source, fitting[0].name)
    if reference.port not in outputs:
        raise ValueError(f"{where}: it has no output '{reference.port}'; it has {', '.join(outputs) or 'none'}")
    found = outputs[reference.port].type
    if found is not port.type:
        raise ValueError(f"{where}: it is a {found.__name__}, expected a {port.type.__name__}")
    return _source(source, reference.port)


def _order(members: Mapping[str, Member], sources: Mapping[str, Mapping[str, tuple[Source, ...]]]) -> tuple[str, ...]:
    sorter: TopologicalSorter[str] = TopologicalSorter()
    for name in members:
        same_tick = {s.component for port in sources[name].values() for s in port if not s.mover}
        sorter.add(name, *sorted(same_tick))
    try:
        order = list(sorter.static_order())
    except CycleError as error:
        loop = " <- ".join(error.args[1])
        raise WiringError(
            [
                (
                    error.args[1][0],
                    f"is part of a loop within one tick: {loop}; let one of them be a Mover, or reconnect it",
                )
            ]
        ) from None
    stage = {"reactor": 0, "mover": 1, "observer": 2}
    rank = {name: i for i, name in enumerate(order)}
    return tuple(sorted(order, key=lambda n: (stage[members[n].ports.kind], rank[n])))
