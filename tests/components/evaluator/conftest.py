"""Scenes in closed form, and what the evaluator says of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import pytest

from components.evaluator.metrics import GROUPS
from components.evaluator.paper import Config, PaperEvaluator
from crowdcosim import Setup
from crowdcosim.messages import Contacts, Crowd, Metrics, RobotState
from crowdcosim.robots import Pose, Robot, RobotModel, Target
from crowdcosim.world import World

Frame = tuple[Crowd, tuple[RobotState, ...], tuple[Contacts, ...]]

MODEL = RobotModel(
    radius=0.2,
    height=0.4,
    mass=20.0,
    max_speed=1.0,
    max_acceleration=5.0,
    max_angular_velocity=3.0,
    max_angular_acceleration=10.0,
)


class Scene:
    """Builds messages and setups; every unnamed robot is called "robot"."""

    def crowd(
        self, position: Any = (), velocity: Any = None, heading: Any = None, ids: Sequence[int] | None = None
    ) -> Crowd:
        position = np.reshape(np.asarray(position, float), (-1, 2))
        n = len(position)
        return Crowd(
            id=np.arange(1, n + 1) if ids is None else ids,
            group=np.zeros(n, np.uint32),
            position=position,
            velocity=np.zeros((n, 2)) if velocity is None else velocity,
            heading=np.zeros(n) if heading is None else heading,
            radius=np.full(n, 0.3),
            stature=np.full(n, 1.7),
            mass=np.full(n, 70.0),
            gait_phase=np.zeros(n),
            gait_speed=np.zeros(n),
        )

    def robot(
        self,
        position: Sequence[float],
        velocity: Sequence[float] = (0.0, 0.0),
        heading: float = 0.0,
        angular_velocity: float = 0.0,
        name: str = "robot",
    ) -> RobotState:
        return RobotState(
            name=name,
            position=position,
            velocity=velocity,
            heading=heading,
            angular_velocity=angular_velocity,
            radius=MODEL.radius,
        )

    def contacts(self, *touches: Mapping[str, Any], robot: str = "robot") -> Contacts:
        """Each touch: `duration`, `energy`, `kind`, ..., as far as it is not a person's first touch without energy."""
        n = len(touches)
        return Contacts(
            robot=robot,
            kind=[t.get("kind", Contacts.PERSON) for t in touches],
            agent=range(1, n + 1),
            body_part=[0] * n,
            robot_part=[Contacts.FRONT] * n,
            striker=[Contacts.BY_BOTH] * n,
            position=np.zeros((n, 2)),
            normal=np.zeros((n, 2)),
            relative_velocity=np.zeros((n, 2)),
            approach_speed=[t.get("approach_speed", 0.0) for t in touches],
            robot_closing_speed=[t.get("robot_closing_speed", 0.0) for t in touches],
            reflected_mass=np.zeros(n),
            energy=[t.get("energy", 0.0) for t in touches],
            duration=[t.get("duration", 0.0) for t in touches],
        )

    def setup(
        self,
        *,
        dt: float = 0.1,
        goal: float = 1000.0,
        names: Sequence[str] = ("robot",),
        world: World | None = None,
        alone: bool = False,
        reference: Mapping[str, Mapping[str, float]] | None = None,
    ) -> Setup:
        """Robots are asked to cross the line x = `goal`."""
        return Setup(
            component="evaluator",
            period=round(dt * 1e9),
            seed=1,
            world=world or World(size=(50.0, 10.0)),
            robots=tuple(
                Robot(
                    name=name,
                    number=number,
                    model=MODEL,
                    start=Pose(x=0.0, y=5.0),
                    goal=Target(x=goal, y=5.0, direction=(1.0, 0.0)),
                )
                for number, name in enumerate(names, 1)
            ),
            alone=alone,
            reference=reference,
        )

    def drive(
        self,
        steps: int,
        *,
        dt: float = 0.1,
        speed: float = 1.0,
        start: Sequence[float] = (0.0, 5.0),
        crowd: Callable[[float], Crowd] | None = None,
        touches: Mapping[int, Sequence[Mapping[str, Any]]] | None = None,
    ) -> list[Frame]:
        """The frames k = 0, ..., `steps` of a robot that drives along x at constant speed, `crowd(t)` around it."""
        return [
            (
                crowd(k * dt) if crowd else self.crowd(),
                (self.robot((start[0] + speed * k * dt, start[1]), (speed, 0.0)),),
                (self.contacts(*(touches or {}).get(k, ())),),
            )
            for k in range(steps + 1)
        ]

    def metrics(
        self, frames: Iterable[Frame], setup: Setup | None = None, metrics: Iterable[str] = GROUPS, **options: Any
    ) -> Metrics:
        evaluator = PaperEvaluator(config=Config(metrics=tuple(metrics)))
        evaluator.reset(setup or self.setup(**options))
        for frame in frames:
            evaluator.step(*frame)
        return evaluator.finish()

    def judge(self, frames: Iterable[Frame], robot: str = "robot", **options: Any) -> dict[str, float | str]:
        """Metric -> value of one robot, or the reason why there is none."""
        m = self.metrics(frames, **options)
        return {
            m.name[i]: float(m.value[i]) if m.valid[i] else m.reason[i]
            for i in range(len(m.name))
            if m.robot[i] == robot
        }


@pytest.fixture
def scene() -> Scene:
    return Scene()
