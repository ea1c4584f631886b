"""The nonlinear programme of the model predictive controller, and its solvers.

    minimise  sum_k dt (Q_x e_x^2 + Q_y e_y^2 + Q_omega omega^2 + R_a a^2 + R_alpha alpha^2 + soft_k)
    soft_k    P sum_j exp(-S h_jk) + P sum_i exp(-S_w g_ik),  h = (d^2 - R^2) / (2 R),  g = n . p - b
    s. t.     z_0 = start,  z_k+1 = z_k + dt f(z_k + dt/2 f(z_k, u_k), u_k),  f = (v cos theta, v sin theta, omega, u)
              x, y, v, omega within bounds for k >= 1, a and alpha for k >= 0

with z = (x, y, theta, v, omega), u = (a, alpha), e the lag behind and the offset from a reference that moves on a
straight line, d the distance to the centre of disc j at stage k, and n . p >= b the half-plane of wall i at stage k.
Positions are relative to the robot's at stage 0.

Solved with fatrop (Vanroye, Sathya, De Schutter, Decré, "FATROP: a fast constrained optimal control problem solver for
robot trajectory optimization and control", IROS 2023), which exploits the order z_0, u_0, z_1, ...; where it fails with
IPOPT (Wächter, Biegler, Mathematical Programming 106, 2006). Both come with CasADi (Andersson et al., Mathematical
Programming Computation 11, 2019). Iterations are bounded, time is not: the answer never depends on the machine's speed.
"""

from __future__ import annotations

from functools import lru_cache
from itertools import chain, pairwise
from typing import Any, NamedTuple

import casadi
import numpy as np
from numpy.typing import NDArray

from components.controllers.differential import Limits

Array = NDArray[np.float64]

X, Y, THETA, V, OMEGA, A, ALPHA = range(7)
"""columns of a plan"""

FAR = 1e3
"""where those are who are not there, and the bounds of an open world: their cost is zero, and so is its slope [m]"""
ROOM = 1.02
"""by how much a plan may be faster than the robot: interior points stay off bounds, and a robot should reach its own"""
IDLE = 2
"""inputs that do nothing, so that a stage has four. With two alone, fatrop 1.1.8 reads beyond the end of its arrays
while it restores feasibility, which can crash a process (github.com/meco-group/fatrop/pull/51 mends a similar read)."""
WIDTH = 7 + IDLE
"""variables per stage"""
FATROP = {"tol": 1e-3, "mu_init": 0.1, "max_iter": 60, "print_level": 0}
IPOPT = {"tol": 1e-3, "mu_init": 1e-2, "max_iter": 200, "print_level": 0, "sb": "yes"}


class Weights(NamedTuple):
    """What the cost goes by, per second."""

    lag: float = 1.0
    """Q_x, of the squared distance behind the reference [1/m2]"""
    offset: float = 0.3
    """Q_y, of the squared distance beside it [1/m2]"""
    turning: float = 0.05
    """Q_omega [s2]"""
    acceleration: float = 0.05
    """R_a [s4/m2]"""
    angular_acceleration: float = 0.02
    """R_alpha [s4]"""
    proximity: float = 4.0
    """P, of touching with the margin"""
    steepness: float = 6.0
    """S [1/m]"""
    wall_steepness: float = 20.0
    """S_w [1/m]"""


class Shape(NamedTuple):
    """How large the programme is."""

    stages: int
    """N"""
    dt: float
    """time between two stages [s]"""
    discs: int
    """discs kept clear of"""
    walls: int
    """half-planes per stage"""


class Task(NamedTuple):
    """What one solution is for. The arrays are written anew for each."""

    start: Array
    """(3,) heading [rad], speed [m/s], turn rate [rad/s]"""
    way: Array
    """(2,) unit vector of the reference's line"""
    reference: Array
    """(N + 1,) how far along it the reference is [m]"""
    radius: Array
    """(K,) R of each disc, positive [m]"""
    disc: Array
    """(N, K, 2) centres at the stages 1 to N [m]"""
    plane: Array
    """(N, W, 3) n_x, n_y, b [m] at the stages 1 to N"""


