"""A controller of your own: straight on, the slower the nearer somebody is ahead."""

from dataclasses import dataclass

import numpy as np

from crowdcosim import Controller
from crowdcosim.messages import LaserScan, Twist, Vector3


@dataclass(frozen=True, kw_only=True)
class Config:
    speed: float = 1.0
    """where nobody is near [m/s]"""
    distance: float = 1.5
    """slow down when somebody ahead is nearer than this [m]"""


class MyController(Controller):
    def __init__(self, config: Config) -> None:
        self.config = config

    def step(self, scan: LaserScan) -> Twist:
        angle = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
        gap = scan.ranges[np.abs(angle) < 0.5].min(initial=self.config.distance)
        return Twist(linear=Vector3(x=self.config.speed * max(0.0, gap / self.config.distance)))
