"""The examples run as they are."""

from __future__ import annotations

from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parent.parent.parent / "examples"


@pytest.mark.parametrize("name", ["my_controller", "plain_controller"])
def test_the_example_runs(crowdcosim, name) -> None:
    settings = ["end.time_limit=2", "crowd.config.count=10", "reference=false"]
    arguments = [part for setting in settings for part in ("--set", setting)]
    outcome = crowdcosim(
        "run", str(EXAMPLES / f"{name}.yaml"), *arguments, "--host", "inline", "--out", "out", "--json"
    )
    assert outcome.code == 0, outcome.stderr
    assert outcome.json["ticks"] == 20
