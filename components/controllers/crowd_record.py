"""The crowd of an earlier run as a prediction for this one: right as long as people do the same again.

That is so with the same scenario and seed and a crowd that does not react to robots. It is checked at every step: who
is not where the record has them is an error, since a wrong oracle would be no bound.
"""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import make_reader
from numpy.typing import NDArray

from components.controllers.surroundings import Discs
from crowdcosim.cdr import decode
from crowdcosim.messages import Crowd
from crowdcosim.world import World

Array = NDArray[np.float64]

SAME = 1e-9
"""distance within which somebody is where the record has them [m]"""


class CrowdRecord:
    """Where everybody was at every time, without jumps at the seams."""

    def __init__(self, log: str, world: World) -> None:
        """Read the crowd of a log.

        Raises:
            ValueError: if the log cannot be read, or holds no crowd, or one whose people come and go.
        """
        self._log, self._world = log, world
        crowds: dict[int, Crowd] = {}
        try:
            with Path(log).open("rb") as stream:
                for schema, _, message in make_reader(stream).iter_messages():
                    if schema is not None and schema.name == Crowd.TYPE:
                        crowds[message.log_time] = decode(message.data, Crowd.TYPE)
        except OSError as error:
            raise ValueError(f"log is '{log}', which cannot be read: {error.strerror}") from None
        except (McapError, EOFError, ValueError, struct.error) as error:
            raise ValueError(
                f"log is '{log}', which is no MCAP log that can be read: {error or type(error).__name__}"
            ) from None
        if len(crowds) < 2:
            raise ValueError(f"log is '{log}', which holds {len(crowds)} states of a crowd, expected at least two")
        times = sorted(crowds)
        people = {crowds[t].id.tobytes() for t in times}
        if len(people) > 1:
            raise ValueError(f"log is '{log}', whose people come and go, expected the same people all the time")
        self._time = np.array(times, np.int64)
        raw = np.array([crowds[t].position for t in times])
        steps = world.displacement(raw[:-1], raw[1:])
        self._position = np.concatenate([raw[:1], raw[0] + np.cumsum(steps, axis=0)])
        """(T, N, 2) [m]"""

    def write(self, now: int, discs: Discs, who: NDArray[np.int64], dt: float, position: Array) -> None:
        """Write where people will be.

        Args:
            now: [ns]
            discs: people first.
            who: (M,) numbers of the discs that are wanted, ascending.
            dt: time between two stages [s].
            position: (N + 1, M, 2) relative to the robot, right at stage 0; those of people are written from 1 on [m].

        Raises:
            ValueError: if the people are others, or elsewhere, or the record has ended.
        """
        if discs.people != self._position.shape[1]:
            raise ValueError(
                f"'{self._log}' has {self._position.shape[1]} people, but there are {discs.people}: record the same "
                "scenario, and let `people_from` be truth"
            )
        if now > self._time[-1]:
            raise ValueError(
                f"'{self._log}' ends after {self._time[-1] * 1e-9:g} s, before this run: record a longer one, such as "
                "with `--set end.goal=none`"
            )
        i = int(np.searchsorted(self._time, now))
        away = self._world.displacement(self._position[i], discs.position[: discs.people])
        if self._time[i] != now or not (np.abs(away) <= SAME).all():
            raise ValueError(
                f"after {now * 1e-9:g} s people are not where '{self._log}' has them: it can be used with the same "
                "scenario and seed only, and with a crowd that does not react to robots (crowd.config.reactive=false)"
            )
        people = who[who < discs.people]
        for k in range(1, len(position)):
            later = self._at(now + round(k * dt * 1e9), people)
            position[k, : len(people)] = position[0, : len(people)] + later - self._position[i, people]

    def _at(self, time: int, people: NDArray[np.int64]) -> Array:
        """Where people are at a time [ns]; after the end of the record, at their last velocity."""
        j = min(len(self._time) - 1, max(1, int(np.searchsorted(self._time, time))))
        first, last = self._time[j - 1], self._time[j]
        share = (time - first) / (last - first)
        return (1.0 - share) * self._position[j - 1, people] + share * self._position[j, people]
