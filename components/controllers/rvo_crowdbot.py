"""RVO as the authors of "Crowd against the machine" ran it: RVO2 with wide bodies and long horizons.

Everything but the settings is in `rvo.py`. Their code (github.com/crowdbotp, 2021) lets the speed be |V| and the turn
rate the heading error, so that the robot turns round and flees where ORCA asks for a step back.

Differs from their code: walls are known, as everywhere here.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from components.controllers import rvo


@dataclass(frozen=True, kw_only=True)
class Config(rvo.Config):
    """Options of `rvo`, with the authors' settings."""

    horizon: float = 5.0
    """tau, for how long the robot wants to be free of collisions with neighbours [s]"""
    wall_horizon: float = 5.0
    """tau_wall, and with walls [s]"""
    neighbours: int = 10
    """how many, at most, are avoided, the nearest first"""
    range: float = 10.0
    """how far neighbours are seen, from centre to centre [m]"""
    margin: float = 0.0
    """added to the robot's radius [m]"""
    radius: float | None = 0.4
    """of the robot, None for its own [m]"""
    person_radius: float | None = 0.41
    """of everybody, None for their own [m]"""
    overlap_time: float | None = 0.5
    """within which to part from who is touched, None for one period [s]"""
    drive: Literal["brake", "nh_orca", "orca_dd", "heading"] = "heading"
    """how the robot follows the velocity that ORCA asks for"""


class CrowdBotRVO(rvo.RVO):
    """RVO with the authors' settings."""

    def __init__(self, config: Config) -> None:
        super().__init__(config)
