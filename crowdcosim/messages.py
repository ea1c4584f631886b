"""The messages that components exchange: typed, frozen, checked when made.

Generated from `crowdcosim/interfaces/msg/*.msg` by `python crowdcosim/interfaces/generate.py`; do not edit.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from crowdcosim.message import ArrayField, CoercedMessage, Message, SequenceField


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Time(Message):
    """The standard ROS 2 message `builtin_interfaces/msg/Time`."""

    TYPE: ClassVar[str] = "builtin_interfaces/msg/Time"

    sec: int = 0
    nanosec: int = 0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Header(Message):
    """The standard ROS 2 message `std_msgs/msg/Header`."""

    TYPE: ClassVar[str] = "std_msgs/msg/Header"

    stamp: Time = field(default_factory=Time)
    frame_id: str = ""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Vector3(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Vector3`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Vector3"

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Point(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Point`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Point"

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Quaternion(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Quaternion`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Quaternion"

    x: float = 0.0
    y: float = 0.0
    z: float = 0.0
    w: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Pose(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Pose`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Pose"

    position: Point = field(default_factory=Point)
    orientation: Quaternion = field(default_factory=Quaternion)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PoseStamped(Message):
    """The standard ROS 2 message `geometry_msgs/msg/PoseStamped`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/PoseStamped"

    header: Header = field(default_factory=Header)
    pose: Pose = field(default_factory=Pose)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PoseWithCovariance(CoercedMessage):
    """The standard ROS 2 message `geometry_msgs/msg/PoseWithCovariance`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/PoseWithCovariance"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("covariance", np.dtype(np.float64), (36,)),
    )

    pose: Pose = field(default_factory=Pose)
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros(36, np.float64))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Twist(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Twist`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Twist"

    linear: Vector3 = field(default_factory=Vector3)
    angular: Vector3 = field(default_factory=Vector3)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TwistStamped(Message):
    """The standard ROS 2 message `geometry_msgs/msg/TwistStamped`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/TwistStamped"

    header: Header = field(default_factory=Header)
    twist: Twist = field(default_factory=Twist)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TwistWithCovariance(CoercedMessage):
    """The standard ROS 2 message `geometry_msgs/msg/TwistWithCovariance`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/TwistWithCovariance"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("covariance", np.dtype(np.float64), (36,)),
    )

    twist: Twist = field(default_factory=Twist)
    covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros(36, np.float64))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Transform(Message):
    """The standard ROS 2 message `geometry_msgs/msg/Transform`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/Transform"

    translation: Vector3 = field(default_factory=Vector3)
    rotation: Quaternion = field(default_factory=Quaternion)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TransformStamped(Message):
    """The standard ROS 2 message `geometry_msgs/msg/TransformStamped`."""

    TYPE: ClassVar[str] = "geometry_msgs/msg/TransformStamped"

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    transform: Transform = field(default_factory=Transform)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Odometry(Message):
    """The standard ROS 2 message `nav_msgs/msg/Odometry`."""

    TYPE: ClassVar[str] = "nav_msgs/msg/Odometry"

    header: Header = field(default_factory=Header)
    child_frame_id: str = ""
    pose: PoseWithCovariance = field(default_factory=PoseWithCovariance)
    twist: TwistWithCovariance = field(default_factory=TwistWithCovariance)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Path(CoercedMessage):
    """The standard ROS 2 message `nav_msgs/msg/Path`."""

    TYPE: ClassVar[str] = "nav_msgs/msg/Path"
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("poses", "_"),
    )

    header: Header = field(default_factory=Header)
    poses: tuple[PoseStamped, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Clock(Message):
    """The standard ROS 2 message `rosgraph_msgs/msg/Clock`."""

    TYPE: ClassVar[str] = "rosgraph_msgs/msg/Clock"

    clock: Time = field(default_factory=Time)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RegionOfInterest(Message):
    """The standard ROS 2 message `sensor_msgs/msg/RegionOfInterest`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/RegionOfInterest"

    x_offset: int = 0
    y_offset: int = 0
    height: int = 0
    width: int = 0
    do_rectify: bool = False


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class CameraInfo(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/CameraInfo`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/CameraInfo"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("d", np.dtype(np.float64), ("_",)),
        ArrayField("k", np.dtype(np.float64), (9,)),
        ArrayField("r", np.dtype(np.float64), (9,)),
        ArrayField("p", np.dtype(np.float64), (12,)),
    )

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    distortion_model: str = ""
    d: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    k: NDArray[np.float64] = field(default_factory=lambda: np.zeros(9, np.float64))
    r: NDArray[np.float64] = field(default_factory=lambda: np.zeros(9, np.float64))
    p: NDArray[np.float64] = field(default_factory=lambda: np.zeros(12, np.float64))
    binning_x: int = 0
    binning_y: int = 0
    roi: RegionOfInterest = field(default_factory=RegionOfInterest)


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Image(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/Image`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/Image"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("data", np.dtype(np.uint8), ("_",)),
    )

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    encoding: str = ""
    is_bigendian: int = 0
    step: int = 0
    data: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Imu(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/Imu`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/Imu"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("orientation_covariance", np.dtype(np.float64), (9,)),
        ArrayField("angular_velocity_covariance", np.dtype(np.float64), (9,)),
        ArrayField("linear_acceleration_covariance", np.dtype(np.float64), (9,)),
    )

    header: Header = field(default_factory=Header)
    orientation: Quaternion = field(default_factory=Quaternion)
    orientation_covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros(9, np.float64))
    angular_velocity: Vector3 = field(default_factory=Vector3)
    angular_velocity_covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros(9, np.float64))
    linear_acceleration: Vector3 = field(default_factory=Vector3)
    linear_acceleration_covariance: NDArray[np.float64] = field(default_factory=lambda: np.zeros(9, np.float64))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class LaserScan(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/LaserScan`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/LaserScan"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("ranges", np.dtype(np.float32), ("_",), may_be_infinite=True),
        ArrayField("intensities", np.dtype(np.float32), ("_",)),
    )
    _NARROW: ClassVar[tuple[str, ...]] = (
        "angle_min",
        "angle_max",
        "angle_increment",
        "time_increment",
        "scan_time",
        "range_min",
        "range_max",
    )

    header: Header = field(default_factory=Header)
    angle_min: float = 0.0
    angle_max: float = 0.0
    angle_increment: float = 0.0
    time_increment: float = 0.0
    scan_time: float = 0.0
    range_min: float = 0.0
    range_max: float = 0.0
    ranges: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))
    intensities: NDArray[np.float32] = field(default_factory=lambda: np.zeros(0, np.float32))


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PointField(Message):
    """The standard ROS 2 message `sensor_msgs/msg/PointField`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/PointField"
    INT8: ClassVar[int] = 1
    UINT8: ClassVar[int] = 2
    INT16: ClassVar[int] = 3
    UINT16: ClassVar[int] = 4
    INT32: ClassVar[int] = 5
    UINT32: ClassVar[int] = 6
    FLOAT32: ClassVar[int] = 7
    FLOAT64: ClassVar[int] = 8

    name: str = ""
    offset: int = 0
    datatype: int = 0
    count: int = 0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class PointCloud2(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/PointCloud2`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/PointCloud2"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("data", np.dtype(np.uint8), ("_",)),
    )
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("fields", "_"),
    )

    header: Header = field(default_factory=Header)
    height: int = 0
    width: int = 0
    fields: tuple[PointField, ...] = ()
    is_bigendian: bool = False
    point_step: int = 0
    row_step: int = 0
    data: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    is_dense: bool = False


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Range(CoercedMessage):
    """The standard ROS 2 message `sensor_msgs/msg/Range`."""

    TYPE: ClassVar[str] = "sensor_msgs/msg/Range"
    ULTRASOUND: ClassVar[int] = 0
    INFRARED: ClassVar[int] = 1
    _NARROW: ClassVar[tuple[str, ...]] = (
        "field_of_view",
        "min_range",
        "max_range",
        "range",
        "variance",
    )
    _MAY_BE_INFINITE: ClassVar[tuple[str, ...]] = (
        "range",
    )

    header: Header = field(default_factory=Header)
    radiation_type: int = 0
    field_of_view: float = 0.0
    min_range: float = 0.0
    max_range: float = 0.0
    range: float = 0.0
    variance: float = 0.0


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class TFMessage(CoercedMessage):
    """The standard ROS 2 message `tf2_msgs/msg/TFMessage`."""

    TYPE: ClassVar[str] = "tf2_msgs/msg/TFMessage"
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("transforms", "_"),
    )

    transforms: tuple[TransformStamped, ...] = ()


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class BeamAgents(CoercedMessage):
    """Who each beam of a laser scan has hit; beam order as in the LaserScan of the same sensor and time."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/BeamAgents"
    NOTHING: ClassVar[int] = 0
    WALL: ClassVar[int] = 1
    PERSON: ClassVar[int] = 2
    ROBOT: ClassVar[int] = 3
    NO_PART: ClassVar[int] = 0
    FEET: ClassVar[int] = 1
    LOWER_LEGS: ClassVar[int] = 2
    UPPER_LEGS: ClassVar[int] = 3
    UPPER_BODY: ClassVar[int] = 4
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("kind", np.dtype(np.uint8), ("B",)),
        ArrayField("agent", np.dtype(np.uint32), ("B",)),
        ArrayField("body_part", np.dtype(np.uint8), ("B",)),
    )

    header: Header = field(default_factory=Header)
    """time and frame of the scan"""
    kind: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(B,) NOTHING, WALL, PERSON or ROBOT"""
    agent: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))
    """(B,) a person's id, a robot's number (from 1), a wall's (from 1), 0 for nothing"""
    body_part: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(B,) the person's part, NO_PART if it is not a person"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Contacts(CoercedMessage):
    """What touched one robot during the step that ends at this time: a structure of arrays over C contacts."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Contacts"
    WALL: ClassVar[int] = 1
    PERSON: ClassVar[int] = 2
    ROBOT: ClassVar[int] = 3
    NO_PART: ClassVar[int] = 0
    FEET: ClassVar[int] = 1
    LOWER_LEGS: ClassVar[int] = 2
    UPPER_LEGS: ClassVar[int] = 3
    UPPER_BODY: ClassVar[int] = 4
    FRONT: ClassVar[int] = 1
    LEFT: ClassVar[int] = 2
    REAR: ClassVar[int] = 3
    RIGHT: ClassVar[int] = 4
    NEITHER: ClassVar[int] = 0
    BY_ROBOT: ClassVar[int] = 1
    BY_OTHER: ClassVar[int] = 2
    BY_BOTH: ClassVar[int] = 3
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("kind", np.dtype(np.uint8), ("C",)),
        ArrayField("agent", np.dtype(np.uint32), ("C",)),
        ArrayField("body_part", np.dtype(np.uint8), ("C",)),
        ArrayField("robot_part", np.dtype(np.uint8), ("C",)),
        ArrayField("striker", np.dtype(np.uint8), ("C",)),
        ArrayField("position", np.dtype(np.float64), ("C", 2)),
        ArrayField("normal", np.dtype(np.float64), ("C", 2)),
        ArrayField("relative_velocity", np.dtype(np.float64), ("C", 2)),
        ArrayField("approach_speed", np.dtype(np.float64), ("C",)),
        ArrayField("robot_closing_speed", np.dtype(np.float64), ("C",)),
        ArrayField("reflected_mass", np.dtype(np.float64), ("C",)),
        ArrayField("energy", np.dtype(np.float64), ("C",)),
        ArrayField("duration", np.dtype(np.float64), ("C",)),
    )

    header: Header = field(default_factory=Header)
    """end of the step; frame map"""
    robot: str = ""
    """the robot that was touched"""
    kind: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(C,) WALL, PERSON or ROBOT"""
    agent: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))
    """(C,) a person's id, a robot's number (from 1, in the order of the scenario) or a wall's (from 1)"""
    body_part: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(C,) the person's part, NO_PART if it is not a person"""
    robot_part: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(C,) FRONT, LEFT, REAR or RIGHT: the quarter of its rim that was touched first"""
    striker: NDArray[np.uint8] = field(default_factory=lambda: np.zeros(0, np.uint8))
    """(C,) who ran into whom: who moved towards the other when they met"""
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C, 2) point of contact [m]"""
    normal: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C, 2) unit vector from the robot's centre to the contact"""
    relative_velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C, 2) velocity of the other minus the robot's, when they met [m/s]"""
    approach_speed: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C,) closing speed of the two centres when they met, positive when closing [m/s]"""
    robot_closing_speed: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C,) what the robot's own motion has of approach_speed [m/s]"""
    reflected_mass: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C,) of the body part or the other robot, 0 for a wall [kg]"""
    energy: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C,) half reduced mass times approach speed squared, 0 if receding [J]"""
    duration: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(C,) how long this contact has lasted so far, 0 at its first step [s]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Crowd(CoercedMessage):
    """The people on the ground plane, as they truly are: a structure of arrays over N people."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Crowd"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("id", np.dtype(np.uint32), ("N",)),
        ArrayField("group", np.dtype(np.uint32), ("N",)),
        ArrayField("position", np.dtype(np.float64), ("N", 2)),
        ArrayField("velocity", np.dtype(np.float64), ("N", 2)),
        ArrayField("heading", np.dtype(np.float64), ("N",)),
        ArrayField("radius", np.dtype(np.float64), ("N",)),
        ArrayField("stature", np.dtype(np.float64), ("N",)),
        ArrayField("mass", np.dtype(np.float64), ("N",)),
        ArrayField("gait_phase", np.dtype(np.float64), ("N",)),
        ArrayField("gait_speed", np.dtype(np.float64), ("N",)),
    )

    header: Header = field(default_factory=Header)
    """time of this state; frame map"""
    id: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))
    """(N,) who, unique and at least 1 (0 means nobody)"""
    group: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))
    """(N,) the social group they walk with, from 1; 0: alone"""
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N, 2) centres [m]"""
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N, 2) velocities [m/s]"""
    heading: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) direction of the body, counter-clockwise from x [rad]"""
    radius: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) radius of the body's disc [m]"""
    stature: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) body height [m]"""
    mass: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) body mass [kg]"""
    gait_phase: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) phase of the walk, 0 to 1 [cycles]"""
    gait_speed: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) speed that the steps are made for: that of the velocity, smoothed [m/s]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Detections(CoercedMessage):
    """People as a sensor or tracker reports them: a structure of arrays over N detections."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Detections"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("track", np.dtype(np.uint32), ("N",)),
        ArrayField("position", np.dtype(np.float64), ("N", 2)),
        ArrayField("velocity", np.dtype(np.float64), ("N", 2)),
        ArrayField("radius", np.dtype(np.float64), ("N",)),
        ArrayField("position_deviation", np.dtype(np.float64), ("N",)),
        ArrayField("velocity_deviation", np.dtype(np.float64), ("N",)),
    )

    header: Header = field(default_factory=Header)
    """time and frame of the positions, usually a robot's base_link"""
    track: NDArray[np.uint32] = field(default_factory=lambda: np.zeros(0, np.uint32))
    """(N,) number under which the reporter follows this person, from 1; 0: it does not"""
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N, 2) centres, seen from the frame [m]"""
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N, 2) velocities over the ground, along the frame's axes, 0 where not known [m/s]"""
    radius: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) radius of the disc to keep clear of [m]"""
    position_deviation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) standard deviation of each coordinate of the position [m]"""
    velocity_deviation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(N,) standard deviation of each coordinate of the velocity; 0 with zero velocity: not known [m/s]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Done(Message):
    """A component's answer to a tick, published after all of its outputs of that tick."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Done"

    phase: int = 0
    """the phase that is done"""
    tick: int = 0
    """the tick that is done"""
    ok: bool = False
    """false: the component failed and error says why"""
    error: str = ""
    """empty if ok"""
    elapsed: int = 0
    """wall-clock time of the component's own work [ns]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class EncoderTicks(CoercedMessage):
    """Counts of the encoders of W wheels since the start of the episode."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/EncoderTicks"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("ticks", np.dtype(np.int64), ("W",)),
        ArrayField("ticks_per_turn", np.dtype(np.float64), ("W",)),
    )
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("wheel", "W"),
    )

    header: Header = field(default_factory=Header)
    """time of the reading; frame of the robot's base"""
    wheel: tuple[str, ...] = ()
    """(W,) which wheel"""
    ticks: NDArray[np.int64] = field(default_factory=lambda: np.zeros(0, np.int64))
    """(W,) count, negative after more turns backwards than forwards"""
    ticks_per_turn: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(W,) counts in one turn of the wheel"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Goal(CoercedMessage):
    """What one robot is asked to reach: a line to cross or a disc to enter."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Goal"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("position", np.dtype(np.float64), (2,)),
        ArrayField("direction", np.dtype(np.float64), (2,)),
    )

    header: Header = field(default_factory=Header)
    """frame map"""
    robot: str = ""
    """whose goal it is"""
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2, np.float64))
    """(2,) the point aimed at [m]"""
    direction: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2, np.float64))
    """(2,) unit vector: reached when the line through position, normal to this, is crossed; (0, 0): reached within tolerance"""
    tolerance: float = 0.0
    """radius of the disc [m]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Metrics(CoercedMessage):
    """What the evaluator found: a table of M rows, one row per robot and metric."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Metrics"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("value", np.dtype(np.float64), ("M",)),
        ArrayField("valid", np.dtype(np.bool_), ("M",)),
    )
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("robot", "M"),
        SequenceField("name", "M"),
        SequenceField("unit", "M"),
        SequenceField("reason", "M"),
    )

    robot: tuple[str, ...] = ()
    """(M,) which robot"""
    name: tuple[str, ...] = ()
    """(M,) which metric"""
    unit: tuple[str, ...] = ()
    """(M,) SI unit, 1 for a ratio"""
    value: NDArray[np.float64] = field(default_factory=lambda: np.zeros(0, np.float64))
    """(M,) the metric, 0 where it is not valid"""
    valid: NDArray[np.bool_] = field(default_factory=lambda: np.zeros(0, np.bool_))
    """(M,) false where the run gives no such value"""
    reason: tuple[str, ...] = ()
    """(M,) why it is not valid, else empty"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Ranges(CoercedMessage):
    """One reading of a ring of range finders."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Ranges"
    _SEQUENCES: ClassVar[tuple[SequenceField, ...]] = (
        SequenceField("ranges", "R"),
    )

    header: Header = field(default_factory=Header)
    """time of the reading; frame of the robot's base"""
    ranges: tuple[Range, ...] = ()
    """(R,) one per range finder, each with its own frame"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class RobotState(CoercedMessage):
    """Where one robot truly is and how it moves."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/RobotState"
    _ARRAYS: ClassVar[tuple[ArrayField, ...]] = (
        ArrayField("position", np.dtype(np.float64), (2,)),
        ArrayField("velocity", np.dtype(np.float64), (2,)),
    )

    header: Header = field(default_factory=Header)
    """time of this state; frame map"""
    name: str = ""
    """the robot's name in the scenario"""
    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2, np.float64))
    """(2,) centre of the base [m]"""
    heading: float = 0.0
    """direction of the base, counter-clockwise from x [rad]"""
    velocity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2, np.float64))
    """(2,) velocity in the map frame [m/s]"""
    angular_velocity: float = 0.0
    """turn rate, counter-clockwise [rad/s]"""
    radius: float = 0.0
    """radius of the base's disc [m]"""


@dataclass(frozen=True, kw_only=True, eq=False, slots=True)
class Tick(Message):
    """The orchestrator's word to every component: what to do next."""

    TYPE: ClassVar[str] = "crowdcosim_msgs/msg/Tick"
    RESET: ClassVar[int] = 0
    STEP: ClassVar[int] = 1
    FINISH: ClassVar[int] = 2
    STOP: ClassVar[int] = 3

    phase: int = 0
    """RESET: begin an episode; STEP: step from tick to tick + 1; FINISH: last look; STOP: exit"""
    episode: int = 0
    """number of the episode, from 1"""
    tick: int = 0
    """number of the committed state k"""
    period: int = 0
    """time from tick to tick [ns]"""
    time: int = 0
    """simulated time of that state [ns]"""
    setup: str = ""
    """RESET only: a JSON object with the keys alone and reference"""


MESSAGES: dict[str, type[Message]] = {
    Time.TYPE: Time,
    Header.TYPE: Header,
    Vector3.TYPE: Vector3,
    Point.TYPE: Point,
    Quaternion.TYPE: Quaternion,
    Pose.TYPE: Pose,
    PoseStamped.TYPE: PoseStamped,
    PoseWithCovariance.TYPE: PoseWithCovariance,
    Twist.TYPE: Twist,
    TwistStamped.TYPE: TwistStamped,
    TwistWithCovariance.TYPE: TwistWithCovariance,
    Transform.TYPE: Transform,
    TransformStamped.TYPE: TransformStamped,
    Odometry.TYPE: Odometry,
    Path.TYPE: Path,
    Clock.TYPE: Clock,
    RegionOfInterest.TYPE: RegionOfInterest,
    CameraInfo.TYPE: CameraInfo,
    Image.TYPE: Image,
    Imu.TYPE: Imu,
    LaserScan.TYPE: LaserScan,
    PointField.TYPE: PointField,
    PointCloud2.TYPE: PointCloud2,
    Range.TYPE: Range,
    TFMessage.TYPE: TFMessage,
    BeamAgents.TYPE: BeamAgents,
    Contacts.TYPE: Contacts,
    Crowd.TYPE: Crowd,
    Detections.TYPE: Detections,
    Done.TYPE: Done,
    EncoderTicks.TYPE: EncoderTicks,
    Goal.TYPE: Goal,
    Metrics.TYPE: Metrics,
    Ranges.TYPE: Ranges,
    RobotState.TYPE: RobotState,
    Tick.TYPE: Tick,
}
"""Every type that may cross a port, by its ROS 2 name."""
