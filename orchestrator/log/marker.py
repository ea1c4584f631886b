"""`visualization_msgs/MarkerArray` as bytes, quickly: points are arrays, where a general encoder takes objects."""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

ARRAY_TYPE = "visualization_msgs/msg/MarkerArray"
CUBE, SPHERE, CYLINDER, LINE_STRIP, LINE_LIST, SPHERE_LIST, TRIANGLE_LIST = 1, 2, 3, 4, 5, 7, 11
"""values of `Marker.type`"""

Colour = tuple[float, float, float, float]


@dataclass(frozen=True, kw_only=True)
class Marker:
    """One shape, or one kind of shape at many points."""

    namespace: str
    number: int = 0
    """tells apart the markers of one namespace"""
    frame: str
    type: int
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """of its own frame in `frame` [m]"""
    yaw: float = 0.0
    """of its own frame in `frame` [rad]"""
    scale: tuple[float, float, float]
    """extent; a line's first is its width [m]"""
    colour: Colour
    """red, green, blue, opacity, from 0 to 1"""
    points: NDArray[np.float64] = field(default_factory=lambda: np.empty((0, 3)))
    """(P, 3) [m]"""
    lifetime: int = 0
    """after which it vanishes, 0: never [ns]"""
    moves_with_frame: bool = False
    """it follows its frame after it was drawn"""


def encode_markers(time_ns: int, markers: Sequence[Marker]) -> bytes:
    """The markers at `time_ns` as CDR with its encapsulation header."""
    wire = Wire()
    wire.pack("I", len(markers))
    for marker in markers:
        _write(wire, time_ns, marker)
    return wire.message()


class Wire:
    """Little-endian CDR: everything is aligned to its own size."""

    def __init__(self) -> None:
        self.data = bytearray()

    def pack(self, kinds: str, *values: float) -> None:
        """Numbers of one size: each of `kinds` is a letter of `struct`."""
        self._align(struct.calcsize(kinds[-1]))
        self.data += struct.pack("<" + kinds, *values)

    def text(self, text: str) -> None:
        data = text.encode() + b"\0"
        self.pack("I", len(data))
        self.data += data

    def rows(self, array: NDArray[np.float64]) -> None:
        """A sequence with a row of float64 for each item."""
        self.pack("I", len(array))
        if len(array):
            self._align(8)
            self.data += np.ascontiguousarray(array, "<f8").tobytes()

    def message(self) -> bytes:
        """All of it, with the encapsulation header."""
        return b"\x00\x01\x00\x00" + bytes(self.data)

    def _align(self, size: int) -> None:
        self.data += bytes(-len(self.data) % size)


def _write(wire: Wire, time_ns: int, marker: Marker) -> None:
    wire.pack("iI", time_ns // 1_000_000_000, time_ns % 1_000_000_000)
    wire.text(marker.frame)
    wire.text(marker.namespace)
    wire.pack("iii", marker.number, marker.type, 0)
    orientation = 0.0, 0.0, math.sin(0.5 * marker.yaw), math.cos(0.5 * marker.yaw)
    wire.pack("10d", *marker.position, *orientation, *marker.scale)
    wire.pack("4f", *marker.colour)
    wire.pack("iI", marker.lifetime // 1_000_000_000, marker.lifetime % 1_000_000_000)
    wire.pack("?", marker.moves_with_frame)
    wire.rows(marker.points)
    wire.pack("I", 0)  # one colour for all points
    wire.text("")  # texture: resource; header; format; data; coordinates
    wire.pack("iI", 0, 0)
    wire.text("")
    wire.text("")
    wire.pack("II", 0, 0)
    wire.text("")  # text
    wire.text("")  # mesh: resource; file and its data
    wire.text("")
    wire.pack("I", 0)
    wire.pack("?", False)
