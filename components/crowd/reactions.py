"""How people react to robots: what they see of them, and where they would rather go because of them.

A reaction changes two things before the policy chooses: the preferred velocity, and the robots that the policy avoids.
So every policy can have every reaction. With g the gap between both bodies, n the unit vector to the robot, v0 the
preferred velocity and v' the one that takes its place:

    none         sees no robot, and walks through it
    person       avoids it as a person of its velocity, of whom half of the avoidance is expected (HuNavSim: regular)
    static       avoids it as a disc that rests where it is now (the paper's simulator; HuNavSim: impassive)
    cautious     person, and v' = (s + (1 - s) c) |v0| unit(v0 + 2 (1 - c) |v0| e), c = min(g / D, 1), e the unit vector
                 across v0 away from the robot, to the right of one dead ahead (HuNavSim: scared)
    curious      for a while v' = min((g - d) / T, |v0|) n, not backwards, facing the robot (HuNavSim: curious)
    surprised    for a while v' = 0, facing the robot (HuNavSim: surprised)
    threatening  for a while, avoiding no robot, v' = u + (q - x) / T limited to the greatest speed, u the robot's
                 velocity, q the place at a gap of d in front of it (HuNavSim: threatening)

T = 0.5 s. `cautious`, `curious`, `surprised` and `threatening` begin when the nearest robot is within `range`, within
100 deg to either side of where the person faces, and no wall stands between. Those that last a while end after
`duration`; after that the person walks on, reacts as `person`, and does not begin again.

The reactions that HuNavSim names are described in words in Perez-Higueras, Otero, Caballero and Merino 2023,
"HuNavSim: A ROS 2 human navigation simulator for benchmarking human-aware robot navigation". The laws are our own.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Discriminator, Field, Tag

from components.crowd.cells import shortest
from components.crowd.scene import Scene
from components.crowd.walls import WallGrid, nearby

Array = NDArray[np.float64]

SETTLING = 0.5
"""T [s]"""
COS_SIGHT = math.cos(math.radians(100.0))
"""robots outside of this angle to the body's direction are not noticed"""
ASIDE = 2.0
"""tangent of the angle by which the cautious turn off who touch the robot"""
TURN = 2.0
"""people who stand turn to the robot at this rate [rad/s]"""
NEAR = 2.0
"""walls are looked for as far as robots, and so much farther: a gap is shorter than the way between centres [m]"""
AT_REST = 0.05
"""slower robots have no front, and slower people turn to the robot [m/s]"""

MOVING, STILL, HIDDEN = range(3)
"""what somebody's policy sees of the robots: them as they move, as if at rest, or none"""


@dataclass(frozen=True, kw_only=True)
class _Noticing:
    range: float = 5.0
    """robots are noticed up to this gap [m]"""

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if isinstance(value, float | int) and not (value > 0 and math.isfinite(value)):
                raise ValueError(f"{name} is {value}, expected a positive number")


@dataclass(frozen=True, kw_only=True)
class Cautious(_Noticing):
    """Steps aside and slows down."""

    name: Literal["cautious"]
    distance: float = 3.0
    """D, where the slowing begins [m]"""
    slowest: float = 0.5
    """s, share of the preferred speed that is left when touching"""


@dataclass(frozen=True, kw_only=True)
class Curious(_Noticing):
    """Comes near, then walks on."""

    name: Literal["curious"]
    distance: float = 1.2
    """d, gap at which it is near enough [m]"""
    duration: float = 10.0
    """for which the robot is interesting [s]"""


@dataclass(frozen=True, kw_only=True)
class Surprised(_Noticing):
    """Stops and looks, then walks on."""

    name: Literal["surprised"]
    duration: float = 3.0
    """for which people stand [s]"""


@dataclass(frozen=True, kw_only=True)
class Threatening(_Noticing):
    """Stands in the robot's way, then walks on."""

    name: Literal["threatening"]
    distance: float = 0.6
    """d, gap that is left to the robot [m]"""
    duration: float = 15.0
    """for which it is fun [s]"""


Law = Cautious | Curious | Surprised | Threatening
ReactionName = Literal["none", "person", "static", "cautious", "curious", "surprised", "threatening"]
Reaction = Annotated[
    Annotated[ReactionName, Tag("by name")] | Annotated[Law, Field(discriminator="name"), Tag("with values")],
    Discriminator(lambda value: "by name" if isinstance(value, str) else "with values"),
]
"""a name, or a mapping with the name and values of its own"""

