"""What every log carries beside the components' outputs, so that viewers open it: `/clock`, `/tf` and `/tf_static`."""

from __future__ import annotations

import math

from crowdcosim.messages import (
    Clock,
    Header,
    Quaternion,
    RobotState,
    TFMessage,
    Transform,
    TransformStamped,
    Vector3,
)
from crowdcosim.setup import time_of
from orchestrator.log.recorder import Channel, Record, record
from orchestrator.scenario.mounts import optical_frames, sensor_frames
from orchestrator.scenario.scenario import Scenario

FRAME_CHANNELS = (
    Channel("/clock", Clock.TYPE, "", "clock"),
    Channel("/tf", TFMessage.TYPE, "", "tf"),
    Channel("/tf_static", TFMessage.TYPE, "", "tf_static", latched=True),
)


def static_records(scenario: Scenario) -> list[Record]:
    """Frames that do not move: `odom` is aligned with `map`, and sensors are fixed to their robots."""
    transforms = [transform("map", "odom", 0, (0.0, 0.0, 0.0), 0.0)]
    robots = {robot.name: robot for robot in scenario.robots}
    for spec in scenario.components:
        if spec.robot:
            for name, mount in sensor_frames(spec, robots[spec.robot].model).items():
                parent = f"{spec.robot}/base_link"
                transforms.append(transform(parent, name, 0, mount.position, mount.yaw, mount.pitch))
            for name, optical in optical_frames(spec, robots[spec.robot].model).items():
                transforms.append(_optical(name, optical))
    return [record("/tf_static", 0, TFMessage(transforms=tuple(transforms)))]


def frame_records(time_ns: int, states: list[RobotState]) -> list[Record]:
    """The clock, and the frames of the robots that have moved."""
    clock = record("/clock", time_ns, Clock(clock=time_of(time_ns)))
    if not states:
        return [clock]
    transforms = tuple(
        transform("map", f"{s.name}/base_link", time_ns, (float(s.position[0]), float(s.position[1]), 0.0), s.heading)
        for s in states
    )
    return [clock, record("/tf", time_ns, TFMessage(transforms=transforms))]


def _optical(camera: str, optical: str) -> TransformStamped:
    """From a camera that looks along x to its optical frame: x right, y down, z ahead (REP 103)."""
    return TransformStamped(
        header=Header(stamp=time_of(0), frame_id=camera),
        child_frame_id=optical,
        transform=Transform(rotation=Quaternion(x=-0.5, y=0.5, z=-0.5, w=0.5)),
    )


def transform(
    parent: str, child: str, time_ns: int, position: tuple[float, float, float], yaw: float, pitch: float = 0.0
) -> TransformStamped:
    """`child` is turned by `yaw` about the parent's z and then by `pitch` about its own y."""
    x, y, z = position
    turn, nod = 0.5 * yaw, 0.5 * pitch
    return TransformStamped(
        header=Header(stamp=time_of(time_ns), frame_id=parent),
        child_frame_id=child,
        transform=Transform(
            translation=Vector3(x=x, y=y, z=z),
            rotation=Quaternion(
                x=-math.sin(turn) * math.sin(nod),
                y=math.cos(turn) * math.sin(nod),
                z=math.sin(turn) * math.cos(nod),
                w=math.cos(turn) * math.cos(nod),
            ),
        ),
    )
