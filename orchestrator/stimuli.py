"""Made-up but plausible inputs for a component that is tried out alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from crowdcosim.component import Sensor
from crowdcosim.message import Message
from crowdcosim.messages import (
    MESSAGES,
    BeamAgents,
    Contacts,
    Crowd,
    Goal,
    Header,
    LaserScan,
    Odometry,
    Point,
    Pose,
    PoseWithCovariance,
    Quaternion,
    RobotState,
    Twist,
    TwistWithCovariance,
    Vector3,
)
from crowdcosim.robots import Differential, Robot, RobotModel, Target
from crowdcosim.robots import Pose as Place
from crowdcosim.setup import Setup, time_of
from crowdcosim.world import Wall, World

SPEED = 0.5
"""of the made-up robot [m/s]"""

WORLD = World(
    size=(50.0, 10.0),
    periodic=(True, True),
    walls=(
        Wall(start=(0.0, 0.0), end=(50.0, 0.0), stops_people=False),
        Wall(start=(0.0, 10.0), end=(50.0, 10.0), stops_people=False),
    ),
)
ROBOT = Robot(
    name="robot",
    number=1,
    model=RobotModel(
        radius=0.177,
        height=0.42,
        mass=20.0,
        max_speed=1.0,
        min_speed=-0.2,
        max_acceleration=5.0,
        max_angular_velocity=math.pi,
        max_angular_acceleration=10.0,
        base=Differential(wheel_radius=0.035, track=0.230),
    ),
    start=Place(x=5.0, y=5.0),
    goal=Target(x=45.0, y=5.0, direction=(1.0, 0.0)),
)


def stimulus(kind: type[Message], phase: float) -> type[Sensor]:
    """A component class that gives a new message of type `kind` at every step; `phase` [s] tells two apart."""
    make = _MAKERS.get(kind, _default(kind))

    class Stimulus(Sensor):
        def reset(self, setup: Setup) -> None:
            self._period = setup.period
            self._tick = 0

        def step(self) -> Message:
            time_ns = self._tick * self._period
            self._tick += 1
            return make(Header(stamp=time_of(time_ns), frame_id="map"), time_ns * 1e-9 + phase)

    Stimulus.step.__annotations__["return"] = kind
    return Stimulus


def _default(kind: type[Message]) -> Callable[[Header, float], Message]:
    return lambda header, time: kind()


def _crowd(header: Header, time: float) -> Crowd:
    n = 12
    speed = np.linspace(0.8, 1.6, n)
    start = np.stack([np.linspace(6.0, 48.0, n), 1.0 + np.arange(n) * 3.7 % 8.0], axis=1)
    velocity = np.stack([-speed, np.zeros(n)], axis=1)
    return Crowd(
        header=header,
        id=np.arange(1, n + 1, dtype=np.uint32),
        group=np.zeros(n, np.uint32),
        position=WORLD.wrap(start + velocity * time),
        velocity=velocity,
        heading=np.full(n, math.pi),
        radius=np.full(n, 0.3),
        stature=np.full(n, 1.7),
        mass=np.full(n, 70.0),
        gait_phase=(time * np.linspace(0.8, 1.0, n)) % 1.0,
        gait_speed=speed,
    )


def _robot_state(header: Header, time: float) -> RobotState:
    return RobotState(
        header=header,
        name="robot",
        position=np.array([5.0 + SPEED * time, 5.0]),
        velocity=np.array([SPEED, 0.0]),
        radius=ROBOT.model.radius,
    )


def _odometry(header: Header, time: float) -> Odometry:
    pose = Pose(position=Point(x=5.0 + SPEED * time, y=5.0), orientation=Quaternion(w=1.0))
    return Odometry(
        header=Header(stamp=header.stamp, frame_id="odom"),
        child_frame_id="robot/base_link",
        pose=PoseWithCovariance(pose=pose),
        twist=TwistWithCovariance(twist=_twist(header, time)),
    )


def _twist(header: Header, time: float) -> Twist:
    return Twist(linear=Vector3(x=SPEED), angular=Vector3(z=0.2 * math.sin(time)))


def _goal(header: Header, time: float) -> Goal:
    return Goal(header=header, robot="robot", position=np.array([45.0, 5.0]), direction=np.array([1.0, 0.0]))


def _scan(header: Header, time: float) -> LaserScan:
    beams = 180
    return LaserScan(
        header=Header(stamp=header.stamp, frame_id="robot/lidar"),
        angle_min=-math.pi,
        angle_max=math.pi - 2 * math.pi / beams,
        angle_increment=2 * math.pi / beams,
        range_min=0.1,
        range_max=10.0,
        ranges=(3.0 + np.sin(np.arange(beams) * 0.1 + time)).astype(np.float32),
    )


def _beam_agents(header: Header, time: float) -> BeamAgents:
    kind, part = np.full(180, BeamAgents.PERSON, np.uint8), np.full(180, BeamAgents.LOWER_LEGS, np.uint8)
    return BeamAgents(header=header, kind=kind, agent=1 + np.arange(180, dtype=np.uint32) % 12, body_part=part)


def _contacts(header: Header, time: float) -> Contacts:
    return Contacts(header=header, robot="robot")


_MAKERS: dict[type[Message], Callable[[Header, float], Message]] = {
    Crowd: _crowd,
    RobotState: _robot_state,
    Odometry: _odometry,
    Twist: _twist,
    Goal: _goal,
    LaserScan: _scan,
    BeamAgents: _beam_agents,
    Contacts: _contacts,
}
assert set(_MAKERS) <= set(MESSAGES.values())
