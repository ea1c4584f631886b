"""Any FMU in the place of the motors: its variables play the parts of a drive, in SI units or with a factor."""

from __future__ import annotations

import math
import re
import shutil
from dataclasses import asdict

import pytest

from components.robot.fmu_build import built_in
from components.robot.fmu_drive import FmuMotors
from components.robot.fmu_file import FmuError
from components.robot.fmu_parts import Variable, Variables
from components.robot.motor import TURTLEBOT2, Motor, NativeMotors, compliance

pytestmark = [
    pytest.mark.usefixtures("own_cache"),
    pytest.mark.skipif(
        not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="building an FMU needs a C compiler"
    ),
]
H = 0.01
NO_LOAD = (0.0, 0.0)
RPM = 2.0 * math.pi / 60.0


def motors(file, variables=None, parameters=None):
    made = FmuMotors(
        file,
        name="robot",
        variables=variables,
        parameters=parameters or {},
        vehicle=TURTLEBOT2,
        wheel_inertia=1e-4,
        h=H,
    )
    made.reset()
    return made


def parts(**names):
    return Variables(**{role: v if isinstance(v, Variable) else Variable(name=v) for role, v in names.items()})


@pytest.mark.parametrize("version", ["2", "3"])
def test_the_built_in_fmu_drives_as_the_native_motors_do(version):
    native = NativeMotors(Motor(), TURTLEBOT2)
    fmu = motors(built_in(version), parameters=asdict(Motor()) | asdict(TURTLEBOT2))
    for k in range(300):
        command, load = (20.0, 20.0 - 0.1 * k), (3.0, 3.0) if 100 < k < 150 else NO_LOAD
        assert fmu.step(command, load, H) == pytest.approx(native.step(command, load, H), abs=1e-6)


def test_variables_with_other_names_and_units(foreign):
    """Wheel speeds in revolutions per minute, and a right wheel that counts the other way round."""
    file = foreign(
        names={"left_command": "n_l_ref", "right_command": "n_r_ref", "left_speed": "n_l", "right_speed": "n_r"}
    )
    fmu = motors(
        file,
        parts(
            left_command=Variable(name="n_l_ref", factor=RPM),
            right_command=Variable(name="n_r_ref", factor=-RPM),
            left_speed=Variable(name="n_l", factor=RPM),
            right_speed=Variable(name="n_r", factor=-2.0 * RPM),
        ),
    )
    assert fmu.step((10.0, 6.0), NO_LOAD, H) == pytest.approx((10.0, 12.0), rel=1e-12)


def test_commands_as_speed_and_turn_rate(foreign):
    """The commands of this FMU come out as its speeds: here the robot's, of 0.5 m/s and 0.2 rad/s."""
    fmu = motors(
        foreign(),
        parts(
            speed_command="left_command",
            turn_rate_command="right_command",
            left_speed="left_speed",
            right_speed="right_speed",
        ),
    )
    left, right = (0.5 - 0.2 * 0.115) / 0.035, (0.5 + 0.2 * 0.115) / 0.035
    assert fmu.step((left, right), NO_LOAD, H) == pytest.approx((0.5, 0.2), rel=1e-12)


BY_TORQUE = {
    "left_command": "left_command",
    "right_command": "right_command",
    "left_torque": "left_torque",
    "right_torque": "right_torque",
}


def test_torques_accelerate_the_inertia_of_the_robot(foreign):
    """1 N m on each wheel, for a second."""
    fmu = motors(foreign(), parts(**BY_TORQUE))
    yielding, coupling = compliance(1e-4, 0.035, 0.230, 20.0, 0.313)
    for _ in range(100):
        speeds = fmu.step((1.0, 1.0), NO_LOAD, H)
    assert speeds == pytest.approx(2 * [yielding + coupling], rel=1e-9)


def test_torques_do_not_move_what_a_load_holds(foreign):
    fmu = motors(foreign(), parts(**BY_TORQUE))
    for _ in range(10):
        assert fmu.step((1.0, 1.0), (2.0, 2.0), H) == (0.0, 0.0)


def test_measured_speeds_go_back_to_an_fmu_that_gives_torques(foreign):
    """This FMU's speeds are its inputs of the step before: those are what it has measured."""
    fmu = motors(
        foreign(),
        parts(
            **BY_TORQUE
            | {"left_command": "left_load", "right_command": "right_load"}
            | {"left_measured": "left_command", "right_measured": "right_command"}
        ),
    )
    seen = fmu._instance.access(["left_speed", "right_speed"])
    before = (0.0, 0.0)
    for _ in range(5):
        now = fmu.step((1.0, 1.0), NO_LOAD, H)
        assert tuple(seen.get()) == before
        before = now


def test_an_fmu_without_namesakes_asks_for_a_mapping(foreign):
    file = foreign(names={"left_command": "w_ref_l"})
    with pytest.raises(FmuError, match=r"no variables called like the parts.*left_command is missing.*`variables`"):
        motors(file)


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"left_command": "left_comand"}, "no variable 'left_comand' (did you mean 'left_command'?)"),
        ({"left_command": "left_speed"}, "variables.left_command: 'left_speed'"),
        ({"left_command": "left_speed"}, "of causality output, expected an input: left_command, right_command"),
        ({"left_torque": "gone"}, "no variable 'gone'; list them: crowdcosim fmu inspect"),
    ],
)
def test_a_wrong_mapping_is_refused(foreign, change, text):
    with pytest.raises(FmuError, match=re.escape(text)):
        motors(foreign(), parts(**BY_TORQUE | change))


def test_a_value_that_is_not_finite_names_the_variable_and_the_time(foreign):
    fmu = motors(foreign("nan", 2))
    for _ in range(2):
        fmu.step((1.0, 1.0), NO_LOAD, H)
    with pytest.raises(FmuError, match=r"variable 'left_speed' of .* is -?nan at t = 0.03 s, expected a finite number"):
        fmu.step((1.0, 1.0), NO_LOAD, H)


def test_a_reset_begins_anew(foreign):
    fmu = motors(foreign("discard", 3))
    for _ in range(2):
        for _ in range(3):
            fmu.step((1.0, 1.0), NO_LOAD, H)
        fmu.reset()


def test_a_fixed_step_that_does_not_fit_names_a_time_step_that_does(foreign):
    motors(foreign(attributes='fixedInternalStepSize="0.005"'))
    with pytest.raises(FmuError, match=r"advances in steps of 0.004 s.*`dt` to a multiple of 0.04 s"):
        motors(foreign(attributes='fixedInternalStepSize="0.004"'))
