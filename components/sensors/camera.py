"""Pinhole cameras among walking people: colour, depth, and the truth about who is seen and which part of them.

All images of a camera are of the same pixels and the same instant, that of the state. A depth is the distance along the
optical axis, as REP 118 has it: infinite where nothing is within `range_max`, minus infinity where something is nearer
than `range_min`; as 16UC1 both are 0. Colour and labels do not end with the range of depth. People across a seam of the
world are seen; the robot that carries the camera is not.

Frames after REP 103: the camera's own frame, ROBOT/CAMERA, looks along x; images are in ROBOT/CAMERA_optical_frame, x
right, y down, z ahead. Which images there are is a question of which camera: those it does not have cost nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from components.sensors.imperfections import (
    Chain,
    Signal,
)
from components.sensors.rendering.picture import ROBOT_NUMBERS, Picture, Renderer
from components.sensors.rendering.view import View, focal_length, view_of
from components.sensors.surroundings import Surroundings, people_of
from components.sensors.timing import BeamKind, Delivery, require_rate
from crowdcosim.component import Sensor
from crowdcosim.messages import CameraInfo, Crowd, Header, Image, RobotState
from crowdcosim.robots import Mount, RobotModel
from crowdcosim.setup import Setup, nanoseconds_of

_DEFAULT_MOUNT = Mount(position=(0.0, 0.0, 1.0))
_MILLIMETRES = 1000.0
_FARTHEST_16 = 65.535


@dataclass(frozen=True, kw_only=True)
class Config:
    """Options of every camera."""

    mount: str | Mount = _DEFAULT_MOUNT
    """a mount of the robot's by name, or a place"""
    width: int = 320
    """columns [pixels]"""
    height: int = 240
    """rows [pixels]"""
    field_of_view: float = 1.0472
    """from the left edge of the picture to the right one; pixels are square [rad]"""
    range_min: float = 0.1
    """nearest depth that is measured [m]"""
    range_max: float = 50.0
    """farthest depth that is measured [m]"""
    depth_encoding: Literal["32FC1", "16UC1"] = "32FC1"
    """depth in metres, or in whole millimetres"""
    threads: int = 1
    """that draw one picture, each a band of its rows; the picture is the same"""
    rate: float | None = None
    """pictures per second, at most one per step; null: one per step [Hz]"""
    imperfections: tuple[BeamKind, ...] = ()
    """what is wrong with the depth, in this order, and with the time of all images"""

    def __post_init__(self) -> None:
        for name in ("width", "height", "threads"):
            if not getattr(self, name) >= 1:
                raise ValueError(f"{name} is {getattr(self, name)}, expected at least 1")
        if not 0.0 < self.field_of_view < math.pi:
            raise ValueError(f"field_of_view is {self.field_of_view}, expected more than 0 and less than pi")
        if not 0.0 <= self.range_min < self.range_max:
            raise ValueError(f"range_min is {self.range_min}, expected from 0 to below range_max ({self.range_max})")
        if self.depth_encoding == "16UC1" and self.range_max > _FARTHEST_16:
            raise ValueError(f"range_max is {self.range_max}, expected at most {_FARTHEST_16}: 16UC1 holds no more")
        require_rate(self)

    @property
    def focal(self) -> float:
        """Focal length [pixels]."""
        return focal_length(self.width, self.field_of_view)

    @property
    def optical(self) -> bool:
        """There is an optical frame beside the sensor's own."""
        return True

    def frames(self, model: RobotModel) -> Mapping[str, Mount]:
        """The camera's own frame, which is called as the sensor is.

        Raises:
            ValueError: if the robot has no such mount.
        """
        return {"": model.mount(self.mount)}


class ColorImages(NamedTuple):
    """What a `ColorCamera` sees."""

    color: Image
    camera_info: CameraInfo


class DepthImages(NamedTuple):
    """What a `DepthCamera` sees."""

    depth: Image
    camera_info: CameraInfo


class RGBDImages(NamedTuple):
    """What an `RGBDCamera` sees."""

    color: Image
    depth: Image
    camera_info: CameraInfo


class LabelledImages(NamedTuple):
    """What a `LabelledCamera` sees."""

    color: Image
    depth: Image
    agents: Image
    body_parts: Image
    camera_info: CameraInfo


