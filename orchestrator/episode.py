"""One episode from start to finish: the reference run without people, the run itself, its log and its result."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from crowdcosim.messages import Metrics
from orchestrator.ending import Reason, Referee
from orchestrator.log.recording import Committer, Reference, open_log
from orchestrator.simulation import Simulation


@dataclass(frozen=True, kw_only=True)
class Metric:
    """One value of the evaluator's verdict."""

    robot: str
    name: str
    value: float | None
    """None where the run gives no such value"""
    unit: str
    reason: str
    """why there is no value"""


@dataclass(frozen=True, kw_only=True)
class Timing:
    """Wall-clock time of a component's own work per step [s]."""

    steps: int
    mean: float
    median: float
    p99: float
    max: float


@dataclass(frozen=True, kw_only=True)
class Result:
    """What became of an episode."""

    scenario: str
    seed: int
    repeatable: bool
    """False: a latency was measured, and another run of the same scenario and seed may end differently"""
    outcome: Reason
    arrived: tuple[str, ...]
    """robots that reached their goal"""
    ticks: int
    simulated_time: float
    """[s]"""
    start_up_time: float
    """from the call to the first tick, be it of the reference run [s]"""
    wall_time: float
    """from the first tick of the episode to its last [s]"""
    real_time_factor: float
    """simulated over wall-clock time"""
    ticks_per_second: float
    data_hash: str | None
    """SHA-256 of all that the log holds of the simulation"""
    log: str | None
    metrics: tuple[Metric, ...] = ()
    timing: Mapping[str, Timing] = field(default_factory=dict)

    def as_dict(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)


@dataclass(kw_only=True)
class Watcher:
    """Is told how a run goes; the default listens to nothing."""

    status: Callable[[str], None] = lambda text: None
    """what is being waited for"""
    ticked: Callable[[int], None] = lambda time: None
    """simulated time [ns] that has been committed"""


class Pace:
    """Holds the run back to `factor` times real time; None lets it run freely."""

    def __init__(self, factor: float | None) -> None:
        self._factor = factor
        self._begin = time.monotonic()

    def wait(self, simulated: int) -> None:
        """Sleep until the wall clock has come to `simulated` [ns]."""
        if self._factor is not None:
            time.sleep(max(0.0, self._begin + simulated * 1e-9 / self._factor - time.monotonic()))


class Episode:
    """One episode of a simulation, tick by tick: its log, its end and its result."""

    def __init__(
        self,
        simulation: Simulation,
        *,
        reference: Reference | None = None,
        log: Path | None = None,
        alone: bool = False,
        began: float | None = None,
    ) -> None:
        """Begin: afterwards every mover's state at t = 0 is committed.

        Args:
            simulation: the scenario's components, connected.
            reference: what the evaluator compares with.
            log: file to write, None to write none.
            alone: there are no people.
            began: `time.monotonic()` when start-up began.

        Raises:
            RunError: if a component fails.
        """
        self.simulation = simulation
        self.tick = 0
        self.reason: Reason | None = None
        """why it is over, None while it is not"""
        self._log = log
        self._began = time.monotonic() if began is None else began
        scenario = simulation.scenario
        self._referee = Referee(scenario.ending, simulation.goals, scenario.last_tick)
        self._recorder = open_log(simulation, log, reference) if log else None
        simulation.lockstep.commit = Committer(self._recorder, simulation) if self._recorder else None
        try:
            simulation.lockstep.reset(alone=alone, reference=reference)
        except BaseException as error:
            self.fail(error)
            raise
        self._started = time.monotonic()

    @property
    def time(self) -> int:
        """Simulated time [ns]."""
        return self.tick * self.simulation.scenario.period

    def observe(self) -> None:
        """The first part of a tick, up to where commands from outside are wanted."""
        self.simulation.lockstep.observe(self.tick)

    def complete(self) -> Reason | None:
        """The rest of the tick; why the episode is over, None if it goes on."""
        self.simulation.lockstep.complete(self.tick)
        self.tick += 1
        self.reason = self._why_over()
        return self.reason

    def finish(self) -> Result:
        """The evaluator's verdict, the end of the log, and what became of it all."""
        simulation, scenario = self.simulation, self.simulation.scenario
        self.reason = self.reason or "stopped"
        simulation.lockstep.finish(self.tick)
        wall = time.monotonic() - self._started
        arrived = tuple(sorted(self._referee.arrived))
        data_hash = self._close_log({"reason": self.reason, "arrived": json.dumps(arrived)})
        return Result(
            scenario=scenario.name,
            seed=scenario.seed,
            repeatable=scenario.repeatable,
            outcome=self.reason,
            arrived=arrived,
            ticks=self.tick,
            simulated_time=self.time * 1e-9,
            start_up_time=(simulation.lockstep.first_step or self._began) - self._began,
            wall_time=wall,
            real_time_factor=self.time * 1e-9 / wall,
            ticks_per_second=self.tick / wall,
            data_hash=data_hash,
            log=str(self._log) if self._log else None,
            metrics=metrics_of(simulation, self.tick),
            timing={name: timing_of(times) for name, times in simulation.lockstep.elapsed.items() if times},
        )

    def fail(self, error: BaseException) -> None:
        """End the log where the run has failed; it keeps every tick that was complete."""
        self._close_log({"reason": "failed", "error": str(error) or type(error).__name__})

    def discard(self) -> None:
        """End an episode in which nothing has happened; it leaves no log."""
        self._close_log({"reason": "stopped"})
        if self._log:
            self._log.unlink()

    def _close_log(self, outcome: dict[str, str]) -> str | None:
        recorder, self._recorder = self._recorder, None
        return recorder.close({"outcome": outcome | {"ticks": str(self.tick)}}) if recorder else None

    def _why_over(self) -> Reason | None:
        scenario, latest = self.simulation.scenario, self.simulation.lockstep.latest
        robots = [robot.name for robot in scenario.robots]
        states = {robot: latest(robot, "state", self.tick) for robot in robots}
        touching = robots if scenario.ending.collision else []
        contacts = {robot: latest(robot, "contacts", self.tick) for robot in touching}
        return self._referee.reason(self.tick, states, contacts)


