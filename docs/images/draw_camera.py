"""Draw `camera.png`: colour, depth, agents and body parts of one camera among the people of the corridor."""

from __future__ import annotations

from pathlib import Path

import matplotlib
import numpy as np
from PIL import Image

from components.sensors.camera import Config, LabelledCamera
from crowdcosim.messages import Crowd, RobotState
from crowdcosim.messages import Image as ImageMessage
from crowdcosim.robots import Mount
from orchestrator.scenario.scenario import load
from orchestrator.session import Session

WIDTH, HEIGHT = 480, 360
SCENARIO = {
    "name": "hall",
    "extends": "corridor",
    "world": {"ceiling": 2.8},
    "crowd": {"config": {"count": 200}},
    "reference": False,
}


def main() -> None:
    scenario = load(SCENARIO)
    with Session(SCENARIO, settings=["host=inline"]) as session:
        view = session.reset()
        for _ in range(30):
            view = session.step()
        robot, crowd = view.robots["robot"].state, view.crowd
    camera = LabelledCamera(Config(width=WIDTH, height=HEIGHT, mount=Mount(position=(0.0, 0.0, 1.1)), range_max=30.0))
    picture(camera, scenario, robot, crowd).save(Path(__file__).with_name("camera.png"), optimize=True)


def picture(camera: LabelledCamera, scenario: object, robot: RobotState, crowd: Crowd) -> Image.Image:
    from orchestrator.simulation import setup_of

    camera.reset(setup_of(scenario, "robot/camera", "robot", 1))
    images = camera.step(robot, crowd, ())
    depth = pixels(images.depth, np.float32)
    near = np.clip(np.nan_to_num(depth, posinf=30.0, neginf=0.0) / 30.0, 0.0, 1.0)
    colours = (np.random.default_rng(1).uniform(60, 255, (65536, 3))).astype(np.uint8)
    colours[0] = 30
    parts = np.array([(30, 30, 30), (230, 160, 40), (90, 170, 220), (60, 110, 190), (200, 90, 110)], np.uint8)
    panels = [
        images.color.data.reshape(HEIGHT, WIDTH, 3),
        (matplotlib.colormaps["viridis_r"](np.sqrt(near))[..., :3] * 255).astype(np.uint8),
        colours[pixels(images.agents, np.uint16)],
        parts[pixels(images.body_parts, np.uint8)],
    ]
    rows = [np.concatenate(panels[k : k + 2], axis=1) for k in (0, 2)]
    return Image.fromarray(np.concatenate(rows)).quantize(256)


def pixels(message: ImageMessage, dtype: type) -> np.ndarray:
    return np.frombuffer(message.data, dtype).reshape(HEIGHT, WIDTH)


if __name__ == "__main__":
    main()
