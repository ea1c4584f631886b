"""Messages hold what their type declares, and are the same after a journey over the wire."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst
from rosbags.typesys import Stores, get_typestore

from crowdcosim.cdr import decode, encode, schema_text, type_hash
from crowdcosim.interfaces.generate import TARGET, generate
from crowdcosim.message import MessageError, check_finite
from crowdcosim.messages import (
    MESSAGES,
    BeamAgents,
    Contacts,
    Crowd,
    Header,
    LaserScan,
    Metrics,
    Odometry,
    Range,
    Ranges,
    RobotState,
    Time,
    Twist,
    Vector3,
)

finite = st.floats(allow_nan=False, allow_infinity=False)


def crowd(n: int) -> Crowd:
    column = np.arange(n, dtype=np.float64)
    return Crowd(
        header=Header(stamp=Time(sec=3, nanosec=7), frame_id="map"),
        id=np.arange(1, n + 1, dtype=np.uint32),
        group=np.zeros(n, np.uint32),
        position=np.stack([column, column + 0.5], axis=1),
        velocity=np.zeros((n, 2)),
        heading=column,
        radius=column,
        stature=column,
        mass=column,
        gait_phase=column,
        gait_speed=column,
    )


def test_the_committed_messages_are_what_the_msg_files_give() -> None:
    assert TARGET.read_text() == generate()


@pytest.mark.parametrize("kind", MESSAGES.values(), ids=lambda kind: kind.__name__)
def test_an_empty_message_of_every_type_survives_the_wire(kind: type) -> None:
    assert decode(encode(kind()), kind.TYPE) == kind()


@pytest.mark.parametrize("n", [0, 1, 2, 350])
def test_a_crowd_of_any_size_survives_the_wire(n: int) -> None:
    assert decode(encode(crowd(n)), Crowd.TYPE) == crowd(n)


@given(
    npst.arrays(np.float64, st.tuples(st.integers(0, 5), st.just(2)), elements=finite),
    st.text(st.characters(exclude_characters="\0", exclude_categories=["Cs"])),
    finite,
)
def test_whatever_a_message_holds_survives_the_wire(points: np.ndarray, text: str, number: float) -> None:
    n = len(points)
    message = Contacts(
        header=Header(frame_id=text),
        robot=text,
        kind=np.full(n, Contacts.PERSON, np.uint8),
        agent=np.arange(n, dtype=np.uint32),
        body_part=np.zeros(n, np.uint8),
        robot_part=np.full(n, Contacts.REAR, np.uint8),
        striker=np.full(n, Contacts.BY_OTHER, np.uint8),
        position=points,
        normal=points,
        relative_velocity=points,
        approach_speed=np.full(n, number),
        robot_closing_speed=np.full(n, number),
        reflected_mass=np.full(n, number),
        energy=np.full(n, number),
        duration=np.full(n, number),
    )
    assert decode(encode(message), Contacts.TYPE) == message


def test_standard_messages_are_read_by_an_independent_ros_2_type_store() -> None:
    scan = LaserScan(header=Header(frame_id="lidar"), angle_min=-1.5, ranges=[1.0, math.inf, 3.0])
    other = get_typestore(Stores.ROS2_JAZZY).deserialize_cdr(encode(scan), LaserScan.TYPE)
    assert other.header.frame_id == "lidar"
    assert other.angle_min == -1.5
    assert other.ranges.tolist() == [1.0, math.inf, 3.0]


def test_standard_types_have_the_hashes_that_ros_2_jazzy_has() -> None:
    # As `ros2 topic info --verbose` prints it for sensor_msgs/msg/LaserScan and geometry_msgs/msg/Twist.
    assert type_hash(Twist.TYPE) == "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
    assert type_hash(LaserScan.TYPE) == "RIHS01_64c191398013af96509d518dac71d5164f9382553fce5c1f8cca5be7924bd828"


def test_schema_texts_name_all_that_a_type_depends_on() -> None:
    text = schema_text(Odometry.TYPE)
    for name in ("std_msgs/Header", "geometry_msgs/PoseWithCovariance", "builtin_interfaces/Time"):
        assert f"MSG: {name}" in text


def test_arrays_are_read_only_contiguous_and_aligned_on_both_sides_of_the_wire() -> None:
    for message in (crowd(3), decode(encode(crowd(3)), Crowd.TYPE)):
        for array in (message.id, message.position, message.heading):
            assert not array.flags.writeable
            assert array.flags.c_contiguous
            assert array.flags.aligned


def test_the_makers_arrays_are_copied_and_stay_his_own() -> None:
    position = np.zeros((1, 2))
    message = RobotState(position=position[0])
    position[:] = 1.0
    assert message.position.tolist() == [0.0, 0.0]


def test_float32_fields_are_rounded_when_made() -> None:
    assert LaserScan(angle_min=0.1).angle_min == float(np.float32(0.1))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Crowd(id=[1], group=[0], position=[[0, 0], [1, 1]]), ["Crowd.position", "2 rows", "1"]),
        (lambda: Crowd(position=[[0, 0, 0]]), ["Crowd.position", "(N, 2)"]),
        (lambda: RobotState(position=[1, 2, 3]), ["RobotState.position", "(2)", "3"]),
        (lambda: BeamAgents(kind=[1.5], agent=[0]), ["BeamAgents.kind", "uint8"]),
        (lambda: BeamAgents(kind=[300], agent=[0]), ["BeamAgents.kind"]),
        (lambda: Crowd(id=["one"]), ["Crowd.id", "uint32"]),
        (lambda: Metrics(robot=["a"], name=[]), ["Metrics.robot", "0"]),
    ],
)
def test_arrays_that_do_not_fit_are_refused_by_name(make, words) -> None:
    with pytest.raises(MessageError) as error:
        make()
    assert all(word in str(error.value) for word in words), str(error.value)


@pytest.mark.parametrize(
    "message", [Twist(linear=Vector3(x="fast")), Header(stamp=Time(sec=2**40)), Twist(linear=None)], ids=str
)
def test_scalars_that_do_not_fit_are_refused_by_the_encoder(message) -> None:
    with pytest.raises(MessageError, match=message.TYPE):
        encode(message)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_a_message_error(data: bytes) -> None:
    try:
        decode(data, Crowd.TYPE)
    except MessageError as error:
        assert "Crowd" in str(error)


@given(st.integers(0, 400))
def test_a_truncated_message_is_refused(length: int) -> None:
    data = encode(crowd(4))
    if length < len(data) - 4:
        with pytest.raises(MessageError):
            decode(data[:length], Crowd.TYPE)


def test_not_finite_values_are_found_wherever_they_are() -> None:
    check_finite(LaserScan(ranges=[math.inf]))
    check_finite(Range(range=-math.inf))
    for message, name in (
        (LaserScan(ranges=[math.nan]), "LaserScan.ranges[0]"),
        (Range(range=math.nan), "Range.range"),
        (Range(variance=math.inf), "Range.variance"),
        (Ranges(ranges=(Range(range=math.nan),)), "Ranges.ranges[0].range"),
        (Twist(angular=Vector3(z=math.inf)), "Twist.angular.z"),
        (Crowd(id=[1], position=[[0, math.nan]], **_ones(1)), "Crowd.position[0, 1]"),
    ):
        with pytest.raises(MessageError) as error:
            check_finite(message)
        assert name in str(error.value)


def _ones(n: int) -> dict[str, np.ndarray]:
    return {name: np.ones(n) for name in ("heading", "radius", "stature", "mass", "gait_phase", "gait_speed")} | {
        "velocity": np.ones((n, 2)),
        "group": np.ones(n, np.uint32),
    }
