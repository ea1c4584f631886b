"""Where people are expected while a plan lasts.

`constant_velocity`: everybody walks on as they do now. `orca`: they do so, but avoid each other, by the half-planes of
van den Berg, Guy, Lin, Manocha, "Reciprocal n-body collision avoidance", ISRR 2009, section 4; what they would walk
like if nobody were near is not known and taken to be how they walk now. `orca_reciprocal`: they also make way for the
robot, which is taken to follow its last plan. `record`: they walk as the log of an earlier run says they will
(`crowd_record.py`), which is as well as people can be predicted: a bound for the others.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.controllers.crowd_record import CrowdRecord
from components.controllers.ego import Ego
from components.controllers.half_planes import best_velocity, escape
from components.controllers.surroundings import Discs, discs_of, frozen, nearest_image
from crowdcosim import Setup
from crowdcosim.messages import Crowd, Header
from crowdcosim.setup import nanoseconds_of

Array = NDArray[np.float64]

Model = Literal["constant_velocity", "orca", "orca_reciprocal", "record"]
"""how people are expected to walk"""

HORIZON = 1.5
"""tau of the people in `orca` [s]"""
NEIGHBOURS = 5
"""whom they avoid, at most, the nearest first"""
SIGHT = 3.0
"""how far they see, from centre to centre [m]"""


class Tracks(NamedTuple):
    """M discs at the stages 0 to N of a plan, relative to the robot's position at stage 0."""

    position: Array
    """(N + 1, M, 2) centres [m]"""
    radius: Array
    """(M,) radii [m]"""


class Horizon(NamedTuple):
    """Which part of the future counts."""

    stages: int
    """N"""
    dt: float
    """time between two stages [s]"""
    speed: float
    """greatest speed of the robot [m/s]"""
    margin: float
    """how near to somebody's edge the robot's centre must come for that to count [m]"""
    body: float
    """radius of the robot [m]"""


@dataclass(frozen=True, kw_only=True)
class Prediction:
    """Which prediction to use."""

    model: Model = "constant_velocity"
    """how people are expected to walk"""
    log: str | None = None
    """of `record`: the log of a run with the same crowd, which must not react to robots"""

    def __post_init__(self) -> None:
        if (self.model == "record") != (self.log is not None):
            found = "no log" if self.log is None else f"log {self.log!r}"
            raise ValueError(f"model is '{self.model}' with {found}, expected a log with 'record' and with no other")


class Predictor:
    """Predicts as a `Prediction` says."""

    def __init__(self, prediction: Prediction, setup: Setup) -> None:
        """Load the record, if there is one.

        Raises:
            ValueError: if it cannot be read.
        """
        self._model = prediction.model
        self._period = frozen(setup.world.period)
        # Without people there is nothing to look up.
        read = prediction.log is not None and not setup.alone
        self._record = CrowdRecord(prediction.log or "", setup.world) if read else None
        # Load the kernels.
        horizon = Horizon(1, 1.0, 1.0, 1.0, 1.0)
        tracks, _ = constant_velocity(Ego(0.0, 0.0, 0.0, 0.0, 0.0), discs_of(Crowd(), (), ""), self._period, horizon)
        if self._model in ("orca", "orca_reciprocal"):
            walk(tracks, 0, np.zeros((2, 2)), True, horizon)

    def tracks(self, ego: Ego, header: Header, discs: Discs, own: Array, horizon: Horizon) -> Tracks:
        """Whom the robot can meet within the horizon, and where they will be when.

        Args:
            ego: the robot's position.
            header: of the odometry, for the time.
            discs: people, seen in the image that is nearest now, and other robots.
            own: (N + 1, 2) where the robot will be by its last plan, relative to where it is now [m].
            horizon: what counts.

        Raises:
            ValueError: if people are not where the record has them.
        """
        tracks, who = constant_velocity(ego, discs, self._period, horizon)
        if self._model in ("orca", "orca_reciprocal"):
            people = int(np.searchsorted(who, discs.people))
            walk(tracks, people, own, self._model == "orca_reciprocal", horizon)
        elif self._record is not None:
            self._record.write(nanoseconds_of(header.stamp), discs, who, horizon.dt, tracks.position)
        return tracks


