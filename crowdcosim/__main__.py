"""The command `crowdcosim`: checks that the house is its own, then hands over to the orchestrator."""

from __future__ import annotations

import importlib
import importlib.util
import sys
from pathlib import Path


def _foreign(package: str) -> str | None:
    """Where `package` comes from, if not from beside this one: another distribution may have taken its name."""
    here = Path(__file__).resolve().parent.parent
    spec = importlib.util.find_spec(package)
    if spec is None or spec.origin is None:
        return "nowhere" if spec is None else str(next(iter(spec.submodule_search_locations or ["an unknown place"])))
    found = Path(spec.origin).resolve().parent.parent
    return None if found == here else str(spec.origin)


def main() -> None:
    """Run the command line."""
    for package in ("orchestrator", "components"):
        if place := _foreign(package):
            print(
                f"error: the package '{package}' of crowdcosim was found at {place}, expected beside "
                f"{Path(__file__).resolve().parent}: another distribution or a folder on the path has taken its name. "
                "Install crowdcosim in an environment of its own, or run it from another folder.",
                file=sys.stderr,
            )
            raise SystemExit(2)
    importlib.import_module("orchestrator.cli").main()


if __name__ == "__main__":
    main()
