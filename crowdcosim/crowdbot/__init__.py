"""The names of the CrowdBot challenge's Python module, so that scripts written for it run after changing the import.

    from crowdcosim.crowdbot import helpers, recorder, robotnavigation, socket_handler

Instead of talking to a simulator over a socket, they step a `Session` in this process. Messages are dicts of texts with
the keys clock, crowd, odom and report, as the module records them. Its units and frame: metres and degrees; the robot
starts at x = 20 and drives towards -x, the goal of a 40 m corridor is at x = -20, y is to the right of its way.
A command is (forward speed [m/s], turn rate [deg/s], counter-clockwise).
"""

from crowdcosim.crowdbot.challenge import SCENARIOS, compute_metrics, load, run

__all__ = ["SCENARIOS", "compute_metrics", "load", "run"]
