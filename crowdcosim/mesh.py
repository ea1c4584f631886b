"""A mesh file as a part of the world that stands still: triangles for cameras, a level section for scanners."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

FORMATS = (".stl", ".obj", ".glb", ".gltf")


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """A mesh file with z upwards (glTF, which has y upwards, is turned), seen by sensors and touched by nobody."""

    file: str
    """STL, OBJ, GLB or glTF; a path relative to the scenario's file"""
    position: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """of the file's origin in the map [m]"""
    yaw: float = 0.0
    """of the file's x, counter-clockwise from the map's [rad]"""
    scale: float = 1.0
    """metres per unit of the file"""

    def __post_init__(self) -> None:
        if not self.scale > 0:
            raise ValueError(f"scale is {self.scale}, expected a positive number")
        if Path(self.file).suffix.lower() not in FORMATS:
            raise ValueError(f"file is '{self.file}', expected one of the formats {', '.join(FORMATS)}")


@cache
def triangles(mesh: Mesh) -> NDArray[np.float64]:
    """(T, 3, 3) corners in the map [m], without triangles of no area; the array is read-only.

    Raises:
        ValueError: if the file cannot be read or holds no triangles.
    """
    import trimesh  # loads slowly, and few worlds have a mesh

    try:
        loaded = trimesh.load_mesh(mesh.file, process=False)
    except Exception as error:  # each format has failures of its own
        raise ValueError(f"file is '{mesh.file}', which cannot be read: {error}") from None
    corners = np.asarray(getattr(loaded, "triangles", ()), np.float64).reshape(-1, 3, 3)
    if Path(mesh.file).suffix.lower() in (".glb", ".gltf"):
        corners = corners[..., [0, 2, 1]] * (1.0, -1.0, 1.0)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    corners = corners[area > 0.0]
    if not len(corners) or not np.isfinite(corners).all():
        raise ValueError(f"file is '{mesh.file}', which holds no triangles with finite corners")
    cos, sin = math.cos(mesh.yaw), math.sin(mesh.yaw)
    turn = np.array([(cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)])
    placed = np.asarray(mesh.scale * corners @ turn.T + mesh.position)
    placed.setflags(write=False)
    return placed


def section(corners: NDArray[np.float64], height: float) -> NDArray[np.float64]:
    """(S, 2, 2) segments in which the plane at `height` [m] cuts triangles (T, 3, 3) [m]."""
    above = corners[:, :, 2] > height
    cut = corners[above.any(axis=1) & ~above.all(axis=1)]
    if not len(cut):
        return np.zeros((0, 2, 2))
    # The corner that is alone on its side comes first; the plane cuts both edges that leave it.
    above = cut[:, :, 2] > height
    alone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), above.argmin(axis=1))
    order = (alone[:, None] + np.arange(3)) % 3
    a, b, c = np.take_along_axis(cut, order[:, :, None], axis=1).transpose(1, 0, 2)
    ends = [a + ((height - a[:, 2]) / (other[:, 2] - a[:, 2]))[:, None] * (other - a) for other in (b, c)]
    segments = np.stack(ends, axis=1)[:, :, :2]
    return np.asarray(segments[(segments[:, 0] != segments[:, 1]).any(axis=1)])
