"""The paper's corridor, its robot, and a robot that drives exactly as it is told within its limits."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crowdcosim import Controller, Setup, messages
from crowdcosim.messages import Crowd, Goal, Odometry, RobotState
from crowdcosim.robots import Pose, Robot, RobotModel, Target
from crowdcosim.world import Wall, World

TURTLEBOT2 = Path(__file__).parents[3] / "scenarios" / "robots" / "turtlebot2.yaml"


def _corridor() -> World:
    corners = [(0.0, 0.0), (50.0, 0.0), (50.0, 10.0), (0.0, 10.0)]
    walls = tuple(
        Wall(start=a, end=b, stops_people=False) for a, b in zip(corners, [*corners[1:], corners[0]], strict=True)
    )
    return World(size=(50.0, 10.0), periodic=(True, True), walls=walls)


@dataclass(frozen=True, kw_only=True)
class Scene:
    """Makes what a controller is given, and drives the robot with what it answers."""

    model: RobotModel
    corridor: World
    open: World
    """as large, without walls and seams"""

    def setup(self, world: World | None = None, dt: float = 0.1) -> Setup:
        robot = Robot(
            name="robot",
            number=1,
            model=self.model,
            start=Pose(x=5.0, y=5.0),
            goal=Target(x=45.0, y=5.0, direction=(1.0, 0.0)),
        )
        return Setup(
            component="controller",
            period=round(dt * 1e9),
            seed=1,
            world=world or self.corridor,
            robots=(robot,),
            robot="robot",
        )

    def line(self, x: float = 45.0) -> Goal:
        return Goal(robot="robot", position=np.array([x, 5.0]), direction=np.array([1.0, 0.0]))

    def disc(self, x: float, y: float, tolerance: float = 0.3) -> Goal:
        return Goal(robot="robot", position=np.array([x, y]), tolerance=tolerance)

    def odometry(self, x: float, y: float, heading: float = 0.0, v: float = 0.0, omega: float = 0.0) -> Odometry:
        orientation = messages.Quaternion(z=math.sin(heading / 2), w=math.cos(heading / 2))
        pose = messages.Pose(position=messages.Point(x=x, y=y), orientation=orientation)
        twist = messages.Twist(linear=messages.Vector3(x=v), angular=messages.Vector3(z=omega))
        return Odometry(pose=messages.PoseWithCovariance(pose=pose), twist=messages.TwistWithCovariance(twist=twist))

    def crowd(self, *position: tuple[float, float], velocity: Any = 0.0, radius: float = 0.3) -> Crowd:
        n = len(position)
        return Crowd(
            id=np.arange(1, n + 1),
            group=np.zeros(n, np.uint32),
            position=np.array(position, np.float64).reshape(n, 2),
            velocity=np.broadcast_to(np.asarray(velocity, np.float64), (n, 2)),
            heading=np.zeros(n),
            radius=np.full(n, radius),
            stature=np.full(n, 1.7),
            mass=np.full(n, 70.0),
            gait_phase=np.zeros(n),
            gait_speed=np.zeros(n),
        )

    def random_crowd(self, seed: int, count: int) -> Crowd:
        rng = np.random.default_rng(seed)
        position = rng.random((count, 2)) * self.corridor.size
        return self.crowd(*map(tuple, position), velocity=rng.normal(0.0, 1.0, (count, 2)))

    def robot(self, name: str, x: float, y: float, radius: float = 0.3) -> RobotState:
        return RobotState(name=name, position=np.array([x, y]), radius=radius)

    def drive(
        self,
        controller: Controller,
        goal: Goal,
        *,
        pose: tuple[float, float, float] = (5.0, 5.0, 0.0),
        speed: float = 0.0,
        dt: float = 0.1,
        seconds: float = 60.0,
        crowd: Crowd | None = None,
        until_x: float = math.inf,
    ) -> np.ndarray:
        """(K, 5) x, y, heading, v, omega at every period: exact arcs, speeds that change within the limits."""
        x, y, heading = pose
        v, omega = speed, 0.0
        inputs = {"odometry", "goal"} if crowd is None else {"odometry", "goal", "crowd", "others"}
        rows = [(x, y, heading, v, omega)]
        for _ in range(round(seconds / dt)):
            given = {"odometry": self.odometry(*rows[-1]), "goal": goal, "crowd": crowd, "others": ()}
            twist = controller.step(**{name: given[name] for name in inputs})
            dv, domega = self.model.max_acceleration * dt, self.model.max_angular_acceleration * dt
            v = min(v + dv, max(v - dv, twist.linear.x))
            omega = min(omega + domega, max(omega - domega, twist.angular.z))
            chord = v * dt * np.sinc(omega * dt / (2 * math.pi))
            x += chord * math.cos(heading + omega * dt / 2)
            y += chord * math.sin(heading + omega * dt / 2)
            heading += omega * dt
            rows.append((x, y, heading, v, omega))
            if x >= until_x:
                break
        return np.array(rows)


@pytest.fixture(scope="session")
def scene() -> Scene:
    return Scene(
        model=RobotModel(**yaml.safe_load(TURTLEBOT2.read_text())),
        corridor=_corridor(),
        open=World(size=(50.0, 10.0)),
    )
