"""The wheel motors against closed forms, conservation laws and an integrator of higher order."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from components.robot.motor import (
    ANGLE,
    BATTERY,
    CURRENT,
    INNER_STEP,
    SPEED,
    TORQUE,
    TURTLEBOT2,
    Motor,
    NativeMotors,
)

KOBUKI = Motor()
K = KOBUKI.torque_constant * KOBUKI.gear_ratio
H = 0.01


def driven(motors, command, seconds, load=(0.0, 0.0)):
    for _ in range(round(seconds / H)):
        motors.step(command, load, H)
    return motors.state


def inertia(motor, vehicle):
    """(2, 2) as the module's docstring has it."""
    m, i, r, b = vehicle.mass, vehicle.yaw_inertia, vehicle.wheel_radius, vehicle.track
    along, about = m * r**2 / 4, i * r**2 / b**2
    own = motor.wheel_inertia + motor.rotor_inertia * motor.gear_ratio**2 + along + about
    return np.array([[own, along - about], [along - about, own]])


def test_a_reachable_command_is_reached_exactly():
    state = driven(NativeMotors(KOBUKI, TURTLEBOT2), (10.0, -7.0), 8.0)
    assert state[SPEED : SPEED + 2] == pytest.approx([10.0, -7.0], abs=1e-6)  # what 8 s leave of the transient


def test_steady_current_carries_the_friction_and_no_more():
    state = driven(NativeMotors(KOBUKI, TURTLEBOT2), (10.0, 10.0), 8.0)
    assert state[CURRENT] == pytest.approx(KOBUKI.friction_torque / K, rel=1e-6)


def test_top_speed_is_where_the_battery_feeds_the_friction():
    """V = R i + K w, with V = V_0 - R_b (2 V i) / V."""
    current = KOBUKI.friction_torque / K
    voltage = KOBUKI.open_circuit_voltage - 2.0 * KOBUKI.battery_resistance * current
    state = driven(NativeMotors(KOBUKI, TURTLEBOT2), (100.0, 100.0), 3.0)
    assert state[BATTERY] == pytest.approx(voltage, rel=1e-6)
    assert state[SPEED] == pytest.approx((voltage - KOBUKI.resistance * current) / K, rel=1e-6)
    assert 0.9 < state[SPEED] * TURTLEBOT2.wheel_radius < 1.0


@pytest.mark.parametrize("sides", [(1.0, 1.0), (1.0, -1.0)], ids=["ahead", "on the spot"])
def test_at_the_current_limit_the_inertia_of_the_whole_robot_is_accelerated(sides):
    """Once the current has built up (5 L / R = 5 ms), J dw/dt = K i_max - friction."""
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    command = (1000.0 * sides[0], 1000.0 * sides[1])
    begin = driven(motors, command, 0.02).copy()
    end = driven(motors, command, 0.05)
    assert end[TORQUE] == pytest.approx(K * KOBUKI.current_limit, rel=1e-3)
    acceleration = np.linalg.solve(inertia(KOBUKI, TURTLEBOT2), np.array(sides)) * (
        K * KOBUKI.current_limit - KOBUKI.friction_torque
    )
    assert (end[SPEED : SPEED + 2] - begin[SPEED : SPEED + 2]) / 0.05 == pytest.approx(acceleration, rel=2e-3)


def test_without_friction_and_limits_it_is_the_linear_system():
    """Against an adaptive Runge-Kutta of order 8; the difference is that of a first-order method at 0.2 ms."""
    motor = Motor(friction_torque=0.0, battery_resistance=0.0, open_circuit_voltage=1000.0, current_limit=1000.0)
    command = np.array([5.0, 2.0])

    def slope(_, y):
        current, speed, integral = y[:2], y[2:4], y[4:]
        error = command - speed
        voltage = motor.proportional_gain * error + integral
        di = (voltage - motor.resistance * current - K * speed) / motor.inductance
        dw = np.linalg.solve(inertia(motor, TURTLEBOT2), K * current)
        return np.concatenate([di, dw, motor.integral_gain * error])

    times = np.arange(1, 60) * H
    exact = solve_ivp(slope, (0.0, 0.6), np.zeros(6), "DOP853", times, rtol=1e-10, atol=1e-10).y
    motors = NativeMotors(motor, TURTLEBOT2)
    ours = np.array([motors.step((5.0, 2.0), (0.0, 0.0), H) for _ in times]).T
    assert np.abs(ours - exact[2:4]).max() < 0.01  # of 5 rad/s


def test_energy_is_neither_made_nor_lost():
    """The battery's work is heat in armatures and friction, and motion; 1% is the step size's share."""
    motor = replace(KOBUKI, battery_resistance=0.0)
    motors = NativeMotors(motor, TURTLEBOT2)
    work = heat = 0.0
    command = (20.0, 14.0)
    for _ in range(round(0.6 / INNER_STEP)):
        before = motors.state.copy()
        motors.step(command, (0.0, 0.0), INNER_STEP)
        current = motors.state[CURRENT : CURRENT + 2]
        speed = 0.5 * (before[SPEED : SPEED + 2] + motors.state[SPEED : SPEED + 2])
        change = motor.inductance * (current - before[CURRENT : CURRENT + 2]) / INNER_STEP
        voltage = motor.resistance * current + change + K * speed
        work += INNER_STEP * float(voltage @ current)
        heat += INNER_STEP * float(motor.resistance * current @ current + motor.friction_torque * np.abs(speed).sum())
    speed, current = motors.state[SPEED : SPEED + 2], motors.state[CURRENT : CURRENT + 2]
    motion = 0.5 * float(speed @ inertia(motor, TURTLEBOT2) @ speed + motor.inductance * current @ current)
    assert motion > 1.0
    assert work == pytest.approx(heat + motion, rel=0.01)


