"""A TurtleBot2, a crowd, and bodies ready to step."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from components.robot.fmu_build import MODEL, compile_library, find_compiler, source_files, write_archive
from components.robot.fmu_file import LIBRARY_SUFFIX, PLATFORM
from components.robot.kinematic import Kinematic
from components.robot.robot_step import RobotStep
from crowdcosim.component import Mover
from crowdcosim.messages import Crowd, Twist, Vector3
from crowdcosim.robots import Differential, Pose, Robot, RobotModel, Target
from crowdcosim.setup import Setup
from crowdcosim.world import World

TURTLEBOT = RobotModel(
    radius=0.177,
    height=0.42,
    mass=20.0,
    max_speed=1.0,
    min_speed=-0.2,
    max_acceleration=5.0,
    max_angular_velocity=np.pi,
    max_angular_acceleration=10.0,
    base=Differential(wheel_radius=0.035, track=0.230),
)
FAULTY = (Path(__file__).parent / "faulty_drive.c").read_text()
OPEN = World(size=(50.0, 10.0))


class Bodies:
    """Robots of one scenario that step together from the same old state."""

    def __init__(
        self,
        *starts: Pose,
        world: World = OPEN,
        model: RobotModel = TURTLEBOT,
        period: int = 100_000_000,
        drive: Callable[[], Mover] = Kinematic,
    ):
        robots = tuple(
            Robot(name=f"robot{n}", number=n, model=model, start=start, goal=Target(x=0.0, y=0.0))
            for n, start in enumerate(starts, 1)
        )
        self.robots = robots
        self.components: list[Any] = [drive() for _ in robots]
        self.last: list[RobotStep] = [
            body.reset(Setup(component=robot.name, period=period, seed=1, world=world, robots=robots, robot=robot.name))
            for body, robot in zip(self.components, robots, strict=True)
        ]

    def step(self, *commands: Twist, crowd: Crowd | None = None) -> list[RobotStep]:
        states = [result.state for result in self.last]
        self.last = [
            body.step(command, crowd or Crowd(), tuple(states[:k] + states[k + 1 :]))
            for k, (body, command) in enumerate(zip(self.components, commands, strict=True))
        ]
        return self.last


def _twist(speed: float = 0.0, turn_rate: float = 0.0, lateral_speed: float = 0.0) -> Twist:
    return Twist(linear=Vector3(x=speed, y=lateral_speed), angular=Vector3(z=turn_rate))


def _people(*rows: tuple[float, float, float, float], stature: float = 1.75) -> Crowd:
    table = np.array(rows, np.float64).reshape(-1, 4)
    n = len(table)
    return Crowd(
        id=np.arange(101, 101 + n),
        group=np.zeros(n, np.uint32),
        position=table[:, :2],
        velocity=table[:, 2:],
        heading=np.zeros(n),
        radius=np.full(n, 0.3),
        stature=np.full(n, stature),
        mass=np.full(n, 70.0),
        gait_phase=np.zeros(n),
        gait_speed=np.zeros(n),
    )


@pytest.fixture(scope="session")
def bodies() -> type[Bodies]:
    return Bodies


@pytest.fixture(scope="session")
def twist() -> Callable[..., Twist]:
    """A command from speed [m/s], turn rate [rad/s] and speed to the left [m/s]."""
    return _twist


@pytest.fixture(scope="session")
def people() -> Callable[..., Crowd]:
    """A crowd from rows of x, y, vx, vy; ids from 101."""
    return _people


@pytest.fixture(scope="session")
def turtlebot() -> RobotModel:
    return TURTLEBOT


@pytest.fixture(scope="module")
def own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module")
def foreign(tmp_path_factory, own_cache):
    """Writes an FMU whose wheels follow at once, with torques of 1 N m, with a fault, or with names of its own."""

    libraries = {}

    def write(fault="none", at=0, names=None, attributes=""):
        files = source_files("3")
        files["sources/wheel_drive.c"] = f'#define FAULT "{fault}"\n#define AT {at}\n{FAULTY}'.encode()
        if (fault, at) not in libraries:
            libraries[fault, at] = compile_library(files, "3", find_compiler())
        xml = files["modelDescription.xml"].decode()
        for old, new in (names or {}).items():
            xml = xml.replace(f'name="{old}"', f'name="{new}"')
        xml = xml.replace("<CoSimulation ", f"<CoSimulation {attributes} ")
        path = tmp_path_factory.mktemp("fmu") / "Foreign.fmu"
        files["modelDescription.xml"] = xml.encode()
        write_archive(path, files | {f"binaries/{PLATFORM['3']}/{MODEL}{LIBRARY_SUFFIX}": libraries[fault, at]})
        return path

    return write
