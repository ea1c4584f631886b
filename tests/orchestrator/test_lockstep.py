"""The lockstep with inline components: who sees which tick. One tiny topology per test."""

import pytest

from crowdcosim import Evaluator, Mover, Sensor, Setup
from crowdcosim.cdr import decode
from crowdcosim.component import ports_of
from crowdcosim.host import ComponentHost
from crowdcosim.messages import Goal, Metrics, RobotState, Twist, Vector3
from crowdcosim.world import World
from orchestrator.errors import RunError
from orchestrator.lockstep import Committed, Lockstep
from orchestrator.wiring import Graph, Member, connect

PERIOD = 100


class Counter(Mover):
    """Its state is the number of steps it has made."""

    def reset(self, setup: Setup) -> RobotState:
        self.stride = setup.period // PERIOD
        self.count = 0
        return RobotState(heading=0.0)

    def step(self) -> RobotState:
        self.count += self.stride
        return RobotState(heading=float(self.count))


class Echo(Sensor):
    """Says what it sees."""

    def step(self, state: RobotState) -> Twist:
        return Twist(linear=Vector3(x=state.heading))


class Listener(Evaluator):
    """Remembers what it saw."""

    def reset(self, setup: Setup) -> None:
        self.seen: list[tuple[float, float]] = []

    def step(self, state: RobotState, twist: Twist) -> None:
        self.seen.append((state.heading, twist.linear.x))

    def finish(self) -> Metrics:
        return Metrics()


def assemble(**components) -> tuple[Graph, dict[str, ComponentHost], Lockstep, list[list[Committed]]]:
    """name=(component, every)"""
    members = tuple(
        Member(name=name, robot=None, every=every, ports=ports_of(type(c))) for name, (c, every) in components.items()
    )
    graph = connect(members)
    hosts = {
        name: ComponentHost(
            c,
            every=every,
            wiring=graph.sources[name],
            setup=Setup(component=name, period=PERIOD * every, seed=1, world=World(size=(1, 1))),
        )
        for name, (c, every) in components.items()
    }
    lockstep = Lockstep(graph, period=PERIOD, constants={}, inline=hosts, remote=None, trusted=frozenset(hosts))
    log: list[list[Committed]] = []
    lockstep.commit = log.append
    return graph, hosts, lockstep, log


def run(lockstep: Lockstep, ticks: int) -> None:
    lockstep.reset(alone=False, reference=None)
    for tick in range(ticks):
        lockstep.step(tick)
    lockstep.finish(ticks)


def test_a_sensor_sees_the_state_of_its_own_tick_and_the_judge_the_last_one_too() -> None:
    """counter => echo -> listener; counter => listener"""
    listener = Listener()
    _, _, lockstep, _ = assemble(counter=(Counter(), 1), echo=(Echo(), 1), listener=(listener, 1))
    run(lockstep, 3)
    assert listener.seen == [(0, 0), (1, 1), (2, 2), (3, 2)]


def test_the_order_in_the_file_does_not_matter() -> None:
    """listener and echo before the counter"""
    listener = Listener()
    _, _, lockstep, _ = assemble(listener=(listener, 1), echo=(Echo(), 1), counter=(Counter(), 1))
    run(lockstep, 3)
    assert listener.seen == [(0, 0), (1, 1), (2, 2), (3, 2)]


def test_a_slow_sensor_holds_its_last_output() -> None:
    """counter => echo(every 2) -> listener"""
    listener = Listener()
    _, _, lockstep, _ = assemble(counter=(Counter(), 1), echo=(Echo(), 2), listener=(listener, 1))
    run(lockstep, 5)
    assert listener.seen == [(0, 0), (1, 0), (2, 2), (3, 2), (4, 4), (5, 4)]


def test_a_slow_mover_is_seen_as_it_was_until_its_step_is_over() -> None:
    """counter(every 3) => echo"""
    listener = Listener()
    _, _, lockstep, _ = assemble(counter=(Counter(), 3), echo=(Echo(), 1), listener=(listener, 1))
    run(lockstep, 6)
    assert [state for state, _ in listener.seen] == [0, 0, 0, 3, 3, 3, 6]