def test_a_saturated_regulator_does_not_wind_up():
    """After a second against the limit, it leaves it as soon as it can: no overshoot to speak of."""
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    driven(motors, (1000.0, 1000.0), 1.0)
    speeds = [motors.step((10.0, 10.0), (0.0, 0.0), H)[0] for _ in range(300)]
    assert min(speeds) > 9.0
    assert speeds[-1] == pytest.approx(10.0, abs=1e-3)


def test_friction_holds_a_wheel_against_less_torque():
    motor = replace(KOBUKI, proportional_gain=0.05, integral_gain=1e-9)
    torque = 0.05 * 2.0 * K / motor.resistance
    assert torque < motor.friction_torque
    state = driven(NativeMotors(motor, TURTLEBOT2), (2.0, 2.0), 1.0)
    assert state[TORQUE] == pytest.approx(torque, rel=1e-6)
    assert state[ANGLE : ANGLE + 2].tolist() == [0.0, 0.0]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_a_load_stalls_a_wheel_and_does_not_drive_it(way):
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    state = driven(motors, (way * 20.0, way * 20.0), 1.0, load=(way * 5.0, way * 5.0))
    assert state[ANGLE : ANGLE + 2].tolist() == [0.0, 0.0]
    assert state[CURRENT] == pytest.approx(way * KOBUKI.current_limit, rel=1e-3)


def test_a_load_ahead_does_not_keep_a_wheel_from_turning_back():
    free = driven(NativeMotors(KOBUKI, TURTLEBOT2), (-10.0, -10.0), 0.5)
    loaded = driven(NativeMotors(KOBUKI, TURTLEBOT2), (-10.0, -10.0), 0.5, load=(5.0, 5.0))
    assert loaded.tolist() == free.tolist()


def test_a_load_too_small_to_stall_slows_the_wheel_down():
    state = driven(NativeMotors(KOBUKI, TURTLEBOT2), (100.0, 100.0), 3.0, load=(1.0, 1.0))
    assert 0.0 < state[SPEED] < 26.0
    assert state[TORQUE] == pytest.approx(1.0 + KOBUKI.friction_torque, rel=1e-6)


def test_the_two_motors_share_a_battery():
    alone = driven(NativeMotors(KOBUKI, TURTLEBOT2), (100.0, 0.0), 3.0)[BATTERY]
    both = driven(NativeMotors(KOBUKI, TURTLEBOT2), (100.0, 100.0), 3.0, load=(1.0, 1.0))[BATTERY]
    assert both < alone < KOBUKI.open_circuit_voltage


def test_encoders_count_whole_ticks_of_the_way_driven():
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    state = driven(motors, (10.0, -10.0), 2.0)
    left, right = motors.ticks
    assert left == math.floor(state[ANGLE] / (2 * math.pi) * 52 * 6545 / 132)
    assert right < 0 < left
    # As published: 11.72 ticks per millimetre.
    assert left / (state[ANGLE] * 35.0) == pytest.approx(11.724, abs=0.01)


command = st.floats(-100.0, 100.0)
torque = st.floats(-10.0, 10.0)


@settings(max_examples=50, deadline=None)
@given(commands=st.lists(st.tuples(command, command, torque, torque), min_size=1, max_size=20))
def test_mirrored_commands_give_mirrored_wheels(commands):
    one, other = NativeMotors(KOBUKI, TURTLEBOT2), NativeMotors(KOBUKI, TURTLEBOT2)
    for left, right, left_load, right_load in commands:
        a = one.step((left, right), (left_load, right_load), H)
        b = other.step((-left, -right), (-left_load, -right_load), H)
        assert a == pytest.approx((-b[0], -b[1]), abs=1e-9)


@settings(max_examples=50, deadline=None)
@given(commands=st.lists(st.tuples(command, command, torque, torque), min_size=1, max_size=50))
def test_limits_hold_whatever_is_asked(commands):
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    for left, right, left_load, right_load in commands:
        motors.step((left, right), (left_load, right_load), H)
        assert np.isfinite(motors.state).all()
        # Braking from full speed the battery's voltage lags behind by an inner step.
        assert np.abs(motors.state[CURRENT : CURRENT + 2]).max() <= KOBUKI.current_limit * 1.02
        assert np.abs(motors.state[SPEED : SPEED + 2]).max() < 1.02 * KOBUKI.open_circuit_voltage / K


def test_a_reset_begins_anew():
    motors = NativeMotors(KOBUKI, TURTLEBOT2)
    first = driven(motors, (10.0, 5.0), 0.3).tolist()
    motors.reset()
    assert motors.state[SPEED] == 0.0
    assert driven(motors, (10.0, 5.0), 0.3).tolist() == first


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"resistance": 0.0}, "resistance is 0.0, expected more than zero"),
        ({"friction_torque": -1.0}, "friction_torque is -1.0, expected zero or more"),
        ({"battery_resistance": 2.0}, "battery_resistance is 2.0, expected less than"),
    ],
)
def test_impossible_motors_are_refused(change, text):
    with pytest.raises(ValueError, match=text):
        Motor(**change)
