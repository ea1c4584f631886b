"""The evaluator: watches every robot until it arrives, and then says what the metrics say."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from components.evaluator.account import Account
from components.evaluator.look import warm_up
from components.evaluator.metrics import BASIC, chosen
from components.evaluator.run import Invalid
from components.evaluator.scene import CrowdStep
from crowdcosim import Evaluator, Setup
from crowdcosim.messages import Contacts, Crowd, Metrics, RobotState


@dataclass(frozen=True, kw_only=True)
class Config:
    """What is to be said about a run."""

    metrics: tuple[str, ...] = ("paper", "task", "motion", "safety", "comfort")
    """groups, metrics by name, or your own as `./my_metric.py:name`; `authors` has variants of the paper's"""

    def __post_init__(self) -> None:
        if not chosen(self.metrics):
            raise ValueError("metrics is empty, expected at least one")


class PaperEvaluator(Evaluator):
    """The paper's metrics and further ones for every robot; wants to be asked at every committed state."""

    def __init__(self, config: Config) -> None:
        self._metrics = chosen(config.metrics)

    def reset(self, setup: Setup) -> None:
        """Begin an episode. Raises `ValueError` if two robots have the same name."""
        names = [robot.name for robot in setup.robots]
        if len(set(names)) < len(names):
            raise ValueError(f"the robots are called {', '.join(names)}, expected a different name for each")
        self._setup = setup
        # The run alone has to say what ratios divide by, whatever is asked for.
        self._wanted = tuple(dict.fromkeys((*self._metrics, *BASIC))) if setup.alone else self._metrics
        self._accounts = [Account(setup, robot, self._wanted) for robot in setup.robots]
        self._crowd: Crowd | None = None
        warm_up()

    def step(self, crowd: Crowd, robots: tuple[RobotState, ...], contacts: tuple[Contacts, ...]) -> None:
        """Take one committed state into account, from that at t = 0 to the last one.

        Raises:
            ValueError: if a robot of the setup has no state.
        """
        states = {state.name: state for state in robots}
        touched = {report.robot: report for report in contacts}
        people = CrowdStep(dt=self._setup.dt, before=self._crowd or crowd, after=crowd)
        for account in self._accounts:
            if account.name not in states:
                raise ValueError(
                    f"there is no state of robot '{account.name}' among those of {', '.join(states) or 'no robot'}: "
                    "connect the output RobotState of its drive to the evaluator"
                )
            account.add(states[account.name], people, touched.get(account.name))
        self._crowd = crowd

    def finish(self) -> Metrics:
        """One row per robot and metric, robots in the scenario's order."""
        rows = [(account.name, metric, account.value(metric)) for account in self._accounts for metric in self._wanted]
        return Metrics(
            robot=tuple(robot for robot, _, _ in rows),
            name=tuple(metric.name for _, metric, _ in rows),
            unit=tuple(metric.unit for _, metric, _ in rows),
            value=np.array([0.0 if isinstance(value, Invalid) else value for _, _, value in rows]),
            valid=np.array([not isinstance(value, Invalid) for _, _, value in rows], np.bool_),
            reason=tuple(value.reason if isinstance(value, Invalid) else "" for _, _, value in rows),
        )
