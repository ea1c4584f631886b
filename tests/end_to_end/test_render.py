"""`crowdcosim render`: films and pictures of a recorded episode."""

from __future__ import annotations

import json
import subprocess
import sys

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from orchestrator.cli import BAD_INPUT, app

SCENARIO = """
extends: corridor
world: {ceiling: 2.8}
crowd: {config: {count: 30}}
reference: false
host: inline
end: {time_limit: 1}
cameras:
  door: {view: fixed, position: [1, 5, 1.6], target: [10, 5, 1.2]}
"""


def crowdcosim(folder, *arguments):
    return subprocess.run(
        [sys.executable, "-m", "crowdcosim", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("render")
    (folder / "hall.yaml").write_text(SCENARIO)
    run = crowdcosim(folder, "run", "hall.yaml", "--out", "run", "--quiet")
    assert run.returncode == 0, run.stderr
    return folder


def test_a_film_has_the_pictures_that_were_asked_for_and_the_same_bytes_each_time(folder):
    for name in ("one.mp4", "two.mp4"):
        options = ("--size", "160x120", "--rate", "10", "--start", "0.2", "--end", "0.8", "--out", str(folder / name))
        made = CliRunner().invoke(app, ["render", str(folder / "run"), "--camera", "robot", *options])
        assert made.exit_code == 0, made.stderr
    assert (folder / "one.mp4").read_bytes() == (folder / "two.mp4").read_bytes()
    frames, seconds = imageio_ffmpeg.count_frames_and_secs(str(folder / "one.mp4"))
    assert (frames, seconds) == (7, pytest.approx(0.7))


def test_a_picture_of_the_scenarios_own_camera(folder):
    made = crowdcosim(folder, "render", "run", "--camera", "door", "--at", "0.55", "--size", "161x121", "--json")
    assert made.returncode == 0, made.stderr
    answer = json.loads(made.stdout)
    assert answer["camera"]["position"] == [1, 5, 1.6]
    picture = np.asarray(Image.open(folder / answer["file"]))
    assert picture.shape == (121, 161, 3)
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 1000


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (("--camera", "folowing"), "did you mean 'following'"),
        (("--at", "99"), "--at is 99, expected from 0 to 1 s"),
        (("--size", "big"), "--size is 'big'"),
        (("--size", "161x120"), "expected even numbers"),
        (("--rate", "0"), "--rate is 0"),
        (("--start", "0.9", "--end", "0.1"), "--end is 0.1"),
        (("--set", "distanse=3"), "did you mean 'distance'"),
        (("--set", "robot=bob"), "there is no robot 'bob'"),
        (("--camera", "robot", "--set", "mount=roof"), "mount is 'roof'"),
    ],
)
def test_what_cannot_be_rendered_is_said(folder, arguments, complaint):
    made = CliRunner().invoke(app, ["render", str(folder / "run"), *arguments])
    assert made.exit_code == BAD_INPUT
    assert complaint in made.stderr
