"""The module's main program: drive through the scenarios, record, compute the metrics."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from crowdcosim.crowdbot import helpers, recorder, robotnavigation, socket_handler
from crowdcosim.crowdbot.helpers import Dico

SCENARIOS: tuple[str, ...] = (
    "paper-extra/alone",
    *(
        f"paper/rvo15-reactive_{flow}_{n:03d}"
        for flow in ("1d+", "1d-", "1dx", "2d", "2dx")
        for n in (50, 100, 200, 350)
    ),
)
"""The robot alone, and the paper's twenty of one behaviour."""

MAX_TIME = 180.0
"""[s]"""
GOAL = -20.0
"""x of the line to cross [m]"""
METRICS = "metrics"
"""name of the file with what the evaluator says"""


def run(
    HOST: str = "127.0.0.1",
    PORT: int = 25001,
    time_step: float = 0.1,
    sleep_time: float = 0.0,
    *,
    compute_vel_cmd: Callable[[Dico], Sequence[float]] = robotnavigation.compute_vel_cmd,
    scenarios: Sequence[str] = SCENARIOS,
    settings: Mapping[str, Any] | Sequence[str] = (),
    folder: str | Path = "recorder",
) -> None:
    """Drive through all scenarios; each leaves `tests_N.json` in the folder, and the evaluator `metrics.json`.

    Args:
        HOST: not used: the simulation runs in this process.
        PORT: not used.
        time_step: of the simulation [s].
        sleep_time: pause after each step [s]; negative: keep pace with the wall clock.
        compute_vel_cmd: from a message to (forward speed [m/s], turn rate [deg/s]).
        scenarios: the first is the one that the ratios of the others' metrics compare with.
        settings: values laid over each scenario.
        folder: for what is recorded.
    """
    s = socket_handler.init_socket(HOST, PORT, scenarios=scenarios, settings=settings, dt=time_step)
    try:
        for i in range(len(scenarios)):
            recorder.save_dico(Path(folder) / f"tests_{i}", _drive(s, time_step, sleep_time, compute_vel_cmd))
            socket_handler.send_and_receive(s, helpers.publish_all(helpers.next()))
    finally:
        socket_handler.stop(s)
    told = {
        scenario: {"outcome": result.outcome} | {metric.name: metric.value for metric in result.metrics}
        for scenario, result in s.results
    }
    recorder.save_dico(Path(folder) / METRICS, told)


def _drive(
    s: socket_handler.Connection,
    time_step: float,
    sleep_time: float,
    compute_vel_cmd: Callable[[Dico], Sequence[float]],
) -> list[Dico]:
    pub: Dico = {"clock": 0, "vel_cmd": (0, 0), "sim_control": "i"}
    recorded: list[Dico] = []
    while True:
        began = time.monotonic()
        dico = helpers.raw_data_to_dict(socket_handler.send_and_receive(s, helpers.publish_all(pub)))
        recorded.append({key: dico[key] for key in ("clock", "crowd", "odom", "report")})
        if (
            helpers.check_ending_conditions(MAX_TIME, GOAL, dico)
            or helpers.get_clock(dico) < pub["clock"] - time_step / 2
        ):
            return recorded
        pub["vel_cmd"] = tuple(compute_vel_cmd(dico))
        pub = helpers.do_step(time_step, pub)
        pause = sleep_time if sleep_time >= 0 else began + time_step - time.monotonic()
        time.sleep(max(0.0, pause))


def load(file: str | Path) -> dict[str, list[Any]]:
    """What a recorded file holds, as numbers: clock [s], crowd (N, 3), odom (6,), report, one entry per step each."""
    dicos = recorder.load_file_as_list_of_dico(file)
    return {
        "clock": [helpers.get_clock(dico) for dico in dicos],
        "crowd": [helpers.get_crowd(dico) for dico in dicos],
        "odom": [helpers.get_odom(dico) for dico in dicos],
        "report": [helpers.get_report(dico) for dico in dicos],
    }


def compute_metrics(folder: str | Path = "recorder") -> dict[str, dict[str, Any]]:
    """Scenario -> metric -> value, as the evaluator gave them in `run`; printed, too."""
    told: dict[str, dict[str, Any]] = recorder.load_file_as_list_of_dico(Path(folder) / f"{METRICS}.json")
    for scenario, metrics in told.items():
        numbers = [f"{name} {value:.3f}" for name, value in metrics.items() if isinstance(value, float)]
        print(f"{scenario}: {metrics['outcome']}; {', '.join(numbers)}")
    return told
