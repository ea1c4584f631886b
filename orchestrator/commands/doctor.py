"""`crowdcosim doctor`: is a log well-formed?"""

from __future__ import annotations

import json
from pathlib import Path

from rich.console import Console

from orchestrator.log.check import faults

_SHOWN = 20


def print_faults(path: Path, as_json: bool) -> bool:
    """Print everything that is wrong with a log; True if nothing is."""
    found = faults(path)
    if as_json:
        print(json.dumps({"log": str(path), "well_formed": not found, "faults": found}))
        return not found
    console = Console(highlight=False, soft_wrap=True, markup=False)
    for fault in found[:_SHOWN]:
        console.print(f"✗ {fault}", style="red")
    if len(found) > _SHOWN:
        console.print(f"and {len(found) - _SHOWN} more")
    if any("cut off" in fault for fault in found):
        console.print(f"`crowdcosim recover {path}` saves every complete chunk")
    if not found:
        console.print("well-formed", style="green")
    return not found
