"""What a run writes into its log: every output, frames and markers for viewers, and where it all came from."""

from __future__ import annotations

import platform
import subprocess
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path

from pydantic import TypeAdapter

from crowdcosim import __version__
from crowdcosim.host import Source
from orchestrator.errors import RunError
from orchestrator.frames import FRAME_CHANNELS, frame_records, static_records
from orchestrator.lockstep import Committed
from orchestrator.recorder import Channel, Record, Recorder, as_json, topic_of
from orchestrator.scenario import Scenario
from orchestrator.scenery import MARKER_CHANNELS, Scenery, world_record
from orchestrator.simulation import Simulation

Reference = Mapping[str, Mapping[str, float]]
"""robot -> metric -> value in the run without people"""


def open_log(simulation: Simulation, path: Path, reference: Reference | None) -> Recorder:
    """A log with all channels, attachments and what does not move.

    Raises:
        RunError: if the file cannot be written.
    """
    graph = simulation.graph
    channels = [
        Channel(topic_of(name, output.name), output.type.TYPE, name, output.name)
        for name, member in graph.members.items()
        for output in member.ports.outputs
    ]
    wiring = TypeAdapter(dict[str, dict[str, tuple[Source, ...]]]).dump_python(
        {name: dict(ports) for name, ports in graph.sources.items()}
    )
    attachments = {
        "scenario.json": as_json(simulation.scenario.resolved),
        "wiring.json": as_json(wiring),
        "reference.json": as_json(reference),
    }
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        recorder = Recorder(
            path,
            (*FRAME_CHANNELS, *MARKER_CHANNELS, *channels),
            attachments=attachments,
            metadata={"run": _provenance(simulation.scenario)},
        )
    except OSError as error:
        raise RunError(None, None, f"cannot write {path}: {error.strerror}") from None
    scenario = simulation.scenario
    recorder.add([*static_records(scenario), world_record(scenario.world, scenario.robots)])
    return recorder


class Committer:
    """Hands what is committed to the recorder, in its order, with the frames and markers that belong to it."""

    def __init__(self, recorder: Recorder, simulation: Simulation) -> None:
        types = {
            (name, output.name): output.type.TYPE
            for name, member in simulation.graph.members.items()
            for output in member.ports.outputs
        }
        self._recorder = recorder
        self._robots = tuple(robot.name for robot in simulation.scenario.robots)
        self._newest = simulation.lockstep.newest
        self._topics = {place: topic_of(*place) for place in types}
        self._scenery = Scenery(types, self._newest)
        self._clock = -1

    def __call__(self, made: list[Committed]) -> None:
        records = [Record(self._topics[c, port], time_ns, payload) for c, port, time_ns, payload in made]
        now = max((c.time for c in made), default=-1)
        if now > self._clock:
            self._clock = now
            moved = {c.component for c in made if c.port == "state"}
            records += frame_records(now, [self._newest(robot, "state") for robot in self._robots if robot in moved])
        self._recorder.add(records + self._scenery.records(made))


def _provenance(scenario: Scenario) -> dict[str, str]:
    packages = ("numpy", "numba", "pymunk", "eclipse-zenoh", "rosbags", "mcap")
    return {
        "scenario": scenario.name,
        "seed": str(scenario.seed),
        "crowdcosim": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "git_commit": _git_commit(),
        **{package: version(package) for package in packages},
    }


def _git_commit() -> str:
    """The commit of the checkout that runs, empty for an installed wheel."""
    here = Path(__file__).parent.parent
    if not (here / ".git").exists():
        return ""
    try:
        answer = subprocess.run(
            ["git", "-C", str(here), "rev-parse", "HEAD"], capture_output=True, text=True, timeout=5, check=False
        )
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip()