class OptimalControl:
    """Finds plans for one robot; keeps no memory of earlier ones."""

    def __init__(self, shape: Shape, limits: Limits, weights: Weights) -> None:
        """Build the solvers, and the arrays that they read and write."""
        n = shape.stages
        sizes = (3, 2, n + 1, shape.discs, 2 * n * shape.discs, 3 * n * shape.walls)
        ends = np.cumsum((0, *sizes)).tolist()
        self._parameters = np.zeros(ends[-1])
        parts = [self._parameters[a:b] for a, b in pairwise(ends)]
        start, way, reference, radius, disc, plane = parts
        self.task = Task(start, way, reference, radius, disc.reshape(n, -1, 2), plane.reshape(n, -1, 3))
        """to be written before each solution"""
        self.guess = np.zeros((n + 1, 7))
        """(N + 1, 7) x, y, theta, v, omega, a, alpha, to be written before each solution; the last inputs are unused"""
        self._begin = np.zeros((n + 1, WIDTH))
        self._lower, self._upper = _bounds(shape, limits)
        self._solvers = [
            _Solver(function, x0=self._begin, p=self._parameters, lbx=self._lower, ubx=self._upper)
            for function in solvers_of(shape, weights)
        ]

    def solve(self, box: Array) -> Array | None:
        """The plan for `task` that is found from `guess`, None if no solver finds one.

        Args:
            box: (4,) least x, least y, greatest x, greatest y of the stages 1 to N [m], infinite where open.

        Returns:
            (N + 1, 7) as `guess`, the last inputs zero.
        """
        # Fatrop takes down at its first solution which bounds are finite, and that must not change the next ones.
        bound = np.clip(box, -FAR, FAR)
        self._lower[1:, :THETA], self._upper[1:, :THETA] = bound[:2], bound[2:]
        self._begin[:, :-IDLE] = self.guess
        # Fatrop never returns from a NaN.
        if not (np.isfinite(self._parameters).all() and np.isfinite(self.guess).all()):
            return None
        for solver in self._solvers:
            if solver.run() and np.isfinite(solver.plan).all():
                return solver.plan[:, :-IDLE].copy()
        return None


class _Solver:
    """A CasADi solver that reads and writes arrays in place, which saves the copies of a call."""

    def __init__(self, function: Any, **given: Array) -> None:
        self.plan = np.zeros_like(given["x0"])
        """(N + 1, WIDTH) the solution; the last stage has no inputs"""
        self._call, self._evaluate = function.buffer()
        # CasADi keeps addresses, not arrays.
        self._given = given
        for name, array in given.items():
            self._call.set_arg(function.index_in(name), _without_last_inputs(array))
        self._call.set_res(function.index_out("x"), _without_last_inputs(self.plan))

    def run(self) -> bool:
        """True if it has converged."""
        self._evaluate()
        return bool(self._call.stats()["success"])


def _without_last_inputs(array: Array) -> memoryview:
    """The memory of an array, of a (N + 1, WIDTH) one only what a programme knows as variables."""
    size = array.size - WIDTH + A if array.ndim == 2 else array.size
    return memoryview(array.reshape(-1)[:size])  # type: ignore[arg-type]  # numpy does not say that it is a buffer


def _bounds(shape: Shape, limits: Limits) -> tuple[Array, Array]:
    """(N + 1, WIDTH) least and greatest values; the first state is free of them, since it is given."""
    _, max_speed, acceleration, rate, angular = limits
    upper = np.full((shape.stages + 1, WIDTH), np.inf)
    upper[:, V : ALPHA + 1] = ROOM * max_speed, rate, acceleration, angular
    lower = -upper
    lower[:, V] = limits.min_speed
    lower[0, :A], upper[0, :A] = -np.inf, np.inf
    return lower, upper


