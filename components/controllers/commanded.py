"""Drive as somebody else says: the controller of robots that a `Session` commands, tick by tick."""

from __future__ import annotations

from crowdcosim import Controller, Setup
from crowdcosim.messages import Twist


class Commanded(Controller):
    """Passes on what it was given in `command`; reads nothing."""

    command: Twist | None = None

    def reset(self, setup: Setup) -> None:
        self.command = None

    def step(self) -> Twist:
        """The command. Raises ValueError if there has been none in this episode."""
        if self.command is None:
            raise ValueError("nobody has given a command: this controller is for robots that a Session commands")
        return self.command
