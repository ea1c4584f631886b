"""The nearest person, robot or wall along each beam of a level scan; only the beams that may meet a thing visit it.

In the sensor's frame, with x ahead, beam k points along u_k at the angle first + k * increment.
Robot, an upright cylinder with centre c and radius r: seen within asin(r / |c|) of its direction, at
c.u - sqrt(r^2 - (c x u)^2).
Wall from a to b: seen between its ends, at (a x (b - a)) / (u x (b - a)).
Person: the capsules of `crowdcosim.avatar`, in `components.sensors.capsule`.
Along a periodic axis people and robots have an image at every whole period, and all within range are seen; a wall has
none.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.capsule import Axis, holds_origin, in_slab, meets, outline
from crowdcosim.avatar import CAPSULES, LEGS, LEGS_ONLY, REACH, pose_legs, pose_one
from crowdcosim.body import BODY_PART
from crowdcosim.messages import BeamAgents

# numba takes globals, but not class attributes, as constants.
NOTHING, WALL, PERSON, ROBOT = BeamAgents.NOTHING, BeamAgents.WALL, BeamAgents.PERSON, BeamAgents.ROBOT
NO_PART = BeamAgents.NO_PART

# How far a wall reaches beyond its ends, as a fraction of its length: closes the corners, which rounding would open.
_OVERLAP = 1e-9
# Angle without beams from which on to ask who is in it [rad].
_WORTHWHILE = 1.0


class Beams(NamedTuple):
    """Directions of a scan, in the sensor's frame."""

    first: float
    """angle of beam 0 [rad]"""
    increment: float
    """angle from one beam to the next [rad]"""
    directions: NDArray[np.float64]
    """(B, 2) unit vectors"""
    limit: float
    """how far they reach [m]"""


class Pose(NamedTuple):
    """Where the sensor is in the map."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    z: float
    """above the ground [m]"""
    cos: float
    """of its heading"""
    sin: float
    """of its heading"""


class People(NamedTuple):
    """Those whom the sensor may see, as in `Crowd`."""

    id: NDArray[np.uint32]
    """(N,)"""
    position: NDArray[np.float64]
    """(N, 2) in the map [m]"""
    velocity: NDArray[np.float64]
    """(N, 2) [m/s]"""
    heading: NDArray[np.float64]
    """(N,) [rad]"""
    stature: NDArray[np.float64]
    """(N,) [m]"""
    gait_phase: NDArray[np.float64]
    """(N,) [cycles]"""


class Cylinders(NamedTuple):
    """Robots: upright cylinders that stand on the ground."""

    number: NDArray[np.uint32]
    """(N,)"""
    centre: NDArray[np.float64]
    """(N, 2) in the map [m]"""
    radius: NDArray[np.float64]
    """(N,) [m]"""
    height: NDArray[np.float64]
    """(N,) [m]"""


class Walls(NamedTuple):
    """Walls and edges of obstacles that are as high as the scanner."""

    number: NDArray[np.uint32]
    """(W,) of the wall or obstacle, from 1"""
    ends: NDArray[np.float64]
    """(W, 2, 2) both ends [m]"""


class Hits(NamedTuple):
    """What each beam meets first."""

    distance: NDArray[np.float64]
    """(B,) [m]; infinite where nothing is met, 0 within a person or robot"""
    kind: NDArray[np.uint8]
    """(B,) as in `BeamAgents`"""
    agent: NDArray[np.uint32]
    """(B,) as in `BeamAgents`"""
    body_part: NDArray[np.uint8]
    """(B,) as in `BeamAgents`"""


@njit(cache=True, nogil=True, error_model="numpy")
def nothing_hit(count: int) -> Hits:
    """So many beams in an empty world."""
    return Hits(
        np.full(count, np.inf),
        np.full(count, NOTHING, np.uint8),
        np.zeros(count, np.uint32),
        np.full(count, NO_PART, np.uint8),
    )


@njit(cache=True, nogil=True, error_model="numpy")
def scan(
    beams: Beams,
    pose: Pose,
    period: NDArray[np.float64],
    walls: Walls,
    people: People,
    robots: Cylinders,
) -> Hits:
    """What each beam meets first; of two at the same distance the wall, then the person, then whoever is listed first.

    `period`: (2,) of the map [m], 0 along an axis that does not wrap around.
    """
    hits = nothing_hit(len(beams.directions))
    for index in range(len(walls.number)):
        _wall(beams, pose, walls.ends[index], walls.number[index], hits)
    _people(beams, pose, period, people, hits)
    _robots(beams, pose, period, robots, hits)
    return hits


@njit(cache=True, nogil=True, error_model="numpy")
def tell(hits: Hits, range_min: float, range_max: float) -> None:
    """Make of distances the ranges of REP 117, and nobody of what is beyond the farthest."""
    for k in range(len(hits.distance)):
        if hits.distance[k] < range_min:
            hits.distance[k] = -np.inf
        elif hits.distance[k] > range_max:
            hits.distance[k], hits.kind[k], hits.agent[k], hits.body_part[k] = np.inf, NOTHING, 0, NO_PART


@njit(cache=True, nogil=True, error_model="numpy")
def near(people: People, x: float, y: float, reach: float, period: NDArray[np.float64]) -> People:
    """Those of whom a part may be within `reach` of (x, y) [m], each at the image that is nearest.

    Several scans from about there are cheaper with these than with everybody.
    """
    count = 0
    index = np.empty(len(people.id), np.intp)
    position = np.empty((len(people.id), 2))
    for n in range(len(people.id)):
        dx, dy = people.position[n, 0] - x, people.position[n, 1] - y
        if period[0] > 0.0:
            dx -= period[0] * round(dx / period[0])
        if period[1] > 0.0:
            dy -= period[1] * round(dy / period[1])
        most = reach + REACH * people.stature[n]
        if dx * dx + dy * dy <= most * most:
            index[count], position[count, 0], position[count, 1] = n, x + dx, y + dy
            count += 1
    index = index[:count]
    return People(
        people.id[index],
        position[:count],
        people.velocity[index],
        people.heading[index],
        people.stature[index],
        people.gait_phase[index],
    )


@njit(cache=True, nogil=True, error_model="numpy")
def _in_sensor(pose: Pose, dx: float, dy: float) -> tuple[float, float]:
    """A vector of the map in the sensor's frame."""
    return pose.cos * dx + pose.sin * dy, pose.cos * dy - pose.sin * dx


