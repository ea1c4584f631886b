"""Markers are the bytes that an independent encoder of ROS 2 messages writes."""

import numpy as np
import pytest
from rosbags.typesys import Stores, get_typestore

from orchestrator.log.marker import ARRAY_TYPE, LINE_LIST, SPHERE_LIST, Marker, encode_markers

STORE = get_typestore(Stores.ROS2_JAZZY)


def marker(namespace: str = "legs", points: int = 3) -> Marker:
    return Marker(
        namespace=namespace,
        number=7,
        frame="map",
        type=LINE_LIST,
        position=(1.0, 2.0, 3.0),
        yaw=0.5,
        scale=(0.1, 0.2, 0.3),
        colour=(0.5, 0.25, 0.125, 1.0),
        points=np.arange(3.0 * points).reshape(-1, 3),
        lifetime=1_500_000_000,
        moves_with_frame=True,
    )


# Names of all lengths modulo 8 move what follows them against its alignment.
@pytest.mark.parametrize("namespace", ["a" * n for n in range(1, 10)])
@pytest.mark.parametrize("points", [0, 1, 4])
def test_rosbags_reads_the_markers_and_writes_the_same_bytes(namespace: str, points: int) -> None:
    data = encode_markers(2_000_000_003, [marker(namespace, points), marker(namespace, points)])
    message = STORE.deserialize_cdr(data, ARRAY_TYPE)
    assert bytes(STORE.serialize_cdr(message, ARRAY_TYPE)) == data


def test_the_fields_of_a_marker_are_where_they_belong() -> None:
    message = STORE.deserialize_cdr(encode_markers(2_000_000_003, [marker()]), ARRAY_TYPE)
    read = message.markers[0]
    assert (read.header.stamp.sec, read.header.stamp.nanosec, read.header.frame_id) == (2, 3, "map")
    assert (read.ns, read.id, read.type, read.action, read.frame_locked) == ("legs", 7, LINE_LIST, 0, True)
    assert (read.pose.position.z, read.scale.y, read.color.g) == (3.0, 0.2, 0.25)
    assert 2.0 * np.arctan2(read.pose.orientation.z, read.pose.orientation.w) == pytest.approx(0.5)
    assert (read.lifetime.sec, read.lifetime.nanosec) == (1, 500_000_000)
    assert [(p.x, p.y, p.z) for p in read.points] == [(0.0, 1.0, 2.0), (3.0, 4.0, 5.0), (6.0, 7.0, 8.0)]


def test_no_marker_is_an_empty_array() -> None:
    assert STORE.deserialize_cdr(encode_markers(0, []), ARRAY_TYPE).markers == []
    assert SPHERE_LIST == STORE.types["visualization_msgs/msg/Marker"].SPHERE_LIST
