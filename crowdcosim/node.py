"""Hosts one Python component as a process on Zenoh: `python -m crowdcosim.node --help`."""

from __future__ import annotations

import argparse
import json
import os
import sys
import threading
import time
import traceback
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from crowdcosim.bus import PROTOCOL, Bus, BusError, Label, Mailbox, Publisher
from crowdcosim.cdr import decode, encode, type_hash
from crowdcosim.component import Component, ComponentError, Ports, make, ports_of, ports_with
from crowdcosim.credentials import Credentials
from crowdcosim.host import ComponentHost, Source, Wiring, blame
from crowdcosim.loading import load_class
from crowdcosim.message import Message, MessageError
from crowdcosim.messages import Done, Tick
from crowdcosim.setup import Setup


def describe(ports: Ports) -> dict[str, Any]:
    """The answer to `hello`: protocol version, kind and ports with type hashes."""
    return {
        "protocol": PROTOCOL,
        "kind": ports.kind,
        "inputs": [
            {
                "name": p.name,
                "type": p.type.TYPE,
                "hash": type_hash(p.type.TYPE),
                "optional": p.optional,
                "many": p.many,
            }
            for p in ports.inputs
        ],
        "outputs": [{"name": p.name, "type": p.type.TYPE, "hash": type_hash(p.type.TYPE)} for p in ports.outputs],
    }


class _Inbox:
    """The messages of one source, by label."""

    def __init__(self, mailbox: Mailbox, source: Source, typename: str) -> None:
        self._mailbox = mailbox
        self._source = source
        self._type = typename
        self._held: tuple[int, int] = (0, -1)
        self._message: Message | None = None

    def read(self, episode: int, tick: int) -> Message:
        """Wait for the message that holds `tick` of `episode`.

        Raises:
            BusError: if the source has gone past it.
            MessageError: if the source sent something else than its type.
        """
        while self._held != (episode, tick):
            payload, attachment = self._mailbox.receive_unnamed()
            label = Label.decode(attachment)
            if label.episode < episode or (label.episode == episode and label.tick < tick):
                continue
            name = f"{self._source.component}.{self._source.port}"
            if (label.episode, label.tick) != (episode, tick):
                raise BusError(f"input from {name} is of tick {label.tick}, expected {tick}")
            try:
                self._message = decode(payload, self._type)
            except MessageError as error:
                raise MessageError(f"input from {name} at tick {tick}: {error}") from None
            self._held = (episode, tick)
        assert self._message is not None
        return self._message


class Node:
    """One component on the bus: answers the handshake, then steps at the orchestrator's word until it says stop."""

    def __init__(self, bus: Bus, run: str, component: str, use: str) -> None:
        self._bus = bus
        self._run = run
        self._key = f"{run}/{component}"
        self._use = use
        self._class: type[Component] | None = None
        self._host: ComponentHost | None = None
        self._inboxes: dict[tuple[str, str], _Inbox] = {}
        self._publishers: dict[str, Publisher] = {}
        self._done = bus.publisher(f"{self._key}/done")
        self._status = bus.publisher(f"{self._key}/status")
        self._episode = 0

    def serve(self) -> int:
        """Live until told to stop; the exit code."""
        ticks = self._bus.mailbox(f"{self._run}/orchestrator/tick")
        requests = self._bus.requests(f"{self._key}/control")
        self._bus.announce(f"{self._key}/alive")
        threading.Thread(target=self._leave_with_orchestrator, daemon=True).start()
        connected = False
        while not connected:
            request = requests.receive()
            try:
                answer = self._answer(request.name, request.body)
                connected = request.name == "connect"
            except Exception as error:
                traceback.print_exc()
                answer = _refusal(error)
            request.reply(answer)
        self._report_compilation()
        while True:
            tick: Tick = decode(ticks.receive_unnamed()[0], Tick.TYPE)
            if tick.phase == Tick.STOP:
                return 0
            if not self._obey(tick):
                return 1

    def _answer(self, request: str, body: dict[str, Any]) -> dict[str, Any]:
        if request == "hello":
            self._class = load_class(self._use)
            return describe(ports_with(self._class, body["config"]) if body else ports_of(self._class))
        if request == "configure":
            self._configure(body)
            return {}
        if request == "connect":
            assert self._host is not None, "connect before configure"
            for output in self._host.ports.outputs:
                self._publishers[output.name] = self._bus.publisher(f"{self._key}/{output.name}")
            return {}
        raise ComponentError(f"unknown request '{request}', expected hello, configure or connect")

    def _configure(self, body: dict[str, Any]) -> None:
        assert self._class is not None, "configure before hello"
        wiring: Wiring = TypeAdapter(dict[str, tuple[Source, ...]]).validate_python(body["inputs"])
        setup = TypeAdapter(Setup).validate_python(body["setup"])
        self._host = ComponentHost(make(self._class, body["config"]), every=body["every"], wiring=wiring, setup=setup)
        types = {port.name: port.type.TYPE for port in self._host.ports.inputs}
        for port, sources in wiring.items():
            for source in sources:
                mailbox = self._bus.mailbox(f"{self._run}/{source.component}/{source.port}")
                self._inboxes[source.component, source.port] = _Inbox(mailbox, source, types[port])

    def _obey(self, tick: Tick) -> bool:
        """Do what the orchestrator says; False if the component failed."""
        assert self._host is not None
        begin = time.perf_counter_ns()
        try:
            match tick.phase:
                case Tick.RESET:
                    self._episode = tick.episode
                    self._send(self._host.reset(**json.loads(tick.setup)), tick, 0)
                case Tick.STEP if self._host.due(tick.tick):
                    begin = self._step(self._host, tick)
                    if self._host.ports.kind != "observer":
                        return True  # its outputs are its answer
                case Tick.FINISH if self._host.ports.kind == "observer":
                    self._send(self._host.finish(tick.tick, self._read), tick, tick.tick)
                case _:
                    return True
        except Exception as error:
            traceback.print_exc()
            self._answer_done(tick, begin, str(error) if isinstance(error, BusError) else blame(error))
            return False
        self._answer_done(tick, begin)
        return True

    def _step(self, host: ComponentHost, tick: Tick) -> int:
        """One step; returns when its own work began, after the wait for its inputs."""
        began = time.perf_counter_ns()

        def read(source: Source, label: int) -> Message:
            nonlocal began
            message = self._read(source, label)
            began = time.perf_counter_ns()
            return message

        outputs = host.step(tick.tick, read)
        self._send(outputs, tick, host.output_label(tick.tick), time.perf_counter_ns() - began)
        return began

    def _read(self, source: Source, label: int) -> Message:
        return self._inboxes[source.component, source.port].read(self._episode, label)

    def _send(self, outputs: dict[str, Message], tick: Tick, label: int, elapsed: int = 0) -> None:
        time_ns = tick.time + (label - tick.tick) * tick.period
        attachment = Label(self._episode, label, time_ns, elapsed).encode()
        for port, message in outputs.items():
            self._publishers[port].send(encode(message), attachment)

    def _answer_done(self, tick: Tick, begin: int, error: str = "") -> None:
        elapsed = time.perf_counter_ns() - begin
        done = Done(phase=tick.phase, tick=tick.tick, ok=not error, error=error, elapsed=elapsed)
        self._done.send(encode(done), Label(self._episode, tick.tick, tick.time).encode())

    def _report_compilation(self) -> None:
        """Tell the orchestrator of each kernel that numba compiles: it takes seconds, once per machine."""
        if "numba" not in sys.modules:
            return
        from numba.core import event

        status = self._status

        class Compiling(event.Listener):
            def on_start(self, event: Any) -> None:
                status.send(f"compiling {event.data['dispatcher'].py_func.__name__}".encode())

            def on_end(self, event: Any) -> None:
                pass

        event.register("numba:compile", Compiling())  # type: ignore[no-untyped-call]

    def _leave_with_orchestrator(self) -> None:
        presence = self._bus.presence(f"{self._run}/orchestrator/alive")
        while (change := presence.wait()) and change[1]:
            pass
        if change is None:
            return
        print("the orchestrator has gone", file=sys.stderr, flush=True)
        os._exit(1)


