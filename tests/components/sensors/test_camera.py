"""Cameras: what their images hold, where there is nothing, where somebody is too near, and across a seam."""

from __future__ import annotations

import math

import numpy as np
import pytest

from components.sensors.camera import ColorCamera, Config, DepthCamera, LabelledCamera, RGBDCamera
from components.sensors.imperfections import Gaussian
from components.sensors.rendering.clothing import clothing
from components.sensors.rendering.scenery import ears
from crowdcosim.component import ports_of
from crowdcosim.messages import Contacts, Crowd
from crowdcosim.obstacles import Box, Polygon
from crowdcosim.robots import Mount
from crowdcosim.world import Wall, World

OPEN = World(size=(50.0, 10.0))
LOW = Mount(position=(0.0, 0.0, 0.5))


@pytest.fixture(scope="module")
def see(setup):
    """The images of a camera on robot1, as arrays by name."""

    def take(config, own, crowd, others=(), world=OPEN, cls=LabelledCamera):
        camera = cls(config)
        camera.reset(setup(world))
        images = camera.step(own, crowd, others)
        return {name: pixels(image) for name, image in images._asdict().items() if name != "camera_info"}

    return take


def pixels(image):
    dtype = {"rgb8": "u1", "mono8": "u1", "mono16": "<u2", "16UC1": "<u2", "32FC1": "<f4"}[image.encoding]
    array = np.frombuffer(image.data, dtype)
    assert image.step * image.height == len(image.data)
    return array.reshape(image.height, image.width, 3) if image.encoding == "rgb8" else array.reshape(image.height, -1)


def test_only_the_images_of_its_kind_are_ports():
    names = {cls: [port.name for port in ports_of(cls).outputs] for cls in (ColorCamera, DepthCamera, RGBDCamera)}
    assert names[ColorCamera] == ["color", "camera_info"]
    assert names[DepthCamera] == ["depth", "camera_info"]
    assert names[RGBDCamera] == ["color", "depth", "camera_info"]


def test_depth_is_measured_along_the_optical_axis(see, robot, people):
    world = World(size=(50.0, 10.0), walls=(Wall(start=(8.0, 0.0), end=(8.0, 10.0), height=9.0),))
    images = see(Config(mount=LOW, width=64, height=48), robot(3.0, 5.0), people(), world=world)
    wall = images["depth"][:20]
    np.testing.assert_allclose(wall, 5.0, rtol=1e-6)  # the same at the edges of the picture


def test_floor_is_as_far_as_the_angle_says(see, robot, people):
    config = Config(mount=Mount(position=(0.0, 0.0, 0.5), pitch=0.4), width=65, height=49, range_max=60.0)
    images = see(config, robot(3.0, 5.0), people())
    # The ray in the middle goes down by the pitch.
    assert images["depth"][24, 32] == pytest.approx(0.5 / math.sin(0.4), rel=1e-6)


def test_camera_info_projects_a_point_to_the_pixel_that_sees_it(setup, robot, people):
    config = Config(mount=LOW, width=200, height=150, field_of_view=1.2)
    camera = LabelledCamera(config)
    camera.reset(setup(OPEN))
    images = camera.step(robot(3.0, 5.0), people((7.0, 5.8)), ())
    info, agents = images.camera_info, pixels(images.agents)
    k = info.k.reshape(3, 3)
    # The person's middle, 0.9 m up, in the optical frame: x right, y down, z ahead.
    u, v, w = k @ np.array([-0.8, 0.5 - 0.9, 4.0])
    columns = np.flatnonzero((agents == 101).any(axis=0))
    assert agents[round(v / w), round(u / w)] == 101
    assert columns.mean() == pytest.approx(u / w, abs=2.0)  # arms swing
    assert info.distortion_model == "plumb_bob" and not info.d.any()
    assert info.header.frame_id == images.color.header.frame_id == "robot1/sensor_optical_frame"
    np.testing.assert_array_equal(info.p.reshape(3, 4)[:, :3], k)


