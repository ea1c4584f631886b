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
from orchestrator.recorder import Channel, Record, record
from orchestrator.scenario import Scenario

FRAME_CHANNELS = (
    Channel("/clock", Clock.TYPE, "", "clock"),
    Channel("/tf", TFMessage.TYPE, "", "tf"),
    Channel("/tf_static", TFMessage.TYPE, "", "tf_static", latched=True),
)


def static_records(scenario: Scenario) -> list[Record]:
    """Frames that do not move: `odom` is aligned with `map`, and a sensor sits at its `position` and `yaw`."""
    transforms = [_transform("map", "odom", 0, 0.0, 0.0, 0.0, 0.0)]
    for spec in scenario.components:
        if spec.robot and {"position", "yaw"} <= spec.config.keys():
            x, y, z = spec.config["position"]
            transforms.append(_transform(f"{spec.robot}/base_link", spec.name, 0, x, y, z, spec.config["yaw"]))
    return [record("/tf_static", 0, TFMessage(transforms=tuple(transforms)))]


def frame_records(time_ns: int, states: list[RobotState]) -> list[Record]:
    """The clock, and the frames of the robots that have moved."""
    clock = record("/clock", time_ns, Clock(clock=time_of(time_ns)))
    if not states:
        return [clock]
    transforms = tuple(
        _transform("map", f"{s.name}/base_link", time_ns, float(s.position[0]), float(s.position[1]), 0.0, s.heading)
        for s in states
    )
    return [clock, record("/tf", time_ns, TFMessage(transforms=transforms))]


def _transform(parent: str, child: str, time_ns: int, x: float, y: float, z: float, yaw: float) -> TransformStamped:
    return TransformStamped(
        header=Header(stamp=time_of(time_ns), frame_id=parent),
        child_frame_id=child,
        transform=Transform(
            translation=Vector3(x=x, y=y, z=z),
            rotation=Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
        ),
    )