@njit(cache=True, nogil=True, error_model="numpy")
def _span(beams: Beams, start: float, extent: float, turn: int) -> tuple[int, int]:
    """Beams [low, high) that lie, or by rounding may lie, between two angles, in the first (0) or second turn (1)."""
    offset = start - beams.first
    offset -= 2.0 * math.pi * (math.floor(offset / (2.0 * math.pi)) + turn)
    low = max(math.ceil(offset / beams.increment) - 1, 0)
    high = min(math.floor((offset + extent) / beams.increment) + 2, len(beams.directions))
    return low, high


@njit(cache=True, nogil=True, error_model="numpy")
def _wall(beams: Beams, pose: Pose, ends: NDArray[np.float64], number: int, hits: Hits) -> None:
    ax, ay = _in_sensor(pose, ends[0, 0] - pose.x, ends[0, 1] - pose.y)
    bx, by = _in_sensor(pose, ends[1, 0] - pose.x, ends[1, 1] - pose.y)
    ex, ey = bx - ax, by - ay
    cross = ax * by - ay * bx
    if cross > 0.0:
        start, extent = math.atan2(ay, ax), math.atan2(cross, ax * bx + ay * by)
    elif cross < 0.0:
        start, extent = math.atan2(by, bx), math.atan2(-cross, ax * bx + ay * by)
    else:  # On the wall's line there is no side from which its ends could be told left from right.
        start, extent = beams.first, 2.0 * math.pi
    for turn in range(2):
        low, high = _span(beams, start, extent, turn)
        for k in range(low, high):
            ux, uy = beams.directions[k, 0], beams.directions[k, 1]
            along = ux * ey - uy * ex
            if along == 0.0:
                continue
            distance = cross / along
            where = (ax * uy - ay * ux) / along
            if distance >= 0.0 and -_OVERLAP <= where <= 1.0 + _OVERLAP:
                _note(beams, k, distance, WALL, number, NO_PART, hits)


@njit(cache=True, nogil=True, error_model="numpy")
def _people(beams: Beams, pose: Pose, period: NDArray[np.float64], people: People, hits: Hits) -> None:
    capsules = np.empty((CAPSULES, 7))
    for n in range(len(people.id)):
        stature = people.stature[n]
        reach = beams.limit + REACH * stature
        dx, dy = people.position[n, 0] - pose.x, people.position[n, 1] - pose.y
        west, east = _images(dx, reach, period[0])
        south, north = _images(dy, reach, period[1])
        count = 0
        for i in range(west, east + 1):
            for j in range(south, north + 1):
                x, y = _in_sensor(pose, dx + i * period[0], dy + j * period[1])
                if x * x + y * y > reach * reach or not _in_view(beams, x, y, REACH * stature):
                    continue
                if count == 0:
                    count = _pose_at(pose.z, people, n, capsules)
                _person(beams, pose, x, y, REACH * stature, people.id[n], capsules[:count], hits)


@njit(cache=True, nogil=True, error_model="numpy")
def _pose_at(z: float, people: People, n: int, capsules: NDArray[np.float64]) -> int:
    """Write the capsules of person `n`, around their own position, that may be at this height; their number."""
    vx, vy, heading = people.velocity[n, 0], people.velocity[n, 1], people.heading[n]
    stature, phase = people.stature[n], people.gait_phase[n]
    if z < LEGS_ONLY * stature:
        pose_legs(0.0, 0.0, vx, vy, heading, stature, phase, capsules)
        return LEGS
    pose_one(0.0, 0.0, vx, vy, heading, stature, phase, capsules)
    return CAPSULES