class _Camera(Sensor):
    """What all cameras have in common."""

    outputs: type[tuple[Any, ...]]
    """the NamedTuple of the images that it makes"""

    def __init__(self, config: Config) -> None:
        self.config = config

    def reset(self, setup: Setup) -> None:
        config = self.config
        self._setup = setup
        self._mount = config.frames(setup.own_robot.model)[""]
        self._around = Surroundings(setup, 0.0)
        self._renderer = Renderer(setup.world, threads=config.threads)
        self._begin()
        self._take(0, RobotState(), Crowd(), ())  # Compile now, not in the first step.
        self._begin()

    def _begin(self) -> None:
        config, setup = self.config, self._setup
        self._delivery = Delivery[Any](config.imperfections, config.rate, setup)
        signal = Signal(instruments=config.height, period=self._delivery.period)
        self._chain = Chain(config.imperfections, signal, setup.seed)

    def _step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> Any:
        time = nanoseconds_of(robot.header.stamp)
        return self._delivery.step(time, lambda: self._take(time, robot, crowd, others))

    def _take(self, time: int, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> Any:
        fields = self.outputs._fields  # type: ignore[attr-defined]
        labels = "agents" in fields
        if labels:
            _check_ids(crowd.id)
        heading = np.array([other.heading for other in others], np.float64)
        picture = self._renderer.picture(
            self._view(robot),
            people_of(crowd),
            self._around.robots(others),
            heading,
            colour="color" in fields,
            labels=labels,
        )
        header = Header(stamp=robot.header.stamp, frame_id=f"{self._setup.component}_optical_frame")
        makers: dict[str, Callable[[], object]] = {
            "color": lambda: _image(header, "rgb8", picture.colour),
            "depth": lambda: _image(header, self.config.depth_encoding, self._depth(picture, time)),
            "agents": lambda: _image(header, "mono16", picture.agents),
            "body_parts": lambda: _image(header, "mono8", picture.body_parts),
            "camera_info": lambda: self._info(header),
        }
        return self.outputs(*(makers[name]() for name in fields))

    def _view(self, robot: RobotState) -> View:
        config, (ahead, left, up) = self.config, self._mount.position
        cos, sin = math.cos(robot.heading), math.sin(robot.heading)
        x, y = robot.position.tolist()
        position = (x + cos * ahead - sin * left, y + sin * ahead + cos * left, up)
        yaw = robot.heading + self._mount.yaw
        return view_of(position, yaw, self._mount.pitch, config.width, config.height, config.field_of_view)

    def _depth(self, picture: Picture, time: int) -> NDArray:
        """(H, W) in the encoding of the config."""
        config = self.config
        inverse = picture.inverse_depth
        if self._chain:
            with np.errstate(divide="ignore"):
                readings = 1.0 / inverse.astype(np.float64)
                self._chain.apply(readings, time)
                inverse = (1.0 / readings).astype(np.float32)
        depth = _measured(inverse, config.range_min, config.range_max)
        if config.depth_encoding == "16UC1":
            depth[~np.isfinite(depth)] = 0.0
            return np.rint(depth * np.float32(_MILLIMETRES)).astype(np.uint16)
        return depth

    def _info(self, header: Header) -> CameraInfo:
        config = self.config
        focal, cx, cy = config.focal, 0.5 * (config.width - 1), 0.5 * (config.height - 1)
        return CameraInfo(
            header=header,
            height=config.height,
            width=config.width,
            distortion_model="plumb_bob",
            d=np.zeros(5),
            k=np.array([focal, 0.0, cx, 0.0, focal, cy, 0.0, 0.0, 1.0]),
            r=np.eye(3).ravel(),
            p=np.array([focal, 0.0, cx, 0.0, 0.0, focal, cy, 0.0, 0.0, 0.0, 1.0, 0.0]),
        )


class ColorCamera(_Camera):
    """A colour camera (rgb8)."""

    outputs = ColorImages

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> ColorImages:
        images: ColorImages = self._step(robot, crowd, others)
        return images


class DepthCamera(_Camera):
    """A depth camera (32FC1 or 16UC1)."""

    outputs = DepthImages

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> DepthImages:
        images: DepthImages = self._step(robot, crowd, others)
        return images


class RGBDCamera(_Camera):
    """A colour camera that measures depth."""

    outputs = RGBDImages

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> RGBDImages:
        images: RGBDImages = self._step(robot, crowd, others)
        return images


class LabelledCamera(_Camera):
    """An RGB-D camera with the truth: agents (mono16: a person's id, 65536 - r for robot r, 0 for nobody) and parts of
    the body (mono8, as in `BeamAgents`)."""

    outputs = LabelledImages

    def step(self, robot: RobotState, crowd: Crowd, others: tuple[RobotState, ...]) -> LabelledImages:
        images: LabelledImages = self._step(robot, crowd, others)
        return images


@njit(cache=True, nogil=True, error_model="numpy")
def _measured(inverse: NDArray[np.float32], nearest: float, farthest: float) -> NDArray[np.float32]:
    """(H, W) depths [m] from inverse ones [1/m], infinite where they are out of range."""
    depth = np.empty_like(inverse)
    for v in range(inverse.shape[0]):
        for u in range(inverse.shape[1]):
            d = np.float32(1.0) / inverse[v, u]
            depth[v, u] = np.inf if d > farthest else -np.inf if d < nearest else d
    return depth


def _check_ids(ids: NDArray[np.uint32]) -> None:
    """Raise ValueError if an id does not fit into a picture of agents; its upper end is for robots."""
    most = ROBOT_NUMBERS - 1001
    if len(ids) and ids.max() > most:
        raise ValueError(f"a person's id is {ids.max()}, expected at most {most}: agents are an image of 16 bits")


def _image(header: Header, encoding: str, pixels: NDArray | None) -> Image:
    assert pixels is not None
    height, width = pixels.shape[:2]
    return Image(
        header=header,
        height=height,
        width=width,
        encoding=encoding,
        is_bigendian=0,
        step=pixels.nbytes // height,
        data=np.ascontiguousarray(pixels.astype(pixels.dtype.newbyteorder("<"), copy=False)).view(np.uint8).reshape(-1),
    )
