"""Two wheels on geared DC motors: a regulator turns wheel speed commands into voltages within what one battery gives.

With the speeds w of the wheels, the currents i and the voltages u, K = torque_constant * gear_ratio, for each wheel:
    u = sat(k_p e + z),  dz/dt = k_i e + (k_i / k_p) (u - (k_p e + z)),  e = command - w        (regulator)
    L di/dt = u - R i - K w                                                                 (armature)
    J dw/dt = K i - f,  |f| <= friction_torque, and at rest whatever holds the wheel         (both wheels at once)
sat() limits u to the battery's voltage V and the current u leads to, (u - K w) / R, to current_limit; the second term
of dz/dt keeps the integral from winding up at a limit (back-calculation; Astrom and Hagglund, PID Controllers: Theory,
Design, and Tuning, 2nd ed. 1995, section 3.5). V = V_0 - R_b (u . i) / V. J is that of wheels and rotors, and of the
robot that they move without slip: J_ll = J_rr = J_w + m r^2 / 4 + I r^2 / b^2, J_lr = m r^2 / 4 - I r^2 / b^2.

A load is a torque with which something in the way can hold a wheel back: a positive one resists turning forward, up to
its size, and never drives the wheel; a negative one resists turning backward.

Time advances in equal steps of at most 0.2 ms: currents implicitly, speeds from the new currents, then friction and
loads as the impulses that bring the wheels nearest to rest (projected Gauss-Seidel). `fmu/wheel_drive.c` is the same
arithmetic in the same order; a change here needs the same change there.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]

INNER_STEP = 2e-4
"""longest step of the integration [s]"""
SWEEPS = 4
"""over both wheels' friction in each step of the integration"""
# Indices into the state of `advance`: two wheels each, left first, but for the battery.
CURRENT, SPEED, ANGLE, INTEGRAL, TORQUE, BATTERY = 0, 2, 4, 6, 8, 10
STATE_SIZE = 11


@dataclass(frozen=True, kw_only=True)
class Motor:
    """One of two equal motors with its gear, regulator and encoder, and the battery that both share.

    The defaults are a TurtleBot2's: gear, encoder and overload current as published for its base, the rest typical of
    a 12 V motor of that size; the rotor's inertia is an estimate. They reach 0.93 m/s and 4 m/s2 at 20 kg.
    """

    open_circuit_voltage: float = 14.8
    """voltage of the battery without load, the most that a motor gets [V]"""
    battery_resistance: float = 0.1
    """internal resistance of the battery [ohm]"""
    current_limit: float = 3.0
    """most current that the regulator drives through a motor [A]"""
    resistance: float = 1.55
    """of the armature [ohm]"""
    inductance: float = 1.51e-3
    """of the armature [H]"""
    torque_constant: float = 0.0109
    """torque per current, and back-EMF per speed of the rotor [N m/A]"""
    gear_ratio: float = 6545.0 / 132.0
    """turns of the rotor per turn of the wheel [1]"""
    friction_torque: float = 0.11
    """dry friction of motor and gear, at the wheel [N m]"""
    rotor_inertia: float = 5e-7
    """of one rotor, about its own axis [kg m2]"""
    wheel_inertia: float = 1e-4
    """of one wheel, about its own axis [kg m2]"""
    proportional_gain: float = 1.0
    """voltage per error of the wheel's speed [V s/rad]"""
    integral_gain: float = 14.0
    """voltage per integrated error of the wheel's speed [V/rad]"""
    ticks_per_turn: float = 52.0 * 6545.0 / 132.0
    """ticks of the encoder per turn of the wheel [1]"""

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            may_be_zero = field.name in ("battery_resistance", "friction_torque", "rotor_inertia", "inductance")
            if not (value > 0.0 or (may_be_zero and value == 0.0)):
                expected = "zero or more" if may_be_zero else "more than zero"
                raise ValueError(f"{field.name} is {value}, expected {expected}")
        if not 4.0 * self.current_limit * self.battery_resistance < self.open_circuit_voltage:
            raise ValueError(
                f"battery_resistance is {self.battery_resistance}, expected less than open_circuit_voltage / "
                f"(4 current_limit) = {self.open_circuit_voltage / (4.0 * self.current_limit)}: the battery could not "
                "supply both motors"
            )


@dataclass(frozen=True, kw_only=True)
class Vehicle:
    """What the two wheels move."""

    wheel_radius: float
    """[m]"""
    track: float
    """distance between the wheels [m]"""
    mass: float
    """of the whole robot [kg]"""
    yaw_inertia: float
    """of the whole robot about the vertical axis through the middle between the wheels [kg m2]"""


TURTLEBOT2 = Vehicle(wheel_radius=0.035, track=0.230, mass=20.0, yaw_inertia=0.313)


def parameters_of(motor: Motor, vehicle: Vehicle) -> Array:
    """(17,) all numbers that `advance` needs, in the order of the fields."""
    return np.array([getattr(part, field.name) for part in (motor, vehicle) for field in fields(part)])


class NativeMotors:
    """The two motors as a numba kernel."""

    def __init__(self, motor: Motor, vehicle: Vehicle) -> None:
        self._parameters = parameters_of(motor, vehicle)
        self._ticks = motor.ticks_per_turn / (2.0 * math.pi)
        self.reset()

    def reset(self) -> None:
        """Back to rest, at angle zero, with a battery without load. Loads the kernel."""
        self.state = at_rest(self._parameters)
        advance(self._parameters, self.state.copy(), 0.0, 0.0, 0.0, 0.0, INNER_STEP)

    def step(self, command: tuple[float, float], load: tuple[float, float], h: float) -> tuple[float, float]:
        """Speeds of the wheels [rad/s] after `h` [s], with the wanted speeds [rad/s] and loads [N m]; left first."""
        advance(self._parameters, self.state, command[0], command[1], load[0], load[1], h)
        return float(self.state[SPEED]), float(self.state[SPEED + 1])

    @property
    def ticks(self) -> tuple[int, int]:
        """What the encoders have counted since the reset, left first."""
        return math.floor(self.state[ANGLE] * self._ticks), math.floor(self.state[ANGLE + 1] * self._ticks)


