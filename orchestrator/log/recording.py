"""What a run writes into its log: every output, frames and markers for viewers, and where it all came from."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from pydantic import TypeAdapter

from crowdcosim.host import Source
from orchestrator.errors import RunError
from orchestrator.lockstep import Committed
from orchestrator.log.frames import FRAME_CHANNELS, frame_records, static_records
from orchestrator.log.provenance import versions
from orchestrator.log.recorder import Channel, Record, Recorder, as_json, topic_of
from orchestrator.log.robot_description import description_channel, description_record
from orchestrator.log.scenery import MARKER_CHANNELS, Scenery, world_record
from orchestrator.scenario.config_files import files_in
from orchestrator.scenario.scenario import Scenario
from orchestrator.simulation import Simulation

Reference = Mapping[str, Mapping[str, float]]
"""robot -> metric -> value in the run without people"""


def open_log(simulation: Simulation, path: Path, reference: Reference | None) -> Recorder:
    """A log with all channels, attachments and what does not move.

    Raises:
        RunError: if the file cannot be written, or one that belongs into it cannot be read.
    """
    graph, scenario = simulation.graph, simulation.scenario
    channels = [
        Channel(topic_of(name, output.name), output.type.TYPE, name, output.name)
        for name, member in graph.members.items()
        for output in member.ports.outputs
    ]
    wiring = TypeAdapter(dict[str, dict[str, tuple[Source, ...]]]).dump_python(
        {name: dict(ports) for name, ports in graph.sources.items()}
    )
    attachments = {
        "scenario.json": as_json(scenario.resolved),
        "wiring.json": as_json(wiring),
        "reference.json": as_json(reference),
    }
    attachments |= _files(scenario)
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        recorder = Recorder(
            path,
            (*FRAME_CHANNELS, *MARKER_CHANNELS, *(description_channel(r.name) for r in scenario.robots), *channels),
            attachments=attachments,
            metadata={"run": _about(scenario) | versions()},
        )
    except OSError as error:
        raise RunError(None, None, f"cannot write {path}: {error.strerror}") from None
    bodies = [description_record(robot) for robot in scenario.robots]
    recorder.add([*static_records(scenario), world_record(scenario.world, scenario.robots), *bodies])
    return recorder


def _files(scenario: Scenario) -> dict[str, bytes]:
    """`COMPONENT/file` -> bytes of every file that a component's options name.

    Raises:
        RunError: if one cannot be read.
    """
    found: dict[str, bytes] = {}
    for spec in scenario.components:
        for file in files_in(dict(spec.config)):
            try:
                found[f"{spec.name}/{file.name}"] = file.read_bytes()
            except OSError as error:
                raise RunError(spec.name, None, f"cannot read {file}: {error.strerror}") from None
    return found


def _about(scenario: Scenario) -> dict[str, str]:
    return {"scenario": scenario.name, "seed": str(scenario.seed), "repeatable": str(scenario.repeatable).lower()}


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
