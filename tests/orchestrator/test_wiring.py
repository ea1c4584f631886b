"""One tiny topology per test, in its docstring: `A -> B` is an edge within a tick, `A => B` into the next."""

import pytest

from crowdcosim.component import Input, Output, Ports
from crowdcosim.messages import Crowd, LaserScan, Odometry, RobotState, Twist
from orchestrator.errors import WiringError
from orchestrator.wiring import Member, Reference, connect


def member(name, inputs=None, outputs=None, *, kind="reactor", robot=None, every=1, explicit=None) -> Member:
    return Member(
        name=name,
        robot=robot,
        every=every,
        ports=Ports(
            kind=kind,
            inputs=tuple(i if isinstance(i, Input) else Input(name=i[0], type=i[1]) for i in inputs or ()),
            outputs=tuple(Output(name=n, type=t) for n, t in (outputs or {}).items()),
        ),
        inputs=explicit or {},
    )


def sources(graph, component, port) -> list[str]:
    return [f"{s.component}.{s.port}" for s in graph.sources[component][port]]


CROWD = member("crowd", [], {"crowd": Crowd}, kind="mover")


def robot(name: str, *sensors: Member) -> list[Member]:
    return [
        member(name, [("twist", Twist)], {"state": RobotState}, kind="mover", robot=name),
        member(f"{name}/odometry", [("robot", RobotState)], {"odometry": Odometry}, robot=name),
        *sensors,
        member(f"{name}/controller", [("odometry", Odometry)], {"twist": Twist}, robot=name),
    ]


def test_a_robot_is_wired_to_itself() -> None:
    """body => odometry -> controller -> body"""
    graph = connect((CROWD, *robot("a"), *robot("b")))
    assert sources(graph, "b/odometry", "robot") == ["b.state"]
    assert sources(graph, "b/controller", "odometry") == ["b/odometry.odometry"]
    assert sources(graph, "b", "twist") == ["b/controller.twist"]


def test_everybody_comes_after_what_he_reads_in_the_same_tick() -> None:
    """controller before odometry in the file; odometry -> controller"""
    graph = connect((CROWD, *reversed(robot("a"))))
    assert graph.order.index("a/odometry") < graph.order.index("a/controller") < graph.order.index("a")


def test_many_takes_all_of_a_type_in_the_scenarios_order() -> None:
    """a, b => crowd"""
    crowd = member("crowd", [Input(name="robots", type=RobotState, many=True)], {"crowd": Crowd}, kind="mover")
    graph = connect((crowd, *robot("b"), *robot("a")))
    assert sources(graph, "crowd", "robots") == ["b.state", "a.state"]


def test_the_others_of_a_robots_sensor_are_not_its_own_body() -> None:
    """b => a/lidar"""
    others = [Input(name="others", type=RobotState, many=True)]
    lidar = member("a/lidar", others, {"scan": LaserScan}, robot="a")
    body = member("c", others, {"state": RobotState}, kind="mover", robot="c")
    graph = connect((CROWD, *robot("a", lidar), *robot("b"), body))
    assert sources(graph, "a/lidar", "others") == ["b.state", "c.state"]
    assert sources(graph, "c", "others") == ["a.state", "b.state"]


def test_of_two_sources_the_one_that_bears_the_ports_name_is_meant() -> None:
    """front -> planner(front), back"""
    front = member("a/front", [], {"scan": LaserScan}, robot="a")
    back = member("a/back", [], {"scan": LaserScan}, robot="a")
    planner = member("a/planner", [("front", LaserScan)], {"twist": Twist}, robot="a")
    assert sources(connect((front, back, planner)), "a/planner", "front") == ["a/front.scan"]


def test_two_sources_are_refused_until_one_is_chosen() -> None:
    """front, back -> planner(scan)"""
    front = member("a/front", [], {"scan": LaserScan}, robot="a")
    back = member("a/back", [], {"scan": LaserScan}, robot="a")
    scan = [Input(name="view", type=LaserScan)]
    with pytest.raises(WiringError, match=r"several sources: a/front.scan, a/back.scan; choose one"):
        connect((front, back, member("a/planner", scan, {"twist": Twist}, robot="a")))
    chosen = member("a/planner", scan, {"twist": Twist}, robot="a", explicit={"view": Reference("a/back")})
    assert sources(connect((front, back, chosen)), "a/planner", "view") == ["a/back.scan"]


def test_an_unconnected_input_is_refused_unless_it_is_optional() -> None:
    """nothing -> lidar(crowd)"""
    with pytest.raises(WiringError, match="component 'lidar': input 'crowd' is not connected.*Crowd"):
        connect((member("lidar", [("crowd", Crowd)], {"scan": LaserScan}),))
    optional = member("lidar", [Input(name="crowd", type=Crowd, optional=True)], {"scan": LaserScan})
    assert sources(connect((optional,)), "lidar", "crowd") == []


def test_a_loop_within_a_tick_is_refused_and_named() -> None:
    """a -> b -> a"""
    a = member("a", [("scan", LaserScan)], {"twist": Twist})
    b = member("b", [("twist", Twist)], {"scan": LaserScan})
    with pytest.raises(WiringError, match=r"loop within one tick: (a <- b <- a|b <- a <- b)"):
        connect((a, b))


def test_a_loop_through_a_mover_is_none() -> None:
    """a -> b => a"""
    a = member("a", [("state", RobotState)], {"twist": Twist})
    b = member("b", [("twist", Twist)], {"state": RobotState}, kind="mover")
    assert connect((a, b)).order == ("a", "b")


@pytest.mark.parametrize(
    ("reference", "words"),
    [
        (Reference("nobody"), "there is no component 'nobody'"),
        (Reference("crowd", "people"), "no output 'people'; it has crowd"),
        (Reference("crowd", "crowd"), "it is a Crowd, expected a Twist"),
        (Reference("crowd"), "0 outputs of type Twist"),
    ],
)
def test_an_explicit_connection_that_does_not_fit_is_refused(reference, words) -> None:
    """crowd -> body(twist)"""
    body = member("body", [("twist", Twist)], {"state": RobotState}, kind="mover", explicit={"twist": reference})
    with pytest.raises(WiringError, match=words):
        connect((CROWD, body))


def test_a_connection_of_a_port_that_is_not_there_is_refused() -> None:
    """crowd -> lidar(people)"""
    lidar = member("lidar", [("crowd", Crowd)], {"scan": LaserScan}, explicit={"people": Reference("crowd")})
    with pytest.raises(WiringError, match="no input 'people'.*crowd"):
        connect((CROWD, lidar))


def test_all_problems_are_told_at_once() -> None:
    with pytest.raises(WiringError) as error:
        connect((member("x", [("crowd", Crowd)]), member("y", [("odometry", Odometry)])))
    assert [component for component, _ in error.value.problems] == ["x", "y"]