@njit(cache=True, nogil=True, error_model="numpy")
def see(beams: Beams, pose: Pose, people: People, n: int, dx: float, dy: float, hits: Hits) -> int:
    """How many beams meet person `n`, at (dx, dy) from the sensor in the map [m], if nothing else is there.

    `hits` must hold nothing, and does so afterwards.
    """
    capsules = np.empty((CAPSULES, 7))
    parts = _pose_at(pose.z, people, n, capsules)
    x, y = _in_sensor(pose, dx, dy)
    _person(beams, pose, x, y, REACH * people.stature[n], people.id[n], capsules[:parts], hits)
    count = 0
    for k in range(len(hits.kind)):
        if hits.kind[k] != NOTHING:
            count += 1
            hits.distance[k], hits.kind[k] = np.inf, NOTHING
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _in_view(beams: Beams, x: float, y: float, radius: float) -> bool:
    """False if no beam can meet the disc around (x, y); to find out is cheaper than to pose somebody for nothing."""
    extent = beams.increment * len(beams.directions)
    if 2.0 * math.pi - extent < _WORTHWHILE:
        return True
    first, last = beams.directions[0], beams.directions[-1]
    right = x * first[1] - y * first[0] > radius
    left = y * last[0] - x * last[1] > radius
    return not (right or left) if extent < math.pi else not (right and left)


@njit(cache=True, nogil=True, error_model="numpy")
def _person(
    beams: Beams, pose: Pose, x: float, y: float, reach: float, number: int, capsules: NDArray[np.float64], hits: Hits
) -> None:
    """Somebody at (x, y), whose `capsules` are those of the map but around their own position, within `reach`."""
    may_hold_sensor = x * x + y * y <= reach * reach
    for c in range(len(capsules)):
        capsule = capsules[c]
        if not in_slab(capsule, pose.z):
            continue
        ax, ay = _in_sensor(pose, capsule[0], capsule[1])
        bx, by = _in_sensor(pose, capsule[3], capsule[4])
        axis = Axis(x + ax, y + ay, capsule[2] - pose.z, bx - ax, by - ay, capsule[5] - capsule[2], capsule[6])
        if may_hold_sensor and holds_origin(axis):
            for k in range(len(beams.directions)):
                _note(beams, k, 0.0, PERSON, number, BODY_PART[c], hits)
            continue
        seen = outline(axis)
        if seen.nearest > beams.limit:
            continue
        for turn in range(2):
            low, high = _span(beams, seen.start, seen.extent, turn)
            for k in range(low, high):
                if seen.nearest < hits.distance[k]:
                    distance = meets(axis, beams.directions[k, 0], beams.directions[k, 1])
                    _note(beams, k, distance, PERSON, number, BODY_PART[c], hits)


@njit(cache=True, nogil=True, error_model="numpy")
def _robots(beams: Beams, pose: Pose, period: NDArray[np.float64], robots: Cylinders, hits: Hits) -> None:
    for n in range(len(robots.number)):
        if robots.height[n] < pose.z:
            continue
        reach = beams.limit + robots.radius[n]
        dx, dy = robots.centre[n, 0] - pose.x, robots.centre[n, 1] - pose.y
        west, east = _images(dx, reach, period[0])
        south, north = _images(dy, reach, period[1])
        for i in range(west, east + 1):
            for j in range(south, north + 1):
                x, y = _in_sensor(pose, dx + i * period[0], dy + j * period[1])
                if x * x + y * y <= reach * reach:
                    _disc(beams, x, y, robots.radius[n], robots.number[n], hits)


@njit(cache=True, nogil=True, error_model="numpy")
def _images(offset: float, reach: float, period: float) -> tuple[int, int]:
    """First and last number of periods that brings `offset` within `reach` of 0; none if the last is the smaller."""
    if period == 0.0:
        return 0, 0
    return math.ceil((-reach - offset) / period), math.floor((reach - offset) / period)


@njit(cache=True, nogil=True, error_model="numpy")
def _disc(beams: Beams, x: float, y: float, radius: float, number: int, hits: Hits) -> None:
    away = math.sqrt(x * x + y * y)
    if away <= radius:
        for k in range(len(beams.directions)):
            _note(beams, k, 0.0, ROBOT, number, NO_PART, hits)
        return
    half = math.asin(radius / away)
    start = math.atan2(y, x) - half
    for turn in range(2):
        low, high = _span(beams, start, 2.0 * half, turn)
        for k in range(low, high):
            ux, uy = beams.directions[k, 0], beams.directions[k, 1]
            ahead, aside = x * ux + y * uy, x * uy - y * ux
            depth = radius * radius - aside * aside
            if depth >= 0.0 and ahead > 0.0:
                _note(beams, k, ahead - math.sqrt(depth), ROBOT, number, NO_PART, hits)


@njit(cache=True, nogil=True, error_model="numpy")
def _note(beams: Beams, k: int, distance: float, kind: int, number: int, part: int, hits: Hits) -> None:
    if distance <= beams.limit and distance < hits.distance[k]:
        hits.distance[k], hits.kind[k], hits.agent[k], hits.body_part[k] = distance, kind, number, part
