"""A picture of one instant: depth, who is seen and which part of them, and colour."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.buffers import PEOPLE, TRIANGLES, Buffers, draw
from components.sensors.rendering.clothing import Clothing, clothing
from components.sensors.rendering.light import light_of
from components.sensors.rendering.people import SIGHT, TAPER, Bodies, InSight, bodies, in_sight
from components.sensors.rendering.scenery import Scenery, joined, robot_scenery, world_scenery
from components.sensors.rendering.shading import shade_rows
from components.sensors.rendering.shadows import shadows
from components.sensors.rendering.smoothing import smooth_rows
from components.sensors.rendering.triangles import outlines
from components.sensors.rendering.view import View
from components.sensors.scan import Cylinders, People
from crowdcosim.avatar import CAPSULES, REACH
from crowdcosim.body import BODY_PART
from crowdcosim.messages import BeamAgents
from crowdcosim.world import World

Array = NDArray[np.float64]

ROBOT_NUMBERS = 65536
"""robot r is this minus r in a picture of agents, where people have their ids"""

_TALLEST = 2.5
"""no person is taller than this [m]"""


class Picture(NamedTuple):
    """What a camera sees."""

    inverse_depth: NDArray[np.float32]
    """(H, W) one over the distance along the optical axis [1/m], 0 for the sky"""
    surface: NDArray[np.int32]
    """(H, W) which surface, for `agents`"""
    colour: NDArray[np.uint8] | None
    """(H, W, 3) red, green and blue, if asked for"""
    agents: NDArray[np.uint16] | None
    """(H, W) a person's id, ROBOT_NUMBERS minus a robot's number, 0 for nobody, if asked for"""
    body_parts: NDArray[np.uint8] | None
    """(H, W) as in `BeamAgents`, if asked for"""


class Renderer:
    """Draws pictures of a world. The same picture comes from any number of threads."""

    def __init__(self, world: World, *, threads: int = 1) -> None:
        self._scenery = world_scenery(world)
        self._size = np.array(world.size, np.float64)
        self._period = world.period
        self._ceiling = float("inf") if world.ceiling is None else world.ceiling
        self._walled = _walled(world)
        self._threads = threads
        self._pool = ThreadPoolExecutor(threads) if threads > 1 else None
        self._dressed: tuple[NDArray[np.uint32], Clothing] | None = None

    def picture(
        self,
        view: View,
        people: People,
        robots: Cylinders,
        heading: Array,
        *,
        colour: bool = True,
        labels: bool = False,
        images: bool = True,
    ) -> Picture:
        """What a camera sees.

        Args:
            view: the camera
            people: everybody
            robots: all robots that it may see
            heading: (R,) of the robots [rad]
            colour: whether the colour is worked out
            labels: whether agents and body parts are
            images: whether people are seen across the world's seams
        """
        period = self._period if images else np.zeros(2)
        seen = in_sight(view, people, period, self._reach(view), self._size)
        scenery = joined([self._scenery, robot_scenery(robots, heading, period, self._size)])
        posed = bodies(view, people, seen, TAPER)
        edges = outlines(view, scenery.corner)
        shape = (view.height, view.width)
        buffers = Buffers(np.empty(shape, np.float32), np.empty(shape, np.int32))
        self._bands(view.height, lambda a, b: draw(view, self._ceiling, edges, posed, a, b, buffers))
        rgb = self._coloured(view, people, robots, seen, posed, scenery, buffers) if colour else None
        if rgb is not None:
            rough, rgb = rgb, rgb.copy()
            smooth = rgb
            self._bands(
                view.height,
                lambda a, b: smooth_rows(view, self._ceiling, edges, posed, buffers, rough, a, b, smooth),
            )
        agents = parts = None
        if labels:
            agents, parts = _labels(buffers.surface, people.id, seen.index, scenery.kind, scenery.number)
        return Picture(buffers.inverse_depth, buffers.surface, rgb, agents, parts)

    def _coloured(
        self,
        view: View,
        people: People,
        robots: Cylinders,
        seen: InSight,
        posed: Bodies,
        scenery: Scenery,
        buffers: Buffers,
    ) -> NDArray[np.uint8]:
        clothes, light = self._clothing(people.id), light_of(view, self._ceiling)
        feet = _feet(view, posed)
        discs = np.column_stack([robots.centre, robots.radius])
        shade = np.empty(buffers.surface.shape, np.float32)
        colour = np.empty((*buffers.surface.shape, 3), np.uint8)

        def rows(top: int, bottom: int) -> None:
            shadows(view, seen, people.stature, feet, discs, buffers, top, bottom, shade)
            shade_rows(view, self._size, light, scenery, seen, posed, clothes, buffers, shade, top, bottom, colour)

        self._bands(view.height, rows)
        return colour

    def _bands(self, height: int, work: Callable[[int, int], None]) -> None:
        """Do `work` on all rows, each thread on a band of them."""
        if self._pool is None:
            work(0, height)
            return
        edges = [height * k // self._threads for k in range(self._threads + 1)]
        for done in [self._pool.submit(work, a, b) for a, b in pairwise(edges)]:
            done.result()

    def _clothing(self, number: NDArray[np.uint32]) -> Clothing:
        if self._dressed is None or not np.array_equal(self._dressed[0], number):
            self._dressed = (number, clothing(number))
        return self._dressed[1]

    def _reach(self, view: View) -> float:
        """How far outside of the world's rectangle a camera may see people [m].

        From within high walls all around, a line of sight ends at a wall; only bodies that reach through one are seen.
        """
        x, y, z = view.position.tolist()
        inside = 0.0 <= x <= self._size[0] and 0.0 <= y <= self._size[1]
        return REACH * _TALLEST if inside and max(z, _TALLEST) <= self._walled else SIGHT


def _walled(world: World) -> float:
    """How high the walls are that enclose the world [m], 0 if they do not."""
    x, y = world.size
    lowest = np.inf
    for a, b in (((0, 0), (x, 0)), ((x, 0), (x, y)), ((0, y), (x, y)), ((0, 0), (0, y))):
        heights = [w.height for w in world.walls if {w.start, w.end} == {a, b}]
        lowest = min(lowest, max(heights, default=0.0))
    return float(lowest)


@njit(cache=True, nogil=True)
def _feet(view: View, bodies: Bodies) -> Array:
    """(V, 2, 3) middles of the feet (x, y, height) in the map [m]: the first two limbs."""
    feet = np.empty((len(bodies.front), 2, 3))
    for v in range(len(bodies.front)):
        for side in range(2):
            cone = bodies.cone[v, side]
            for axis in range(3):
                feet[v, side, axis] = view.position[axis]
                for k in range(3):
                    feet[v, side, axis] += 0.5 * (cone[k] + cone[4 + k]) * view.axes[k, axis]
    return feet


@njit(cache=True, nogil=True)
def _labels(
    surface: NDArray[np.int32],
    person: NDArray[np.uint32],
    index: NDArray[np.intp],
    kind: NDArray[np.uint8],
    number: NDArray[np.uint32],
) -> tuple[NDArray[np.uint16], NDArray[np.uint8]]:
    """(H, W) agents and (H, W) body parts."""
    agents, parts = np.empty(surface.shape, np.uint16), np.empty(surface.shape, np.uint8)
    before, agent, part = -1, 0, 0
    for v in range(surface.shape[0]):
        for u in range(surface.shape[1]):
            code = surface[v, u]
            # Most pixels see what the one before them sees.
            if code != before:
                before, agent, part = code, 0, BODY_NONE
                if code >= PEOPLE:
                    k = (code - PEOPLE) // CAPSULES
                    agent, part = person[index[k]], BODY_PART[code - PEOPLE - CAPSULES * k]
                elif code >= TRIANGLES and kind[code - TRIANGLES] == ROBOT_KIND:
                    agent = ROBOT_NUMBERS - number[code - TRIANGLES]
            agents[v, u], parts[v, u] = agent, part
    return agents, parts


# numba takes globals, but not class attributes, as constants.
BODY_NONE, ROBOT_KIND = BeamAgents.NO_PART, BeamAgents.ROBOT
