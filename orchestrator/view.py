"""What there is to see of an episode at one time: sensors' outputs, people, contacts, clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from crowdcosim.message import Message
from crowdcosim.messages import Contacts, Crowd, RobotState
from orchestrator.errors import InputError
from orchestrator.log.recorder import topic_of
from orchestrator.simulation import Simulation


@dataclass(frozen=True, kw_only=True)
class RobotView:
    """One robot at one time."""

    state: RobotState
    """where it truly is"""
    contacts: Contacts | None
    """what touched it in the step that ends now; None if its drive does not say"""
    sensors: Mapping[str, Message]
    """what its sensors say, named as in the log: `lidar/scan`, `lidar/agents`, `odometry`"""


@dataclass(frozen=True, kw_only=True)
class View:
    """The episode at one time."""

    tick: int
    """steps since the start"""
    time: float
    """the clock [s]"""
    crowd: Crowd | None
    """the people as they truly are; None without a crowd"""
    robots: Mapping[str, RobotView]
    """robot's name -> how it is"""

    @property
    def robot(self) -> RobotView:
        """The only robot.

        Raises:
            InputError: if there are several or none.
        """
        if len(self.robots) != 1:
            raise InputError(f"there are {len(self.robots)} robots, expected one: use robots[NAME]")
        return next(iter(self.robots.values()))


class Viewer:
    """Makes views of a simulation."""

    def __init__(self, simulation: Simulation) -> None:
        self._lockstep = simulation.lockstep
        self._period = simulation.scenario.period
        members = simulation.graph.members
        self._has_crowd = "crowd" in members
        self._touched = frozenset(
            name for name, m in members.items() if "contacts" in {o.name for o in m.ports.outputs}
        )
        self._sensors = {
            robot.name: [
                (topic_of(spec.name, output.name).removeprefix(f"/{robot.name}/"), spec.name, output.name)
                for spec in simulation.scenario.components
                if spec.robot == robot.name and spec.name not in (robot.name, f"{robot.name}/controller")
                for output in members[spec.name].ports.outputs
            ]
            for robot in simulation.scenario.robots
        }

    def view(self, tick: int) -> View:
        """The episode at `tick`, the sensors' outputs of that tick included."""
        observed = self._lockstep.observed
        robots = {
            robot: RobotView(
                state=observed(robot, "state", tick),
                contacts=observed(robot, "contacts", tick) if robot in self._touched else None,
                sensors={name: observed(component, port, tick) for name, component, port in sensors},
            )
            for robot, sensors in self._sensors.items()
        }
        crowd = observed("crowd", "crowd", tick) if self._has_crowd else None
        return View(tick=tick, time=tick * self._period * 1e-9, crowd=crowd, robots=robots)
