"""The components that live in other processes: handshake, ticks, answers, and a watch over them all."""

from __future__ import annotations

import contextlib
import json
import re
import select
import threading
import time
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import NamedTuple

from crowdcosim.bus import PROTOCOL, Answer, Bus, BusError, Label, Publisher
from crowdcosim.cdr import decode, encode, type_hash
from crowdcosim.component import Input, Output, Ports
from crowdcosim.message import MessageError
from crowdcosim.messages import MESSAGES, Done, Tick
from orchestrator.errors import InputError, RunError
from orchestrator.processes import Exit, Processes, tail

WATCH_PERIOD = 0.02
"""How often the watch looks for silence [s]; exits and lost connections wake it at once."""

RESERVED = ("alive", "control", "done", "status")
"""No output may bear these names: they are keys of the protocol."""

STOP_GRACE = 3.0
"""How long components may take to leave when told to stop [s]."""


class Data(NamedTuple):
    """A message of a component, as it came in."""

    component: str
    port: str
    label: Label
    payload: bytes


class Finished(NamedTuple):
    """A component's answer to a tick."""

    component: str
    done: Done


class Remote:
    """All components that are not inline, behind one Zenoh session."""

    def __init__(
        self,
        bus: Bus,
        processes: Processes,
        run: str,
        components: Iterable[str],
        *,
        logs: Path,
        start_deadline: float,
        step_deadline: float,
        status: Callable[[str], None],
        awaited: Mapping[str, str] | None = None,
    ) -> None:
        """Say that the orchestrator is there, and begin to watch.

        `awaited` has words for those who come from outside and have not: where they were expected.
        """
        self._bus = bus
        self._processes = processes
        self._run = run
        self.components = tuple(components)
        self._logs = logs
        self._start_deadline = start_deadline
        self._step_deadline = step_deadline
        self._deadline = start_deadline
        self._status = status
        self._awaited = awaited or {}
        self._mailbox = bus.mailbox(f"{run}/**")
        self._presence = bus.presence(f"{run}/**/alive")
        self._tick = bus.publisher(f"{run}/orchestrator/tick")
        self._publishers: dict[tuple[str, str], Publisher] = {}
        self._ports = {f"{run}/{c}/done": (c, "done") for c in self.components}
        self._ports |= {f"{run}/{c}/status": (c, "status") for c in self.components}
        self._present: set[str] = set()
        self.exits: list[Exit] = []
        """the processes that have ended, in that order"""
        self._tick_number: int | None = None
        self._waiting: tuple[str, ...] = ()
        self._last_sign = time.monotonic()
        self._silent = False
        self._closing = threading.Event()
        bus.announce(f"{run}/orchestrator/alive")
        self._watch = threading.Thread(target=self._watch_loop, daemon=True)
        self._watch.start()

    # --- handshake -----------------------------------------------------------------------------------------------

    def hello(self, bodies: Mapping[str, str] | None = None) -> dict[str, Ports]:
        """Wait until every component is there and says what it takes and gives.

        `bodies` tells some of them what it depends on, their config.
        """
        self._await_all("has not attached", self._have_attached)
        answers = self._ask("hello", dict.fromkeys(self.components, "{}") | dict(bodies or {}))
        ports = {component: _ports(component, body) for component, body in answers.items()}
        for component, described in ports.items():
            for output in described.outputs:
                self._ports[f"{self._run}/{component}/{output.name}"] = (component, output.name)
        return ports

    def configure(self, bodies: Mapping[str, str]) -> None:
        """Hand every component its config, setup and wiring; it subscribes to its inputs."""
        self._ask("configure", bodies)

    def connect(self) -> None:
        """Let every component declare its outputs, now that all who read them have subscribed."""
        self._ask("connect", dict.fromkeys(self.components, "{}"))

    def _have_attached(self) -> set[str]:
        while change := self._presence.poll():
            component = change[0].removeprefix(f"{self._run}/").removesuffix("/alive")
            (self._present.add if change[1] else self._present.discard)(component)
        return self._present & set(self.components)

    def _ask(self, request: str, bodies: Mapping[str, str]) -> dict[str, dict[str, object]]:
        pending = {
            component: self._bus.ask(f"{self._run}/{component}/control", request, body, 3600.0)
            for component, body in bodies.items()
        }
        answers: dict[str, dict[str, object]] = {}

        def collect() -> set[str]:
            for component, answer in pending.items():
                if component not in answers and (body := self._poll(component, request, answer)) is not None:
                    answers[component] = body
            return set(answers)

        self._await_all(f"has not answered '{request}'", collect)
        return answers

    def _poll(self, component: str, request: str, answer: Answer) -> dict[str, object] | None:
        try:
            body = answer.poll()
        except BusError as error:
            self._raise_if_lost(grace=0.5)
            raise RunError(component, None, f"'{request}' failed: {error}{self._tail(component)}") from None
        if body is not None and "error" in body:
            raise RunError(component, None, f"{body['error']}")
        return body

    def _await_all(self, complaint: str, done: Callable[[], set[str]]) -> None:
        """Poll until all components are `done`, one is lost, or nothing has been heard for the start-up deadline."""
        self._last_sign = time.monotonic()
        ready: set[str] = set()
        while len(ready) < len(self.components):
            now_ready = done()
            if now_ready != ready:
                ready, self._last_sign = set(now_ready), time.monotonic()
            if self.exits:
                self._raise_if_lost()
            self._hear_status()
            if time.monotonic() - self._last_sign > self._deadline:
                missing = next(c for c in self.components if c not in ready)
                where = self._awaited.get(missing, "") if missing not in self._present else ""
                text = f"{complaint} within {self._deadline:g} s of start-up{where}{self._tail(missing)}"
                raise RunError(missing, None, text)
            time.sleep(0.002)

    def _hear_status(self) -> None:
        """Before the first tick nothing but `status` comes; every word is a sign of life."""
        while received := self._mailbox.poll():
            component, port = self._ports.get(received.key, ("", ""))
            if port == "status":
                self._last_sign = time.monotonic()
                self._status(f"{component}: {received.payload.decode(errors='replace')}")

    # --- ticks ---------------------------------------------------------------------------------------------------

    def publisher(self, component: str, port: str) -> Publisher:
        """Declare an output of a component that lives inline and is read by one that does not."""
        return self._publishers.setdefault((component, port), self._bus.publisher(f"{self._run}/{component}/{port}"))

    def tell(self, tick: Tick, waiting: tuple[str, ...]) -> None:
        """Send the tick to all; `waiting` are those who will answer, the first to blame for silence first."""
        resetting = tick.phase == Tick.RESET
        self._tick_number = None if resetting else tick.tick
        self._deadline = self._start_deadline if resetting else self._step_deadline
        self._last_sign = time.monotonic()
        self._silent = False
        self._waiting = waiting
        self._tick.send(encode(tick))

    def resume(self) -> None:
        """The components may have waited for us: their silence counts from now."""
        self._last_sign = time.monotonic()
        self._silent = False

    def answered(self, component: str) -> None:
        """Take note that `component` has answered."""
        self._waiting = tuple(c for c in self._waiting if c != component)
        self._last_sign = time.monotonic()

    def receive(self) -> Data | Finished:
        """Wait for the next message of any component.

        Raises:
            RunError: if a component is lost, silent beyond the deadline, or breaks the protocol.
        """
        while True:
            key, payload, attachment = self._mailbox.receive()
            place = self._ports.get(key)
            if place is None:
                if key.endswith("orchestrator/wake"):
                    self._on_wake()
                continue
            component, port = place
            if port == "status":
                self._last_sign = time.monotonic()
                self._status(f"{component}: {payload.decode(errors='replace')}")
                continue
            try:
                if port == "done":
                    return Finished(component, decode(payload, Done.TYPE))
                return Data(component, port, Label.decode(attachment), payload)
            except (BusError, MessageError) as error:
                raise RunError(component, self._tick_number, f"message on '{port}': {error}") from None

    def _on_wake(self) -> None:
        if self.exits:
            self._raise_if_lost(drain=True)
        if self._silent and self._waiting:
            component = self._waiting[0]
            raise RunError(
                component,
                self._tick_number,
                f"has not answered for {self._deadline:g} s{self._tail(component)}",
            )

    def _raise_if_lost(self, *, grace: float = 0.0, drain: bool = False) -> None:
        """Raise for the first component that has gone; its own last words, if it had any, come first."""
        until = time.monotonic() + grace
        while not self.exits and time.monotonic() < until:
            time.sleep(0.005)
        if not self.exits:
            return
        component, text, _ = self.exits[0]
        while drain and (received := self._mailbox.poll()):
            if received.key == f"{self._run}/{component}/done":
                with contextlib.suppress(MessageError):
                    if error := decode(received.payload, Done.TYPE).error:
                        raise RunError(component, self._tick_number, error)
        raise RunError(component, self._tick_number, f"{text}{self._tail(component)}")

    def _tail(self, component: str) -> str:
        return tail(self.log_of(component))

    def log_of(self, component: str) -> Path:
        """Where a component's process writes what it prints."""
        return self._logs / f"{component.replace('/', '.')}.log"

    # --- watch ---------------------------------------------------------------------------------------------------

    def _watch_loop(self) -> None:
        """Runs in a thread of its own: notice exits, lost connections and silence, and wake the run."""
        while not self._closing.is_set():
            select.select([self._processes.events], [], [], WATCH_PERIOD)
            if self._closing.is_set():
                return
            before = len(self.exits)
            self.exits += self._processes.poll()
            if self._waiting:
                self._notice_departures()
            silent = bool(self._waiting) and time.monotonic() - self._last_sign > self._deadline
            if len(self.exits) > before or (silent and not self._silent):
                self._silent = silent
                self._bus.wake(f"{self._run}/orchestrator/wake")

    def _notice_departures(self) -> None:
        """Components that have no process here tell only by their liveliness token that they have gone."""
        while change := self._presence.poll():
            component = change[0].removeprefix(f"{self._run}/").removesuffix("/alive")
            if not change[1] and component in self.components and component not in self._processes.running:
                self.exits.append(Exit(component, "it has left: its connection is gone", False))

    def say_stop(self) -> None:
        """Tell all to leave."""
        self._waiting = ()
        self._tick.send(encode(Tick(phase=Tick.STOP)))

    def stop(self) -> None:
        """Tell all to leave, give them a moment, and kill who is still there."""
        self.say_stop()
        until = time.monotonic() + STOP_GRACE
        while self._processes.running and time.monotonic() < until:
            time.sleep(0.005)
        self.close()

    def vanish(self) -> None:
        """Leave without a word, as an orchestrator does that is killed."""
        if not self._closing.is_set():
            self._closing.set()
            self._watch.join()
            self._bus.close()

    def close(self) -> None:
        """Leave at once, and kill the processes that are still there."""
        self.vanish()
        self._processes.kill()


