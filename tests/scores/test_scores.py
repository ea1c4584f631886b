"""The scores of the smoke suite stay what they are, unless a change says so."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import polars as pl
import pytest

HERE = Path(__file__).parent


@pytest.mark.slow
def test_the_scores_of_the_smoke_suite_have_not_moved() -> None:
    spec = importlib.util.spec_from_file_location("regenerate", HERE / "regenerate.py")
    assert spec is not None and spec.loader is not None
    regenerate = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(regenerate)
    now, before = regenerate.scores(), pl.read_csv(HERE / "smoke.csv")
    assert now.select(regenerate.KEY).equals(before.select(regenerate.KEY))
    moved = []
    for old, new in zip(before.iter_rows(named=True), now.iter_rows(named=True), strict=True):
        changes = [f"{name} {old[name]} -> {new[name]}" for name in regenerate.SCORES if old[name] != new[name]]
        if changes:
            moved.append(f"  {old['scenario']}, {old['controller']}: {', '.join(changes)}")
    assert not moved, (
        f"{len(moved)} of {len(now)} rows of the smoke suite moved:\n" + "\n".join(moved) + "\n"
        "If that is meant: python tests/scores/regenerate.py, and a line under 'Changes scores' in CHANGELOG.md"
    )
