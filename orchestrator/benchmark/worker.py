"""Runs one episode of a sweep, inline, and says what became of it as plain data."""

from __future__ import annotations

import resource
import sys
import tempfile
import threading
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from crowdcosim.goal import reached
from crowdcosim.messages import Contacts
from orchestrator.benchmark.plan import Task
from orchestrator.episode import Result, Watcher, run_episode
from orchestrator.errors import InputError, RunError
from orchestrator.log.provenance import versions
from orchestrator.scenario.scenario import Scenario, load
from orchestrator.simulation import Simulation

PATH_EVERY = 5
"""of so many ticks one is kept of the robots' paths"""

Outcome = dict[str, Any]
"""what a worker sends home, and the journal keeps: JSON"""

# A cluster's worker may have several threads; episodes take turns, since they are bound to one core anyway.
_one_at_a_time = threading.Lock()


def run(task: Task) -> Outcome:
    """Run the task's episode; a failure of the episode is an outcome too."""
    with _one_at_a_time, tempfile.TemporaryDirectory(prefix="crowdcosim-") as logs:
        began = time.perf_counter()
        try:
            scenario = load(task.resolved, task.settings)
            simulation = Simulation(scenario, logs=Path(logs))
            try:
                witness = _Witness(scenario, simulation)
                result = run_episode(simulation, log=None, watcher=Watcher(ticked=witness.ticked))
            except BaseException:
                simulation.close(stop=False)
                raise
            simulation.close()
        except (InputError, RunError) as error:
            return failure(str(error))
        return _outcome(scenario, result, witness, time.perf_counter() - began)


def failure(error: str) -> Outcome:
    """The outcome of an episode that did not come to its end."""
    return {"status": "failed", "error": error}


class _Witness:
    """Watches an episode for what no metric keeps: each collision, and where the robots went."""

    def __init__(self, scenario: Scenario, simulation: Simulation) -> None:
        self._lockstep = simulation.lockstep
        self._goals = simulation.goals
        self._period = scenario.period
        self._under_way = [robot.name for robot in scenario.robots]
        outputs = {(n, o.name) for n, m in simulation.graph.members.items() for o in m.ports.outputs}
        self._reporting = {robot for robot in self._under_way if (robot, "contacts") in outputs}
        self.collisions: dict[str, list[list[float]]] = {robot: [] for robot in self._under_way}
        self.paths: dict[str, list[list[float]]] = {r.name: [[0.0, r.start.x, r.start.y]] for r in scenario.robots}

    def ticked(self, time_ns: int) -> None:
        tick, seconds = time_ns // self._period, time_ns * 1e-9
        for robot in tuple(self._under_way):
            position = self._lockstep.newest(robot, "state").position
            if robot in self._reporting:
                self._note_collisions(robot, seconds, self._lockstep.newest(robot, "contacts"))
            arrived = reached(self._goals[robot], position)
            if arrived or tick % PATH_EVERY == 0:
                self.paths[robot].append([round(seconds, 3), *np.round(position, 3).tolist()])
            if arrived:
                self._under_way.remove(robot)

    def _note_collisions(self, robot: str, time: float, contacts: Contacts) -> None:
        if not len(contacts.kind):
            return
        for i in np.flatnonzero((contacts.kind == Contacts.PERSON) & (contacts.duration == 0.0)).tolist():
            part, agent = int(contacts.body_part[i]), int(contacts.agent[i])
            speed, energy = float(contacts.approach_speed[i]), float(contacts.energy[i])
            x, y = contacts.position[i].tolist()
            self.collisions[robot].append([round(time, 3), agent, part, speed, energy, x, y])


def _outcome(scenario: Scenario, result: Result, witness: _Witness, wall_time: float) -> Outcome:
    return {
        "status": "done",
        "factors": _factors(scenario),
        "outcome": result.outcome,
        "arrived": list(result.arrived),
        "ticks": result.ticks,
        "simulated_time": result.simulated_time,
        "metrics": [asdict(metric) for metric in result.metrics],
        "collisions": witness.collisions,
        "paths": witness.paths,
        "versions": versions(),
        "wall_time": wall_time,
        "timing": {name: asdict(timing) for name, timing in result.timing.items()},
        "peak_memory": _peak_memory(),
    }


def _factors(scenario: Scenario) -> dict[str, Any]:
    """What the scenarios of a suite differ in, where they have our crowd."""
    crowd: Any = scenario.resolved.get("crowd", {}).get("config", {})
    people = len(crowd.get("positions") or ()) or crowd.get("count") or 0
    policy = crowd.get("policy")
    return {
        "policy": policy if isinstance(policy, str) else None if policy is None else "own",
        "time_horizon": crowd.get("time_horizon") if policy == "orca" else None,
        "reactive": crowd.get("reactive"),
        "flow": crowd.get("flow"),
        "people": people,
        "world_x": scenario.world.size[0],
        "world_y": scenario.world.size[1],
        "density": round(people / (scenario.world.size[0] * scenario.world.size[1]), 3),
    }


def _peak_memory() -> int:
    """The most that this process has used so far [bytes]."""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
