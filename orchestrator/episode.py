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
from orchestrator.recording import Committer, Reference, open_log
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
    watcher = watcher or Watcher()
    began = time.monotonic() if began is None else began
    scenario = simulation.scenario
    reference = _reference_run(simulation)
    recorder = open_log(simulation, log, reference) if log else None
    lockstep = simulation.lockstep
    lockstep.commit = Committer(recorder, simulation) if recorder else None
    referee = _referee(simulation)
    outcome: dict[str, str] = {"reason": "failed"}
    tick = 0
    data_hash = None
    started = time.monotonic()
    try:
        lockstep.reset(alone=False, reference=reference)
        started = time.monotonic()
        pace = Pace(real_time)
        while True:
            lockstep.step(tick)
            tick += 1
            watcher.ticked(tick * scenario.period)
            if reason := _reason(simulation, referee, tick):
                break
            pace.wait(tick * scenario.period)
        lockstep.finish(tick)
        wall = time.monotonic() - started
        outcome = {"reason": reason, "arrived": json.dumps(sorted(referee.arrived))}
    except BaseException as error:
        outcome["error"] = str(error) or type(error).__name__
        raise
    finally:
        if recorder:
            data_hash = recorder.close({"outcome": outcome | {"ticks": str(tick)}})
    return Result(
        scenario=scenario.name,
        seed=scenario.seed,
        outcome=reason,
        arrived=tuple(sorted(referee.arrived)),
        ticks=tick,
        simulated_time=tick * scenario.period * 1e-9,
        start_up_time=(lockstep.first_step or began) - began,
        wall_time=wall,
        real_time_factor=tick * scenario.period * 1e-9 / wall,
        ticks_per_second=tick / wall,
        data_hash=data_hash,
        log=str(log) if log else None,
        metrics=metrics_of(simulation, tick),
        timing={name: timing_of(times) for name, times in lockstep.elapsed.items() if times},
    )


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


def _reference_run(simulation: Simulation) -> Reference | None:
    """The same robots without people: what the ratios of the metrics compare with. None if nobody would."""
    judged = any(member.ports.kind == "observer" for member in simulation.graph.members.values())
    if not (judged and simulation.scenario.reference):
        return None
    lockstep = simulation.lockstep
    lockstep.commit = None
    lockstep.reset(alone=True, reference=None)
    referee, tick = _referee(simulation), 0
    while not (tick and _reason(simulation, referee, tick)):
        lockstep.step(tick)
        tick += 1
    lockstep.finish(tick)
    values: dict[str, dict[str, float]] = {}
    for metric in metrics_of(simulation, tick):
        if metric.value is not None:
            values.setdefault(metric.robot, {})[metric.name] = metric.value
    return values or None


def _referee(simulation: Simulation) -> Referee:
    return Referee(simulation.scenario.ending, simulation.goals, simulation.scenario.last_tick)


def _reason(simulation: Simulation, referee: Referee, tick: int) -> Reason | None:
    robots = [robot.name for robot in simulation.scenario.robots]
    states = {robot: simulation.lockstep.latest(robot, "state", tick) for robot in robots}
    touching = robots if simulation.scenario.ending.collision else []
    return referee.reason(tick, states, {r: simulation.lockstep.latest(r, "contacts", tick) for r in touching})