def run_episode(
    simulation: Simulation,
    *,
    log: Path | None,
    real_time: float | None = None,
    began: float | None = None,
    watcher: Watcher | None = None,
) -> Result:
    """Run the scenario once, after a reference run without people if there is an evaluator that wants one.

    Args:
        simulation: the scenario's components, connected.
        log: file to write, None to write none.
        real_time: pace, in simulated seconds per second; None runs as fast as it can.
        began: `time.monotonic()` when start-up began.
        watcher: is told how the run goes.

    Raises:
        RunError: if the run fails; the log then ends with the last tick that was complete.
    """
    began = time.monotonic() if began is None else began
    reference = reference_run(simulation)
    episode = Episode(simulation, reference=reference, log=log, began=began)
    return _to_the_end(episode, Pace(real_time), watcher or Watcher())


def reference_run(simulation: Simulation) -> Reference | None:
    """The same robots without people: what the ratios of the metrics compare with. None if nobody would."""
    judged = any(member.ports.kind == "observer" for member in simulation.graph.members.values())
    if not (judged and simulation.scenario.reference):
        return None
    return reference_of(_to_the_end(Episode(simulation, alone=True), Pace(None), Watcher()))


def reference_of(result: Result) -> Reference | None:
    """What a run without people gives others to compare with."""
    values: dict[str, dict[str, float]] = {}
    for metric in result.metrics:
        if metric.value is not None:
            values.setdefault(metric.robot, {})[metric.name] = metric.value
    return values or None


def _to_the_end(episode: Episode, pace: Pace, watcher: Watcher) -> Result:
    try:
        over = None
        while not over:
            episode.observe()
            over = episode.complete()
            watcher.ticked(episode.time)
            if not over:
                pace.wait(episode.time)
        return episode.finish()
    except BaseException as error:
        episode.fail(error)
        raise


def metrics_of(simulation: Simulation, tick: int) -> tuple[Metric, ...]:
    """The verdict of the scenario's evaluator on a run that ended at `tick`; nothing if it has none."""
    messages = [
        simulation.lockstep.latest(name, "metrics", tick)
        for name, member in simulation.graph.members.items()
        if member.ports.kind == "observer"
    ]
    return tuple(metric for message in messages if message for metric in rows_of(message))


def rows_of(message: Metrics) -> tuple[Metric, ...]:
    """A `Metrics` message as rows."""
    return tuple(
        Metric(
            robot=message.robot[i],
            name=message.name[i],
            value=float(message.value[i]) if message.valid[i] else None,
            unit=message.unit[i],
            reason=message.reason[i],
        )
        for i in range(len(message.name))
    )


def timing_of(times: list[int]) -> Timing:
    """Statistics of durations in ns."""
    ordered = sorted(times)
    return Timing(
        steps=len(ordered),
        mean=statistics.fmean(ordered) * 1e-9,
        median=statistics.median(ordered) * 1e-9,
        p99=ordered[min(len(ordered) - 1, int(0.99 * len(ordered)))] * 1e-9,
        max=ordered[-1] * 1e-9,
    )
