"""Where things are kept that can be made again."""

from __future__ import annotations

import os
import sys
from pathlib import Path


def cache_folder(name: str) -> Path:
    """The folder `name` of this user's cache, made if it is not there: `$XDG_CACHE_HOME/crowdcosim/` or its like."""
    if root := os.environ.get("XDG_CACHE_HOME"):
        base = Path(root)
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    elif sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home()))
    else:
        base = Path.home() / ".cache"
    folder = base / "crowdcosim" / name
    folder.mkdir(parents=True, exist_ok=True)
    return folder
