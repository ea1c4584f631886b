"""Whom a controller knows about: the true crowd, people as a sensor detects them, or the points of a laser scan.

What is used is said by the option `people_from` and by nothing else; what else is wired to the controller is ignored.
"""

from __future__ import annotations

import math
from typing import Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from components.controllers.ego import Ego
from components.controllers.surroundings import Discs, discs_of, frozen
from components.controllers.tracker import Tracker
from crowdcosim import Setup
from crowdcosim.messages import Crowd, Detections, Header, LaserScan, RobotState
from crowdcosim.setup import nanoseconds_of

Array = NDArray[np.float64]

People = Literal["truth", "detections"]
"""`truth`: everybody's true position and velocity, and all other robots'; `detections`: who is detected, followed"""
PeopleOrScan = Literal["truth", "detections", "scan"]
"""as `People`; `scan`: standing points wherever a laser beam ends, and no knowledge of walls"""

T = TypeVar("T")
FIXED = ("", "map", "odom")
"""frames that do not move; `odom` is taken to lie on `map`"""


class Sight:
    """What a controller sees, as discs in the frame `map`."""

    def __init__(self, people: PeopleOrScan, setup: Setup, mount: str | None = None) -> None:
        """`mount`: where on the robot the laser scanner sits; None: at its centre, facing ahead.

        Raises:
            ValueError: if the robot has no such mount.
        """
        self._people = people
        self._own = setup.own_robot.name
        mounts = setup.own_robot.model.mounts
        if mount is not None and mount not in mounts:
            raise ValueError(f"mount is '{mount}', expected one of the robot's: {', '.join(mounts) or 'it has none'}")
        self._laser = (0.0, 0.0, 0.0) if mount is None else (*mounts[mount].position[:2], mounts[mount].yaw)
        self._tracker = Tracker()
        self._now = self._detected = -1

    def discs(
        self,
        ego: Ego,
        header: Header,
        crowd: Crowd | None,
        others: tuple[RobotState, ...],
        detections: Detections | None,
        scan: LaserScan | None = None,
    ) -> Discs:
        """Whom the robot must not touch.

        Args:
            ego: the robot's pose.
            header: of the odometry, for the time.
            crowd: read if `people_from` is `truth`, as are `others`.
            others: all robots.
            detections: read if `people_from` is `detections`.
            scan: read if `people_from` is `scan`.

        Raises:
            ValueError: if what `people_from` asks for is not connected, or is in a frame that is not known.
        """
        if self._people == "truth":
            return discs_of(_connected(crowd, "crowd", "Crowd", "truth"), others, self._own)
        if self._people == "detections":
            return self._followed(ego, header, _connected(detections, "detections", "Detections", "detections"))
        return self._points(ego, _connected(scan, "scan", "LaserScan", "scan"))

    def _followed(self, ego: Ego, header: Header, detections: Detections) -> Discs:
        """Everybody who is followed from detection to detection, also if the reporter has missed them just now."""
        position, velocity = _in_map(ego, detections)
        now, seen = nanoseconds_of(header.stamp), nanoseconds_of(detections.header.stamp)
        if self._now >= 0:
            self._tracker.predict((now - self._now) * 1e-9)
        self._now = now
        if seen != self._detected:
            self._detected = seen
            unknown = (detections.velocity_deviation == 0.0) & (detections.velocity == 0.0).all(axis=1)
            self._tracker.correct(
                position,
                detections.position_deviation,
                velocity,
                np.where(unknown, np.inf, detections.velocity_deviation),
                detections.radius,
            )
        return _discs(self._tracker.position, self._tracker.velocity, self._tracker.radius)

    def _points(self, ego: Ego, scan: LaserScan) -> Discs:
        """Where beams end; one that something is too near for ends at the least range."""
        ahead, left, yaw = self._laser
        ranges = np.asarray(scan.ranges, np.float64)
        ranges = np.where(ranges == -np.inf, scan.range_min, ranges)
        hit = np.flatnonzero(np.isfinite(ranges) & (ranges <= scan.range_max))
        angles = ego.heading + yaw + scan.angle_min + scan.angle_increment * hit
        cos, sin = math.cos(ego.heading), math.sin(ego.heading)
        centre = np.array([ego.x + cos * ahead - sin * left, ego.y + sin * ahead + cos * left])
        points = centre + ranges[hit, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        return _discs(points, np.zeros_like(points), np.zeros(len(points)))


def _connected(message: T | None, port: str, kind: str, people: str) -> T:
    if message is None:
        raise ValueError(
            f"people_from is '{people}', but the input '{port}' is not connected: let the scenario have one component "
            f"that gives a {kind}, or choose one: `inputs: {{{port}: COMPONENT.PORT}}`"
        )
    return message


def _in_map(ego: Ego, detections: Detections) -> tuple[Array, Array]:
    """Positions and velocities of detections along the axes of `map`."""
    frame = detections.header.frame_id.rpartition("/")[2]
    if frame in FIXED:
        return detections.position, detections.velocity
    if frame != "base_link":
        raise ValueError(
            f"detections are in the frame '{detections.header.frame_id}', expected map, odom or the robot's base_link"
        )
    cos, sin = math.cos(ego.heading), math.sin(ego.heading)
    turn = np.array([[cos, sin], [-sin, cos]])
    return np.array([ego.x, ego.y]) + detections.position @ turn, detections.velocity @ turn


def _discs(position: Array, velocity: Array, radius: Array) -> Discs:
    return Discs(frozen(position), frozen(velocity), frozen(radius), 0)
