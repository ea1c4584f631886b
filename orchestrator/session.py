"""A scenario stepped by hand: give velocity commands, get back what the sensors say, the crowd, contacts and clock."""

from __future__ import annotations

import json
import time
from collections.abc import Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from itertools import count
from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Any, Literal, Self

from components.controllers.commanded import Commanded
from crowdcosim.messages import Goal, Twist
from orchestrator.commanding import Command, robots_to_command, take_over, twists
from orchestrator.episode import Episode, Pace, Result, reference_of, reference_run
from orchestrator.errors import InputError
from orchestrator.log.recording import Reference
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation, goal_of
from orchestrator.view import View, Viewer


class Session:
    """A scenario that is open: `step` it, `reset` it, `load` another, `close` it. Also a context.

    The first episode begins at once; `view` is what there is to see. When `over`, `result` holds the metrics.
    """

    view: View
    """the episode as it is now"""

    def __init__(
        self,
        scenario: str | Path | Mapping[str, Any] = "corridor",
        settings: Mapping[str, Any] | Sequence[str] = (),
        *,
        commanded: str | Collection[str] = (),
        seed: int | None = None,
        dt: float | None = None,
        latency: float | Literal["measured"] = 0.0,
        reference: Reference | None = None,
        alone: bool = False,
        real_time: float | None = None,
        record: str | Path | None = None,
        host: Literal["inline", "process"] = "inline",
    ) -> None:
        """Open a scenario and begin an episode.

        Args:
            scenario: a file, a shipped scenario's name, or plain data.
            settings: values laid over it, `{"crowd.config.count": 200}` or `["crowd.config.count=200"]`.
            commanded: robots that you command in place of their controllers; those without one are anyway.
            seed: in place of the scenario's.
            dt: time step in place of the scenario's [s].
            latency: commands take effect so much later [s], or after the time you took for them: `measured`.
            reference: what the evaluator compares with: robot -> metric -> value in a run without people.
            alone: the first episode is one without people, as in `reset`.
            real_time: pace, in simulated seconds per second; None runs as fast as it can.
            record: folder into which each episode's log is written; None writes none.
            host: where components run for which the scenario does not say it.

        Raises:
            InputError: if the scenario cannot be run.
            RunError: if a component fails.
        """
        self.real_time = real_time
        self._record = None if record is None else Path(record)
        self._host = host
        self._closed = False
        self._closing = ExitStack()
        self._simulation: Simulation | None = None
        self._episode: Episode | None = None
        self._reference: Reference | None = None
        self.result: Result | None = None
        """what became of the episode; None while it is not over"""
        try:
            self.load(
                scenario,
                settings,
                commanded=commanded,
                seed=seed,
                dt=dt,
                latency=latency,
                reference=reference,
                alone=alone,
            )
        except BaseException:
            self.close()
            raise

    def load(
        self,
        scenario: str | Path | Mapping[str, Any],
        settings: Mapping[str, Any] | Sequence[str] = (),
        *,
        commanded: str | Collection[str] = (),
        seed: int | None = None,
        dt: float | None = None,
        latency: float | Literal["measured"] = 0.0,
        reference: Reference | None = None,
        alone: bool = False,
    ) -> View:
        """Switch to another scenario and begin an episode of it; the arguments are those of `Session`."""
        if self._closed:
            raise InputError("the session is closed: open another")
        self._leave()
        own = [f"host={self._host}", *as_list(settings)]
        own += [f"{key}={value}" for key, value in (("seed", seed), ("dt", dt)) if value is not None]
        loaded = load(scenario, own)
        self.commanded = robots_to_command(loaded, [commanded] if isinstance(commanded, str) else list(commanded))
        """the robots that wait for commands"""
        if latency and not self.commanded:
            raise InputError(f"latency is {latency}, expected none: no robot is commanded; set that of its controller")
        self.scenario = load(scenario, [*own, *(s for robot in self.commanded for s in take_over(robot, latency))])
        self._reference = reference
        self._open()
        return self.reset(alone=alone)

    def reset(self, seed: int | None = None, *, alone: bool = False) -> View:
        """Stop the episode and begin another.

        Args:
            seed: of this and later episodes; None keeps the one before.
            alone: there are no people. Its metrics are what those of later episodes are compared with (T/Tcr, ...), in
                place of the reference run that robots with controllers make by themselves. It is not recorded.
        """
        if self._closed:
            raise InputError("the session is closed: open another")
        self.stop()
        if self._simulation is None:
            self._open()
        assert self._simulation is not None
        if seed is not None and seed != self.scenario.seed:
            self._reseed(seed)
        if not self.commanded and not alone and self._reference is None:
            self._reference = reference_run(self._simulation)
        self.result = None
        reference = None if alone else self._reference
        log = None if alone else self._new_log()
        self._alone = alone
        self._episode = Episode(self._simulation, reference=reference, log=log, alone=alone)
        self._pace = Pace(self.real_time)
        self._observe(self._episode)
        return self.view

    def step(self, command: Command | Mapping[str, Command] | None = None) -> View:
        """Carry out a command for one time step.

        Args:
            command: a `Twist` or (forward speed [m/s], turn rate [rad/s]) for the only commanded robot, or robot ->
                command for all of them; None if none is commanded.

        Raises:
            InputError: if the episode is over, or the command is not one for each commanded robot, of finite numbers.
            RunError: if a component fails; the episode then is over without a result.
        """
        episode = self._going_on()
        thought = time.perf_counter_ns() - self._shown
        for robot, twist in twists(self.commanded, command).items():
            self._hand(robot, twist, thought)
        try:
            over = episode.complete()
            self._pace.wait(episode.time)
            if over:
                self._finish(episode)
            else:
                self._observe(episode)
        except BaseException as error:
            self._fail(error)
            raise
        return self.view

    @property
    def goals(self) -> Mapping[str, Goal]:
        """Robot -> its goal."""
        return {robot.name: goal_of(robot) for robot in self.scenario.robots}

    @property
    def over(self) -> bool:
        """True when the goal is reached, the time is up, or whatever else ends the scenario."""
        return self._episode is None

    def stop(self) -> Result | None:
        """End the episode here, if it is not over. Its result; None if it was stopped before the first step."""
        if (episode := self._episode) is None:
            return self.result
        assert self._simulation is not None
        try:
            if not self._simulation.inline:  # Components elsewhere are amid a tick, and cannot be called back.
                for robot in self.commanded:
                    self._hand(robot, self._component(robot).command or Twist(), 0)
                episode.complete()
            if episode.tick:
                self._finish(episode)
            else:
                episode.discard()
        except BaseException as error:
            self._fail(error)
            raise
        self._episode = None
        return self.result

    def close(self) -> None:
        """Stop the episode, and end all processes. Closing twice does no harm."""
        self._closed = True
        try:
            self._leave()
        finally:
            self._closing.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None and self._episode:
            self._fail(error)
        self.close()

    # --- opening and closing -------------------------------------------------------------------------------------

    def _open(self) -> None:
        names = [f"{robot}/controller" for robot in self.commanded]
        logs = Path()  # only processes print into files
        if any(spec.host != "inline" for spec in self.scenario.components):
            logs = Path(self._closing.enter_context(TemporaryDirectory()))
        self._simulation = Simulation(self.scenario, logs=logs, commanded=names)
        self._viewer = Viewer(self._simulation)

    def _leave(self) -> None:
        try:
            self.stop()
        finally:
            if self._simulation:
                self._simulation.close()
            self._simulation = None

    def _reseed(self, seed: int) -> None:
        assert self._simulation is not None
        again = load(self.scenario.resolved, [f"seed={seed}"])  # refuses what is no seed
        self.scenario = replace(again, admission=self.scenario.admission)
        if not self.commanded:
            self._reference = None
        if self._simulation.inline:
            self._simulation.reseed(seed)
        else:
            self._simulation.close()
            self._open()

    def _new_log(self) -> Path | None:
        if self._record is None:
            return None
        return next(p for n in count(1) if not (p := self._record / f"episode_{n}.mcap").exists())

    # --- one step ------------------------------------------------------------------------------------------------

    def _going_on(self) -> Episode:
        if self._episode is None:
            why = "has failed" if self.result is None else f"is over ({self.result.outcome})"
            raise InputError(f"the episode {why}: begin another with reset()")
        return self._episode

    def _hand(self, robot: str, twist: Twist, thought: int) -> None:
        assert self._simulation is not None
        self._component(robot).command = twist
        self._simulation.lockstep.thought[f"{robot}/controller"] = thought

    def _component(self, robot: str) -> Commanded:
        assert self._simulation is not None
        component = self._simulation.hosted(f"{robot}/controller")
        assert isinstance(component, Commanded)
        return component

    def _observe(self, episode: Episode) -> None:
        try:
            episode.observe()
            self.view = self._viewer.view(episode.tick)
        except BaseException as error:
            self._fail(error)
            raise
        self._shown = time.perf_counter_ns()

    def _finish(self, episode: Episode) -> None:
        self.result = episode.finish()
        self._episode = None
        episode.simulation.lockstep.observe_end(episode.tick)
        self.view = self._viewer.view(episode.tick)
        if self._alone:
            self._reference = reference_of(self.result)

    def _fail(self, error: BaseException) -> None:
        if self._episode:
            self._episode.fail(error)
        self._episode = None
        if self._simulation and not self._simulation.inline:  # Who knows what the processes still wait for.
            self._simulation.close(stop=False)
            self._simulation = None


def as_list(settings: Mapping[str, Any] | Sequence[str]) -> list[str]:
    """Settings as `--set` takes them, `key.path=value`."""
    if isinstance(settings, Mapping):
        return [f"{key}={json.dumps(value)}" for key, value in settings.items()]
    return [settings] if isinstance(settings, str) else list(settings)
