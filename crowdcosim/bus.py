"""Zenoh as crowdcosim uses it: publishers that never drop, mailboxes without callbacks, questions, presence.

The orchestrator's session is the router and listens; every component's session is a client of it. Multicast
scouting is off, so that runs on one machine never hear each other.
"""

from __future__ import annotations

import json
import socket
import struct
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Any, NamedTuple

import zenoh

from crowdcosim.credentials import Admission, Credentials, CredentialsError, Obstacle, obstacle, stranger

PROTOCOL = 1
"""Version of the protocol of `docs/protocol.md`; both sides must agree."""

CAPACITY = 1024
"""Messages that a mailbox holds before its sender has to wait."""

LEASE = 60_000
"""A link that is silent for so long is taken for lost [ms]; one that is closed is noticed at once. A machine that was
suspended, or a process that was stopped for a while, goes on."""

_ATTACHMENT = struct.Struct("<QQqQ")

zenoh.init_log_from_env_or("off")


class BusError(Exception):
    """The transport cannot be set up, or what came over it does not follow the protocol."""


class Label(NamedTuple):
    """The attachment of every data message: 32 bytes, little-endian."""

    episode: int
    """number of the episode, from 1 (uint64)"""
    tick: int
    """which tick's state or observation the message holds (uint64)"""
    time: int
    """simulated time of that tick [ns] (int64)"""
    elapsed: int = 0
    """wall-clock time of the component's own work in this step [ns] (uint64); never reaches the log's data"""

    def encode(self) -> bytes:
        return _ATTACHMENT.pack(*self)

    @classmethod
    def decode(cls, data: bytes) -> Label:
        """Raise `BusError` unless the attachment is one."""
        if len(data) != _ATTACHMENT.size:
            raise BusError(
                f"attachment of {len(data)} bytes, expected {_ATTACHMENT.size}: episode, tick, time, elapsed"
            )
        return cls(*_ATTACHMENT.unpack(data))


class Received(NamedTuple):
    """A message as it came in."""

    key: str
    payload: bytes
    attachment: bytes


class Mailbox:
    """The messages of one subscription, in order of arrival."""

    def __init__(self, subscriber: Any) -> None:
        self._subscriber = subscriber
        self._next = subscriber.handler.recv

    def receive(self) -> Received:
        """Wait for the next message."""
        return _received(self._next())

    def receive_unnamed(self) -> tuple[bytes, bytes]:
        """Wait for the next message: payload and attachment, for a subscription to one key."""
        sample = self._next()
        attachment = sample.attachment
        return sample.payload.to_bytes(), attachment.to_bytes() if attachment else b""

    def poll(self) -> Received | None:
        """The next message if it is there."""
        sample = self._subscriber.try_recv()
        return None if sample is None else _received(sample)

    def close(self) -> None:
        self._subscriber.undeclare()


class Publisher:
    """Sends on one key; waits rather than drops when the way is jammed."""

    def __init__(self, publisher: Any) -> None:
        self._put = publisher.put

    def send(self, payload: bytes, attachment: bytes | None = None) -> None:
        self._put(payload, attachment=attachment)


class Request:
    """A question asked of this process."""

    def __init__(self, query: Any) -> None:
        self._query = query
        self.name = str(query.selector.parameters)
        """what is asked: hello, configure or connect"""
        self.body: dict[str, Any] = json.loads(query.payload.to_bytes() or b"{}") if query.payload else {}

    def reply(self, body: dict[str, Any]) -> None:
        """Answer once; a query that is never answered keeps its sender waiting."""
        with self._query as query:
            query.reply(query.key_expr, json.dumps(body).encode())


class Requests:
    """The questions asked of this process, one after the other."""

    def __init__(self, queryable: Any) -> None:
        self._queryable = queryable

    def receive(self) -> Request:
        """Wait for the next question."""
        return Request(self._queryable.recv())


class Answer:
    """The pending answer to a question."""

    def __init__(self, handler: Any) -> None:
        self._handler = handler

    def poll(self) -> dict[str, Any] | None:
        """The answer if it is there.

        Raises:
            BusError: if there will be none, because nobody listens any more or it is not a JSON object.
        """
        try:
            reply = self._handler.try_recv()
        except zenoh.ZError:
            raise BusError("no answer: it is not connected any more") from None
        if reply is None:
            return None
        if reply.ok is None:
            raise BusError(f"no answer: {reply.err.payload.to_string()}")
        try:
            body = json.loads(reply.ok.payload.to_bytes())
        except ValueError:
            body = None
        if not isinstance(body, dict):
            raise BusError("the answer is not a JSON object")
        return body


class Presence:
    """Who is there: the liveliness tokens that match a key expression, as they come and go."""

    def __init__(self, subscriber: Any) -> None:
        self._subscriber = subscriber

    def poll(self) -> tuple[str, bool] | None:
        """(key, present) of the next change if there is one."""
        sample = self._subscriber.try_recv()
        return None if sample is None else _presence(sample)

    def wait(self) -> tuple[str, bool] | None:
        """(key, present) of the next change; None once this session is closed."""
        try:
            return _presence(self._subscriber.recv())
        except zenoh.ZError:
            return None


