"""A controller that fails in the way, and at the tick, that its config says."""

import os
import signal
import sys
import time
from dataclasses import dataclass

from crowdcosim import Controller, Setup
from crowdcosim.messages import Odometry, Twist, Vector3


@dataclass(frozen=True, kw_only=True)
class Config:
    fault: str
    at: int = 50


class Faulty(Controller):
    """Stands still until its time has come."""

    def __init__(self, config: Config) -> None:
        self.config = config
        if config.fault == "init":
            raise RuntimeError("no camera found")
        if config.fault == "exit_at_start":
            print("I cannot live here", file=sys.stderr, flush=True)
            os._exit(3)

    def reset(self, setup: Setup) -> None:
        self.tick = 0
        self.alone = setup.alone
        if self.config.fault == "reset":
            raise RuntimeError("no map found")
        if self.config.fault == "hang_at_reset":
            time.sleep(3600)

    def step(self, odometry: Odometry) -> Twist:
        if self.tick == self.config.at and not self.alone:
            self.fail()
        self.tick += 1
        nan = self.config.fault == "nan" and not self.alone and self.tick > self.config.at
        return Twist(linear=Vector3(x=float("nan") if nan else 0.0))

    def fail(self) -> None:
        match self.config.fault:
            case "raise":
                raise RuntimeError("the wheels came off")
            case "exit":
                print("goodbye, cruel world", file=sys.stderr, flush=True)
                os._exit(7)
            case "kill":
                os.kill(os.getpid(), signal.SIGKILL)
            case "hang":
                time.sleep(3600)


class NotAComponent:
    pass
