"""The programme of the MPC: its model, its cost, its derivatives, and what its solvers make of it."""

from __future__ import annotations

import math

import casadi
import numpy as np
import pytest

from components.controllers.differential import Limits
from components.controllers.ego import Ego
from components.controllers.optimal_control import (
    IDLE,
    OMEGA,
    THETA,
    A,
    OptimalControl,
    Shape,
    V,
    Weights,
    X,
    Y,
    programme_of,
)
from components.controllers.prediction import Tracks
from components.controllers.starting_plans import (
    Scales,
    choose_discs,
    choose_planes,
    cost,
    turn_and_go,
)

SHAPE = Shape(stages=20, dt=0.2, discs=4, walls=2)
LIMITS = Limits(-0.2, 1.0, 5.0, math.pi, 10.0)
WEIGHTS = Weights()
OPEN = np.array([-np.inf, -np.inf, np.inf, np.inf])
EGO = Ego(12.0, 5.0, 0.3, 0.6, -0.4)


@pytest.fixture(scope="module")
def control() -> OptimalControl:
    return OptimalControl(SHAPE, LIMITS, WEIGHTS)


@pytest.fixture(scope="module")
def symbols() -> dict[str, casadi.Function]:
    programme, _ = programme_of(SHAPE, WEIGHTS)
    x, p, f, g = (programme[name] for name in "xpfg")
    return {
        "cost": casadi.Function("cost", [x, p], [f]),
        "slope": casadi.Function("slope", [x, p], [casadi.gradient(f, x)]),
        "constraints": casadi.Function("constraints", [x, p], [g]),
    }


def scales_of(control, bearing=0.0, segments=()) -> Scales:
    task = control.task
    task.way[:] = math.cos(bearing), math.sin(bearing)
    task.reference[:] = 0.2 * np.arange(21)
    return Scales(
        task.way,
        task.reference,
        OPEN.copy(),
        np.array(segments, np.float64).reshape(-1, 2, 2),
        0.2,
        SHAPE,
        LIMITS,
        WEIGHTS,
    )


def tracks(position, velocity, radius) -> Tracks:
    """People at constant velocity."""
    times = SHAPE.dt * np.arange(SHAPE.stages + 1)
    return Tracks(position + times[:, None, None] * velocity, radius)


def people(rng) -> Tracks:
    return tracks(rng.uniform(-3.0, 3.0, (4, 2)), rng.normal(0.0, 0.3, (4, 2)), rng.uniform(0.4, 0.7, 4))


def posed(control, seed) -> tuple[Tracks, Scales]:
    """A problem with people and two walls, written into `control`, with a candidate as guess."""
    rng = np.random.default_rng(seed)
    near = people(rng)
    scales = scales_of(control, rng.uniform(-3, 3), [[(-9.0, 2.5), (9.0, 3.0)], [(4.0, -9.0), (4.5, -1.0)]])
    ego = EGO._replace(heading=rng.uniform(-3, 3), speed=rng.uniform(-0.2, 1), turn_rate=rng.uniform(-3, 3))
    control.task.start[:] = ego[2:]
    turn_and_go(ego, rng.uniform(-3, 3), rng.uniform(0, 1), scales, control.guess)
    choose_discs(control.guess, near, SHAPE.dt, control.task.radius, control.task.disc)
    choose_planes(control.guess, scales, control.task.plane)
    return near, scales


def given(control) -> tuple[np.ndarray, np.ndarray]:
    return variables(control.guess), control._parameters.copy()


def variables(plan) -> np.ndarray:
    """A plan as the programme's vector, with inputs that do nothing."""
    return np.pad(plan, [(0, 0), (0, IDLE)]).reshape(-1)[: -2 - IDLE]


@pytest.mark.parametrize("seed", range(10))
def test_candidates_obey_the_programmes_dynamics(control, symbols, seed):
    posed(control, seed)
    # The same formula in two languages: equal but for rounding.
    np.testing.assert_allclose(symbols["constraints"](*given(control)), 0.0, atol=1e-14)


@pytest.mark.parametrize("seed", range(10))
def test_candidates_are_charged_the_programmes_cost(control, symbols, seed):
    near, scales = posed(control, seed)
    scales = scales._replace(segments=np.empty((0, 2, 2)))
    control.task.plane[:, :, :2], control.task.plane[:, :, 2] = 0.0, -1e3
    charged = cost(control.guess, near, scales, np.inf)
    # What is negligible is left out: less than 1e-4 of a touch per person, over 4 s.
    assert float(symbols["cost"](*given(control))) == pytest.approx(charged, abs=4 * 4 * WEIGHTS.proximity * 1e-4)


def test_a_wall_beside_a_stage_is_charged_the_same(control, symbols):
    scales = scales_of(control, 0.0, [[(-9.0, 0.35), (9.0, 0.35)]])
    nobody = tracks(np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    control.task.start[:] = 0.0, 1.0, 0.0
    turn_and_go(Ego(0.0, 0.0, 0.0, 1.0, 0.0), 0.0, 1.0, scales, control.guess)
    choose_discs(control.guess, nobody, SHAPE.dt, control.task.radius, control.task.disc)
    choose_planes(control.guess, scales, control.task.plane)
    # 20 stages at 0.15 m from where the wall would be touched, no lag, no effort.
    expected = 4.0 * WEIGHTS.proximity * math.exp(-WEIGHTS.wall_steepness * 0.15)
    assert cost(control.guess, nobody, scales, np.inf) == pytest.approx(expected, rel=1e-12)
    assert float(symbols["cost"](*given(control))) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(5))
