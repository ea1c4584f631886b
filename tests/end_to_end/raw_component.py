"""A controller on bare Zenoh that stands still, and breaks the protocol in the one way that `--fault` names.

From tick `--at` of the run with people on, unless the fault is one of the handshake or of the end.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import struct
import sys
import time
from typing import Any

import zenoh

FAULTS = {
    # handshake
    "dies_before_hello": "exits with code 4 before it announces itself",
    "wrong_hash": "its Twist has another definition",
    "wrong_protocol": "speaks another version of the protocol",
    "takes_any_config": "accepts options that it does not have",
    # ticks
    "wrong_tick": "labels its output with the tick after",
    "nan": "commands NaN",
    "malformed": "sends bytes that are no Twist",
    "hang": "says nothing any more",
    "die": "exits with code 9",
    "any_input": "steps on whatever input comes first",
    # repetition
    "clock": "commands what the clock says",
    "process": "commands what differs from process to process",
    "ignores_reset": "goes on where the last episode ended",
    # the end
    "ignores_stop": "stays when told to stop",
    "exit_code": "leaves with code 3",
    "stays_alone": "stays when the orchestrator has gone",
}
RESET, STEP, FINISH, STOP = range(4)
ODOMETRY = "RIHS01_3cc97dc7fb7502f8714462c526d369e35b603cfc34d946e3f2eda2766dfec6e0"
TWIST = "RIHS01_9c45bf16fe0983d80e3cfe750d6835843d265a9a6c46bd2e609fcddde6fb8d2a"
LABEL = struct.Struct("<QQqQ")
TICK = struct.Struct("<4xB7xQQqqI")
ME = random.SystemRandom().random()


class RawComponent:
    """Reads `odometry`, gives `twist`."""

    def __init__(self, fault: str | None, at: int) -> None:
        self.fault = fault
        self.at = at
        self.steps = 0
        run, component = os.environ["CROWDCOSIM_RUN"], os.environ["CROWDCOSIM_COMPONENT"]
        self.run, self.key = run, f"{run}/{component}"
        self.session = zenoh.open(_settings(os.environ["CROWDCOSIM_ENDPOINT"]))
        self.ticks = self.subscribe(f"{run}/orchestrator/tick")
        self.requests = self.session.declare_queryable(f"{self.key}/control", zenoh.handlers.FifoChannel(16))
        if fault != "stays_alone":
            self.watch = self.session.liveliness().declare_subscriber(
                f"{run}/orchestrator/alive", _leave_if_gone, history=True
            )
        self.token = self.session.liveliness().declare_token(f"{self.key}/alive")

    def serve(self) -> int:
        """Live until told to stop; the exit code."""
        while self.answer() != "connect":
            pass
        while True:
            data = self.ticks.recv().payload.to_bytes()
            phase, episode, tick, period, now, size = TICK.unpack_from(data)
            if phase == STOP:
                return self.stop()
            if phase == RESET:
                self.reset(json.loads(data[TICK.size : TICK.size + size - 1]))
                self.say_done(phase, tick)
            elif phase == STEP and tick % self.every == 0:
                self.step(episode, tick, period, now)

    # --- handshake ---------------------------------------------------------------------------------------------------

    def answer(self) -> str:
        """Answer the next request; its name."""
        with self.requests.recv() as query:
            request, body = str(query.parameters), json.loads(query.payload.to_bytes())
            query.reply(query.key_expr, json.dumps(getattr(self, f"on_{request}")(body)))
        return request

    def on_hello(self, body: dict[str, Any]) -> dict[str, Any]:
        twist = "RIHS01_" + "0" * 64 if self.fault == "wrong_hash" else TWIST
        return {
            "protocol": 99 if self.fault == "wrong_protocol" else 1,
            "kind": "reactor",
            "inputs": [{"name": "odometry", "type": "nav_msgs/msg/Odometry", "hash": ODOMETRY}],
            "outputs": [{"name": "twist", "type": "geometry_msgs/msg/Twist", "hash": twist}],
        }

    def on_configure(self, body: dict[str, Any]) -> dict[str, Any]:
        if body["config"] and self.fault != "takes_any_config":
            return {"error": f"there is no option {next(iter(body['config']))}"}
        self.every = body["every"]
        ((source,),) = body["inputs"].values()
        self.source_every = source["every"]
        self.odometry = self.subscribe(f"{self.run}/{source['component']}/{source['port']}")
        return {}

    def on_connect(self, body: dict[str, Any]) -> dict[str, Any]:
        self.twist, self.done = self.publisher("twist"), self.publisher("done")
        return {}

    def subscribe(self, key: str) -> Any:
        return self.session.declare_subscriber(key, zenoh.handlers.FifoChannel(1024))

    def publisher(self, name: str) -> Any:
        block = zenoh.CongestionControl.BLOCK
        return self.session.declare_publisher(f"{self.key}/{name}", congestion_control=block, express=True)

    # --- ticks -------------------------------------------------------------------------------------------------------

    def reset(self, setup: dict[str, Any]) -> None:
        self.alone = setup["alone"]
        self.held = -1
        if self.fault != "ignores_reset":
            self.steps = 0

    def step(self, episode: int, tick: int, period: int, now: int) -> None:
        if problem := self.wait_for_odometry(episode, tick // self.source_every * self.source_every):
            self.say_done(STEP, tick, problem)
            sys.exit(1)
        self.steps += 1
        fault = self.fault if tick >= self.at and not self.alone else None
        match fault:
            case "hang":
                time.sleep(3600)
            case "die":
                print("the battery is empty", file=sys.stderr, flush=True)
                os._exit(9)
        forward = {
            "nan": float("nan"),
            "clock": time.time(),
            "process": ME,
            "ignores_reset": self.steps * 0.001,
        }.get(fault or "", 0.0)
        payload = b"\0\1\0\0" + struct.pack("<6d", forward, 0, 0, 0, 0, 0)
        ahead = 1 if fault == "wrong_tick" else 0
        label = LABEL.pack(episode, tick + ahead, now + ahead * period, 1000)
        self.twist.put(b"no Twist" if fault == "malformed" else payload, attachment=label)

    def wait_for_odometry(self, episode: int, wanted: int) -> str:
        """What is wrong with it, if anything is."""
        while self.held != wanted:
            e, self.held, *_ = LABEL.unpack(self.odometry.recv().attachment.to_bytes())
            if self.fault == "any_input":
                return ""
            if (e, self.held) > (episode, wanted):
                return f"odometry is of tick {self.held}, expected {wanted}"
            if e < episode:
                self.held = -1
        return ""

    def say_done(self, phase: int, tick: int, error: str = "") -> None:
        head = struct.pack("<B7xQ?3xI", phase, tick, not error, len(error) + 1) + error.encode() + b"\0"
        self.done.put(b"\0\1\0\0" + head + bytes(-len(head) % 8) + struct.pack("<q", 0))

    def stop(self) -> int:
        if self.fault == "ignores_stop":
            time.sleep(3600)
        self.session.close()
        return 3 if self.fault == "exit_code" else 0


def _settings(endpoint: str) -> zenoh.Config:
    off = {"enabled": False}
    settings = {"mode": "client", "connect": {"endpoints": [endpoint]}, "scouting": {"multicast": off, "gossip": off}}
    return zenoh.Config.from_json5(json.dumps(settings))


def _leave_if_gone(token: zenoh.Sample) -> None:
    if token.kind == zenoh.SampleKind.DELETE:
        os._exit(1)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--fault", choices=FAULTS, help="; ".join(f"{name}: {what}" for name, what in FAULTS.items()))
    parser.add_argument("--at", type=int, default=0, help="tick from which on the fault shows")
    arguments = parser.parse_args()
    if arguments.fault == "dies_before_hello":
        sys.exit(4)
    os._exit(RawComponent(arguments.fault, arguments.at).serve())
