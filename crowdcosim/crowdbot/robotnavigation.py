"""The baseline of the paper as the module has it: put your own `compute_vel_cmd` in its place."""

from __future__ import annotations

from crowdcosim.crowdbot.helpers import Dico


def compute_vel_cmd(dico: Dico) -> tuple[float, float]:
    """Straight on at 1 m/s, whoever is there: (forward speed [m/s], turn rate [deg/s])."""
    return 1.0, 0.0
