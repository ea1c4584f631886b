"""A folder with one small component of each kind and a scenario of them, for tests that need no real ones."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

MINE = '''
from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from crowdcosim import Controller, Evaluator, Mover, Sensor
from crowdcosim.messages import Crowd, LaserScan, RobotState, Twist


@dataclass(frozen=True, kw_only=True)
class Gait:
    stride: float = 0.7
    """length of a step [m]"""


@dataclass(frozen=True, kw_only=True)
class CrowdConfig:
    count: int
    """number of people"""
    speed: float = 1.3
    """preferred speed [m/s]"""
    policy: Literal["orca", "social_force"] = "orca"
    gait: Gait = Gait()
    sizes: tuple[float, ...] = ()
    seat: float | None = None

    def __post_init__(self) -> None:
        if self.speed < 0:
            raise ValueError(f"speed is {self.speed}, expected zero or more")
        if self.count > 1000:
            raise ValueError("that is too many people")
        if self.count == 13:
            raise KeyError("thirteen")


class People(Mover):
    def __init__(self, config: CrowdConfig) -> None: ...
    def step(self) -> Crowd: ...


class Drive(Mover):
    def step(self, command: Twist) -> RobotState: ...


class Scanner(Sensor):
    def step(self, robot: RobotState, crowd: Crowd | None) -> LaserScan: ...


class Driver(Controller):
    def step(self, scan: LaserScan) -> Twist: ...


class Judge(Evaluator):
    def step(self, robots: tuple[RobotState, ...]) -> None: ...


class Odd(Controller):
    def step(self, scan: int) -> Twist: ...


class NoComponent: ...
'''

SCENARIO = """\
dt: 0.1
world:
  size: [50, 10]
  boundary: robots
crowd:
  use: ./mine.py:People
  config:
    count: 3
robots:
  robot:
    model: turtlebot2
    start: {x: 5, y: 5}
    goal: {x: 45, y: 5, direction: [1, 0]}
    drive: {use: ./mine.py:Drive}
    sensors:
      lidar: {use: ./mine.py:Scanner, every: 2}
    controller:
      use: ./mine.py:Driver
      inputs: {scan: robot/lidar}
evaluator: {use: ./mine.py:Judge}
end:
  time_limit: 30
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, which holds `mine.py` and `base.yaml`."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.py").write_text(MINE)
    (tmp_path / "base.yaml").write_text(SCENARIO)
    return tmp_path


@pytest.fixture
def changed(folder: Path) -> Callable[[str, str], str]:
    """Writes `base.yaml` with one piece of text replaced to `s.yaml`."""

    def change(old: str, new: str) -> str:
        assert SCENARIO.count(old) == 1
        (folder / "s.yaml").write_text(SCENARIO.replace(old, new))
        return "s.yaml"

    return change
