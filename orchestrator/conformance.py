"""The conformance test of a component: the same for Python and for any other language, over real Zenoh."""

from __future__ import annotations

import json
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from crowdcosim.bus import Bus, Label, Publisher
from crowdcosim.cdr import encode
from crowdcosim.component import Ports, make, ports_of
from crowdcosim.host import ComponentHost, Source
from crowdcosim.messages import Tick
from crowdcosim.setup import Setup
from orchestrator.errors import InputError, RunError
from orchestrator.lockstep import Committed, Lockstep
from orchestrator.processes import Exit, Processes, tail
from orchestrator.remote import Finished, Remote
from orchestrator.simulation import PRELOAD
from orchestrator.stimuli import ROBOT, WORLD, stimulus
from orchestrator.wiring import Graph, Member, Reference, connect

NAME = "robot/subject"
PERIOD = 100_000_000
TICKS = 20
LEAVE = 3.0
"""How long a component may take to leave [s]."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """One thing that a component must do, and whether it does."""

    name: str
    passed: bool
    detail: str


@dataclass(frozen=True, kw_only=True)
class Subject:
    """The component that is tried out: an import string or a command line."""

    use: str | None
    command: tuple[str, ...]
    config: dict[str, Any]
    deadline: float
    """longest silence [s]"""


class _Trial:
    """One life of the subject's process, with made-up neighbours."""

    def __init__(self, subject: Subject, folder: Path, processes: Processes) -> None:
        self._subject = subject
        self.processes = processes
        self.exits: list[Exit] = []
        self.bus = Bus.listen()
        self.remote = Remote(
            self.bus,
            self.processes,
            "check",
            [NAME],
            logs=folder,
            start_deadline=subject.deadline,
            step_deadline=subject.deadline,
            status=lambda text: None,
        )
        address = {"endpoint": self.bus.endpoint, "run": "check"}
        log = self.remote.log_of(NAME)
        if subject.use:
            self.processes.fork(NAME, subject.use, log=log, **address)
        else:
            environment = {f"CROWDCOSIM_{k.upper()}": v for k, v in (address | {"component": NAME}).items()}
            self.processes.execute(NAME, subject.command, folder=Path.cwd(), environment=environment, log=log)

    def meet(self) -> Ports:
        """The handshake's first step."""
        return self.remote.hello()[NAME]

    def prepare(self, ports: Ports) -> Lockstep:
        """Wire the subject to its made-up neighbours."""
        graph, hosts = _neighbourhood(ports)
        self.configure(graph, self._subject.config)
        self.remote.connect()
        return Lockstep(
            graph, period=PERIOD, constants={}, inline=hosts, remote=self.remote, trusted=frozenset(hosts)
        )

    def configure(self, graph: Graph, config: dict[str, Any]) -> None:
        body = {
            "config": config,
            "every": 1,
            "inputs": TypeAdapter(dict[str, tuple[Source, ...]]).dump_python(dict(graph.sources[NAME])),
            "setup": TypeAdapter(Setup).dump_python(_setup(NAME), mode="json"),
        }
        self.remote.configure({NAME: json.dumps(body)})

    def left(self) -> str | None:
        """Wait for the subject to leave; what is wrong with how it did, None if nothing."""
        until = time.monotonic() + LEAVE
        while NAME in self.processes.running and time.monotonic() < until:
            self.exits += self.processes.poll()
            time.sleep(0.01)
        if NAME in self.processes.running:
            return f"still runs {LEAVE:g} s later"
        return None


def conformance(subject: Subject) -> Iterator[Verdict]:
    """Try everything that the protocol asks of a component; one verdict for each."""
    processes = Processes()
    processes.preload(PRELOAD)
    try:
        with tempfile.TemporaryDirectory(prefix="crowdcosim-check-") as folder:
            yield from _Examination(subject, Path(folder), processes).verdicts()
    finally:
        processes.close()


