"""When an episode ends, and why."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal

from crowdcosim.goal import reached
from crowdcosim.messages import Contacts, Goal, RobotState
from orchestrator.scenario.file import Ending

Reason = Literal["goal", "collision", "time_limit", "stopped"]


class Referee:
    """Watches one episode for its end; `arrived` are the robots that have reached their goals so far."""

    def __init__(self, ending: Ending, goals: Mapping[str, Goal], last_tick: int) -> None:
        self._ending = ending
        self._goals = goals
        self._last_tick = last_tick
        self.arrived: set[str] = set()

    def reason(self, tick: int, states: Mapping[str, RobotState], contacts: Mapping[str, Contacts]) -> Reason | None:
        """Why the episode ends at the state `tick`; None if it goes on. `contacts` are needed to end at a collision."""
        self.arrived |= {r for r, state in states.items() if reached(self._goals[r], state.position)}
        enough = {"all": len(states) or 1, "any": 1, "none": len(states) + 1}[self._ending.goal]
        if len(self.arrived) >= enough:
            return "goal"
        if self._ending.collision and any((c.kind == Contacts.PERSON).any() for c in contacts.values()):
            return "collision"
        return "time_limit" if tick >= self._last_tick else None
