"""A policy from an ONNX file: what it is fed, what becomes of its answer, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import onnx
import pytest
from onnx import TensorProto, helper, numpy_helper

from components.controllers.onnx_policy import OnnxPolicy
from crowdcosim.component import make
from crowdcosim.messages import LaserScan

OBSERVATION = [{"part": "goal"}, {"part": "velocity"}, {"part": "people", "count": 2}]


def linear(path, weights, shape=None, kind=TensorProto.FLOAT, name="observation"):
    """A file with the policy y = W x."""
    weights = np.asarray(weights, np.float64 if kind == TensorProto.DOUBLE else np.float32)
    inputs = [helper.make_tensor_value_info(name, kind, shape or ["batch", weights.shape[1]])]
    outputs = [helper.make_tensor_value_info("action", kind, ["batch", len(weights)])]
    nodes = [
        helper.make_node("Reshape", [name, "flat"], ["x"]),
        helper.make_node("MatMul", ["x", "W"], ["action"]),
    ]
    constants = [
        numpy_helper.from_array(np.array([1, -1], np.int64), "flat"),
        numpy_helper.from_array(np.ascontiguousarray(weights.T), "W"),
    ]
    graph = helper.make_graph(nodes, "policy", inputs, outputs, constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model)
    onnx.save(model, path)
    return str(path)


def policy(scene, model, parts=OBSERVATION, **options):
    controller = make(OnnxPolicy, {"model": model, "observation": {"observation": parts}} | options)
    controller.reset(scene.setup())
    return controller


def answer(controller, odometry, goal, crowd, **given):
    twist = controller.step(odometry=odometry, goal=goal, crowd=crowd, others=(), **given)
    return twist.linear.x, twist.angular.z


def pick(size, first, second):
    """A policy that answers with two of the numbers that it sees."""
    weights = np.zeros((2, size))
    weights[0, first] = weights[1, second] = 1.0
    return weights


@pytest.mark.parametrize("kind", [TensorProto.FLOAT, TensorProto.DOUBLE])
def test_it_is_fed_what_is_declared_in_the_robots_frame(scene, tmp_path, kind):
    theta = 0.5
    odometry = scene.odometry(20.0, 9.5, theta, 0.6, -0.2)
    # The nearer one is seen across the seam.
    crowd = scene.crowd((23.0, 9.0), (21.0, 0.2), velocity=[(1.0, 0.0), (0.0, -0.5)])
    turn = np.array([[math.cos(theta), math.sin(theta)], [-math.sin(theta), math.cos(theta)]])
    expected = np.concatenate(
        [
            turn @ [4.0, -2.0],
            [0.6, -0.2],
            turn @ [1.0, 0.7],
            turn @ [0.0, -0.5],
            [0.3],
            turn @ [3.0, -0.5],
            turn @ [1.0, 0.0],
            [0.3],
        ]
    )
    for i in range(0, 14, 2):
        model = linear(tmp_path / f"{i}.onnx", pick(14, i, i + 1), kind=kind)
        found = answer(policy(scene, model), odometry, scene.disc(24.0, 7.5), crowd)
        # Single precision: seven digits.
        assert found == pytest.approx(tuple(expected[i : i + 2]), abs=1e-6)


def test_fewer_people_than_it_wants_are_filled_with_zeros_and_far_goals_are_pulled_in(scene, tmp_path):
    model = linear(tmp_path / "p.onnx", pick(14, 0, 9))
    assert answer(policy(scene, model), scene.odometry(20.0, 5.0), scene.line(), scene.crowd((21.0, 5.0))) == (
        10.0,
        0.0,
    )


def test_a_scan_is_the_least_of_groups_of_beams(scene, tmp_path):
    ranges = np.full(8, np.inf, np.float32)
    ranges[[0, 3, 6]] = 4.0, 2.0, -np.inf
    scan = LaserScan(range_min=0.1, range_max=8.0, ranges=ranges)
    parts = [{"part": "scan", "beams": 4, "range": 6.0}]
    for (i, j), expected in {(0, 1): (4.0, 2.0), (2, 3): (6.0, 0.1)}.items():
        controller = policy(scene, linear(tmp_path / f"{i}.onnx", pick(4, i, j)), parts)
        found = answer(controller, scene.odometry(20.0, 5.0), scene.line(), scene.crowd(), scan=scan)
        assert found == pytest.approx(expected)
    with pytest.raises(ValueError, match="'scan' is not connected"):
        answer(controller, scene.odometry(20.0, 5.0), scene.line(), scene.crowd())
    with pytest.raises(ValueError, match="has 8 beams, expected a multiple of beams"):
        uneven = policy(scene, linear(tmp_path / "u.onnx", pick(3, 0, 1)), [{"part": "scan", "beams": 3}])
        answer(uneven, scene.odometry(20.0, 5.0), scene.line(), scene.crowd(), scan=scan)


def test_unit_actions_span_the_robots_limits(scene, tmp_path):
    parts = [{"part": "velocity"}]
    controller = policy(scene, linear(tmp_path / "p.onnx", np.eye(2)), parts, action="unit")
    for (v, omega), expected in {(-1, -1): (-0.2, -math.pi), (0, 0): (0.4, 0.0), (3, 1): (1.0, math.pi)}.items():
        found = answer(controller, scene.odometry(20.0, 5.0, 0.0, v, omega), scene.line(), scene.crowd())
        assert found == pytest.approx(expected, abs=1e-6)


def test_it_rests_at_the_goal_and_says_the_same_every_time(scene, tmp_path):
    model = linear(tmp_path / "p.onnx", np.random.default_rng(1).normal(0, 0.1, (2, 14)))
    crowd = scene.random_crowd(1, 50)
    first, second = policy(scene, model), policy(scene, model)
    given = (scene.odometry(20.0, 5.0, 0.3, 0.5), scene.line(), crowd)
    assert answer(first, *given) == answer(second, *given) == answer(first, *given)
    assert answer(first, scene.odometry(20.0, 5.0), scene.disc(20.1, 5.0), crowd) == (0.0, 0.0)


def test_a_shape_of_several_dimensions_is_filled_in_order(scene, tmp_path):
    weights = pick(10, 5, 6)
    model = linear(tmp_path / "p.onnx", weights, shape=[1, 2, 5])
    controller = policy(scene, model, [{"part": "people", "count": 2}])
    found = answer(controller, scene.odometry(20.0, 5.0), scene.line(), scene.crowd((22.0, 6.0), (21.0, 5.0)))
    assert found == pytest.approx((2.0, 1.0))


def test_what_does_not_fit_the_model_is_named(scene, tmp_path):
    model = linear(tmp_path / "p.onnx", pick(14, 0, 1))
    with pytest.raises(ValueError, match=r"14 numbers, but observation fills it with goal 2 \+ velocity 2 = 4"):
        policy(scene, model, OBSERVATION[:2])
    with pytest.raises(ValueError, match="observation fills 'observation', but the inputs of .* are 'state'"):
        policy(scene, linear(tmp_path / "q.onnx", pick(14, 0, 1), name="state"))
    with pytest.raises(ValueError, match="output is 'command', expected one of those of .*: 'action'"):
        policy(scene, model, output="command")
    with pytest.raises(ValueError, match="is a tensor.int64., expected one of"):
        path = tmp_path / "i.onnx"
        info = [helper.make_tensor_value_info(n, TensorProto.INT64, [1, 14]) for n in ("observation", "action")]
        graph = helper.make_graph([helper.make_node("Identity", ["observation"], ["action"])], "g", info[:1], info[1:])
        onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8), path)
        policy(scene, str(path))


def test_an_answer_that_is_no_command_is_refused(scene, tmp_path):
    state = (scene.odometry(20.0, 5.0, 0.0, 0.5), scene.line(), scene.crowd())
    with pytest.raises(ValueError, match=r"output 'action' is \[0.5, 0.0, 0.5\], expected two finite numbers"):
        three = linear(tmp_path / "3.onnx", [[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
        answer(policy(scene, three, [{"part": "velocity"}]), *state)
    with pytest.raises(ValueError, match="nan"):
        nan = linear(tmp_path / "n.onnx", np.full((2, 2), np.nan))
        answer(policy(scene, nan, [{"part": "velocity"}]), *state)


def test_a_file_that_is_missing_or_no_model_is_refused(scene, tmp_path):
    with pytest.raises(ValueError, match="there is no such file"):
        policy(scene, str(tmp_path / "none.onnx"))
    (tmp_path / "bad.onnx").write_text("bad")
    with pytest.raises(ValueError, match="which onnxruntime cannot load"):
        policy(scene, str(tmp_path / "bad.onnx"))