def _refusal(error: Exception) -> dict[str, Any]:
    if isinstance(error, ValidationError):
        first = error.errors()[0]
        key = ".".join(str(part) for part in first["loc"])
        return {"error": f"{key}: {first['msg']}, found {first['input']!r}" if key else first["msg"]}
    return {"error": blame(error)}


def serve(endpoint: str, run: str, component: str, use: str, credentials: Credentials | None = None) -> int:
    """Host the component that `use` names until the orchestrator says stop; the exit code."""
    bus = Bus.connect(endpoint, credentials=credentials)
    code = Node(bus, run, component, use).serve()
    sys.stdout.flush()
    sys.stderr.flush()
    bus.close()
    return code


def main() -> int:
    """The command line of an `external` component, or of one that runs in another Python environment."""
    parser = argparse.ArgumentParser(prog="python -m crowdcosim.node", description=__doc__)
    parser.add_argument("use", help="package.module:Class or ./file.py:Class")
    for option, required, help_text in (
        ("endpoint", True, "where the orchestrator listens, such as tcp/127.0.0.1:7450 or tls/robots.example:7450"),
        ("run", True, "name of the run: the scenario's name"),
        ("component", True, "this component's name in the scenario, such as robot/controller"),
        ("authority", False, "certificates (PEM) of those who may sign the orchestrator's"),
        ("certificate", False, "this component's certificate (PEM)"),
        ("key", False, "the private key of that certificate (PEM)"),
        ("user", False, "name to attach with; the password is in --password-file or $CROWDCOSIM_PASSWORD"),
    ):
        variable = f"CROWDCOSIM_{option.upper()}"
        value = os.environ.get(variable)
        parser.add_argument(
            f"--{option}", default=value, required=required and value is None, help=f"{help_text} [${variable}]"
        )
    parser.add_argument("--password-file", type=Path, help="file with the password of --user, and nothing else")
    arguments = parser.parse_args()
    try:
        return serve(arguments.endpoint, arguments.run, arguments.component, arguments.use, _credentials(arguments))
    except BusError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2


def _credentials(arguments: argparse.Namespace) -> Credentials:
    authority, certificate, key = (
        Path(path) if path else None for path in (arguments.authority, arguments.certificate, arguments.key)
    )
    password = os.environ.get("CROWDCOSIM_PASSWORD")
    if arguments.password_file:
        try:
            password = arguments.password_file.read_text().rstrip("\r\n")
        except OSError as error:
            raise BusError(f"--password-file: cannot read {arguments.password_file}: {error.strerror}") from None
    return Credentials(authority=authority, certificate=certificate, key=key, user=arguments.user, password=password)


if __name__ == "__main__":
    code = main()
    os._exit(code)  # the watching thread waits for ever inside Zenoh