def test_labels_say_who_and_which_part(see, robot, people):
    images = see(Config(mount=LOW), robot(3.0, 5.0), people((7.0, 5.0)), (robot(7.0, 6.5, number=2),))
    agents, parts = images["agents"], images["body_parts"]
    assert set(np.unique(agents)) == {0, 101, 65536 - 2}
    assert set(np.unique(parts)) == {0, Contacts.FEET, Contacts.LOWER_LEGS, Contacts.UPPER_LEGS, Contacts.UPPER_BODY}
    np.testing.assert_array_equal(parts > 0, agents == 101)
    rows = {part: np.nonzero(parts == part)[0].mean() for part in np.unique(parts) if part}
    assert rows[Contacts.FEET] > rows[Contacts.LOWER_LEGS] > rows[Contacts.UPPER_LEGS] > rows[Contacts.UPPER_BODY]


def test_an_empty_world_is_floor_and_sky(see, robot, people):
    images = see(Config(mount=LOW, width=32, height=24), robot(3.0, 5.0), people())
    assert not images["agents"].any() and not images["body_parts"].any()
    assert np.isposinf(images["depth"][:11]).all()
    assert np.isfinite(images["depth"][15:]).all()


def test_a_camera_inside_a_person_sees_that_person_too_near(see, robot, people):
    config = Config(mount=Mount(position=(0.0, 0.0, 1.2)), width=32, height=24)
    images = see(config, robot(3.0, 5.07), people((3.0, 5.0), (6.0, 5.0)))
    assert (images["agents"] == 101).all()
    assert np.isneginf(images["depth"]).all()


def test_what_is_nearer_or_farther_than_it_measures_is_infinite_and_still_labelled(see, robot, people):
    config = Config(mount=LOW, range_min=2.0, range_max=5.0, width=160, height=120)
    images = see(config, robot(3.0, 5.0), people((4.5, 5.0), (13.0, 6.5)))
    assert np.isneginf(images["depth"][images["agents"] == 101]).all()
    assert np.isposinf(images["depth"][images["agents"] == 102]).all() and (images["agents"] == 102).any()


def test_sixteen_bits_hold_millimetres(see, robot, people):
    config = Config(mount=LOW, width=64, height=48, range_max=6.0)
    metres = see(config, robot(3.0, 5.0), people((6.0, 5.0)))["depth"]
    thin = Config(mount=LOW, width=64, height=48, range_max=6.0, depth_encoding="16UC1")
    millimetres = see(thin, robot(3.0, 5.0), people((6.0, 5.0)), cls=DepthCamera)["depth"]
    known = np.isfinite(metres)
    np.testing.assert_allclose(millimetres[known] / 1000.0, metres[known], atol=0.5001e-3)
    assert (millimetres[~known] == 0).all()


def test_people_across_the_seam_are_seen(see, robot, people):
    config = Config(mount=LOW, width=160, height=120, range_max=100.0)
    apart = see(config, robot(48.0, 5.0), people((2.0, 5.2)), world=World(size=(50.0, 10.0)))
    across = see(config, robot(48.0, 5.0), people((2.0, 5.2)), world=World(size=(50.0, 10.0), periodic=(True, False)))
    straight = see(config, robot(18.0, 5.0), people((22.0, 5.2)))
    assert not (apart["agents"] == 101).any()
    # One period farther on, 54 m away, they are seen once more.
    once = across["depth"] < 50.0
    assert (across["agents"][~once] == 101).sum() < 4
    np.testing.assert_array_equal(across["agents"][once], straight["agents"][once])
    np.testing.assert_allclose(across["depth"][once], straight["depth"][once], rtol=1e-6)