@njit(cache=True, nogil=True, error_model="numpy")
def constant_velocity(ego: Ego, discs: Discs, period: Array, horizon: Horizon) -> tuple[Tracks, NDArray[np.int64]]:
    """Everybody at constant velocity whom the robot can meet, and (M,) their numbers among `discs`, ascending."""
    count, lasting = len(discs.radius), horizon.stages * horizon.dt
    position, who = np.empty((horizon.stages + 1, count, 2)), np.empty(count, np.int64)
    m = 0
    for i in range(count):
        x, y = discs.position[i, 0] - ego.x, discs.position[i, 1] - ego.y
        if i < discs.people:
            x, y = nearest_image(x, period[0]), nearest_image(y, period[1])
        vx, vy = discs.velocity[i, 0], discs.velocity[i, 1]
        reach = discs.radius[i] + horizon.margin + (horizon.speed + math.hypot(vx, vy)) * lasting
        if math.hypot(x, y) <= reach:
            for k in range(horizon.stages + 1):
                position[k, m] = x + k * horizon.dt * vx, y + k * horizon.dt * vy
            who[m] = i
            m += 1
    return Tracks(position[:, :m].copy(), discs.radius[who[:m]]), who[:m].copy()


@njit(cache=True, nogil=True, error_model="numpy")
def walk(tracks: Tracks, people: int, own: Array, reciprocal: bool, horizon: Horizon) -> None:
    """Let the first `people` of the tracks avoid everybody; the others, who are robots, stay as they are.

    Args:
        tracks: at constant velocity; written anew from stage 1 on.
        people: how many of them are people.
        own: (N + 1, 2) where the robot will be [m].
        reciprocal: people avoid the robot too.
        horizon: what counts.
    """
    position, radius, dt = tracks.position, tracks.radius, horizon.dt
    count = len(radius)
    velocity = (position[1] - position[0]) / dt
    preferred, chosen = velocity.copy(), velocity.copy()
    planes, near, squares = np.empty((NEIGHBOURS + 1, 3)), np.empty(NEIGHBOURS, np.int64), np.empty(NEIGHBOURS)
    for k in range(horizon.stages):
        for i in range(people):
            x, y = position[k, i]
            vx, vy = velocity[i]
            used = 0
            if reciprocal:
                ox, oy = (own[k + 1] - own[k]) / dt
                used = _avoid(own[k, 0] - x, own[k, 1] - y, ox, oy, vx, vy, radius[i] + horizon.body, dt, planes, 0)
            found = 0
            for j in range(count):
                dx, dy = position[k, j, 0] - x, position[k, j, 1] - y
                square = dx * dx + dy * dy
                if j == i or square > SIGHT * SIGHT or (found == NEIGHBOURS and square >= squares[found - 1]):
                    continue
                slot = min(found, NEIGHBOURS - 1)
                while slot > 0 and squares[slot - 1] > square:
                    near[slot], squares[slot] = near[slot - 1], squares[slot - 1]
                    slot -= 1
                near[slot], squares[slot] = j, square
                found = min(found + 1, NEIGHBOURS)
            for j in near[:found]:
                dx, dy = position[k, j, 0] - x, position[k, j, 1] - y
                wx, wy = velocity[j]
                used = _avoid(dx, dy, wx, wy, vx, vy, radius[i] + radius[j], dt, planes, used)
            fast = math.hypot(preferred[i, 0], preferred[i, 1])
            chosen[i] = best_velocity(planes[:used], 0, fast, preferred[i, 0], preferred[i, 1])
        velocity[:people] = chosen[:people]
        position[k + 1, :people] = position[k, :people] + dt * velocity[:people]


@njit(cache=True, nogil=True, error_model="numpy")
def _avoid(
    x: float, y: float, wx: float, wy: float, vx: float, vy: float, contact: float, dt: float, planes: Array, row: int
) -> int:
    """Write the half-plane of somebody at (x, y) who walks at w, for a person who walks at v; the next row."""
    ux, uy, nx, ny = escape(x, y, vx - wx, vy - wy, contact, HORIZON, dt)
    planes[row] = -nx, -ny, -(nx * (vx + 0.5 * ux) + ny * (vy + 0.5 * uy))
    return row + 1
