"""What one step of a robot costs among 350 people, for every drive and base: `python benchmarks/robots.py`."""

from __future__ import annotations

import statistics
import time
from typing import Any

import numpy as np

from components.crowd.crowd import CrowdModel
from components.robot.forces import Forces
from components.robot.kinematic import Kinematic
from components.robot.wheels import Wheels
from crowdcosim.component import make
from crowdcosim.messages import Crowd, Twist, Vector3
from crowdcosim.robots import Pose, Robot, Target
from crowdcosim.setup import Setup
from crowdcosim.world import World
from orchestrator.scenario.scenario import load

STEPS = 300
PEOPLE = 350
BOUND = 0.5  # [ms]
ROBOTS = {"differential": "turtlebot2", "holonomic": "pepper", "car": "car"}


def crowd_frames() -> list[Crowd]:
    """People in 500 m2, who walk in both directions; a robot among them is touched all the time."""
    crowd = make(CrowdModel, {"flow": "1dx", "count": PEOPLE, "policy": "orca", "reactive": False})
    crowd.reset(Setup(component="crowd", period=100_000_000, seed=1, world=world()))
    return [crowd.step(()) for _ in range(STEPS)]


def world() -> World:
    return load("corridor").world


def median_ms(drive: Any, model_name: str, frames: list[Crowd]) -> tuple[float, float]:
    """Median and 95th percentile of a step [ms]."""
    (robot,) = load("corridor", [f"robots.robot.model={model_name}"]).robots
    robot = Robot(name="robot", number=1, model=robot.model, start=Pose(x=5.0, y=5.0), goal=Target(x=0.0, y=0.0))
    setup = Setup(component="robot", period=100_000_000, seed=1, world=world(), robots=(robot,), robot="robot")
    drive.reset(setup)
    times, touched = [], 0
    for k, crowd in enumerate(frames):
        command = Twist(linear=Vector3(x=0.5), angular=Vector3(z=0.2 * np.sin(0.1 * k)))
        begin = time.perf_counter()
        result = drive.step(command, crowd, ())
        times.append(1e3 * (time.perf_counter() - begin))
        touched += len(result.contacts.kind) > 0
    assert touched > 0, "nobody was near"
    return statistics.median(times), float(np.percentile(times, 95))


def main() -> None:
    frames = crowd_frames()
    drives = {"kinematic": (Kinematic, {}), "wheels": (Wheels, {}), "forces": (Forces, {})}
    print(f"step of one robot among {PEOPLE} people in 500 m2, 10 inner steps; at most {BOUND} ms [ms]")
    print(f"{'drive':12}{'base':14}{'median':>8}{'95%':>8}")
    for name, (cls, options) in drives.items():
        for base, model in ROBOTS.items():
            if name == "wheels" and base != "differential":
                continue
            median, most = median_ms(make(cls, options), model, frames)
            print(f"{name:12}{base:14}{median:8.3f}{most:8.3f}{'' if median <= BOUND else '   too slow'}")


if __name__ == "__main__":
    main()