_NAMES: tuple[ReactionName, ...] = ("none", "person", "static", "cautious", "curious", "surprised", "threatening")
NONE, PERSON, STATIC, CAUTIOUS, CURIOUS, SURPRISED, THREATENING = range(7)
_LAWS: dict[str, Law] = {
    "cautious": Cautious(name="cautious"),
    "curious": Curious(name="curious"),
    "surprised": Surprised(name="surprised"),
    "threatening": Threatening(name="threatening"),
}


class Reacted(NamedTuple):
    """What the robots make of N people."""

    preferred: Array
    """(N, 2) preferred velocities [m/s]"""
    sight: NDArray[np.int8]
    """(N,) what everybody sees of the robots: MOVING, STILL or HIDDEN"""
    attended: Array
    """(N,) how long everybody has attended to a robot [s]"""
    bearing: Array
    """(N,) where the robot is that people turn to [rad], NaN for who minds no robot"""


class Reactions:
    """The reactions of N people."""

    def __init__(self, reactions: Sequence[Reaction], population: NDArray[np.int64]) -> None:
        """Reactions, and the index of everybody's (N,)."""
        rows = []
        for reaction in reactions:
            law = _LAWS.get(reaction, reaction) if isinstance(reaction, str) else reaction
            name = law if isinstance(law, str) else law.name
            values = [float(getattr(law, key, 0.0)) for key in ("range", "distance", "duration", "slowest")]
            rows.append([float(_NAMES.index(name)), *values])
        self._laws = np.array(rows, np.float64)[population]
        kind = self._laws[:, 0]
        self._reach = math.ceil(self._laws[:, 1].max(initial=0.0)) + NEAR
        self.pushed = kind != NONE
        """(N,) False for those who walk through robots"""
        self._sight = np.where(kind == NONE, HIDDEN, np.where(kind == STATIC, STILL, MOVING)).astype(np.int8)
        self._plain = bool((kind < CAUTIOUS).all())
        self._nowhere = np.full(len(population), np.nan)

    def react(self, scene: Scene, heading: Array, attended: Array) -> Reacted:
        """What the robots of a scene make of its people.

        Args:
            scene: the old state
            heading: (N,) where everybody faces [rad]
            attended: (N,) how long everybody has attended to a robot [s]
        """
        if self._plain:
            return Reacted(scene.preferred, self._sight, attended, self._nowhere)
        return _react(
            self._laws,
            scene.position,
            heading,
            scene.preferred,
            scene.radius,
            scene.max_speed,
            scene.robots,
            scene.walls.within(self._reach),
            scene.period,
            self._sight,
            attended,
            scene.dt,
        )


@njit(cache=True, nogil=True, error_model="numpy")
def _hidden(walls: WallGrid, x: float, y: float, dx: float, dy: float) -> bool:
    """True if a wall stands between (x, y) and what is at (dx, dy) from there."""
    begin, end = nearby(walls, x, y)
    for q in range(begin, end):
        f = walls.listed[q]
        ax, ay, bx, by = walls.ends[f, 0] - x, walls.ends[f, 1] - y, walls.ends[f, 2] - x, walls.ends[f, 3] - y
        ux, uy = bx - ax, by - ay
        here, there = ux * -ay + uy * ax, ux * (dy - ay) - uy * (dx - ax)
        if here * there < 0.0 and (dx * ay - dy * ax) * (dx * by - dy * bx) < 0.0:
            return True
    return False


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest(robots: Array, x: float, y: float, r: float, period: Array) -> tuple[int, float, float, float]:
    """Index, relative position and gap [m] of the robot nearest to somebody of radius r; -1 if there is none."""
    which, px, py, least = -1, 0.0, 0.0, np.inf
    for f in range(len(robots)):
        dx, dy = shortest(robots[f, 0] - x, period[0]), shortest(robots[f, 1] - y, period[1])
        gap = math.sqrt(dx * dx + dy * dy) - r - robots[f, 4]
        if gap < least:
            which, px, py, least = f, dx, dy, gap
    return which, px, py, least


