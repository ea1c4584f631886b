"""The environment: one robot of a scenario is driven by actions, the rest of the scenario goes on as it always does."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Literal

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from crowdcosim.goal import reached
from crowdcosim.messages import Contacts, Twist, Vector3
from crowdcosim.robots import Holonomic, Robot
from orchestrator.errors import InputError
from orchestrator.gym.observation import Part, People, WayToGoal, sensed
from orchestrator.gym.reward import DEFAULT, Reward, Transition
from orchestrator.gym.top_view import TopView
from orchestrator.scenario.problems import near_miss
from orchestrator.scenario.scenario import load
from orchestrator.session import Session, as_list

Observation = dict[str, NDArray[Any]]


class Navigation(gymnasium.Env[Observation, NDArray[np.float32]]):
    """Reach the goal among people.

    Action: forward speed, (of a holonomic robot) speed to the left, turn rate; each from -1 to 1, which are the robot's
    limits. Observation: one array per output of the robot's sensors, `goal`, and on request `people`. An episode is
    terminated at the goal, or at a collision where the scenario says so, and truncated at the time limit.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": 10}  # noqa: RUF012

    def __init__(
        self,
        scenario: str | Path | Mapping[str, Any] = "corridor",
        settings: Mapping[str, Any] | Sequence[str] = (),
        *,
        robot: str | None = None,
        reward: Mapping[str, float] = DEFAULT,
        observe: Sequence[str] | None = None,
        people: int = 0,
        record: str | Path | None = None,
        render_mode: Literal["rgb_array"] | None = None,
    ) -> None:
        """Open the scenario.

        Args:
            scenario: a file, a shipped scenario's name, or plain data.
            settings: values laid over it, `{"crowd.config.count": 200}` or `["crowd.config.count=200"]`.
            robot: the one that the actions drive; None if there is only one.
            reward: weights of the terms of `orchestrator.gym.reward` and of metrics.
            observe: sensors' outputs to observe, such as `lidar/scan`; None for all that can be.
            people: number of nearest people to observe as they truly are; also how many `Detections` are kept.
            record: folder for a log per episode; None writes none.
            render_mode: `rgb_array` for `render()` to give a picture from above.

        Raises:
            InputError: if the scenario cannot be run, or has no such robot, sensor or reward.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise InputError(f"render_mode is {render_mode!r}, expected None or 'rgb_array'")
        if people < 0:
            raise InputError(f"people is {people}, expected zero or more")
        self.render_mode = render_mode
        self._reward = Reward(reward)
        robot = robot or _only_robot(scenario, settings)
        self.session = Session(scenario, settings, commanded=robot, record=record)
        opened = self.session.scenario
        self.metadata = {**self.metadata, "render_fps": round(1e9 / opened.period)}
        self._robot = next(r for r in opened.robots if r.name == robot)
        if others := [name for name in self.session.commanded if name != self._robot.name]:
            raise InputError(f"who drives {', '.join(others)}? Give each of the other robots a controller")
        self._goal = self.session.goals[self._robot.name]
        self._way = WayToGoal(self._goal, self._robot, opened.ending.time_limit)
        self._people = People(people, self._robot.name, opened.world) if people else None
        self._sensors = self._parts(observe, people)
        parts: dict[str, spaces.Space[Any]] = {name: part.space for name, part in self._sensors.items()}
        parts["goal"] = self._way.space
        if self._people:
            parts["people"] = self._people.space
        self.observation_space = spaces.Dict(parts)  # type: ignore[assignment]  # Dict's type says less
        self._low, self._high = _limits(self._robot)
        self.action_space = spaces.Box(-1.0, 1.0, self._low.shape, np.float32)
        self._top_view = TopView(opened.world, opened.robots) if render_mode else None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Another episode, its seed drawn from the environment's own; `options={"alone": True}`: one without people."""
        super().reset(seed=seed)
        view = self.session.reset(int(self.np_random.integers(2**31)), alone=bool((options or {}).get("alone")))
        return self._observation(), {"time": view.time, "seed": self.session.scenario.seed}

    def step(self, action: NDArray[np.float32]) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Drive for one time step. The last step's info has the `outcome` and the `metrics` that there are."""
        before = self.session.view
        after = self.session.step({self._robot.name: self._twist(action)})
        now = after.robots[self._robot.name]
        arrived = self.session.scenario.ending.goal != "none" and reached(self._goal, now.state.position)
        if arrived and not self.session.over:  # others may still be under way
            self.session.stop()
        result = self.session.result
        truncated = result is not None and not arrived and result.outcome == "time_limit"
        step = Transition(
            before=before,
            after=after,
            robot=self._robot.name,
            goal=self._goal,
            world=self.session.scenario.world,
            arrived=arrived,
            timed_out=truncated,
        )
        info: dict[str, Any] = {"time": after.time, "clearance": step.clearance}
        if now.contacts is not None:
            info["contacts"] = int((now.contacts.kind == Contacts.PERSON).sum())
        if result is not None:
            own = [metric for metric in result.metrics if metric.robot == self._robot.name]
            info["outcome"] = "goal" if arrived else result.outcome
            info["metrics"] = {metric.name: metric.value for metric in own if metric.value is not None}
        return self._observation(), self._reward.of(step, result), result is not None and not truncated, truncated, info

    def render(self) -> NDArray[np.uint8] | None:
        """(height, width, 3) the episode from above; None without a render mode."""
        return self._top_view.draw(self.session.view) if self._top_view else None

    def close(self) -> None:
        """End the session."""
        self.session.close()

    def _parts(self, observe: Sequence[str] | None, people: int) -> dict[str, Part]:
        sensors = self.session.view.robots[self._robot.name].sensors
        opened = self.session.scenario
        parts = {
            name: sensed(message, self._robot, opened.world, opened.ending.time_limit, max(people, 1))
            for name, message in sensors.items()
        }
        for name in observe or ():
            if name not in parts:
                raise InputError(
                    f"observe: there is no sensor output '{name}'{near_miss(name, parts)}; {', '.join(parts)}"
                )
            if parts[name] is None:
                raise InputError(f"observe: '{name}' is a {type(sensors[name]).__name__}, which has no known bounds")
        return {name: part for name, part in parts.items() if part and (observe is None or name in observe)}

    def _observation(self) -> Observation:
        view = self.session.view
        own = view.robots[self._robot.name]
        observation = {name: part.array(own.sensors[name]) for name, part in self._sensors.items()}
        observation["goal"] = self._way.array(own)
        if self._people:
            observation["people"] = self._people.array(view)
        return observation

    def _twist(self, action: NDArray[np.float32]) -> Twist:
        speed, left, turn_rate = 0.0, 0.0, 0.0
        values = (self._low + 0.5 * (np.asarray(action, np.float64) + 1.0) * (self._high - self._low)).tolist()
        if len(values) == 3:
            speed, left, turn_rate = values
        else:
            speed, turn_rate = values
        return Twist(linear=Vector3(x=speed, y=left), angular=Vector3(z=turn_rate))


def _only_robot(scenario: str | Path | Mapping[str, Any], settings: Mapping[str, Any] | Sequence[str]) -> str:
    robots = [robot.name for robot in load(scenario, as_list(settings)).robots]
    if len(robots) != 1:
        raise InputError(f"there are {len(robots)} robots, expected robot= one of {', '.join(robots) or 'them'}")
    return robots[0]


def _limits(robot: Robot) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the actions -1 and 1 mean: least and greatest speed ahead, (to the left,) and turn rate."""
    model = robot.model
    low, high = [model.min_speed, -model.max_angular_velocity], [model.max_speed, model.max_angular_velocity]
    if isinstance(model.base, Holonomic):
        low.insert(1, -model.base.max_lateral_speed)
        high.insert(1, model.base.max_lateral_speed)
    return np.array(low), np.array(high)
