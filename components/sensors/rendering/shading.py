"""The colour of every pixel, once, for the surface that it sees; neighbours in a row that see the same, together.

The painters are inlined: a call for every few pixels would take as long as the painting.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.rendering.buffers import FLOOR, PEOPLE, SKY, TRIANGLES, Buffers
from components.sensors.rendering.clothing import Clothing
from components.sensors.rendering.light import Light
from components.sensors.rendering.paint_people import paint_limb
from components.sensors.rendering.paint_scenery import paint_level, paint_sky, paint_triangle
from components.sensors.rendering.people import Bodies, InSight
from components.sensors.rendering.scenery import Scenery
from components.sensors.rendering.view import View
from crowdcosim.avatar import CAPSULES

Array = NDArray[np.float64]


@njit(cache=True, nogil=True, error_model="numpy")
def shade_rows(
    view: View,
    size: Array,
    light: Light,
    scenery: Scenery,
    seen: InSight,
    bodies: Bodies,
    clothing: Clothing,
    buffers: Buffers,
    shade: NDArray[np.float32],
    top: int,
    bottom: int,
    colour: NDArray[np.uint8],
) -> None:
    """Fill the rows [top, bottom) of `colour`, (H, W, 3); `size`: (2,) of the world [m], `shade`: (H, W) shadows."""
    surface, depths, index = buffers.surface, buffers.inverse_depth, seen.index
    cone, facing, floor = bodies.cone, bodies.facing, view.position[2]
    cloth, hair, jacket, untucked = clothing.colour, clothing.hair, clothing.jacket, clothing.untucked
    one, two = np.empty(view.width, np.float32), np.empty(view.width, np.float32)
    lines, step = colour.reshape(view.height, 3 * view.width), 1.0 / view.focal
    for v in range(top, bottom):
        end, y = 0, (v - view.cy) * step
        while end < view.width:
            first, code = end, surface[v, end]
            end += 1
            while end < view.width and surface[v, end] == code:
                end += 1
            # Slices, so that loops count from 0: only then they become vector instructions.
            depth, line = depths[v, first:end], lines[v, 3 * first : 3 * end]
            x = (first - view.cx) * step
            if code >= PEOPLE:
                k = (code - PEOPLE) // CAPSULES
                c = code - PEOPLE - CAPSULES * k
                n = index[k]
                paint_limb(
                    step,
                    x,
                    y,
                    floor,
                    light,
                    cone,
                    facing,
                    cloth,
                    hair[n],
                    jacket[n],
                    untucked[n],
                    n,
                    k,
                    c,
                    depth,
                    one,
                    two,
                    line,
                )
            elif code >= TRIANGLES:
                paint_triangle(view, light, scenery, code - TRIANGLES, x, y, depth, line)
            elif code == SKY:
                paint_sky(view, light, y, line)
            else:
                paint_level(view, light, size, depth[0], shade[v, first:end], x, y, code == FLOOR, one, two, line)