def test_walls_all_around_hide_nobody_who_could_be_seen(see, robot, people):
    corners = [(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]
    walls = tuple(Wall(start=a, end=b) for a, b in zip(corners, corners[1:] + corners[:1], strict=True))
    crowd = people((0.05, 5.0), (19.9, 2.0), (10.0, 0.1), (10.0, 9.9), (3.0, 4.0), heading=0.7)
    for heading in np.linspace(-3.0, 3.0, 7):
        config = Config(mount=Mount(position=(0.0, 0.0, 1.2)), width=160, height=120, field_of_view=1.4)
        for world in (World(size=(20.0, 10.0), periodic=(True, True), walls=walls),):
            walled = see(config, robot(10.0, 5.0, heading), crowd, world=world)
            # A fifth wall, elsewhere, and one wall in two parts: not known to be all around.
            halves = (Wall(start=(0.0, 0.0), end=(9.0, 0.0)), Wall(start=(9.0, 0.0), end=(20.0, 0.0)))
            open_ = World(size=(20.0, 10.0), periodic=(True, True), walls=halves + walls[1:])
            searched = see(config, robot(10.0, 5.0, heading), crowd, world=open_)
            np.testing.assert_array_equal(walled["agents"], searched["agents"])


def test_pictures_are_the_same_from_one_and_from_more_threads(see, robot, people):
    rng = np.random.default_rng(5)
    crowd = people(*rng.uniform((4, 0), (20, 10), (60, 2)), heading=2.0)
    world = World(
        size=(50.0, 10.0),
        periodic=(True, True),
        walls=(Wall(start=(0.0, 0.0), end=(50.0, 0.0)),),
        obstacles=(Box(shape="box", centre=(9.0, 8.0), size=(1.0, 2.0), yaw=0.4, height=0.8),),
        ceiling=2.6,
    )
    pictures = [
        see(Config(threads=threads, height=121), robot(3.0, 5.0), crowd, (robot(6.0, 4.0, number=2),), world=world)
        for threads in (1, 2, 3)
    ]
    for name, first in pictures[0].items():
        for other in pictures[1:]:
            np.testing.assert_array_equal(first, other[name])


def test_edges_are_smooth_in_colour_only(see, robot, people):
    images = see(Config(mount=LOW), robot(3.0, 5.0), people((6.0, 5.0)))
    agents, color = images["agents"], images["color"].astype(int)
    assert set(np.unique(agents)) == {0, 101}
    # Along the person's left outline in the upper half some pixels are mixtures: between the sky's colour and theirs.
    mixtures = 0
    for row in range(40, 100):
        edge = np.flatnonzero(agents[row] == 101)[0]
        sky, body = color[row, edge - 3], color[row, edge + 2]
        for u in (edge - 1, edge):
            share = (color[row, u] - sky) @ (body - sky) / ((body - sky) @ (body - sky))
            mixtures += 0.1 < share < 0.9
    assert mixtures > 25


def test_people_are_dressed_by_their_ids():
    once, again = clothing(np.arange(1, 500, dtype=np.uint32)), clothing(np.arange(250, 750, dtype=np.uint32))
    np.testing.assert_array_equal(once.colour[249:], again.colour[:250])
    assert len(np.unique(once.colour.reshape(499, -1), axis=0)) > 490


def test_imperfections_change_the_depth_and_nothing_else(see, robot, people):
    exact = see(Config(mount=LOW), robot(3.0, 5.0), people((6.0, 5.0)))
    noisy = see(
        Config(mount=LOW, imperfections=(Gaussian(kind="gaussian", deviation=0.02),)),
        robot(3.0, 5.0),
        people((6.0, 5.0)),
    )
    person = exact["agents"] == 101
    difference = noisy["depth"][person] - exact["depth"][person]
    # The deviation of n samples is known to 3 sigma = 3 / sqrt(2 n).
    assert difference.std() == pytest.approx(0.02, rel=3 / math.sqrt(2 * person.sum()))
    np.testing.assert_array_equal(noisy["color"], exact["color"])


def test_a_concave_top_is_cut_into_triangles_of_the_same_area():
    outline = Polygon(shape="polygon", corners=((0, 0), (4, 0), (4, 3), (2, 1), (0, 3), (0, 1.5))).outline
    triangles = np.array([outline[list(ear)] for ear in ears(outline)])
    u, v = triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]
    assert 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() == pytest.approx(8.0)


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"width": 0}, "width is 0"),
        ({"field_of_view": 3.2}, "field_of_view is 3.2"),
        ({"range_min": 3.0, "range_max": 2.0}, "range_min is 3.0"),
        ({"depth_encoding": "16UC1", "range_max": 70.0}, "range_max is 70.0"),
    ],
)
def test_wrong_options_are_refused(options, complaint):
    with pytest.raises(ValueError, match=complaint):
        Config(**options)


def test_an_id_that_does_not_fit_is_refused(setup, robot):
    camera = LabelledCamera(Config(width=8, height=6))
    camera.reset(setup(OPEN))
    crowd = Crowd(
        id=np.array([70_000]),
        group=np.zeros(1, np.uint32),
        **{name: np.ones(1) for name in ("heading", "radius", "stature", "mass", "gait_phase", "gait_speed")},
        position=np.ones((1, 2)),
        velocity=np.ones((1, 2)),
    )
    with pytest.raises(ValueError, match="70000"):
        camera.step(robot(3.0, 5.0), crowd, ())
