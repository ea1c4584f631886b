"""What people wear and what they look like, from a hash of their ids: the same person looks the same in every run."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from crowdcosim.avatar import CAPSULES
from crowdcosim.body import SEGMENTS

SHORT, LONG, BALD = 0, 1, 2
"""hair"""

_SHIRTS = (
    "1f4e9c 2f6fb3 7fb2d6 c9d6df f0efe9 e6e2d8 3a3f47 23272e 6b7078 9aa0a6 a8323a c8504a d98a94 8a2f4b 5d3a66 2e6b4f"
    " 4f8a5b 8fae6b c9a227 e0b84c d9762b b5683a 7a5a3c 2b8a8a 5aa6a6"
)
_TROUSERS = "1e2a44 24365c 3d5278 5a6f92 22252b 33363c 4b4e55 6e7076 8c8271 a3947a 4a3b2c 5c4a38 3b4436 2a2d34"
_SKIN = "f0cdb4 e8bd9e d9a583 c68f6b b07a57 97623f 7a4b2f 5b3722 43281a"
_HAIR = "1b1512 2a1d16 3b281b 55371f 70492a 8c6239 b08d57 d3b679 6e6a66 9c9893 c9c6c2"
_SHOES = "1c1a1a 2b2422 4a3020 6b4a30 e8e6e1 d5d3cf 3b4252 7c1f24"


def _palette(names: str) -> NDArray[np.float32]:
    """(P, 3) red, green and blue, 0 to 1."""
    return np.array([tuple(bytes.fromhex(name)) for name in names.split()], np.float32) / np.float32(255.0)


class Clothing(NamedTuple):
    """What N people look like."""

    colour: NDArray[np.float32]
    """(N, 19, 3) red, green and blue, 0 to 1, of each limb; of the hair; of what is worn under an open jacket"""
    hair: NDArray[np.uint8]
    """(N,) SHORT, LONG or BALD"""
    jacket: NDArray[np.bool_]
    """(N,) an open jacket"""
    untucked: NDArray[np.bool_]
    """(N,) the shirt covers the hips"""


def clothing(number: NDArray[np.uint32]) -> Clothing:
    """What the people with these ids, (N,), look like."""

    def pick(stream: int, count: int) -> NDArray[np.intp]:
        return (_hashed(number, stream) % np.uint64(count)).astype(np.intp)

    def of(names: str, stream: int) -> NDArray[np.float32]:
        palette = _palette(names)
        return palette[pick(stream, len(palette))]

    skin, trousers, shirt = of(_SKIN, 1), of(_TROUSERS, 2), of(_SHIRTS, 3)
    shorts, short_sleeves = pick(4, 6) == 0, pick(5, 2) == 0
    jacket = ~short_sleeves & (pick(6, 3) == 0)
    worn = {
        "foot": of(_SHOES, 7),
        "shank": np.where(shorts[:, None], skin, trousers),
        "thigh": trousers,
        "pelvis": trousers,
        "trunk": shirt,
        "upper arm": shirt,
        "forearm": np.where(short_sleeves[:, None], skin, shirt),
    }
    colour = np.empty((len(number), CAPSULES + 2, 3), np.float32)
    for limb, segment in enumerate(SEGMENTS):
        colour[:, limb] = next((cloth for part, cloth in worn.items() if part in segment), skin)
    colour[:, CAPSULES], colour[:, CAPSULES + 1] = of(_HAIR, 8), of("f0efe9 e6e2d8 9aa0a6 23272e 7fb2d6", 9)
    hair = np.array([SHORT, SHORT, SHORT, LONG, LONG, BALD], np.uint8)[pick(10, 6)]
    return Clothing(colour, hair, jacket, pick(11, 3) > 0)


def _hashed(number: NDArray[np.uint32], stream: int) -> NDArray[np.uint64]:
    """Steele, Lea and Flood's SplitMix64 (2014) of ids, (N,); other streams are independent."""
    x = (number.astype(np.uint64) << np.uint64(8)) + np.uint64(stream)
    with np.errstate(over="ignore"):
        x = (x + np.uint64(1)) * np.uint64(0x9E3779B97F4A7C15)
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return np.asarray(x ^ (x >> np.uint64(31)))
