"""`crowdcosim draw`: from a run to a picture and a film."""

from __future__ import annotations

from PIL import Image


def test_a_crowd_without_robots_is_drawn_and_filmed(crowdcosim) -> None:
    settings = ["robots.robot=null", "crowd.config.count=12", "end.time_limit=1", "end.goal=none"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    run = crowdcosim("run", "corridor", *arguments, "--host", "inline", "--out", "out", "--quiet")
    assert run.code == 0, run.stderr
    drawn = crowdcosim("draw", "out", "--json")
    assert drawn.code == 0, drawn.stderr
    with Image.open(crowdcosim.folder / drawn.json["file"]) as picture:
        assert picture.size[0] > 1000
    filmed = crowdcosim("draw", "out", "--out", "films/crowd.gif", "--from", "0.5", "--json")
    assert (filmed.json["from"], filmed.json["to"], filmed.json["frames"]) == (0.5, 1.0, 6)
    with Image.open(crowdcosim.folder / "films/crowd.gif") as film:
        assert film.n_frames == 6
    refused = crowdcosim("draw", "out", "--out", "crowd.webm")
    assert refused.code == 2
    assert "found '.webm', expected a name that ends in one of .png, .svg, .pdf, .gif, .mp4" in refused.stderr
