"""Turn to the goal and drive: a controller made of Zenoh, the standard library, and what docs/protocol.md says."""

import json
import math
import os
import struct
import time

import zenoh

TYPES = {
    "odometry": ("nav_msgs/msg/Odometry", "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"),
    "goal": ("crowdcosim_msgs/msg/Goal", "RIHS01_1de622eef3e1ab66f16bb99b1b3c8186696bdbf81ef9cd44beb5edca05d7865d"),
    "twist": ("geometry_msgs/msg/Twist", "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"),
}
RESET, STEP, FINISH, STOP = range(4)
LABEL = struct.Struct("<QQqQ")  # episode, tick, time, elapsed
WAIT = {"congestion_control": zenoh.CongestionControl.BLOCK, "express": True}


def read(data, codes):
    """The first fields of a CDR message: a `struct` code for each, or `s` for a string."""
    values, at = [], 0  # offsets count from after the 4-byte header
    for code in codes:
        number = "<I" if code == "s" else "<" + code
        at += -at % struct.calcsize(number)  # every field is aligned to its own size
        (value,) = struct.unpack_from(number, data, 4 + at)
        at += struct.calcsize(number)
        if code == "s":  # that was the length, which counts the closing NUL
            at, value = at + value, data[4 + at : 4 + at + value - 1].decode()
        values.append(value)
    return values


def write(codes, *values):
    """A whole CDR message."""
    data = bytearray()
    for code, value in zip(codes, values, strict=True):
        text = value.encode() + b"\0" if code == "s" else b""
        number, value = ("<I", len(text)) if code == "s" else ("<" + code, value)
        data += bytes(-len(data) % struct.calcsize(number)) + struct.pack(number, value) + text
    return b"\0\1\0\0" + bytes(data)


def command(odometry, goal, speed, max_turn_rate):
    """The `Twist` that follows from an `Odometry` and a `Goal`."""
    *_, x, y, _z, _qx, _qy, qz, qw = read(odometry, "iIss" + "ddd" + "dddd")
    *_, goal_x, goal_y, direction_x, direction_y, tolerance = read(goal, "iIss" + "ddddd")
    bearing = math.atan2(direction_y, direction_x)  # a line to cross, at right angles
    if not (direction_x or direction_y):  # a disc to enter
        bearing = math.atan2(goal_y - y, goal_x - x)
        if math.hypot(goal_x - x, goal_y - y) <= tolerance:
            speed = max_turn_rate = 0.0
    error = math.remainder(bearing - 2.0 * math.atan2(qz, qw), math.tau)
    turn = max(-max_turn_rate, min(max_turn_rate, 2.0 * error))
    return write("dddddd", speed * max(0.0, math.cos(error)), 0.0, 0.0, 0.0, 0.0, turn)


class Input:
    """The messages of one source, in order."""

    def __init__(self, session, run, component, port, every, **_):
        self.name, self.every = f"{component}.{port}", every
        self.queue = session.declare_subscriber(f"{run}/{component}/{port}", zenoh.handlers.FifoChannel(1024))
        self.held, self.payload = (0, 0), b""

    def read(self, episode, tick):
        """Wait for the message that belongs to this tick."""
        wanted = (episode, tick // self.every * self.every if self.every else 0)
        while self.held != wanted:
            sample = self.queue.recv()
            label = LABEL.unpack(sample.attachment.to_bytes())[:2]
            if label > wanted:
                raise ValueError(f"input from {self.name} is of tick {label[1]}, expected {wanted[1]}")
            self.held, self.payload = label, sample.payload.to_bytes()
        return self.payload


class Node:
    """Answers the handshake, then steps at the orchestrator's word until it says stop."""

    def __init__(self, session, run, component):
        self.session, self.run, self.key = session, run, f"{run}/{component}"
        self.watch = session.liveliness().declare_subscriber(f"{run}/orchestrator/alive", leave_if_gone, history=True)
        self.ticks = session.declare_subscriber(f"{run}/orchestrator/tick", zenoh.handlers.FifoChannel(1024))
        self.requests = session.declare_queryable(f"{self.key}/control", zenoh.handlers.FifoChannel(16))
        self.token = session.liveliness().declare_token(f"{self.key}/alive")

    def answer(self):
        """Answer the next request; its name."""
        with self.requests.recv() as query:
            request, body = str(query.parameters), json.loads(query.payload.to_bytes())
            try:
                methods = {"hello": self.hello, "configure": self.configure, "connect": self.connect}
                answer = methods[request](**body) or {}
            except Exception as error:
                answer = {"error": str(error)}
            query.reply(query.key_expr, json.dumps(answer))
        return request

    def hello(self):
        odometry, goal, twist = ({"name": name, "type": t, "hash": h} for name, (t, h) in TYPES.items())
        return {"protocol": 1, "kind": "reactor", "inputs": [odometry, goal], "outputs": [twist]}

    def configure(self, *, config, every, inputs, setup):
        if unknown := config.keys() - {"speed"}:
            raise ValueError(f"there is no option {', '.join(sorted(unknown))}, expected speed")
        model = next(robot["model"] for robot in setup["robots"] if robot["name"] == setup["robot"])
        self.limits = (config.get("speed", model["max_speed"]), model["max_angular_velocity"])
        self.every = every
        self.inputs = {port: Input(self.session, self.run, **source) for port, (source,) in inputs.items()}

    def connect(self):
        self.twist = self.session.declare_publisher(f"{self.key}/twist", **WAIT)
        self.done = self.session.declare_publisher(f"{self.key}/done", **WAIT)

    def obey(self):
        """Do what the next tick says; its phase."""
        phase, episode, tick, _period, now, _setup = read(self.ticks.recv().payload.to_bytes(), "BQQqqs")
        try:
            if phase == STEP and tick % self.every == 0:
                odometry, goal = (self.inputs[port].read(episode, tick) for port in ("odometry", "goal"))
                began = time.perf_counter_ns()
                twist = command(odometry, goal, *self.limits)
                self.twist.put(twist, attachment=LABEL.pack(episode, tick, now, time.perf_counter_ns() - began))
            elif phase == RESET:
                self.done.put(write("BQ?sq", phase, tick, True, "", 0))
        except Exception as error:
            self.done.put(write("BQ?sq", phase, tick, False, str(error), 0))
            raise
        return phase


def leave_if_gone(token):
    if token.kind == zenoh.SampleKind.DELETE:
        os._exit(1)


if __name__ == "__main__":
    config = {"mode": "client", "connect": {"endpoints": [os.environ["CROWDCOSIM_ENDPOINT"]]}}
    config["scouting"] = {"multicast": {"enabled": False}, "gossip": {"enabled": False}}
    if user := os.environ.get("CROWDCOSIM_USER"):
        config["transport"] = {"auth": {"usrpwd": {"user": user, "password": os.environ["CROWDCOSIM_PASSWORD"]}}}
    with zenoh.open(zenoh.Config.from_json5(json.dumps(config))) as session:
        node = Node(session, os.environ["CROWDCOSIM_RUN"], os.environ["CROWDCOSIM_COMPONENT"])
        while node.answer() != "connect":
            pass
        while node.obey() != STOP:
            pass