class _Examination:
    def __init__(self, subject: Subject, folder: Path, processes: Processes) -> None:
        self._subject = subject
        self._folder = folder
        self._processes = processes
        self._ports: Ports | None = None

    def verdicts(self) -> Iterator[Verdict]:
        """In order; what depends on something that failed is left out."""
        ports = self._try("hello: protocol, ports and type hashes", self._hello)
        yield ports
        if not ports.passed:
            return
        yield self._try("an unknown key in the config is refused", self._refuses_config)
        first = self._try("finite outputs on every port, with the right tick", self._episodes)
        yield first
        if first.passed:
            yield self._try("the same seed gives the same bytes after a reset", self._deterministic)
            yield self._try("leaves with exit code 0 when told to stop", self._stops)
            yield self._try("an input of the wrong tick is refused", self._refuses_wrong_tick)
        yield self._try("leaves when the orchestrator has gone", self._leaves)

    def _try(self, name: str, examine: Callable[[], str]) -> Verdict:
        try:
            return Verdict(name=name, passed=True, detail=examine())
        except (InputError, RunError) as error:
            return Verdict(name=name, passed=False, detail=str(error))

    @contextmanager
    def _trial(self) -> Iterator[_Trial]:
        trial = _Trial(self._subject, self._folder, self._processes)
        try:
            yield trial
        finally:
            trial.remote.close()
            trial.left()

    def _hello(self) -> str:
        with self._trial() as trial:
            self._ports = trial.meet()
        if not self._ports.outputs:
            raise RunError(NAME, None, "has no output port")
        inputs = ", ".join(f"{p.name}: {p.type.__name__}" for p in self._ports.inputs) or "nothing"
        outputs = ", ".join(f"{p.name}: {p.type.__name__}" for p in self._ports.outputs)
        return f"{self._ports.kind}; takes {inputs}; gives {outputs}"

    def _refuses_config(self) -> str:
        with self._trial() as trial:
            ports = trial.meet()
            try:
                trial.configure(_neighbourhood(ports)[0], {**self._subject.config, "no_such_option": 1})
            except RunError as error:
                return str(error).partition(": ")[2]
        raise RunError(NAME, None, "took the option 'no_such_option' without a word")

    def _episodes(self) -> str:
        with self._trial() as trial:
            lockstep = trial.prepare(trial.meet())
            self._first = _episode(lockstep)
            self._second = _episode(lockstep)
            self._left = _stopped(trial)
        return f"{len(self._first)} messages in {TICKS} ticks"

    def _deterministic(self) -> str:
        for a, b in zip(self._first, self._second, strict=True):
            if a != b:
                raise RunError(NAME, a.time // PERIOD, f"output '{a.port}' differs from the episode before")
        with self._trial() as trial:
            third = _episode(trial.prepare(trial.meet()))
        if third != self._first:
            raise RunError(NAME, None, "a new process gives other bytes for the same seed")
        return "two episodes in one process and one in another are equal"

    def _stops(self) -> str:
        if self._left:
            raise RunError(NAME, None, self._left)
        return ""

    def _refuses_wrong_tick(self) -> str:
        assert self._ports is not None
        if not self._ports.inputs:
            return "it has no inputs"
        with self._trial() as trial:
            ports = trial.meet()
            graph, hosts = _neighbourhood(ports)
            publishers = {place: trial.remote.publisher(*place) for place in _places(graph)}
            trial.configure(graph, self._subject.config)
            trial.remote.connect()
            _reset(trial)
            trial.remote.tell(Tick(phase=Tick.STEP, episode=1, tick=0, period=PERIOD), (NAME,))
            _send_future(publishers, hosts)
            return _refusal(trial)

    def _leaves(self) -> str:
        with self._trial() as trial:
            trial.meet()
            trial.remote.vanish()
            if complaint := trial.left():
                raise RunError(NAME, None, complaint)
        return ""


def _setup(component: str) -> Setup:
    return Setup(component=component, period=PERIOD, seed=20211, world=WORLD, robots=(ROBOT,), robot="robot")


def _neighbourhood(ports: Ports) -> tuple[Graph, dict[str, ComponentHost]]:
    """The subject and one made-up source for each of its inputs, two for those that take many."""
    sources = {
        f"robot/{port.name}{n}": (port, stimulus(port.type, 0.7 * n))
        for port in ports.inputs
        for n in range(2 if port.many else 1)
    }
    subject = Member(
        name=NAME,
        robot="robot",
        every=1,
        ports=ports,
        inputs={p.name: Reference(f"robot/{p.name}0") for p in ports.inputs if not p.many},
    )
    neighbours = [
        Member(name=name, robot="other" if port.many else "robot", every=1, ports=ports_of(cls))
        for name, (port, cls) in sources.items()
    ]
    graph = connect((*neighbours, subject))
    hosts = {
        name: ComponentHost(make(cls, {}), every=1, wiring={}, setup=_setup(name))
        for name, (_, cls) in sources.items()
    }
    return graph, hosts


def _episode(lockstep: Lockstep) -> list[Committed]:
    """All that the subject gives in one episode."""
    made: list[Committed] = []
    lockstep.commit = lambda batch: made.extend(c for c in batch if c.component == NAME)
    lockstep.reset(alone=False, reference=None)
    for tick in range(TICKS):
        lockstep.step(tick)
    lockstep.finish(TICKS)
    if not made:
        raise RunError(NAME, TICKS, "has published nothing")
    return made


def _stopped(trial: _Trial) -> str | None:
    trial.remote.say_stop()
    if complaint := trial.left():
        return complaint
    ends = [*trial.remote.exits, *trial.exits]
    return None if ends[0].clean else ends[0].text + tail(trial.remote.log_of(NAME))


def _places(graph: Graph) -> list[tuple[str, str]]:
    return [(s.component, s.port) for sources in graph.sources[NAME].values() for s in sources]


def _reset(trial: _Trial) -> None:
    setup = json.dumps({"alone": False, "reference": None})
    trial.remote.tell(Tick(phase=Tick.RESET, episode=1, period=PERIOD, setup=setup), (NAME,))
    while not isinstance(event := trial.remote.receive(), Finished):
        pass
    if not event.done.ok:
        raise RunError(NAME, None, event.done.error)
    trial.remote.answered(NAME)


def _send_future(publishers: dict[tuple[str, str], Publisher], hosts: dict[str, ComponentHost]) -> None:
    """Inputs that claim to be of tick 7 when tick 0 is asked for."""
    label = Label(1, 7, 7 * PERIOD)
    for (component, port), publisher in publishers.items():
        host = hosts[component]
        host.reset(alone=False, reference=None)
        publisher.send(encode(host.step(0, lambda source, tick: Tick())[port]), label)


def _refusal(trial: _Trial) -> str:
    while True:
        event = trial.remote.receive()
        if isinstance(event, Finished) and not event.done.ok:
            return event.done.error
        raise RunError(NAME, 0, "stepped on inputs of tick 7 when it was asked for tick 0")
