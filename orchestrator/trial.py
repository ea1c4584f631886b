"""One life of a component that is tried out alone, among made-up neighbours, over real Zenoh."""

from __future__ import annotations

import json
import time
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from crowdcosim.bus import Bus, Label
from crowdcosim.cdr import encode
from crowdcosim.component import Component, Input, Ports, make, ports_of
from crowdcosim.host import ComponentHost, Source
from crowdcosim.message import Message
from crowdcosim.messages import Tick
from crowdcosim.setup import Setup
from orchestrator.errors import RunError
from orchestrator.lockstep import Committed, Lockstep
from orchestrator.processes import Exit, Processes
from orchestrator.remote import Remote
from orchestrator.stimuli import ROBOT, WORLD, stimulus
from orchestrator.wiring import Graph, Member, Reference, connect

RUN = "check"
NAME = "robot/subject"
PERIOD = 100_000_000
TICKS = 20
LEAVE = 3.0
"""How long a component may take to leave [s]."""


@dataclass(frozen=True, kw_only=True)
class Subject:
    """The component that is tried out: an import string or a command line."""

    use: str | None
    command: tuple[str, ...]
    config: dict[str, Any]
    deadline: float
    """longest silence [s]"""


class Output(NamedTuple):
    """One message of the subject."""

    port: str
    time: int
    """simulated time of what it holds [ns]"""
    payload: bytes
    """CDR"""


class Trial:
    """One life of the subject's process."""

    def __init__(self, subject: Subject, folder: Path, processes: Processes) -> None:
        self._subject = subject
        self._processes = processes
        self._episodes = 0
        bus = Bus.listen()
        self.remote = Remote(
            bus,
            processes,
            RUN,
            [NAME],
            logs=folder,
            start_deadline=subject.deadline,
            step_deadline=subject.deadline,
            status=lambda _: None,
        )
        address = {"endpoint": bus.endpoint, "run": RUN}
        log = self.remote.log_of(NAME)
        if subject.use:
            processes.fork(NAME, subject.use, log=log, **address)
        else:
            environment = {f"CROWDCOSIM_{k.upper()}": v for k, v in (address | {"component": NAME}).items()}
            processes.execute(NAME, subject.command, folder=Path.cwd(), environment=environment, log=log)

    @cached_property
    def ports(self) -> Ports:
        """What the subject takes and gives: the first step of the handshake."""
        body = json.dumps({"config": self._subject.config}) if self._subject.use else "{}"
        return self.remote.hello({NAME: body})[NAME]

    def connect(self) -> None:
        """The rest of the handshake, with the config that the subject is to have."""
        _ = self._lockstep

    def configure(self, config: Mapping[str, Any]) -> None:
        """The second step: the subject among its neighbours."""
        body = {
            "config": config,
            "every": 1,
            "inputs": TypeAdapter(dict[str, tuple[Source, ...]]).dump_python(dict(self._graph.sources[NAME])),
            "setup": TypeAdapter(Setup).dump_python(_setup(NAME), mode="json"),
        }
        self.remote.configure({NAME: json.dumps(body)})

    def episode(self) -> list[Output]:
        """All that the subject gives in one episode."""
        made: list[Output] = []

        def commit(batch: list[Committed]) -> None:
            made.extend(Output(c.port, c.time, c.payload) for c in batch if c.component == NAME)

        self._lockstep.commit = commit
        self._reset()
        for tick in range(TICKS):
            self._lockstep.step(tick)
        self._lockstep.finish(TICKS)
        if not made:
            raise RunError(NAME, TICKS, "has published nothing")
        return made

    def begin_step(self) -> None:
        """Begin an episode and ask for tick 0, but hold the inputs back."""
        self._reset()
        self.remote.tell(Tick(phase=Tick.STEP, episode=self._episodes, tick=0, period=PERIOD), (NAME,))

    def send_inputs(self, tick: int) -> None:
        """The inputs that were held back, labelled `tick`."""
        attachment = Label(self._episodes, tick, tick * PERIOD).encode()
        for name, host in self._neighbours.items():
            for port, message in host.step(0, _nothing_to_read).items():
                self.remote.publisher(name, port).send(encode(message), attachment)

    def wait_for_end(self) -> Exit:
        """How the subject's process has ended, waiting a moment for it to do so."""
        until = time.monotonic() + LEAVE
        seen: list[Exit] = []
        while NAME in self._processes.running and time.monotonic() < until:
            seen += self._processes.poll()
            time.sleep(0.005)
        # Until it is closed, the remote watches too: either may be the one that has heard of it.
        ends = [*self.remote.exits, *seen]
        return ends[0] if ends else Exit(NAME, f"still runs {LEAVE:g} s later", False)

    def _reset(self) -> None:
        self._lockstep.reset(alone=False, reference=None)
        self._episodes += 1

    @cached_property
    def _lockstep(self) -> Lockstep:
        self.configure(self._subject.config)
        self.remote.connect()
        return Lockstep(
            self._graph,
            period=PERIOD,
            constants={},
            inline=self._neighbours,
            remote=self.remote,
            trusted=frozenset(self._neighbours),
        )

    @cached_property
    def _sources(self) -> dict[str, tuple[Input, type[Component]]]:
        """A made-up source for each input, two for those that take many."""
        return {
            f"robot/{port.name}{n}": (port, stimulus(port.type, 0.7 * n))
            for port in self.ports.inputs
            for n in range(2 if port.many else 1)
        }

    @cached_property
    def _neighbours(self) -> dict[str, ComponentHost]:
        return {
            name: ComponentHost(make(cls, {}), every=1, wiring={}, setup=_setup(name))
            for name, (_, cls) in self._sources.items()
        }

    @cached_property
    def _graph(self) -> Graph:
        subject = Member(
            name=NAME,
            robot="robot",
            every=1,
            ports=self.ports,
            inputs={p.name: Reference(f"robot/{p.name}0") for p in self.ports.inputs if not p.many},
        )
        neighbours = [
            Member(name=name, robot="other" if port.many else "robot", every=1, ports=ports_of(cls))
            for name, (port, cls) in self._sources.items()
        ]
        return connect((*neighbours, subject))


def _setup(component: str) -> Setup:
    return Setup(component=component, period=PERIOD, seed=20211, world=WORLD, robots=(ROBOT,), robot="robot")


def _nothing_to_read(source: Source, tick: int) -> Message:
    raise AssertionError(f"made-up sources read nothing, but {source} at tick {tick} was asked for")