def _ports(component: str, body: Mapping[str, object]) -> Ports:
    """Ports from the answer to `hello`, checked."""
    if body.get("protocol") != PROTOCOL:
        raise InputError(
            f"component '{component}' speaks protocol {body.get('protocol')}, expected {PROTOCOL}: "
            "rebuild it for this version of crowdcosim"
        )
    kind = body.get("kind")
    if kind not in ("reactor", "mover", "observer"):
        raise InputError(f"component '{component}' is of kind {kind!r}, expected reactor, mover or observer")
    try:
        inputs = tuple(
            Input(
                name=str(port["name"]),
                type=_message_type(component, port),
                optional=bool(port.get("optional", False)),
                many=bool(port.get("many", False)),
            )
            for port in body["inputs"]  # type: ignore[attr-defined]
        )
        outputs = tuple(
            Output(name=str(port["name"]), type=_message_type(component, port))
            for port in body["outputs"]  # type: ignore[attr-defined]
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise InputError(
            f"component '{component}' answered 'hello' with {json.dumps(body)[:200]}: "
            f"expected lists `inputs` and `outputs` of objects with name, type and hash ({error!r})"
        ) from None
    for output in outputs:
        if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_]*", output.name) or output.name in RESERVED:
            raise InputError(
                f"component '{component}' calls an output '{output.name}', expected letters, digits and _, "
                f"and another name than {', '.join(RESERVED)}"
            )
    if len({output.name for output in outputs}) < len(outputs):
        raise InputError(f"component '{component}' has two outputs of one name: {', '.join(o.name for o in outputs)}")
    return Ports(kind=kind, inputs=inputs, outputs=outputs)


def _message_type(component: str, port: Mapping[str, object]) -> type:
    name = str(port["type"])
    if name not in MESSAGES:
        raise InputError(f"component '{component}', port '{port['name']}': no message type '{name}'")
    if port["hash"] != type_hash(name):
        raise InputError(
            f"component '{component}', port '{port['name']}': its {name} has hash {port['hash']}, expected "
            f"{type_hash(name)}: it was built from another definition of the message"
        )
    return MESSAGES[name]