def at_rest(parameters: Array) -> Array:
    """(11,) the state at the start."""
    state = np.zeros(STATE_SIZE)
    state[BATTERY] = parameters[0]
    return state


@njit(cache=True, nogil=True, error_model="numpy")
def advance(
    parameters: Array,
    state: Array,
    left_command: float,
    right_command: float,
    left_load: float,
    right_load: float,
    duration: float,
) -> None:
    """Let `duration` [s] pass.

    Args:
        parameters: (17,) of `parameters_of`.
        state: (11,) changed in place: currents [A], speeds [rad/s], angles [rad], integrals [V] and torques [N m] of
            the wheels, and the battery's voltage [V].
        left_command: wanted speed of the left wheel [rad/s]
        right_command: of the right wheel [rad/s]
        left_load: torque that resists the left wheel [N m]
        right_load: the right wheel [N m]
        duration: [s]
    """
    open_circuit, battery_resistance, current_limit, resistance, inductance = parameters[:5]
    torque_constant, gear_ratio, friction_torque, rotor_inertia, wheel_inertia = parameters[5:10]
    proportional, integral_gain, _, wheel_radius, track, mass, yaw_inertia = parameters[10:]

    steps = max(1, math.ceil(duration / INNER_STEP - 1e-6))
    h = duration / steps
    k = torque_constant * gear_ratio
    inertia = wheel_inertia + rotor_inertia * gear_ratio * gear_ratio
    yielding, coupling = compliance(inertia, wheel_radius, track, mass, yaw_inertia)

    command = (left_command, right_command)
    for _ in range(steps):
        power = 0.0
        for j in range(2):
            error = command[j] - state[SPEED + j]
            wanted = proportional * error + state[INTEGRAL + j]
            emf = k * state[SPEED + j]
            low = max(-state[BATTERY], emf - resistance * current_limit)
            high = min(state[BATTERY], emf + resistance * current_limit)
            voltage = min(max(wanted, low), high)
            state[INTEGRAL + j] += h * (integral_gain * error + (integral_gain / proportional) * (voltage - wanted))
            current = (inductance * state[CURRENT + j] + h * (voltage - emf)) / (inductance + h * resistance)
            state[CURRENT + j] = current
            state[TORQUE + j] = k * current
            power += voltage * current
        state[BATTERY] = open_circuit - battery_resistance * power / state[BATTERY]

        before_left, before_right = state[SPEED], state[SPEED + 1]
        left = before_left + h * (yielding * state[TORQUE] + coupling * state[TORQUE + 1])
        right = before_right + h * (coupling * state[TORQUE] + yielding * state[TORQUE + 1])
        left, right = hold(left, right, friction_torque, left_load, right_load, yielding, coupling, h)
        state[SPEED] = left
        state[SPEED + 1] = right
        state[ANGLE] += 0.5 * h * (before_left + left)
        state[ANGLE + 1] += 0.5 * h * (before_right + right)


@njit(cache=True, nogil=True, error_model="numpy")
def compliance(
    wheel_inertia: float, wheel_radius: float, track: float, mass: float, yaw_inertia: float
) -> tuple[float, float]:
    """How much a torque on one wheel speeds up this wheel, and the other [1/(kg m2)]: the inverse of J.

    `wheel_inertia` is that of a wheel and all that turns with it [kg m2]; the others are a `Vehicle`'s.
    """
    along = 0.25 * mass * wheel_radius * wheel_radius
    about = yaw_inertia * wheel_radius * wheel_radius / (track * track)
    own = wheel_inertia + along + about
    cross = along - about
    determinant = own * own - cross * cross
    return own / determinant, -cross / determinant


@njit(cache=True, nogil=True, error_model="numpy")
def hold(
    left: float,
    right: float,
    friction: float,
    left_load: float,
    right_load: float,
    yielding: float,
    coupling: float,
    h: float,
) -> tuple[float, float]:
    """Speeds of the wheels [rad/s] once friction and loads [N m] have acted on them for `h` [s].

    `left` and `right` are the speeds without [rad/s]; `yielding` and `coupling` are of `compliance` [1/(kg m2)].
    """
    left_low, left_high = -h * (friction + max(left_load, 0.0)), h * (friction + max(-left_load, 0.0))
    right_low, right_high = -h * (friction + max(right_load, 0.0)), h * (friction + max(-right_load, 0.0))
    left_impulse = 0.0
    right_impulse = 0.0
    for _ in range(SWEEPS):
        impulse = min(max(left_impulse - left / yielding, left_low), left_high)
        left += yielding * (impulse - left_impulse)
        right += coupling * (impulse - left_impulse)
        left_impulse = impulse
        impulse = min(max(right_impulse - right / yielding, right_low), right_high)
        right += yielding * (impulse - right_impulse)
        left += coupling * (impulse - right_impulse)
        right_impulse = impulse
    if left_low < left_impulse < left_high and right_low < right_impulse < right_high:
        return 0.0, 0.0  # both are held: what the sweeps have left is not motion
    return left, right
