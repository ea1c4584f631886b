"""Initial positions of frozen scenarios: random sequential addition, in millimetres.

The crowd places people too; this one is apart from it so that frozen files stay the same when the crowd changes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

MILLIMETRES = 3
"""decimals of a position [m]"""


def place(
    number: int, count: int, *, radius: float, size: tuple[float, float], keep_free: tuple[float, float, float]
) -> NDArray[np.float64]:
    """(count, 2) centres of discs in a world that wraps around both ways, none touching another [m].

    Args:
        number: of the draw; the same gives the same.
        count: how many, at most about half of the area.
        radius: of every disc [m].
        size: of the world [m].
        keep_free: x, y and radius of a disc that nobody touches [m].
    """
    rng = np.random.Generator(np.random.PCG64(np.random.SeedSequence([2021, number])))
    extent = np.array(size)
    placed = np.empty((count, 2))
    n = 0
    while n < count:
        candidate = np.round(rng.random(2) * extent, MILLIMETRES)
        candidate[candidate >= extent] = 0.0  # the far edge is another name of the near one
        others = np.vstack([placed[:n], keep_free[:2]])
        d = others - candidate
        d -= np.rint(d / extent) * extent
        least = np.full(n + 1, 2 * radius)
        least[-1] = radius + keep_free[2]
        if (np.hypot(*d.T) >= least).all():
            placed[n] = candidate
            n += 1
    return placed
