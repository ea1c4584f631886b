"""Time the sensors in the paper's densest corridor beside ray casters: `python benchmarks/sensors.py [--people 350]`.

Each row is the median of a whole step of a component, posing and messages included, with people who move in between.
embree (embreex) and MuJoCo (if it is installed: `pip install mujoco`) see the same people as 17 capsules each; their
rows have the posing and the change of the scene apart from the scan. All in one run, on one thread.
"""

from __future__ import annotations

import argparse
import math
import time
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from components.sensors import camera, detections, imu, lidar, ultrasound
from components.sensors.imperfections import Dropout, MixedPixels, RangeDependent
from crowdcosim.avatar import pose
from crowdcosim.messages import Crowd, Header, RobotState
from crowdcosim.robots import Mount
from crowdcosim.setup import Setup, time_of
from orchestrator.scenario.scenario import load

BEAMS, RANGE, HEIGHT = 720, 10.0, 0.3
NOISE = (
    RangeDependent(kind="range_dependent", deviation=0.01, per_metre=0.005),
    Dropout(kind="dropout", probability=0.01),
    MixedPixels(kind="mixed_pixels"),
)


class Row(NamedTuple):
    """One line of the table."""

    name: str
    milliseconds: float


class Corridor:
    """The corridor with people who walk, and a robot in its middle."""

    def __init__(self, people: int) -> None:
        scenario = load("corridor")
        self.setup = Setup(
            component="robot/sensor",
            period=scenario.period,
            seed=1,
            world=scenario.world,
            robots=scenario.robots,
            robot="robot",
        )
        rng = np.random.default_rng(1)
        self._start = rng.uniform((0, 0), scenario.world.size, (people, 2))
        self._velocity = rng.normal((-1.3, 0.0), (0.2, 0.1), (people, 2))
        self._phase, self._stature = rng.random(people), rng.uniform(1.55, 1.9, people)

    def at(self, tick: int) -> tuple[RobotState, Crowd]:
        """The states at a tick."""
        header = Header(stamp=time_of(tick * self.setup.period), frame_id="map")
        seconds, n = tick * self.setup.dt, len(self._start)
        crowd = Crowd(
            header=header,
            id=np.arange(1, n + 1),
            group=np.zeros(n, np.uint32),
            position=self.setup.world.wrap(self._start + seconds * self._velocity),
            velocity=self._velocity,
            heading=np.arctan2(self._velocity[:, 1], self._velocity[:, 0]),
            radius=np.full(n, 0.3),
            stature=self._stature,
            mass=np.full(n, 70.0),
            gait_phase=(self._phase + 0.9 * seconds) % 1.0,
            gait_speed=np.hypot(*self._velocity.T),
        )
        return RobotState(header=header, name="robot", position=[25.0, 5.0], heading=0.1 * tick, radius=0.177), crowd


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--people", type=int, default=350)
    parser.add_argument("--ticks", type=int, default=200)
    options = parser.parse_args()
    corridor = Corridor(options.people)
    print(f"{options.people} people in 500 m2; {BEAMS} beams, {RANGE:g} m, all around, {HEIGHT} m above the floor\n")
    for rows in (own_rows, camera_rows, embree_rows, mujoco_rows):
        for row in rows(corridor, options.ticks):
            print(f"{row.name:<64}{row.milliseconds:8.3f} ms", flush=True)


