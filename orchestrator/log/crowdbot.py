"""Writes a log as the JSON of the recorder of the CrowdBot module, which the paper's scripts read."""

from __future__ import annotations

from pathlib import Path

from crowdcosim.crowdbot.frame import Frame
from crowdcosim.crowdbot.recorder import save_dico
from crowdcosim.crowdbot.state import texts
from crowdcosim.messages import RobotState
from orchestrator.errors import InputError
from orchestrator.log.folder import make_folder
from orchestrator.log.reader import Log


def to_crowdbot(log: Log, folder: Path) -> list[Path]:
    """A new folder with a file per robot, each a list with `clock`, `crowd`, `odom` and `report` of every tick.

    Raises:
        InputError: if the log has no robots, or the folder exists or cannot be written.
    """
    robots = [component for component, port in log.places.values() if port == "state"]
    if not robots:
        raise InputError(f"{log.path} has no robots, and the module's recorder is about one")
    make_folder(folder)
    crowds, written = dict(log.outputs("crowd", "crowd")), []
    for robot in robots:
        contacts = dict(log.outputs(robot, "contacts"))
        states: list[tuple[int, RobotState]] = list(log.outputs(robot, "state"))
        (_, goal), *_ = log.outputs(f"{robot}/goal", "goal")
        frame = Frame(goal, states[0][1].position)
        steps = [texts(frame, t / 1e9, state, crowds.get(t), contacts.get(t)) for t, state in states]
        save_dico(folder / robot, steps)
        written.append(folder / f"{robot}.json")
    return written
