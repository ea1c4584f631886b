"""What ran: versions, platform, commit."""

from __future__ import annotations

import platform
import subprocess
from functools import cache
from importlib.metadata import version
from pathlib import Path

from crowdcosim import __version__

PACKAGES = ("numpy", "numba", "pymunk", "eclipse-zenoh", "rosbags", "mcap")


@cache
def versions() -> dict[str, str]:
    """Versions of crowdcosim, of Python and of what results may depend on, the platform, and the commit."""
    return {
        "crowdcosim": __version__,
        "python": platform.python_version(),
        "platform": platform.platform(),
        "git_commit": git_commit(),
        **{package: version(package) for package in PACKAGES},
    }


@cache
def git_commit() -> str:
    """The commit of the checkout that runs, with `-dirty` where files differ from it; empty for an installed wheel."""
    here = Path(__file__).parents[2]
    if not (here / ".git").exists():
        return ""
    command = ["git", "-C", str(here), "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        answer = subprocess.run(command, capture_output=True, text=True, timeout=5, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return answer.stdout.strip()
