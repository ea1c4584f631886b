"""The connection to the simulation: a session in this process behind the functions that once used a socket."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from typing import Any

from crowdcosim.crowdbot.frame import Frame
from crowdcosim.crowdbot.state import texts


class Connection:
    """One scenario after the other, each stepped to the clock of the messages that it is sent."""

    def __init__(self, scenarios: Sequence[str], settings: Mapping[str, Any] | Sequence[str], dt: float | None) -> None:
        from crowdcosim import Session  # on demand: it loads the orchestrator

        self._scenarios, self._settings, self._dt = scenarios, settings, dt
        self._index = 0
        self._clock = 0.0
        self.results: list[tuple[str, Any]] = []
        """scenario and the session's result, for each that was driven"""
        self._session = Session(scenarios[0], settings, commanded="robot", dt=dt)
        self._frame = Frame(self._session.goals["robot"], self._session.view.robot.state.position)

    def exchange(self, raw: str) -> str:
        """Do what a message says; how things are then."""
        message = json.loads(raw)
        match message["sim_control"]:
            case "n":
                self._next()
            case "r":
                self._session.reset()
            case "s":
                self.close()
            case _:
                self._clock = float(message["clock"])
                self._advance(self._clock, message["vel_cmd"])
        return json.dumps(self._state())

    def close(self) -> None:
        """Stop, and end the session; twice does no harm."""
        self._end()
        self._session.close()

    def _advance(self, clock: float, vel_cmd: Sequence[float]) -> None:
        period = self._session.scenario.period * 1e-9
        if clock < self._session.view.time - 0.5 * period:
            self._session.reset()
        steps = (clock - self._session.view.time) / period
        if abs(steps - round(steps)) > 1e-3:
            raise ValueError(
                f"the clock is {clock:g} s, expected a multiple of the scenario's time step, {period:g} s: "
                "open the connection with another, init_socket(dt=...)"
            )
        *speeds, turn = vel_cmd
        for _ in range(round(steps)):
            if not self._session.over:
                self._session.step((*speeds, math.radians(turn)))

    def _next(self) -> None:
        self._end()
        self._index += 1
        if self._index < len(self._scenarios):
            alone = self.results[0][1] if self.results else None
            reference: dict[str, dict[str, float]] = {}
            for metric in alone.metrics if alone else ():
                if metric.value is not None:
                    reference.setdefault(metric.robot, {})[metric.name] = metric.value
            self._session.load(
                self._scenarios[self._index],
                self._settings,
                commanded="robot",
                dt=self._dt,
                reference=reference or None,
            )
            self._frame = Frame(self._session.goals["robot"], self._session.view.robot.state.position)

    def _end(self) -> None:
        result = self._session.stop()
        if result is not None and all(result is not known for _, known in self.results):
            self.results.append((self._scenarios[self._index], result))

    def _state(self) -> dict[str, str]:
        view, frame = self._session.view, self._frame
        # When the episode is over, only the clock goes on: scripts wait for it to pass their limit.
        clock = max(view.time, self._clock) if self._session.over else view.time
        return texts(frame, clock, view.robot.state, view.crowd, view.robot.contacts)


def init_socket(
    HOST: str = "127.0.0.1",
    PORT: int = 25001,
    *,
    scenarios: Sequence[str] | None = None,
    settings: Mapping[str, Any] | Sequence[str] = (),
    dt: float | None = None,
) -> Connection:
    """Open the first of the scenarios.

    Args:
        HOST: not used: the simulation runs in this process.
        PORT: not used.
        scenarios: names or files, each with one robot called `robot`; by default those of `crowdcosim.crowdbot`.
        settings: values laid over each.
        dt: time step in place of the scenarios' [s].
    """
    from crowdcosim.crowdbot.challenge import SCENARIOS  # it uses this file

    return Connection(scenarios or SCENARIOS, settings, dt)


def send_and_receive(s: Connection, to_send: str) -> str:
    """Send a message, step to its clock, and get back how things are."""
    return s.exchange(to_send)


def stop(s: Connection) -> None:
    """End the simulation."""
    s.close()
