"""Drives a scenario's robot from ROS 2: its sensors appear as topics, and `/cmd_vel` is its command.

With one robot the topics are those that ROS users know: /clock, /tf, /tf_static, /odom, /scan, /imu, /people, /crowd,
/contacts, /markers/..., /goal_pose; further outputs are called `/SENSOR/PORT`. With several robots each has its own
under `/ROBOT`. Commands come as `geometry_msgs/Twist` or `TwistStamped` on `/cmd_vel`.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from crowdcosim.cdr import decode, encode, type_hash
from crowdcosim.message import Message
from crowdcosim.messages import (
    Goal,
    Header,
    Imu,
    LaserScan,
    Odometry,
    Point,
    Pose,
    PoseStamped,
    Quaternion,
    RobotState,
    Twist,
    TwistStamped,
)
from crowdcosim.setup import time_of
from orchestrator.errors import RunError
from orchestrator.log.frames import FRAME_CHANNELS, frame_records, static_records
from orchestrator.log.recorder import Record
from orchestrator.log.scenery import MARKER_CHANNELS, contact_records, people_record, world_record
from orchestrator.ros2.messages import PEOPLE_TYPE, people, types
from orchestrator.ros2.node import Ros2Node, Ros2Publisher
from orchestrator.session import Session
from orchestrator.view import View

REPEAT = 0.5
"""what is shown is repeated so often until the first command comes [s]"""
POLL = 0.0002
"""between two looks for a command [s]"""

_CHANNELS = {channel.topic: channel for channel in (*FRAME_CHANNELS, *MARKER_CHANNELS)}
_FAMILIAR: Mapping[type[Message], str] = {Odometry: "odom", LaserScan: "scan", Imu: "imu"}
"""names that the first sensor of a type has"""


@dataclass(frozen=True, kw_only=True)
class Waiting:
    """How long the lockstep waits for a command."""

    first: float
    """for the first one, while the others start up [s]"""
    next: float
    """for each further one [s]"""


class Gateway:
    """Publishes what a session shows, and steps it as ROS 2 commands."""

    def __init__(self, session: Session, node: Ros2Node) -> None:
        self._session = session
        self._node = node
        self._publishers: dict[str, Ros2Publisher] = {}
        self._commands = {robot: self._subscriptions(robot) for robot in session.commanded}
        self._last = dict.fromkeys(session.commanded, Twist())
        self._commanded = False

    def run(self, waiting: Waiting | None) -> None:
        """Go on until the episode is over.

        Args:
            waiting: wait in every step for the command that answers it; None goes on at the session's pace and takes
                the newest command that is there.

        Raises:
            RunError: if a command does not come in time.
        """
        scenario = self._session.scenario
        for record in (*static_records(scenario), world_record(scenario.world, scenario.robots)):
            self._publish_record(record)
        while not self._session.over:
            self._show(self._session.view)
            self._take(waiting)
            self._session.step(self._last if self._session.commanded else None)
        self._show(self._session.view)

    def _subscriptions(self, robot: str) -> list[tuple[type[Message], Callable[[], bytes | None]]]:
        topic = self._topic(robot, "cmd_vel")
        return [
            (kind, self._node.subscription(topic, kind.TYPE, type_hash(kind.TYPE)).take)
            for kind in (Twist, TwistStamped)
        ]

    def _take(self, waiting: Waiting | None) -> None:
        """Take the newest command of every robot."""
        missing = set(self._commands)
        limit = 0.0 if waiting is None else waiting.next if self._commanded else waiting.first
        shown = time.monotonic()
        until = shown + limit
        while missing:
            for robot in sorted(missing):
                if self._newest(robot):
                    missing.discard(robot)
                    self._commanded = True
            if waiting is None:
                return
            if missing and time.monotonic() > until:
                topics = ", ".join(self._topic(robot, "cmd_vel") for robot in sorted(missing))
                raise RunError(
                    None,
                    self._session.view.tick,
                    f"no command on {topics} within {limit:g} s: is the controller running, in the same ROS_DOMAIN_ID, "
                    "with RMW_IMPLEMENTATION=rmw_zenoh_cpp and use_sim_time?",
                )
            if missing:
                time.sleep(POLL)
                shown = self._show_again(shown)

    def _show_again(self, shown: float) -> float:
        """Until somebody drives, repeat what was shown: who comes late would wait for a clock that stands still."""
        if self._commanded or time.monotonic() - shown < REPEAT:
            return shown
        self._show(self._session.view)
        return time.monotonic()

    def _newest(self, robot: str) -> bool:
        found = False
        for kind, take in self._commands[robot]:
            while (payload := take()) is not None:
                message = decode(payload, kind.TYPE)
                self._last[robot] = message.twist if isinstance(message, TwistStamped) else message
                found = True
        return found

    def _show(self, view: View) -> None:
        """Publish everything there is to see; the clock last, since it is what timers wait for."""
        now = round(view.time * 1e9)
        if view.crowd is not None:
            self._publish("/crowd", view.crowd, now)
            self._send("/people", PEOPLE_TYPE, people(view.crowd), now)
            self._publish_record(people_record(view.crowd, now))
        states: list[RobotState] = []
        for robot, seen in view.robots.items():
            states.append(seen.state)
            named = self._names(robot, seen.sensors)
            for name, message in seen.sensors.items():
                self._publish(named[name], message, now)
            if seen.contacts is not None:
                self._publish(self._topic(robot, "contacts"), seen.contacts, now)
                for record in contact_records(seen.contacts, now):
                    self._publish_record(record)
        if not self._commanded:
            for robot, goal in self._session.goals.items():
                self._publish(self._topic(robot, "goal_pose"), pose_of(goal, now), now)
        clock, *frames = frame_records(now, states)
        for record in (*frames, clock):
            self._publish_record(record)

    def _names(self, robot: str, sensors: Mapping[str, Message]) -> dict[str, str]:
        """Sensor output -> topic: the first of a kind that ROS has a name for is called so."""
        taken: set[str] = set()
        names = {}
        for output, message in sensors.items():
            familiar = _FAMILIAR.get(type(message))
            name = familiar if familiar and familiar not in taken else output
            taken.add(name)
            names[output] = self._topic(robot, name)
        return names

    def _topic(self, robot: str, name: str) -> str:
        return f"/{name}" if len(self._session.scenario.robots) == 1 else f"/{robot}/{name}"

    def _publish(self, topic: str, message: Message, time_ns: int) -> None:
        self._send(topic, message.TYPE, encode(message), time_ns)

    def _publish_record(self, record: Record) -> None:
        self._send(record.topic, _CHANNELS[record.topic].type, record.payload, record.time)

    def _send(self, topic: str, typename: str, payload: bytes, time_ns: int) -> None:
        if topic not in self._publishers:
            latched = topic in _CHANNELS and _CHANNELS[topic].latched
            hash_ = types().hash_rihs01(typename)
            self._publishers[topic] = self._node.publisher(topic, typename, hash_, latched=latched)
        self._publishers[topic].publish(payload, time_ns)


def pose_of(goal: Goal, time_ns: int) -> PoseStamped:
    """A goal as Nav2 takes it: the point aimed at, facing the way across its line."""
    yaw = math.atan2(goal.direction[1], goal.direction[0])
    return PoseStamped(
        header=Header(stamp=time_of(time_ns), frame_id="map"),
        pose=Pose(
            position=Point(x=float(goal.position[0]), y=float(goal.position[1])),
            orientation=Quaternion(z=math.sin(yaw / 2), w=math.cos(yaw / 2)),
        ),
    )
