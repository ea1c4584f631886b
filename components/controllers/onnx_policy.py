"""A learned policy from an ONNX file: a declared observation in, speed and turn rate out.

Every input of the model is filled with the parts that the option `observation` declares for it, one after the other, in
the model's own number type and shape; a dimension that the model leaves open is 1 (the batch). Its output is two
numbers. One thread and no random numbers: the same observation gives the same command.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from components.controllers.ego import command, ego_of, way_to
from components.controllers.observation import Part, View
from components.controllers.sight import People, Sight
from crowdcosim import Controller, Setup
from crowdcosim.messages import Crowd, Detections, Goal, LaserScan, Odometry, RobotState, Twist

NUMBERS: Mapping[str, type] = {"tensor(float)": np.float32, "tensor(double)": np.float64}
"""what a model's inputs and its output can be made of"""


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of a policy."""

    model: str
    """the ONNX file"""
    observation: Mapping[str, tuple[Part, ...]]
    """what each input of the model is filled with, by the input's name"""
    output: str | None = None
    """name of the output that holds the command; None for the only one"""
    action: Literal["velocity", "unit"] = "velocity"
    """`velocity`: the output is m/s and rad/s; `unit`: -1 to 1 stands for the robot's least to greatest of each"""
    people_from: People = "truth"
    """where the robot knows people from"""


class OnnxPolicy(Controller):
    """Asks a neural network what to do."""

    def __init__(self, config: Config) -> None:
        self._config = config

    def reset(self, setup: Setup) -> None:
        """Load the model, and hold it against what is declared.

        Raises:
            ValueError: if it cannot be loaded, or its inputs and outputs are others.
        """
        self._world, self._model = setup.world, setup.own_robot.model
        self._sight = Sight(self._config.people_from, setup)
        self._session = _session(self._config.model)
        given = {i.name: i for i in self._session.get_inputs()}
        if set(given) != set(self._config.observation):
            raise ValueError(
                f"observation fills {_names(self._config.observation)}, but the inputs of '{self._config.model}' are "
                f"{_names(given)}: declare parts for each of them, and for no other"
            )
        self._inputs = {name: _Filled(name, given[name], parts) for name, parts in self._config.observation.items()}
        self._output = self._output_name()

    def step(
        self,
        odometry: Odometry,
        goal: Goal,
        crowd: Crowd | None = None,
        others: tuple[RobotState, ...] = (),
        detections: Detections | None = None,
        scan: LaserScan | None = None,
    ) -> Twist:
        """What the policy says; rest at the goal.

        Raises:
            ValueError: if it does not say two finite numbers.
        """
        ego = ego_of(odometry)
        way = way_to(goal, ego)
        if way is None:
            return command(0.0, 0.0)
        discs = self._sight.discs(ego, odometry.header, crowd, others, detections)
        displacement = discs.position - np.array([ego.x, ego.y])
        people = self._world.displacement(np.array([ego.x, ego.y]), discs.position[: discs.people])
        displacement[: discs.people] = people
        view = View(ego, way, discs, displacement, scan, self._model)
        fed = {name: filled.array(view) for name, filled in self._inputs.items()}
        answer = np.asarray(self._session.run([self._output], fed)[0], np.float64).reshape(-1)
        if len(answer) != 2 or not np.isfinite(answer).all():
            raise ValueError(f"output '{self._output}' is {answer.tolist()}, expected two finite numbers")
        speed, turn_rate = answer.tolist()
        if self._config.action == "unit":
            low, high = self._model.min_speed, self._model.max_speed
            speed = low + 0.5 * (max(-1.0, min(1.0, speed)) + 1.0) * (high - low)
            turn_rate = max(-1.0, min(1.0, turn_rate)) * self._model.max_angular_velocity
        return command(speed, turn_rate)

    def _output_name(self) -> str:
        outputs = [output.name for output in self._session.get_outputs()]
        wanted = self._config.output
        if wanted is None and len(outputs) == 1:
            return str(outputs[0])
        if wanted not in outputs:
            found = "not given" if wanted is None else f"'{wanted}'"
            raise ValueError(f"output is {found}, expected one of those of '{self._config.model}': {_names(outputs)}")
        return wanted


class _Filled:
    """One input of the model, and what fills it."""

    def __init__(self, name: str, given: Any, parts: tuple[Part, ...]) -> None:
        if given.type not in NUMBERS:
            raise ValueError(f"input '{name}' of the model is a {given.type}, expected one of {_names(NUMBERS)}")
        self._parts, self._type = parts, NUMBERS[given.type]
        self._shape = [size if isinstance(size, int) else 1 for size in given.shape]
        numbers = sum(part.size for part in parts)
        if math.prod(self._shape) != numbers:
            sizes = " + ".join(f"{part.part} {part.size}" for part in parts) or "nothing"
            raise ValueError(
                f"input '{name}' of the model has the shape {given.shape}, {math.prod(self._shape)} numbers, but "
                f"observation fills it with {sizes} = {numbers}"
            )

    def array(self, view: View) -> NDArray[Any]:
        return np.concatenate([part.read(view) for part in self._parts]).astype(self._type).reshape(self._shape)


def _session(path: str) -> Any:
    """The model, ready to run on one thread."""
    try:
        import onnxruntime
    except ImportError:
        raise ValueError(
            "the controller 'onnx' needs onnxruntime, which is not installed: pip install 'crowdcosim[onnx]'"
        ) from None
    if not Path(path).is_file():
        raise ValueError(f"model is '{path}', but there is no such file")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        return onnxruntime.InferenceSession(path, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its errors share no base but Exception
        raise ValueError(f"model is '{path}', which onnxruntime cannot load: {error}") from None


def _names(names: Any) -> str:
    return ", ".join(f"'{name}'" for name in names) or "none"
