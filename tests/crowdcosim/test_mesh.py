"""Mesh files: read in every format, placed, cut, and seen by LiDARs and cameras."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from components.sensors import camera, lidar
from crowdcosim.mesh import Mesh, section, triangles
from crowdcosim.messages import BeamAgents, Crowd, RobotState
from crowdcosim.robots import Mount, Pose, Robot, RobotModel, Target
from crowdcosim.setup import Setup
from crowdcosim.world import World
from orchestrator.scenario.problems import ScenarioError
from orchestrator.scenario.scenario import from_resolved, load

EXTENTS = (2.0, 1.0, 3.0)
ROBOT = Robot(
    name="robot",
    number=1,
    model=RobotModel(
        radius=0.2,
        height=0.4,
        mass=20.0,
        max_speed=1.0,
        max_acceleration=5.0,
        max_angular_velocity=3.0,
        max_angular_acceleration=9.0,
    ),
    start=Pose(x=1.0, y=5.0),
    goal=Target(x=19.0, y=5.0),
)


@pytest.fixture(params=["stl", "obj", "glb", "gltf"])
def block(request, tmp_path):
    """A block of 2 x 1 x 3 m around the file's origin, z upwards."""
    box = trimesh.creation.box(EXTENTS)
    path = tmp_path / f"block.{request.param}"
    if request.param in ("glb", "gltf"):
        box.apply_transform(trimesh.transformations.rotation_matrix(-np.pi / 2, (1, 0, 0)))  # y upwards
    if request.param == "gltf":
        for name, data in trimesh.exchange.gltf.export_gltf(trimesh.Scene(box)).items():
            (tmp_path / name).write_bytes(data)
        (tmp_path / "model.gltf").rename(path)
    else:
        box.export(path)
    return path


def setup(mesh):
    world = World(size=(20.0, 10.0), mesh=mesh)
    return Setup(component="robot/eye", period=10**8, seed=1, world=world, robots=(ROBOT,), robot="robot")


def test_every_format_has_the_same_block_with_z_upwards(block):
    corners = triangles(Mesh(file=str(block), position=(5.0, 5.0, 1.5), yaw=np.pi / 2, scale=2.0))
    assert corners.shape == (12, 3, 3)
    # Turned by a right angle, x and y change places.
    np.testing.assert_allclose(corners.min(axis=(0, 1)), (5 - 1.0, 5 - 2.0, 1.5 - 3.0), atol=1e-6)
    np.testing.assert_allclose(corners.max(axis=(0, 1)), (5 + 1.0, 5 + 2.0, 1.5 + 3.0), atol=1e-6)


def test_a_section_goes_round_what_it_cuts():
    ball = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    for height in (-0.5, 0.1, 0.8):
        cut = section(np.asarray(ball.triangles), height)
        length = np.linalg.norm(cut[:, 1] - cut[:, 0], axis=1).sum()
        # A chord of 1/40 of the circumference is 0.1% short, and the plane lies between corners.
        assert length == pytest.approx(2 * np.pi * np.sqrt(1 - height**2), rel=5e-3)
    assert section(np.asarray(ball.triangles), 1.5).shape == (0, 2, 2)


def test_lidar_and_camera_see_it_at_the_same_place(block):
    here = setup(Mesh(file=str(block), position=(5.0, 5.0, 1.5)))
    state = RobotState(name="robot", position=(1.0, 5.0), radius=0.2)
    mount = Mount(position=(0.0, 0.0, 0.5))
    scanner = lidar.Lidar(lidar.Config(mount=mount, beams=361, field_of_view=np.pi))
    eye = camera.DepthCamera(camera.Config(mount=mount, width=65, height=49))
    scanner.reset(here)
    eye.reset(here)
    seen = scanner.step(state, Crowd(), ())
    assert seen.scan.ranges[180] == pytest.approx(3.0, abs=1e-6)
    assert seen.agents.kind[180] == BeamAgents.WALL and seen.agents.agent[180] == 1
    depth = np.frombuffer(eye.step(state, Crowd(), ()).depth.data, np.float32).reshape(49, 65)
    assert depth[24, 32] == pytest.approx(3.0, abs=1e-6)
    high = lidar.Lidar(lidar.Config(mount=Mount(position=(0.0, 0.0, 3.5)), beams=3, field_of_view=0.1))
    high.reset(here)
    assert np.isinf(high.step(state, Crowd(), ()).scan.ranges).all()


def test_a_scenario_finds_it_beside_its_file_and_its_log_says_where(block, tmp_path):
    file = tmp_path / "hall.yaml"
    file.write_text(f"extends: corridor\nworld: {{mesh: {{file: {block.name}, position: [20, 5, 0]}}}}\n")
    scenario = load(str(file))
    assert scenario.world.mesh.file == str(block)
    assert from_resolved(scenario.resolved).world == scenario.world


@pytest.mark.parametrize(
    ("file", "content", "complaint"),
    [
        ("gone.stl", None, "gone.stl', which cannot be read"),
        ("empty.obj", "# nothing\n", "empty.obj', which"),
        ("hall.dae", "", "expected one of the formats .stl"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_refused_where_it_is_written(tmp_path, file, content, complaint):
    if content is not None:
        (tmp_path / file).write_text(content)
    path = tmp_path / "hall.yaml"
    path.write_text(f"extends: corridor\nworld:\n  mesh:\n    file: {file}\n")
    with pytest.raises(ScenarioError) as caught:
        load(str(path))
    assert complaint in str(caught.value) and "hall.yaml:4" in str(caught.value)
