"""What every log carries beside the components' outputs, so that viewers open it: `/clock`, `/tf` and `/tf_static`."""

from __future__ import annotations

import math

from crowdcosim.cdr import decode
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
from orchestrator.lockstep import Committed
from orchestrator.recorder import Channel, Record, record
from orchestrator.scenario import Scenario

FRAME_CHANNELS = (
    Channel("/clock", Clock.TYPE, "", "clock"),
    Channel("/tf", TFMessage.TYPE, "", "tf"),
    Channel("/tf_static", TFMessage.TYPE, "", "tf_static"),
)


def static_records(scenario: Scenario) -> list[Record]:
    """Frames that do not move: `odom` is aligned with `map`, and each sensor sits where its `mount` says."""
    transforms = [_transform("map", "odom", 0, 0.0, 0.0, 0.0, 0.0)]
    return [record("/tf_static", 0, TFMessage(transforms=tuple(transforms)))]


def frame_records(made: list[Committed], robots: frozenset[str]) -> list[Record]:
    """The clock and the robots' frames that belong to what was committed."""
    states = [c for c in made if c.port == "state" and c.component in robots]
    if not states:
        return []
    time_ns = states[0].time
    transforms = tuple(_of_robot(state) for state in states)
    return [
        record("/clock", time_ns, Clock(clock=time_of(time_ns))),
        record("/tf", time_ns, TFMessage(transforms=transforms)),
    ]


def _of_robot(committed: Committed) -> TransformStamped:
    state: RobotState = decode(committed.payload, RobotState.TYPE)
    x, y = state.position
    return _transform("map", f"{state.name}/base_link", committed.time, float(x), float(y), 0.0, state.heading)


def _transform(parent: str, child: str, time_ns: int, x: float, y: float, z: float, yaw: float) -> TransformStamped:
    return TransformStamped(
        header=Header(stamp=time_of(time_ns), frame_id=parent),
        child_frame_id=child,
        transform=Transform(
            translation=Vector3(x=x, y=y, z=z),
            rotation=Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
        ),
    )
