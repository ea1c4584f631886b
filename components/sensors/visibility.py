"""How much of each person a level scanner would see past other people, robots and walls."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.scan import PERSON, Beams, Cylinders, People, Pose, Walls, nothing_hit, scan, see


class Visibility(NamedTuple):
    """Of N people, each at the image that is nearest to the scanner."""

    share: NDArray[np.float64]
    """(N,) beams that hit the person over beams that would if nothing else were there; 0 where there are none"""
    distance: NDArray[np.float64]
    """(N,) from the scanner to the person's position [m]"""


@njit(cache=True, nogil=True)
def visibility(
    beams: Beams, pose: Pose, period: NDArray[np.float64], walls: Walls, people: People, robots: Cylinders
) -> Visibility:
    """Cast `beams` at everybody together, and at each person alone.

    `period`: (2,) of the map [m], 0 along an axis that does not wrap around.
    """
    count = len(people.id)
    numbers = np.arange(count).astype(np.uint32)
    here = People(numbers, people.position, people.velocity, people.heading, people.stature, people.gait_phase)
    seen = np.zeros(count)
    hits = scan(beams, pose, period, walls, here, robots)
    for k in range(len(hits.kind)):
        if hits.kind[k] == PERSON:
            seen[hits.agent[k]] += 1.0
    alone = nothing_hit(len(beams.directions))
    share, distance = np.zeros(count), np.empty(count)
    for n in range(count):
        dx, dy = people.position[n, 0] - pose.x, people.position[n, 1] - pose.y
        if period[0] > 0.0:
            dx -= period[0] * round(dx / period[0])
        if period[1] > 0.0:
            dy -= period[1] * round(dy / period[1])
        distance[n] = math.sqrt(dx * dx + dy * dy)
        if seen[n] > 0.0:
            whole = see(beams, pose, people, n, dx, dy, alone)
            if whole > 0:  # or only a farther image is in range
                share[n] = min(seen[n] / whole, 1.0)
    return Visibility(share, distance)