@njit(cache=True, nogil=True, error_model="numpy")
def step_aside(
    gx: float, gy: float, dx: float, dy: float, gap: float, distance: float, slowest: float
) -> tuple[float, float]:
    """v' of the cautious, who prefer (gx, gy), for a robot at (dx, dy)."""
    c = min(max(gap, 0.0) / distance, 1.0)
    speed = math.sqrt(gx * gx + gy * gy)
    if speed == 0.0:
        return 0.0, 0.0
    # The right-hand side of v0, or the left one if the robot is on the right.
    ex, ey = gy / speed, -gx / speed
    if ex * dx + ey * dy > 0.0:
        ex, ey = -ex, -ey
    aside = ASIDE * (1.0 - c)
    scale = (slowest + (1.0 - slowest) * c) / math.sqrt(1.0 + aside * aside)
    return scale * (gx + aside * speed * ex), scale * (gy + aside * speed * ey)


@njit(cache=True, nogil=True, error_model="numpy")
def _block(
    dx: float, dy: float, ux: float, uy: float, reach: float, distance: float, limit: float
) -> tuple[float, float]:
    """v' of the threatening, for a robot at (dx, dy) that moves at (ux, uy); `reach` is the sum of both radii."""
    speed = math.sqrt(ux * ux + uy * uy)
    hx, hy = (ux / speed, uy / speed) if speed > AT_REST else (0.0, 0.0)
    if speed <= AT_REST:
        away = math.sqrt(dx * dx + dy * dy)
        hx, hy = (-dx / away, -dy / away) if away > 0.0 else (1.0, 0.0)
    x = ux + (dx + (reach + distance) * hx) / SETTLING
    y = uy + (dy + (reach + distance) * hy) / SETTLING
    wanted = math.sqrt(x * x + y * y)
    return (x * limit / wanted, y * limit / wanted) if wanted > limit else (x, y)


@njit(cache=True, nogil=True, error_model="numpy")
def _react(
    laws: Array,
    position: Array,
    heading: Array,
    preferred: Array,
    radius: Array,
    max_speed: Array,
    robots: Array,
    walls: WallGrid,
    period: Array,
    usual: NDArray[np.int8],
    attended: Array,
    dt: float,
) -> Reacted:
    n = len(position)
    result, sight, time, bearing = preferred.copy(), usual.copy(), attended.copy(), np.full(n, np.nan)
    for i in range(n):
        kind, reach, distance, duration, slowest = laws[i, 0], laws[i, 1], laws[i, 2], laws[i, 3], laws[i, 4]
        if kind < CAUTIOUS or (kind != CAUTIOUS and attended[i] >= duration):
            continue
        x, y = position[i, 0], position[i, 1]
        f, dx, dy, gap = _nearest(robots, x, y, radius[i], period)
        if f < 0:
            continue
        away = math.sqrt(dx * dx + dy * dy)
        if kind == CAUTIOUS or attended[i] == 0.0:
            ahead = dx * math.cos(heading[i]) + dy * math.sin(heading[i]) >= COS_SIGHT * away
            if gap > reach or not ahead or _hidden(walls, x, y, dx, dy):
                continue
        gx, gy = preferred[i, 0], preferred[i, 1]
        if kind == CAUTIOUS:
            result[i, 0], result[i, 1] = step_aside(gx, gy, dx, dy, gap, distance, slowest)
            continue
        time[i] += dt
        bearing[i] = math.atan2(dy, dx)
        if kind == CURIOUS:
            pace = min(max((gap - distance) / SETTLING, 0.0), math.sqrt(gx * gx + gy * gy))
            scale = pace / away if away > 0.0 else 0.0
            result[i, 0], result[i, 1] = scale * dx, scale * dy
        elif kind == SURPRISED:
            result[i, 0], result[i, 1] = 0.0, 0.0
        else:
            sight[i] = HIDDEN
            result[i, 0], result[i, 1] = _block(
                dx, dy, robots[f, 2], robots[f, 3], radius[i] + robots[f, 4], distance, max_speed[i]
            )
    return Reacted(result, sight, time, bearing)


@njit(cache=True, nogil=True, error_model="numpy")
def face(heading: Array, bearing: Array, velocity: Array, dt: float) -> Array:
    """(N,) headings after those who stand have turned towards `bearing` (N,), where that is a number [rad]."""
    turned = heading.copy()
    for i in range(len(heading)):
        if not math.isnan(bearing[i]) and math.hypot(velocity[i, 0], velocity[i, 1]) < AT_REST:
            turn = shortest(bearing[i] - heading[i], 2.0 * math.pi)
            turned[i] = shortest(heading[i] + min(max(turn, -TURN * dt), TURN * dt), 2.0 * math.pi)
    return turned
