"""Recorded people: they walk as they once walked, whatever robots do.

Positions between samples are those of a cubic Hermite spline whose slopes are those of the parabola through each sample
and its two neighbours, or linear; velocities are its derivative at the same time. A person is there from the first
to the last sample. A sample at p in the file is at offset + R(rotation) scale p in the world.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.crowd.distributions import Distribution, draw, require_positive
from components.crowd.gait import walk
from components.crowd.people import BODIES, RADII, STATURES, STEPS, draw_bodies
from components.crowd.tracks import Form, Tracks, Unit, read_tracks
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Header
from crowdcosim.setup import Setup, time_of

Array = NDArray[np.float64]

SAME_TIME = 1e-9
"""times that differ by less are the same [s]"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Which tracks, and how they come into the world."""

    file: str
    """path of the tracks; `./tracks.csv` is beside the scenario that says so"""
    format: Form | None = None
    """of the file; by default as its content looks"""
    frame_rate: float | None = None
    """frames per second, where the file does not say it [1/s]"""
    unit: Unit | None = None
    """of positions, where the file does not say it"""
    scale: float = 1.0
    """factor of positions"""
    rotation: float = 0.0
    """counter-clockwise, after scaling [rad]"""
    offset: tuple[float, float] = (0.0, 0.0)
    """where the file's origin is in the world [m]"""
    begin: float | None = None
    """time after the first sample at which the episode begins [s]; by default 0, or when who is replaced comes"""
    interpolation: Literal["cubic", "linear"] = "cubic"
    """between samples"""
    replace: int | None = None
    """id of one person to leave out, whose place the robot takes (`crowdcosim tracks` tells where that is)"""
    radius: Distribution = 0.3
    """radii of the bodies' discs [m]"""
    stature: Distribution | None = None
    """body heights [m]; by default those of adults, half of them men"""

    def __post_init__(self) -> None:
        for name in ("frame_rate", "scale"):
            value = getattr(self, name)
            if value is not None and not value > 0:
                raise ValueError(f"{name} is {value}, expected a positive number")
        require_positive("radius", self.radius)
        if self.stature is not None:
            require_positive("stature", self.stature)


class Visit(NamedTuple):
    """One person's way through the world."""

    id: int
    """as in the file"""
    begin: float
    """when they come, after the first sample of all [s]"""
    end: float
    """when they go [s]"""
    start: tuple[float, float]
    """where they come [m]"""
    goal: tuple[float, float]
    """where they go [m]"""
    length: float
    """of their way, from sample to sample [m]"""


class Replay(Mover):
    """The people of a file of tracks."""

    def __init__(self, config: Config) -> None:
        self._config = config
        self._file = Path(config.file).absolute()

    def visits(self) -> list[Visit]:
        """Everybody in the file, in the world's coordinates, by id.

        Raises:
            TrackError: if the file is not as expected.
        """
        tracks = self._tracks()
        ways = []
        for p, number in enumerate(tracks.id):
            time, place = (a[tracks.first[p] : tracks.first[p + 1]] for a in (tracks.time, tracks.position))
            length = float(np.hypot(*np.diff(place, axis=0).T).sum())
            (x, y), (gx, gy) = place[[0, -1]].tolist()
            ways.append(Visit(int(number), float(time[0]), float(time[-1]), (x, y), (gx, gy), length))
        return ways

    def reset(self, setup: Setup) -> Crowd:
        """Who is there at the beginning.

        Raises:
            ValueError: if the file is not as expected, or its people do not fit into the world.
        """
        config, tracks = self._config, self._tracks()
        count = len(tracks.id)
        stays = np.full(count, not setup.alone)
        begin = config.begin
        if config.replace is not None:
            replaced = np.flatnonzero(tracks.id == config.replace)
            if not len(replaced):
                raise ValueError(f"replace is {config.replace}, expected an id of {self._file}: {_some(tracks.id)}")
            stays[replaced] = False
            begin = float(tracks.time[tracks.first[replaced[0]]]) if begin is None else begin
        self._begin = 0.0 if begin is None else float(begin)
        position = setup.world.wrap(tracks.position)
        self._check_inside(tracks, position, setup)
        self._stays = stays
        # Unwrapped: nobody crosses the world between two samples at the seam.
        self._spline = _spline(tracks, linear=config.interpolation == "linear")
        everybody = np.arange(count)
        try:
            radius = draw(config.radius, setup.rng(RADII), count, everybody)
            stature, mass = draw_bodies(setup.rng(BODIES), count)
            if config.stature is not None:
                given = draw(config.stature, setup.rng(STATURES), count, everybody)
                stature, mass = given, mass * (given / stature) ** 2
        except ValueError as error:
            raise ValueError(f"radius or stature: {error}") from None
        # 0 means nobody in messages.
        number = (tracks.id + (tracks.id.min() == 0)).astype(np.uint32)
        self._body = {
            "id": number,
            "group": np.zeros(count, np.uint32),
            "radius": radius,
            "stature": stature,
            "mass": mass,
        }
        whole = tracks.position[tracks.first[1:] - 1] - tracks.position[tracks.first[:-1]]
        self._heading = np.arctan2(whole[:, 1], whole[:, 0])
        self._phase = setup.rng(STEPS).random(count)
        self._pace = np.full(count, np.nan)
        self._dt, self._period, self._time, self._world = setup.dt, setup.period, 0, setup.world
        return self._now()

    def step(self) -> Crowd:
        """Who is there one time step later."""
        self._time += self._period
        return self._now()

    def _tracks(self) -> Tracks:
        config = self._config
        tracks = read_tracks(self._file, form=config.format, frame_rate=config.frame_rate, unit=config.unit)
        c, s = math.cos(config.rotation), math.sin(config.rotation)
        placed = config.scale * tracks.position @ np.array([[c, s], [-s, c]]) + np.array(config.offset, np.float64)
        return Tracks(id=tracks.id, first=tracks.first, time=tracks.time, position=placed)

    def _check_inside(self, tracks: Tracks, position: Array, setup: Setup) -> None:
        """Refuse people who walk outside of the world."""
        outside = ((position < 0) | (position > np.asarray(setup.world.size))).any(axis=1)
        if outside.any():
            k = int(outside.argmax())
            who = tracks.id[np.searchsorted(tracks.first, k, "right") - 1]
            (left, low), (right, high) = tracks.position.min(axis=0), tracks.position.max(axis=0)
            x, y = setup.world.size
            at = ", ".join(f"{c:.2f}" for c in tracks.position[k])
            raise ValueError(
                f"person {who} is at ({at}) at {tracks.time[k]:.2f} s, outside of the world of {x:g} x {y:g} m; all "
                f"tracks are within x {left:.2f} to {right:.2f} and y {low:.2f} to {high:.2f}: move them with `offset` "
                "or make the world larger"
            )

    def _now(self) -> Crowd:
        time = self._begin + 1e-9 * self._time
        first, samples = self._spline.first, self._spline.time
        there = (samples[first[:-1]] <= time + SAME_TIME) & (time - SAME_TIME <= samples[first[1:] - 1]) & self._stays
        who = np.flatnonzero(there)
        position, velocity = _sample(self._spline, who, time)
        speed = np.hypot(velocity[:, 0], velocity[:, 1])
        # Whoever comes is walking already.
        pace = np.where(np.isnan(self._pace[who]), speed, self._pace[who])
        heading, pace, phase = walk(
            velocity, self._heading[who], pace, self._phase[who], self._body["stature"][who], self._dt
        )
        self._heading[who], self._pace[who], self._phase[who] = heading, pace, phase
        return Crowd(
            header=Header(stamp=time_of(self._time), frame_id="map"),
            position=self._world.wrap(position),
            velocity=velocity,
            heading=heading,
            gait_phase=phase,
            gait_speed=pace,
            **{name: values[who] for name, values in self._body.items()},
        )


