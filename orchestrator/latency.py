"""The command that is in effect while a robot lives with the time that its controller takes.

A decision of tick k, made from what was sensed at t_k, takes effect at t_k + latency; until the first one does, the
robot is told to stand still. A command is given for a whole step, so what the drive gets is the mean over the step's
time of the commands that are in effect in it.

With a fixed latency, each decision takes effect, one after the other: a dead time, as of a slow link. With a measured
one, the controller is busy for as long as it computed: a decision that it would have had to begin before it was done
with the one before is not carried out.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import astuple, replace

from crowdcosim.component import Controller, ports_of
from crowdcosim.messages import Twist, Vector3
from crowdcosim.setup import Setup
from orchestrator.scenario.component_specs import ComponentSpec
from orchestrator.scenario.problems import ScenarioError
from orchestrator.wiring import Graph, Member, Reference


class CommandInEffect(Controller):
    """Stands between a controller and its robot's drive."""

    def __init__(self, latency: int | Callable[[], int], *, period: int, every: int) -> None:
        """`latency` [ns], or what tells that of the newest decision; `period` [ns] of a tick; a decision `every` n."""
        self._latency = latency
        self._period = period
        self._every = every

    def reset(self, setup: Setup) -> None:
        self._tick = 0
        self._busy_until = 0
        self._now = Twist()
        self._to_come: deque[tuple[int, Twist]] = deque()

    def step(self, twist: Twist) -> Twist:
        """The mean command of this tick's step."""
        begin = self._tick * self._period
        if self._tick % self._every == 0:
            self._take(twist, begin)
        self._tick += 1
        return self._mean(begin, begin + self._period)

    def _take(self, decision: Twist, begin: int) -> None:
        if isinstance(self._latency, int):
            self._to_come.append((begin + self._latency, decision))
        elif begin >= self._busy_until:
            self._busy_until = begin + self._latency()
            self._to_come.append((self._busy_until, decision))

    def _mean(self, begin: int, end: int) -> Twist:
        shares: list[tuple[float, Twist]] = []
        since = begin
        while self._to_come and self._to_come[0][0] < end:
            when, twist = self._to_come.popleft()
            if when > since:
                shares.append(((when - since) / self._period, self._now))
            since, self._now = when, twist
        if not shares:  # one command for all of the step, to the last bit
            return self._now
        shares.append(((end - since) / self._period, self._now))
        return Twist(
            linear=_mean([(share, twist.linear) for share, twist in shares]),
            angular=_mean([(share, twist.angular) for share, twist in shares]),
        )


def command_of(controller: ComponentSpec) -> str:
    """The name of what stands between a controller with a latency and its robot's drive."""
    return f"{controller.robot}/command"


def with_commands(members: Sequence[Member], late: Sequence[ComponentSpec], graph: Graph) -> list[Member]:
    """The members of a graph, with a command in effect between each controller that is `late` and its robot's drive.

    Raises:
        ScenarioError: if a drive takes no Twist from such a controller.
    """
    result = {member.name: member for member in members}
    for controller in late:
        assert controller.robot is not None, "only robots have controllers"
        drive = result[controller.robot]
        types = {port.name: port.type for port in drive.ports.inputs}
        taken = {
            port: source.port
            for port, sources in graph.sources[drive.name].items()
            for source in sources
            if types[port] is Twist and source.component == controller.name
        }
        if not taken:
            text = "the drive takes no Twist from this controller, so none can come late; leave it out"
            raise ScenarioError([controller.problem(text, "latency")])
        command = command_of(controller)
        result[command] = Member(
            name=command,
            robot=controller.robot,
            every=1,
            ports=ports_of(CommandInEffect),
            inputs={"twist": Reference(controller.name, next(iter(taken.values())))},
        )
        inputs = {**drive.inputs, **dict.fromkeys(taken, Reference(command, "twist"))}
        result[drive.name] = replace(drive, inputs=inputs)
    return list(result.values())


def _mean(shares: list[tuple[float, Vector3]]) -> Vector3:
    x, y, z = (sum(share * astuple(vector)[i] for share, vector in shares) for i in range(3))
    return Vector3(x=x, y=y, z=z)
