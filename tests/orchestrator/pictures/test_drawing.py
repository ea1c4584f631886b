"""Pictures and films of runs: nobody is drawn across the world at a seam, and files are what their names say."""

from dataclasses import replace

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

from crowdcosim.messages import Crowd
from crowdcosim.obstacles import Disc
from crowdcosim.robots import Target
from crowdcosim.world import World
from orchestrator.errors import InputError
from orchestrator.pictures.map_film import _instants, save_film
from orchestrator.pictures.map_picture import images, save_picture, unbroken
from orchestrator.pictures.trajectories import RobotPath, Trajectories

WORLD = World(size=(10.0, 4.0), periodic=(True, False), obstacles=(Disc(shape="disc", centre=(5.0, 1.0), radius=0.5),))


def people(time):
    """Person 3 walks over the seam at x = 10; person 4 comes at 0.5 s and goes at 1.5 s."""
    there = [True, 0.5 <= time <= 1.5]
    x = np.array([(9.0 + time) % 10.0, 2.0])[there]
    n = len(x)
    return Crowd(
        id=np.array([3, 4], np.uint32)[there],
        group=np.zeros(n, np.uint32),
        position=np.column_stack([x, np.full(n, 2.0)]),
        velocity=np.tile((1.0, 0.0), (n, 1)),
        heading=np.zeros(n),
        radius=np.full(n, 0.3),
        stature=np.full(n, 1.7),
        mass=np.full(n, 70.0),
        gait_phase=np.zeros(n),
        gait_speed=np.ones(n),
    )


@pytest.fixture
def run():
    time = np.arange(21) * 0.1
    robot = RobotPath(
        name="robot",
        radius=0.2,
        goal=Target(x=8.0, y=3.0),
        time=time,
        position=np.column_stack([1.0 + time, np.full(21, 3.0)]),
        heading=np.zeros(21),
    )
    return Trajectories(
        scenario="test",
        description="Two & one.",
        world=WORLD,
        time=time,
        crowd=tuple(map(people, time)),
        robots=(robot,),
    )


def test_ways_are_everybodys_own(run):
    (first, time, _), (second, short, place) = run.ways()
    assert (first, second) == (3, 4)
    assert len(time) == 21
    assert short == pytest.approx(np.arange(5, 16) * 0.1)
    assert (place == (2.0, 2.0)).all()


def test_a_way_breaks_at_the_seam_and_where_somebody_was_away(run):
    _, time, place = next(run.ways())
    assert list(unbroken(time, place, WORLD, 0.1)) == [(0, 10), (10, 21)]
    away = np.r_[0:4, 9:14]
    still = np.tile((2.0, 2.0), (9, 1))
    assert list(unbroken(0.1 * away, still, WORLD, 0.1)) == [(0, 4), (4, 9)]


def test_who_stands_on_a_seam_is_drawn_at_both_sides():
    centres, index = images(np.array([(0.1, 2.0), (5.0, 0.1)]), np.full(2, 0.3), WORLD)
    assert sorted(map(tuple, centres.round(6).tolist())) == [(0.1, 2.0), (5.0, 0.1), (10.1, 2.0)]
    assert sorted(index) == [0, 0, 1]


def test_a_part_of_a_run_is_what_happened_then(run):
    part = run.within(0.5, 1.0)
    assert part.time == pytest.approx(np.arange(5, 11) * 0.1)
    assert len(part.robots[0].position) == len(part.crowd) == 6
    assert run.within(None, None).time == pytest.approx(run.time)
    with pytest.raises(InputError, match="nothing from 3 to 4 s: the run lasts from 0 to 2 s"):
        run.within(3.0, 4.0)


@pytest.mark.parametrize(("suffix", "begins"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")])
def test_a_picture_is_the_same_bytes_every_time(run, tmp_path, suffix, begins):
    files = [tmp_path / f"{name}{suffix}" for name in "ab"]
    for file in files:
        save_picture(run, file, dpi=40)
    one, other = (file.read_bytes() for file in files)
    assert one.startswith(begins)
    assert one == other


def test_a_picture_shows_the_robot_the_obstacle_and_the_ways_in_their_colours(run, tmp_path):
    def colours(drawn):
        save_picture(drawn, tmp_path / "p.png", dpi=60)
        pixels = np.asarray(Image.open(tmp_path / "p.png").convert("RGB")).reshape(-1, 3)
        return {tuple(c) for c in pixels}

    whole, without = colours(run), colours(replace(run, robots=()))
    vermilion, grey = (0xD5, 0x5E, 0x00), (0xC9, 0xC6, 0xC0)
    assert vermilion in whole
    assert vermilion not in without
    assert grey in whole
    assert grey not in colours(replace(run, world=replace(WORLD, obstacles=())))


def test_frames_are_the_nearest_instants(run):
    assert _instants(run, 5.0).tolist() == list(range(0, 21, 2))
    assert _instants(run, 4.0).tolist() == [0, 2, 5, 7, 10, 12, 15, 17, 20]


def test_a_gif_has_a_frame_for_each_and_people_move_in_it(run, tmp_path):
    told = []
    assert save_film(run, tmp_path / "f.gif", fps=5.0, dpi=40, told=lambda *progress: told.append(progress)) == 11
    assert told == [(k, 11) for k in range(11)]
    with Image.open(tmp_path / "f.gif") as film:
        assert film.n_frames == 11
        assert film.info["duration"] == 200
        first = np.asarray(film.convert("RGB"))
        film.seek(5)
        assert (np.asarray(film.convert("RGB")) != first).any()


def test_an_mp4_can_be_read_again(run, tmp_path):
    save_film(run, tmp_path / "f.mp4", fps=10.0, dpi=40, told=lambda *_: None)
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(tmp_path / "f.mp4"))
    assert frames == 21
    assert seconds == pytest.approx(2.1, abs=0.05)
    with pytest.raises(InputError, match="nowhere"):
        save_film(run, tmp_path / "nowhere" / "f.mp4", dpi=40, told=lambda *_: None)


def test_a_run_without_people_or_without_robots_can_be_drawn(run, tmp_path):
    save_picture(replace(run, robots=()), tmp_path / "crowd.png", dpi=40)
    save_picture(replace(run, crowd=(Crowd(),) * 21), tmp_path / "robot.png", dpi=40)
    save_film(replace(run, crowd=(Crowd(),) * 21), tmp_path / "robot.gif", fps=2.0, dpi=40, told=lambda *_: None)
