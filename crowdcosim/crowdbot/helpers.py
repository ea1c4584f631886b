"""What goes to the simulation and what comes back."""

from __future__ import annotations

import json
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

Dico = dict[str, Any]

_GROUP = re.compile(r"\(([^)]*)\)")


def publish_all(pub: Dico) -> str:
    """A message to the simulation as text."""
    return json.dumps({"clock": 0, "vel_cmd": (0, 0), "sim_control": "i"} | pub)


def raw_data_to_dict(raw: str) -> Dico:
    """A message of the simulation: clock, crowd, odom and report, each a text."""
    dico: Dico = json.loads(raw)
    return dico


def do_step(time_step: float, pub: Dico) -> Dico:
    """The next message: the clock is `time_step` [s] later."""
    return pub | {"clock": pub["clock"] + time_step, "sim_control": "i"}


def next() -> Dico:  # noqa: A001  # the module's name
    """The message that switches to the next scenario."""
    return {"clock": 0, "vel_cmd": (0, 0), "sim_control": "n"}


def reset() -> Dico:
    """The message that begins the scenario again."""
    return {"clock": 0, "vel_cmd": (0, 0), "sim_control": "r"}


def stop() -> Dico:
    """The message that ends the simulation."""
    return {"clock": 0, "vel_cmd": (0, 0), "sim_control": "s"}


def get_clock(dico: Dico) -> float:
    """Time since the scenario began [s]."""
    return float(dico["clock"])


def get_crowd(dico: Dico) -> NDArray[np.float64]:
    """(N, 3) everybody's id, x and y [m]."""
    return np.array([text.split() for text in _GROUP.findall(dico["crowd"])], np.float64).reshape(-1, 3)


def get_odom(dico: Dico) -> NDArray[np.float64]:
    """(6,) x, y [m], theta [deg], and their rates [m/s, deg/s]."""
    return np.array(dico["odom"].split()[1:7], np.float64)


def get_report(dico: Dico) -> list[tuple[int, str, NDArray[np.float64]]]:
    """Who is being touched: id, body part, and (2,) their velocity relative to the robot's [m/s]."""
    found = [text.split() for text in _GROUP.findall(dico["report"])]
    return [(int(who), part, np.array([x, y], np.float64)) for who, part, x, y in found]


def check_ending_conditions(max_time: float, min_x: float, dico: Dico) -> bool:
    """True when the clock has passed `max_time` [s] or the robot the line x = `min_x` [m]."""
    return get_clock(dico) > max_time or bool(get_odom(dico)[0] <= min_x)
