"""Scripts written for the CrowdBot module run after changing the import."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from crowdcosim import crowdbot
from crowdcosim.crowdbot import helpers, recorder, socket_handler
from crowdcosim.crowdbot.frame import Frame
from crowdcosim.messages import Goal
from orchestrator.episode import run_episode
from orchestrator.scenario.scenario import load
from orchestrator.simulation import Simulation

CROWDED = "paper/rvo15-reactive_1d-_050"

SCRIPT = """
import time
from crowdcosim.crowdbot import helpers, recorder, robotnavigation, socket_handler

def main(time_step=0.1):
    s = socket_handler.init_socket('127.0.0.1', 25001)
    for i in range(2):
        list_save = []
        pub = {'clock': 0, 'vel_cmd': (0, 0), 'sim_control': 'i'}
        for _ in range(5):
            raw = socket_handler.send_and_receive(s, helpers.publish_all(pub))
            pub = helpers.do_step(time_step, pub)
        while True:
            raw = socket_handler.send_and_receive(s, helpers.publish_all(pub))
            dico = helpers.raw_data_to_dict(raw)
            list_save.append({k: dico[k] for k in ('clock', 'crowd', 'odom', 'report')})
            pub['vel_cmd'] = robotnavigation.compute_vel_cmd(dico)
            if helpers.check_ending_conditions(180.0, -20, dico):
                break
            pub = helpers.do_step(time_step, pub)
        socket_handler.send_and_receive(s, helpers.publish_all(helpers.next()))
        recorder.save_dico('recorder/tests_' + str(i), list_save)
    socket_handler.stop(s)

main()
"""


def test_a_script_written_for_the_module_runs_after_changing_the_import(tmp_path) -> None:
    (tmp_path / "main.py").write_text(SCRIPT)
    command = [sys.executable, "-W", "error", "main.py"]
    process = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
    assert process.returncode == 0, process.stderr
    alone, crowded = (crowdbot.load(tmp_path / "recorder" / f"tests_{i}.json") for i in range(2))
    # 40 m at 1 m/s after half a second of standing still
    assert alone["clock"][-1] == pytest.approx(40.6, abs=0.11)
    assert alone["odom"][0][:3] == pytest.approx([20.0, 0.0, 180.0])
    assert alone["odom"][-1][0] <= -20.0
    assert len(alone["crowd"][0]) == 0
    assert crowded["crowd"][0].shape == (50, 3)
    assert crowded["odom"][-1][0] <= -20.0


def test_run_leaves_records_and_the_metrics_of_the_evaluator(tmp_path, capsys) -> None:
    crowdbot.run(scenarios=["paper-extra/alone", CROWDED], folder=tmp_path)
    metrics = crowdbot.compute_metrics(tmp_path)
    assert list(metrics) == ["paper-extra/alone", CROWDED]
    assert "time_ratio" in capsys.readouterr().out
    inline = [f"{'.'.join(spec.path)}.host=inline" for spec in load(CROWDED).components]
    simulation = Simulation(load(CROWDED, ["robots.robot.controller.use=baseline", *inline]), logs=tmp_path)
    result = run_episode(simulation, log=None)
    assert {m.name: m.value for m in result.metrics} == {k: v for k, v in metrics[CROWDED].items() if k != "outcome"}


def test_who_does_not_arrive_comes_to_the_end_of_time(tmp_path) -> None:
    settings = {"end.time_limit": 1.0}
    s = socket_handler.init_socket(scenarios=["paper-extra/alone"], settings=settings)
    pub = {"clock": 0.0, "vel_cmd": (0.0, 0.0), "sim_control": "i"}
    clocks = []
    while len(clocks) < 50:
        dico = helpers.raw_data_to_dict(socket_handler.send_and_receive(s, helpers.publish_all(pub)))
        clocks.append(helpers.get_clock(dico))
        if helpers.check_ending_conditions(1.0, -20, dico):
            break
        pub = helpers.do_step(0.1, pub)
    assert clocks == pytest.approx([0.1 * k for k in range(12)])
    socket_handler.stop(s)
    assert [result.outcome for _, result in s.results] == ["time_limit"]


def test_turning_left_increases_theta_by_degrees_and_contacts_are_reported(tmp_path) -> None:
    ahead = {"count": None, "positions": [[6.0, 5.0]], "flow": "1d-", "reactive": False}
    s = socket_handler.init_socket(scenarios=["corridor"], settings={"crowd.config": ahead}, dt=0.05)

    def step(clock: float, *vel_cmd: float) -> dict:
        message = {"clock": clock, "vel_cmd": vel_cmd, "sim_control": "i"}
        return helpers.raw_data_to_dict(socket_handler.send_and_receive(s, helpers.publish_all(message)))

    first = step(0.0, 0.0, 0.0)
    assert helpers.get_crowd(first) == pytest.approx(np.array([[1.0, 19.0, 0.0]]))
    assert helpers.get_report(first) == []
    touched = step(0.5, 0.0, 90.0)
    assert helpers.get_odom(touched)[5] == pytest.approx(90.0, abs=0.01)
    assert -180.0 < helpers.get_odom(touched)[2] < -130.0  # from 180, on to the left
    ((who, part, velocity),) = helpers.get_report(touched)
    assert who == 1
    assert part in ("feet", "lower_legs", "upper_legs")
    assert velocity[0] > 0.5  # towards +x, as all do who walk against the robot
    again = helpers.raw_data_to_dict(socket_handler.send_and_receive(s, helpers.publish_all(helpers.reset())))
    assert helpers.get_clock(again) == 0.0
    assert helpers.get_crowd(again) == pytest.approx(helpers.get_crowd(first))
    with pytest.raises(ValueError, match=r"multiple of the scenario's time step, 0.05 s"):
        step(0.07, 0.0, 0.0)
    socket_handler.send_and_receive(s, helpers.publish_all(helpers.stop()))
    socket_handler.stop(s)


def test_the_frame_looks_back_from_the_goal_wherever_that_is() -> None:
    goal = Goal(position=np.array([3.0, 12.0]), direction=np.array([0.0, 1.0]))
    frame = Frame(goal, np.array([3.0, 2.0]))
    places = np.array([[3.0, 2.0], [3.0, 12.0], [4.0, 7.0]])
    assert frame.place(places) == pytest.approx(np.array([[5.0, 0.0], [-5.0, 0.0], [0.0, 1.0]]))
    assert frame.direction(0.5 * math.pi) == pytest.approx(180.0)
    assert frame.vector(np.array([0.0, 2.0])) == pytest.approx([-2.0, 0.0])


def test_records_are_json(tmp_path: Path) -> None:
    recorder.save_dico(tmp_path / "deep" / "name", [{"clock": "0"}])
    assert json.loads((tmp_path / "deep" / "name.json").read_text()) == [{"clock": "0"}]
    assert recorder.load_file_as_list_of_dico(tmp_path / "deep" / "name.json") == [{"clock": "0"}]