@lru_cache(maxsize=8)
def solvers_of(shape: Shape, weights: Weights) -> tuple[casadi.Function, ...]:
    """The solvers in order of preference; built once, for they are the same in every episode."""
    programme, equality = programme_of(shape, weights)
    settings: dict[str, dict[str, Any]] = {
        "fatrop": {"structure_detection": "auto", "equality": equality, "fatrop": FATROP},
        "ipopt": {"ipopt": IPOPT},
    }
    silent: dict[str, Any] = {"print_time": False, "error_on_fail": False}
    return tuple(casadi.nlpsol("plan", plugin, programme, silent | own) for plugin, own in settings.items())


def programme_of(shape: Shape, weights: Weights) -> tuple[dict[str, Any], list[bool]]:
    """Variables, parameters, cost and constraints, and that all constraints are equalities."""
    n, dt = shape.stages, shape.dt
    start, way, reference = casadi.SX.sym("start", 3), casadi.SX.sym("way", 2), casadi.SX.sym("reference", n + 1)
    radius = casadi.SX.sym("radius", shape.discs)
    discs = [[casadi.SX.sym(f"disc{k}_{j}", 2) for j in range(shape.discs)] for k in range(1, n + 1)]
    planes = [[casadi.SX.sym(f"plane{k}_{i}", 3) for i in range(shape.walls)] for k in range(1, n + 1)]
    states = [casadi.SX.sym(f"z{k}", 5) for k in range(n + 1)]
    inputs = [casadi.SX.sym(f"u{k}", 2 + IDLE) for k in range(n)]
    cost: Any = 0.0
    equations, variables = [], []
    for k, z in enumerate(states):
        along, across = way[0] * z[X] + way[1] * z[Y], way[0] * z[Y] - way[1] * z[X]
        rate = weights.lag * (along - reference[k]) ** 2 + weights.offset * across**2 + weights.turning * z[OMEGA] ** 2
        variables.append(z)
        if k < n:
            u = inputs[k]
            rate += weights.acceleration * u[0] ** 2 + weights.angular_acceleration * u[1] ** 2 + casadi.sumsqr(u[2:])
            variables.append(u)
            equations.append(states[k + 1] - _next(z, u, dt))
        if k == 0:
            equations.append(z - casadi.vertcat(0, 0, start))
        else:
            rate += _soft(z, radius, discs[k - 1], planes[k - 1], weights)
        cost += dt * rate
    parameters = casadi.vertcat(start, way, reference, radius, *chain(*discs, *planes))
    programme = {"x": casadi.vertcat(*variables), "p": parameters, "f": cost, "g": casadi.vertcat(*equations)}
    return programme, [True] * programme["g"].numel()


def _next(z: Any, u: Any, dt: float) -> Any:
    """The state one stage later, by the midpoint rule."""

    def rate(state: Any) -> Any:
        v, theta = state[V], state[THETA]
        return casadi.vertcat(v * casadi.cos(theta), v * casadi.sin(theta), state[OMEGA], u[:2])

    return z + dt * rate(z + 0.5 * dt * rate(z))


def _soft(z: Any, radius: Any, discs: list[Any], planes: list[Any], weights: Weights) -> Any:
    """The cost rate of being near to people, other robots and walls."""
    rate = 0.0
    for j, disc in enumerate(discs):
        gap = ((z[X] - disc[0]) ** 2 + (z[Y] - disc[1]) ** 2 - radius[j] ** 2) / (2 * radius[j])
        rate += weights.proximity * casadi.exp(-weights.steepness * gap)
    for plane in planes:
        gap = plane[0] * z[X] + plane[1] * z[Y] - plane[2]
        rate += weights.proximity * casadi.exp(-weights.wall_steepness * gap)
    return rate