class Spline(NamedTuple):
    """Ways through samples, with slopes."""

    first: NDArray[np.int64]
    """(P + 1,) person p has the samples first[p] to first[p + 1]"""
    time: Array
    """(S,) [s]"""
    position: Array
    """(S, 2) [m]"""
    slope: Array
    """(S, 2) velocities at the samples [m/s]; NaN: straight on to the next"""


def _spline(tracks: Tracks, *, linear: bool) -> Spline:
    slope = np.full_like(tracks.position, np.nan)
    for p in range(0 if linear else len(tracks.id)):
        part = slice(tracks.first[p], tracks.first[p + 1])
        if part.stop - part.start >= 3:
            slope[part] = _parabolic(tracks.time[part], tracks.position[part])
    return Spline(tracks.first, tracks.time, tracks.position, slope)


def _parabolic(time: Array, position: Array) -> Array:
    """(K, 2) slopes at K >= 3 samples of the parabola through each and its neighbours, at the ends of the outermost."""
    h = np.diff(time)[:, None]
    chord = np.diff(position, axis=0) / h
    inner = (h[1:] * chord[:-1] + h[:-1] * chord[1:]) / (h[1:] + h[:-1])
    return np.concatenate([2 * chord[:1] - inner[:1], inner, 2 * chord[-1:] - inner[-1:]])


@njit(cache=True, nogil=True, error_model="numpy")
def _sample(spline: Spline, who: NDArray[np.int64], t: float) -> tuple[Array, Array]:
    """Positions [m] and velocities [m/s], both (K, 2), of some people at a time at which they are there."""
    time, position, slope = spline.time, spline.position, spline.slope
    place, velocity = np.empty((len(who), 2)), np.zeros((len(who), 2))
    for k in range(len(who)):
        begin, end = spline.first[who[k]], spline.first[who[k] + 1]
        if end - begin == 1:
            place[k, 0], place[k, 1] = position[begin, 0], position[begin, 1]
            continue
        a = begin + np.searchsorted(time[begin:end], t, "right") - 1
        a = min(max(a, begin), end - 2)
        h = time[a + 1] - time[a]
        s = min(max((t - time[a]) / h, 0.0), 1.0)
        for d in range(2):
            p, q = position[a, d], position[a + 1, d]
            m, n = h * slope[a, d], h * slope[a + 1, d]
            if math.isnan(m):
                place[k, d], velocity[k, d] = p + s * (q - p), (q - p) / h
                continue
            # Hermite's cubic and its derivative.
            place[k, d] = p + s * (m + s * (3.0 * (q - p) - 2.0 * m - n + s * (m + n - 2.0 * (q - p))))
            velocity[k, d] = (m + s * (2.0 * (3.0 * (q - p) - 2.0 * m - n) + 3.0 * s * (m + n - 2.0 * (q - p)))) / h
    return place, velocity


def _some(ids: NDArray[np.int64]) -> str:
    """A few of many numbers."""
    shown = ", ".join(str(i) for i in ids[:8])
    return f"{shown} ... {ids[-1]}" if len(ids) > 8 else shown
