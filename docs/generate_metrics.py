"""Writes the tables of `docs/metrics.md` from the metrics themselves: `python docs/generate_metrics.py`."""

from __future__ import annotations

import re
from pathlib import Path

from components.evaluator.metrics import GROUPS

PAGE = Path(__file__).parent / "metrics.md"
BETTER = {"higher": "↑", "lower": "↓", "none": ""}


def table(group: str) -> str:
    """The metrics of a group, one per line."""
    lines = ["| name | symbol | unit | better | what it is |", "|---|---|---|---|---|"]
    for metric in GROUPS[group]:
        unit = "" if metric.unit == "1" else metric.unit
        cells = (f"`{metric.name}`", metric.symbol, unit, BETTER[metric.direction], metric.description)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines)


def generated(text: str) -> str:
    """The page with every table made anew."""
    for group in GROUPS:
        block = rf"(<!-- {group} -->\n).*?(<!-- end -->)"
        text = re.sub(block, lambda m, g=group: f"{m[1]}{table(g)}\n{m[2]}", text, flags=re.DOTALL)  # type: ignore[misc]
    return text


if __name__ == "__main__":
    PAGE.write_text(generated(PAGE.read_text("utf-8")), encoding="utf-8")
