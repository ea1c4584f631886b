"""A node that ROS 2 sees without ROS: publishers and subscriptions in the manner of rmw_zenoh (Jazzy and later).

Data go under `<domain>/<topic>/<type>/<type hash>` with an attachment of sequence number, time and the endpoint's GID;
liveliness tokens under `@ros2_lv` tell the ROS graph who there is. Sources: rmw_zenoh's design document and its
independent implementations. This is the only place beside the bus that speaks Zenoh.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from typing import Any

import xxhash
import zenoh
from zenoh import ext

from orchestrator.errors import InputError

CAPACITY = 1024
"""messages that a subscription holds before its sender has to wait"""

_ATTACHMENT = struct.Struct("<qqB")
_GID_BYTES = 16


class Ros2Publisher:
    """Sends messages on one topic."""

    def __init__(self, put: Callable[..., None], gid: bytes) -> None:
        self._put = put
        self._gid = gid
        self._sequence = 0

    def publish(self, payload: bytes, time_ns: int) -> None:
        """Send a message, CDR with its header, as of `time_ns`."""
        self._sequence += 1
        attachment = _ATTACHMENT.pack(self._sequence, time_ns, _GID_BYTES) + self._gid
        self._put(payload, attachment=attachment)


class Ros2Subscription:
    """The messages of one topic, in order of arrival."""

    def __init__(self, subscriber: Any) -> None:
        self._subscriber = subscriber

    def take(self) -> bytes | None:
        """The next message if it is there, as CDR."""
        sample = self._subscriber.try_recv()
        return None if sample is None else bytes(sample.payload.to_bytes())


class Ros2Node:
    """One node on one Zenoh session: a client of the router at an endpoint, or that router itself."""

    def __init__(self, endpoint: str, *, domain: int = 0, name: str = "crowdcosim") -> None:
        """Join the ROS graph.

        Args:
            endpoint: where the router of rmw_zenoh is, such as tcp/127.0.0.1:7447; if nobody listens there, this
                session becomes the router.
            domain: ROS_DOMAIN_ID.
            name: of the node.

        Raises:
            InputError: if the endpoint can neither be reached nor listened on.
        """
        self._session, self.is_router = _join(endpoint)
        self._domain = domain
        self._name = name
        self._entities = 0
        self._declared: list[Any] = [self._announce("NN", "")]

    def publisher(self, topic: str, typename: str, type_hash: str, *, latched: bool = False) -> Ros2Publisher:
        """A reliable publisher of a topic such as `/scan`; `latched`: who subscribes late gets the last message too."""
        key = self._key(topic, typename, type_hash)
        token = self._token("MP", topic, typename, type_hash, ":1:,1:,:,:,," if latched else "::,10:,:,:,,")
        settings: dict[str, Any] = {"congestion_control": zenoh.CongestionControl.BLOCK, "express": True}
        publisher: Any
        if latched:
            cache = ext.CacheConfig(max_samples=1)
            publisher = ext.declare_advanced_publisher(
                self._session, key, cache=cache, publisher_detection=True, **settings
            )
        else:
            publisher = self._session.declare_publisher(key, **settings)
        self._declared += [publisher, self._session.liveliness().declare_token(token)]
        return Ros2Publisher(publisher.put, gid_of(token))

    def subscription(self, topic: str, typename: str, type_hash: str) -> Ros2Subscription:
        """A reliable subscription of a topic such as `/cmd_vel`."""
        key = self._key(topic, typename, type_hash)
        subscriber = self._session.declare_subscriber(key, zenoh.handlers.FifoChannel(CAPACITY))
        token = self._token("MS", topic, typename, type_hash, "::,10:,:,:,,")
        self._declared += [subscriber, self._session.liveliness().declare_token(token)]
        return Ros2Subscription(subscriber)

    def close(self) -> None:
        """Leave the graph."""
        for declared in reversed(self._declared):
            declared.undeclare()
        self._declared.clear()
        self._session.close()

    def _key(self, topic: str, typename: str, type_hash: str) -> str:
        return f"{self._domain}/{topic.strip('/')}/{dds_type(typename)}/{type_hash}"

    def _announce(self, kind: str, rest: str) -> Any:
        return self._session.liveliness().declare_token(self._place(kind, 0) + rest)

    def _place(self, kind: str, entity: int) -> str:
        """The part of a token that says whose it is: session, node, entity, kind, no enclave, no namespace, name."""
        return f"@ros2_lv/{self._domain}/{self._session.zid()}/0/{entity}/{kind}/%/%/{self._name}"

    def _token(self, kind: str, topic: str, typename: str, type_hash: str, qos: str) -> str:
        self._entities += 1
        mangled = topic.replace("/", "%")
        return f"{self._place(kind, self._entities)}/{mangled}/{dds_type(typename)}/{type_hash}/{qos}"


def gid_of(token: str) -> bytes:
    """The 16 bytes that identify an endpoint: XXH3-128 of its liveliness token, the low half first."""
    number = xxhash.xxh3_128_intdigest(token.encode())
    return struct.pack("<QQ", number & (2**64 - 1), number >> 64)


def dds_type(typename: str) -> str:
    """`geometry_msgs::msg::dds_::Twist_` for `geometry_msgs/msg/Twist`."""
    package, kind, name = typename.split("/")
    return f"{package}::{kind}::dds_::{name}_"


def _join(endpoint: str) -> tuple[Any, bool]:
    """A session at an endpoint, and whether it is the router there."""
    try:
        return _open("client", "connect", endpoint), False
    except zenoh.ZError:
        pass
    try:
        return _open("router", "listen", endpoint), True
    except zenoh.ZError as error:
        raise InputError(f"nobody answers at {endpoint}, and it cannot be listened on: {error}") from None


def _open(mode: str, role: str, endpoint: str) -> Any:
    config = zenoh.Config()
    for key, value in (
        ("mode", mode),
        (f"{role}/endpoints", [endpoint]),
        (f"{role}/exit_on_failure", True),
        ("scouting/multicast/enabled", False),
        ("timestamping/enabled", True),
    ):
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)
