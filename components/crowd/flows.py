"""The five flows of the corridor, x along it and y across it.

Grzeskowiak et al. 2021, "Crowd against the machine", "Benchmark setup": with the robot (1D+), against it (1D-), half
and half (1Dx), crossing its path one way (2D), crossing it both ways (2Dx).

Not in the paper: which way the crossing flow 2D goes (here +y, to the robot's left), and who goes which way in the
mixed flows (here every other person, so that of an odd number one more goes the positive way).
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray

Flow = Literal["1d+", "1d-", "1dx", "2d", "2dx"]

DIRECTIONS: dict[Flow, tuple[tuple[float, float], ...]] = {
    "1d+": ((1.0, 0.0),),
    "1d-": ((-1.0, 0.0),),
    "1dx": ((1.0, 0.0), (-1.0, 0.0)),
    "2d": ((0.0, 1.0),),
    "2dx": ((0.0, 1.0), (0.0, -1.0)),
}
"""the directions that people take in turn"""


def directions(flow: Flow, count: int) -> NDArray[np.float64]:
    """(count, 2) unit vectors of the ways that people go."""
    ways = np.array(DIRECTIONS[flow])
    return ways[np.arange(count) % len(ways)]