def test_its_derivatives_are_those_of_its_cost(control, symbols, seed):
    posed(control, seed)
    x, p = given(control)
    exact = np.array(symbols["slope"](x, p)).ravel()
    step = 1e-5
    for i in range(0, len(x), 3):
        shift = np.zeros(len(x))
        shift[i] = step
        rise = float(symbols["cost"](x + shift, p)) - float(symbols["cost"](x - shift, p))
        # Central differences are off by a third derivative, at most about S_w^3 of the cost, times step^2 / 6.
        assert rise / (2 * step) == pytest.approx(exact[i], rel=1e-5, abs=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_a_plan_obeys_dynamics_and_limits_and_is_no_worse_than_its_start(control, symbols, seed):
    posed(control, seed)
    before = float(symbols["cost"](*given(control)))
    plan = control.solve(OPEN)
    assert plan is not None
    x, p = variables(plan), control._parameters
    np.testing.assert_allclose(symbols["constraints"](x, p), 0.0, atol=1e-3)  # the solver's tolerance
    assert float(symbols["cost"](x, p)) <= before + 1e-6
    lowest, highest = (-0.2, -math.pi, -5.0, -10.0), (1.02, math.pi, 5.0, 10.0)
    assert (plan[1:, V:] >= np.array(lowest) - 1e-6).all()
    assert (plan[1:, V:] <= np.array(highest) + 1e-6).all()
    np.testing.assert_allclose(plan[0, THETA:A], control.task.start, atol=1e-3)


@pytest.mark.parametrize("seed", range(10))
def test_the_fallback_finds_the_same_plan(control, seed):
    posed(control, seed)
    plans = []
    for solver in control._solvers:
        control.solve(OPEN)  # sets the bounds
        assert solver.run()
        plans.append(solver.plan.copy())
    # From one start they may end on two sides of somebody; where they do not, they differ by their tolerance.
    if np.abs(plans[0] - plans[1])[:, :2].max() < 0.2:
        np.testing.assert_allclose(plans[0][:, :2], plans[1][:, :2], atol=0.05)
    assert np.isfinite(plans).all()


def test_no_plan_leaves_the_box(control):
    posed(control, 1)
    scales = scales_of(control, math.pi / 2)
    control.task.start[:] = 0.2, 1.0, 0.0
    turn_and_go(Ego(0.0, 0.0, 0.2, 1.0, 0.0), 0.0, 1.0, scales, control.guess)
    plan = control.solve(np.array([-np.inf, -0.1, np.inf, 0.5]))
    assert plan is not None
    assert plan[1:, Y].min() >= -0.1 - 1e-6
    assert 0.4 < plan[1:, Y].max() <= 0.5 + 1e-6


def test_without_anybody_the_plan_is_the_reference(control):
    scales = scales_of(control)
    nobody = tracks(np.empty((0, 2)), np.empty((0, 2)), np.empty(0))
    control.task.start[:] = 0.0, 1.0, 0.0
    turn_and_go(Ego(0.0, 0.0, 0.0, 1.0, 0.0), 0.5, 0.5, scales, control.guess)
    choose_discs(control.guess, nobody, SHAPE.dt, control.task.radius, control.task.disc)
    choose_planes(control.guess, scales, control.task.plane)
    plan = control.solve(OPEN)
    assert plan is not None
    # An interior point stops before it is at its optimum, here by 2 % of the speed at most.
    np.testing.assert_allclose(plan[:, X], scales.reference, atol=0.08)
    np.testing.assert_allclose(plan[:, [Y, THETA, OMEGA]], 0.0, atol=0.02)


@pytest.mark.parametrize("what", ["guess", "start", "disc", "plane", "radius"])
@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_a_solver_never_sees_what_is_not_finite(control, what, value):
    posed(control, 2)
    array = control.guess if what == "guess" else getattr(control.task, what)
    array.reshape(-1)[0] = value
    assert control.solve(OPEN) is None
    posed(control, 2)
    assert control.solve(OPEN) is not None


def test_where_there_is_no_plan_it_says_so_in_bounded_time(control):
    posed(control, 3)
    assert control.solve(np.array([30.0, -1.0, 31.0, 1.0])) is None


def test_a_solution_depends_on_its_task_alone(control):
    def solved(seed, by):
        posed(by, seed)
        plan = by.solve(OPEN)
        assert plan is not None
        return plan.tobytes()

    first = [solved(seed, control) for seed in range(8)]
    control.solve(np.array([30.0, -1.0, 31.0, 1.0]))
    assert [solved(seed, control) for seed in range(8)] == first
    fresh = OptimalControl(SHAPE, LIMITS, WEIGHTS)
    assert [solved(seed, fresh) for seed in reversed(range(8))] == first[::-1]
