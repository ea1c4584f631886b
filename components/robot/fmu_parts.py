"""The parts of a wheel drive that variables of an FMU can play, each with its unit here and the factor to it."""

from __future__ import annotations

from dataclasses import dataclass

INPUTS = (
    "left_command",
    "right_command",
    "speed_command",
    "turn_rate_command",
    "left_load",
    "right_load",
    "left_measured",
    "right_measured",
)
"""parts that the FMU is given"""
COMMANDS = (INPUTS[:2], INPUTS[2:4])
"""either of these it needs"""
RESULTS = {False: ("left_speed", "right_speed"), True: ("left_torque", "right_torque")}
"""by torque? -> the parts that it gives"""


@dataclass(frozen=True, kw_only=True)
class Variable:
    """A variable of the FMU."""

    name: str
    """as the FMU calls it"""
    factor: float = 1.0
    """SI units per unit of the variable: 0.10472 where it is in revolutions per minute; below 0 where it counts the
    other way round"""

    def __post_init__(self) -> None:
        if self.factor == 0.0:
            raise ValueError("factor is 0.0, expected the SI units per unit of the variable")


@dataclass(frozen=True, kw_only=True)
class Variables:
    """Which variable of the FMU plays which part: a pair of commands, and speeds or torques; the rest may lack."""

    left_command: Variable | None = None
    """wanted speed of the left wheel, forward [rad/s]"""
    right_command: Variable | None = None
    """wanted speed of the right wheel, forward [rad/s]"""
    speed_command: Variable | None = None
    """wanted speed of the robot, forward [m/s]"""
    turn_rate_command: Variable | None = None
    """wanted turn rate of the robot, counter-clockwise [rad/s]"""
    left_load: Variable | None = None
    """torque that resists the left wheel, and never drives it: against turning forward if positive [N m]"""
    right_load: Variable | None = None
    """torque that resists the right wheel [N m]"""
    left_measured: Variable | None = None
    """speed that the left wheel has, for an FMU that gives torques [rad/s]"""
    right_measured: Variable | None = None
    """speed that the right wheel has [rad/s]"""
    left_speed: Variable | None = None
    """speed of the left wheel that the FMU gives [rad/s]"""
    right_speed: Variable | None = None
    """speed of the right wheel that the FMU gives [rad/s]"""
    left_torque: Variable | None = None
    """torque on the left wheel that the FMU gives [N m]"""
    right_torque: Variable | None = None
    """torque on the right wheel that the FMU gives [N m]"""

    def __post_init__(self) -> None:
        filled = [name for name in self.__dataclass_fields__ if getattr(self, name) is not None]
        for name in filled:
            side, _, rest = name.partition("_")
            other = {"left": f"right_{rest}", "right": f"left_{rest}"}.get(side)
            if other is not None and other not in filled:
                raise ValueError(f"{other} is missing, expected a variable of the FMU beside that of {name}")
        for pairs, what in ((COMMANDS, "commands"), (tuple(RESULTS.values()), "results")):
            complete = [pair for pair in pairs if set(pair) <= set(filled)]
            if len(complete) != 1:
                choices = ", or ".join(" and ".join(pair) for pair in pairs)
                found = " and ".join(n for pair in complete for n in pair) or "neither"
                raise ValueError(f"{pairs[0][0]} and other {what}: found {found}, expected either {choices}")