def test_a_slow_judge_sees_every_nth_state() -> None:
    """counter => listener(every 2)"""
    listener = Listener()
    _, _, lockstep, _ = assemble(counter=(Counter(), 1), echo=(Echo(), 1), listener=(listener, 2))
    run(lockstep, 5)
    assert [state for state, _ in listener.seen] == [0, 2, 4]


def test_what_is_committed_comes_in_the_scenarios_order_with_the_time_it_holds() -> None:
    """echo before counter in the file: observations of k, then the state k + 1"""
    _, _, lockstep, log = assemble(echo=(Echo(), 1), counter=(Counter(), 1))
    lockstep.reset(alone=False, reference=None)
    lockstep.step(0)
    lockstep.step(1)
    assert [[(c.component, c.time) for c in batch] for batch in log] == [
        [("counter", 0)],
        [("echo", 0), ("counter", PERIOD)],
        [("echo", PERIOD), ("counter", 2 * PERIOD)],
    ]
    assert decode(log[2][1].payload, RobotState.TYPE).heading == 2.0


def test_a_second_episode_begins_anew() -> None:
    listener = Listener()
    _, _, lockstep, log = assemble(counter=(Counter(), 1), echo=(Echo(), 1), listener=(listener, 1))
    run(lockstep, 4)
    first, log[:] = list(log), []
    run(lockstep, 4)
    assert log == first


def test_what_a_component_raises_names_it_its_tick_and_its_line() -> None:
    class Faulty(Echo):
        def step(self, state: RobotState) -> Twist:
            return Twist(linear=Vector3(x=1 / (2 - state.heading)))

    _, _, lockstep, _ = assemble(counter=(Counter(), 1), echo=(Faulty(), 1))
    with pytest.raises(RunError, match=r"component 'echo' at tick 2: ZeroDivisionError.*test_lockstep.py:\d+ in step"):
        run(lockstep, 5)


def test_what_is_not_finite_is_never_committed() -> None:
    class Faulty(Echo):
        def step(self, state: RobotState) -> Twist:
            return Twist(linear=Vector3(x=float("nan") if state.heading == 1 else 0.0))

    _, _, lockstep, log = assemble(counter=(Counter(), 1), echo=(Faulty(), 1))
    with pytest.raises(RunError, match="component 'echo' at tick 1: Twist.linear.x is nan"):
        run(lockstep, 5)
    assert len(log) == 2


def test_a_mover_must_say_its_state_at_the_start() -> None:
    class Mute(Counter):
        def reset(self, setup: Setup) -> None:  # type: ignore[override]
            self.count, self.stride = 0, 1

    _, _, lockstep, _ = assemble(counter=(Mute(), 1))
    with pytest.raises(RunError, match="component 'counter': returned 0 messages where its signature promises 1"):
        run(lockstep, 1)


def test_constants_are_read_at_every_tick() -> None:
    """goal (said once) -> reader"""

    class Reader(Sensor):
        def step(self, goal: Goal) -> Twist:
            return Twist(linear=Vector3(x=goal.tolerance))

    from crowdcosim.component import Output, Ports

    goal = Member(
        name="r/goal",
        robot=None,
        every=0,
        ports=Ports(kind="reactor", inputs=(), outputs=(Output(name="goal", type=Goal),)),
    )
    reader = Member(name="reader", robot=None, every=1, ports=ports_of(Reader))
    graph = connect((goal, reader))
    setup = Setup(component="reader", period=PERIOD, seed=1, world=World(size=(1, 1)))
    host = ComponentHost(Reader(), every=1, wiring=graph.sources["reader"], setup=setup)
    lockstep = Lockstep(
        graph,
        period=PERIOD,
        constants={("r/goal", "goal"): Goal(tolerance=0.25)},
        inline={"reader": host},
        remote=None,
        trusted=frozenset({"reader"}),
    )
    lockstep.reset(alone=False, reference=None)
    for tick in range(3):
        lockstep.step(tick)
        assert lockstep.latest("reader", "twist", tick).linear.x == 0.25
