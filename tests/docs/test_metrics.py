"""The page about metrics says what the metrics say of themselves."""

from __future__ import annotations

import importlib.util
import re
from pathlib import Path

from components.evaluator.metrics import METRICS

DOCS = Path(__file__).parent.parent.parent / "docs"


def test_the_tables_are_those_that_are_generated() -> None:
    spec = importlib.util.spec_from_file_location("generate_metrics", DOCS / "generate_metrics.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    text = (DOCS / "metrics.md").read_text("utf-8")
    assert module.generated(text) == text
    assert all(f"| `{metric.name}` |" in text for metric in METRICS)


def test_the_coverage_of_the_guideline_names_metrics_that_exist() -> None:
    coverage = (DOCS / "metrics.md").read_text("utf-8").partition("## Francis et al. 2023")[2]
    named = set(re.findall(r"`([a-z_]+)`", coverage))
    assert named <= {metric.name for metric in METRICS}