def median(run: Callable[[int], Any], ticks: int) -> float:
    """Of the time of `run(tick)` [ms]; the first few warm up."""
    times = []
    for tick in range(ticks):
        begin = time.perf_counter()
        run(tick)
        times.append(time.perf_counter() - begin)
    return 1e3 * float(np.median(times[ticks // 10 :]))


def own_rows(corridor: Corridor, ticks: int) -> Iterator[Row]:
    """Our components, each a whole step, and what is in it."""
    states = [corridor.at(tick) for tick in range(ticks)]
    mounts = [Mount(position=(0.13, 0.0, HEIGHT)), Mount(position=(-0.13, 0.0, HEIGHT), yaw=math.pi)]
    for text, noise in (("", ()), (", noise, dropout, mixed pixels", NOISE)):
        pair = [lidar.Lidar(lidar.Config(mount=mount, imperfections=noise)) for mount in mounts]
        for sensor in pair:
            sensor.reset(corridor.setup)

        def both(tick: int, pair: list[lidar.Lidar] = pair) -> None:
            for sensor in pair:
                sensor.step(*states[tick], ())

        yield Row(f"2 LiDARs{text}", median(both, ticks))
    sensors: dict[str, Any] = {
        "12 ultrasounds of 15 degrees, 4 m, 45 rays each": ultrasound.Ultrasound(ultrasound.Config()),
        "people tracker, 10 m": detections.PeopleTracker(detections.Config()),
    }
    for name, sensor in sensors.items():
        sensor.reset(corridor.setup)
        yield Row(name, median(lambda tick, sensor=sensor: sensor.step(*states[tick], ()), ticks))
    unit = imu.InertialUnit(imu.Config())
    unit.reset(corridor.setup)
    yield Row("IMU", median(lambda tick: unit.step(states[tick][0]), ticks))
    yield Row("posing everybody's 17 capsules", median(lambda tick: posed(states[tick][1]), ticks))


CAMERA = Mount(position=(0.0, 0.0, 1.0))
PICTURES = ((320, 240), (640, 480))
CAMERAS = {
    "depth": camera.DepthCamera,
    "colour, depth": camera.RGBDCamera,
    "colour, depth, agents, parts": camera.LabelledCamera,
}


def camera_rows(corridor: Corridor, ticks: int) -> Iterator[Row]:
    """Our cameras, on one thread and on two."""
    states = [corridor.at(tick) for tick in range(max(ticks // 4, 20))]
    for width, height in PICTURES:
        for threads in (1, 2):
            for images, cls in CAMERAS.items():
                sensor = cls(camera.Config(mount=CAMERA, width=width, height=height, threads=threads))
                sensor.reset(corridor.setup)
                time = median(lambda tick, sensor=sensor: sensor.step(*states[tick], ()), len(states))
                yield Row(f"camera {width} x {height}, {threads} thread(s): {images}", time)


def pixel_rays(width: int, height: int) -> np.ndarray:
    """(W H, 3) level, as our cameras look."""
    focal = 0.5 * width / math.tan(0.5 * camera.Config.field_of_view)
    u, v = np.meshgrid((np.arange(width) - 0.5 * (width - 1)) / focal, (np.arange(height) - 0.5 * (height - 1)) / focal)
    return np.ascontiguousarray(np.stack([np.ones_like(u), -u, -v], axis=-1).reshape(-1, 3), np.float32)


def posed(crowd: Crowd) -> np.ndarray:
    return pose(crowd.position, crowd.velocity, crowd.heading, crowd.stature, crowd.gait_phase)


def rays() -> np.ndarray:
    """(B, 3) unit vectors, level and all around."""
    angles = 2.0 * math.pi * np.arange(BEAMS) / BEAMS
    return np.column_stack([np.cos(angles), np.sin(angles), np.zeros(BEAMS)])


def embree_rows(corridor: Corridor, ticks: int) -> Iterator[Row]:
    """The same by embree, with 8 x 5 quads per capsule, which are built anew at every step."""
    try:
        from embreex import rtcore_scene
        from embreex.mesh_construction import TriangleMesh
    except ImportError:
        print("(embreex is not installed)")
        return
    template, faces = _unit_capsule(8, 2)
    directions = np.ascontiguousarray(rays(), np.float32)
    eye = np.array([25.0, 5.0, HEIGHT])
    scenes = {}

    def build(tick: int) -> None:
        capsules = posed(corridor.at(tick)[1]).reshape(-1, 7)
        corners = _capsule_corners(template, capsules) - eye
        indices = faces + len(template) * np.arange(len(corners))[:, None, None]
        scene = rtcore_scene.EmbreeScene()
        vertices = corners.reshape(-1, 3).astype(np.float32)
        scenes[0] = (scene, TriangleMesh(scene, vertices, indices.reshape(-1, 3).astype(np.int32)))
        scene.run(np.zeros((1, 3), np.float32), directions[:1], output=1)  # commits the scene

    def cast(tick: int) -> None:
        scenes[0][0].run(np.zeros_like(directions), directions, output=1)

    yield Row("embree: pose, triangles, build", median(build, max(ticks // 20, 5)))
    yield Row("embree: 1 scan, one thread per core", median(cast, ticks))
    for width, height in PICTURES:
        directions = pixel_rays(width, height)
        time = median(cast, max(ticks // 10, 5))
        yield Row(f"embree: rays of a camera {width} x {height}, no colour", time)


def mujoco_rows(corridor: Corridor, ticks: int) -> Iterator[Row]:
    """The same by MuJoCo's `mj_multiRay` with capsules of its own."""
    try:
        import mujoco
    except ImportError:
        print("(MuJoCo is not installed)")
        return
    capsules = posed(corridor.at(0)[1]).reshape(-1, 7)
    half = 0.5 * np.linalg.norm(capsules[:, 3:6] - capsules[:, 0:3], axis=1)
    geoms = "".join(
        f'<body mocap="true"><geom type="capsule" size="{capsule[6]} {h}"/></body>'
        for capsule, h in zip(capsules, half, strict=True)
    )
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{geoms}</worldbody></mujoco>")
    data = mujoco.MjData(model)
    directions, eye = rays().ravel(), np.array([25.0, 5.0, HEIGHT])
    geom, distance = np.zeros(BEAMS, np.int32), np.zeros(BEAMS)

    def move(tick: int) -> None:
        ends = posed(corridor.at(tick)[1]).reshape(-1, 7)
        data.mocap_pos[:] = 0.5 * (ends[:, 0:3] + ends[:, 3:6])
        axis = ends[:, 3:6] - ends[:, 0:3]
        axis /= np.linalg.norm(axis, axis=1)[:, None]
        # The turn from z to the axis.
        data.mocap_quat[:] = np.column_stack([1.0 + axis[:, 2], -axis[:, 1], axis[:, 0], np.zeros(len(axis))])
        data.mocap_quat[:] /= np.linalg.norm(data.mocap_quat, axis=1)[:, None]
        mujoco.mj_kinematics(model, data)

    def cast(tick: int) -> None:
        mujoco.mj_multiRay(model, data, eye, directions, None, 1, -1, geom, distance, None, BEAMS, RANGE)

    move(0)
    yield Row("MuJoCo: pose, kinematics", median(move, max(ticks // 20, 5)))
    try:
        cast(0)
    except TypeError:  # releases differ in whether they return normals

        def cast(tick: int) -> None:
            mujoco.mj_multiRay(model, data, eye, directions, None, 1, -1, geom, distance, BEAMS, RANGE)

    yield Row("MuJoCo: 1 scan (mj_multiRay)", median(cast, max(ticks // 20, 5)))


def _unit_capsule(around: int, along: int) -> tuple[np.ndarray, np.ndarray]:
    """((P, 4), (T, 3)): of each corner its direction (right, up, axis) and its end, 0 or 1; corners of triangles."""
    angle = 2.0 * math.pi * np.arange(around) / around
    rings = [(t, end) for end, low in ((0, -0.5), (1, 0.0)) for t in math.pi * np.linspace(low, low + 0.5, along + 1)]
    corners = np.array(
        [(math.cos(t) * math.cos(a), math.cos(t) * math.sin(a), math.sin(t), end) for t, end in rings for a in angle]
    )
    grid = np.arange(len(corners)).reshape(len(rings), around)
    here, right, above, across = grid[:-1], np.roll(grid, -1, 1)[:-1], grid[1:], np.roll(grid, -1, 1)[1:]
    faces = np.concatenate([np.stack([here, right, across], -1), np.stack([here, across, above], -1)])
    return corners, faces.reshape(-1, 3)


def _capsule_corners(template: np.ndarray, capsules: np.ndarray) -> np.ndarray:
    """(C, P, 3) corners of capsules (C, 7) in the map [m]."""
    a, b, radius = capsules[:, None, 0:3], capsules[:, None, 3:6], capsules[:, None, 6:7]
    axis = (b - a) / np.linalg.norm(b - a, axis=2, keepdims=True)
    helper = np.where(np.abs(axis[..., :1]) < 0.5, (1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    right = np.cross(axis, helper)
    right /= np.linalg.norm(right, axis=2, keepdims=True)
    up = np.cross(axis, right)
    r, u, along, end = (template[None, :, k : k + 1] for k in range(4))
    return a + end * (b - a) + radius * (r * right + u * up + along * axis)


if __name__ == "__main__":
    main()
