"""A ROS 2 node by somebody else (zenoh-ros2-sdk): drives at 0.8 m/s at every clock tick and notes what it sees.

Usage: ros2_peer.py PORT SECONDS. Prints one JSON object.
"""

import json
import os
import sys
import threading
import time
import warnings

warnings.simplefilter("ignore")

from rosbags.typesys import Stores, get_typestore  # noqa: E402
from zenoh_ros2_sdk import ROS2Publisher, ROS2Subscriber, get_topic_names_and_types  # noqa: E402

STORE = get_typestore(Stores.ROS2_JAZZY)
PORT, SECONDS = int(sys.argv[1]), float(sys.argv[2])
seen = {"clock": [], "odom": [], "scan": [], "tf": [], "tf_static": []}
last = time.monotonic()
lock = threading.Lock()


def definition(typename: str) -> dict[str, str]:
    text, _ = STORE.generate_msgdef(typename, ros_version=2)
    return {"msg_type": typename, "msg_definition": text, "type_hash": STORE.hash_rihs01(typename)}


def subscribe(topic: str, typename: str, note) -> ROS2Subscriber:
    def callback(message) -> None:
        global last
        with lock:
            last = time.monotonic()
            seen[topic].append(note(message))
        if topic == "clock":
            drive()

    return ROS2Subscriber(f"/{topic}", callback=callback, router_port=PORT, **definition(typename))


def drive() -> None:
    twist.publish(linear=vector(x=0.8, y=0.0, z=0.0), angular=vector(x=0.0, y=0.0, z=0.0))


twist = ROS2Publisher("/cmd_vel", router_port=PORT, **definition("geometry_msgs/msg/Twist"))
vector = twist.session_mgr.store.types["geometry_msgs/msg/Vector3"]
kept = [
    subscribe("odom", "nav_msgs/msg/Odometry", lambda m: (m.pose.pose.position.x, m.child_frame_id)),
    subscribe("scan", "sensor_msgs/msg/LaserScan", lambda m: len(m.ranges)),
    subscribe("tf", "tf2_msgs/msg/TFMessage", lambda m: [t.child_frame_id for t in m.transforms]),
    subscribe("tf_static", "tf2_msgs/msg/TFMessage", lambda m: [t.child_frame_id for t in m.transforms]),
    subscribe("clock", "rosgraph_msgs/msg/Clock", lambda m: m.clock.sec * 1_000_000_000 + m.clock.nanosec),
]
began = time.monotonic()
graph: list = []
while time.monotonic() - began < SECONDS and (not seen["clock"] or time.monotonic() - last < 3.0):
    time.sleep(0.05)
    if seen["clock"] and not graph:
        graph = [[str(part) for part in topic] for topic in get_topic_names_and_types(router_port=PORT)]
print(json.dumps({**seen, "graph": graph}), flush=True)
os._exit(0)  # a live callback may keep an orderly exit waiting for ever
