"""Lists of messages as JSON files."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any


def save_dico(name: str | Path, dico: Any) -> None:
    """Write to `NAME.json`; its folder is made if there is none."""
    path = Path(f"{name}.json")
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(dico, indent=4), "utf-8")


def load_file_as_list_of_dico(name: str | Path) -> Any:
    """What such a file holds; `name` with its suffix."""
    return json.loads(Path(name).read_text("utf-8"))