class Bus:
    """One Zenoh session. Use `listen` in the orchestrator and `connect` in a component."""

    def __init__(self, session: Any, endpoint: str, identity: Mapping[str, str] | None = None) -> None:
        self._session = session
        self.endpoint = endpoint
        """where the router listens, such as tcp/127.0.0.1:40123"""
        self.identity = dict(identity or {})
        """`user` and `password` of the processes on this machine, if the router asks for any"""
        self._declared: list[Any] = []

    @classmethod
    def listen(cls, endpoint: str | None = None, *, admission: Admission | None = None) -> Bus:
        """A router session on `endpoint`, by default on a free port of the loopback interface.

        Args:
            endpoint: for the processes on this machine.
            admission: a second endpoint, for components from outside, and what they must show.

        Raises:
            BusError: if an endpoint cannot be listened on, or a certificate, key or list of users cannot be used.
        """
        chosen = endpoint or f"tcp/127.0.0.1:{_free_port()}"
        if admission is None:
            return cls(_open("router", "listen", [chosen]), chosen)
        try:
            settings, passwords = admission.settings(), admission.passwords()
        except CredentialsError as error:
            raise BusError(str(error)) from None
        endpoints = [chosen, admission.listen]
        if not passwords:
            return cls(_open("router", "listen", endpoints, settings), chosen)
        user, password = stranger()  # Zenoh asks at every endpoint or at none
        with _dictionary(passwords | {user: password}) as path:
            session = _open("router", "listen", endpoints, settings | {"transport/auth/usrpwd/dictionary_file": path})
        return cls(session, chosen, {"user": user, "password": password})

    @classmethod
    def connect(cls, endpoint: str, deadline: float = 10.0, *, credentials: Credentials | None = None) -> Bus:
        """A client session of the router at `endpoint`, tried for `deadline` [s] or until it refuses us.

        Raises:
            BusError: if nobody listens there, or one of the two sides does not trust the other.
        """
        shown = credentials or Credentials()
        try:
            settings = shown.settings()
        except CredentialsError as error:
            raise BusError(str(error)) from None
        until = time.monotonic() + deadline
        cause = Obstacle("", False)
        while True:
            try:
                return cls(_open("client", "connect", [endpoint], settings), endpoint)
            except BusError:
                # What is lasting is believed at the second failure: it may have begun to listen before our look.
                if not cause.lasting:
                    cause = obstacle(endpoint, shown)
                    if time.monotonic() < until:
                        time.sleep(0.05)
                        continue
                raise BusError(f"cannot connect to {endpoint}: {cause.text}") from None

    def publisher(self, key: str) -> Publisher:
        publisher = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.BLOCK,
            express=True,
            allowed_destination=zenoh.Locality.REMOTE,
        )
        return Publisher(publisher)

    def mailbox(self, key: str) -> Mailbox:
        return Mailbox(self._session.declare_subscriber(key, zenoh.handlers.FifoChannel(CAPACITY)))

    def wake(self, key: str) -> None:
        """Put an empty message into this session's own mailboxes that match `key`."""
        self._session.put(key, b"", allowed_destination=zenoh.Locality.SESSION_LOCAL)

    def requests(self, key: str) -> Requests:
        """The questions asked of this process under `key`, from now on."""
        return Requests(self._session.declare_queryable(key, zenoh.handlers.FifoChannel(16)))

    def ask(self, key: str, request: str, body: str, deadline: float) -> Answer:
        """Ask the process that answers under `key`; `body` is a JSON object, `deadline` [s] ends the wait."""
        handler = self._session.get(
            f"{key}?{request}", zenoh.handlers.FifoChannel(4), payload=body.encode(), timeout=deadline
        )
        return Answer(handler)

    def announce(self, key: str) -> None:
        """Declare a liveliness token: others see at once when this process has gone."""
        self._declared.append(self._session.liveliness().declare_token(key))

    def presence(self, key: str) -> Presence:
        subscriber = self._session.liveliness().declare_subscriber(
            key, zenoh.handlers.FifoChannel(CAPACITY), history=True
        )
        return Presence(subscriber)

    def close(self) -> None:
        self._session.close()


def _open(mode: str, role: str, endpoints: list[str], settings: Mapping[str, object] | None = None) -> Any:
    options: dict[str, object] = {
        "mode": mode,
        f"{role}/endpoints": endpoints,
        f"{role}/exit_on_failure": True,
        "scouting/multicast/enabled": False,
        "scouting/gossip/enabled": False,
        "scouting/delay": 0,
        "transport/link/tx/lease": LEASE,
        **(settings or {}),
    }
    try:
        config = zenoh.Config()
        for key, value in options.items():
            config.insert_json5(key, json.dumps(value))
        return zenoh.open(config)
    except zenoh.ZError as error:
        reason = str(error).partition(" at /")[0]  # a place in Zenoh's own source
        raise BusError(f"cannot {role} at {' and '.join(endpoints)}: {reason}") from None


@contextmanager
def _dictionary(passwords: Mapping[str, str]) -> Iterator[str]:
    """A file that only we can read, while Zenoh reads it."""
    with tempfile.NamedTemporaryFile("w", prefix="crowdcosim-") as file:
        file.writelines(f"{user}:{password}\n" for user, password in passwords.items())
        file.flush()
        yield file.name


def _free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def _received(sample: Any) -> Received:
    attachment = sample.attachment
    return Received(str(sample.key_expr), sample.payload.to_bytes(), attachment.to_bytes() if attachment else b"")


def _presence(sample: Any) -> tuple[str, bool]:
    return str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT
