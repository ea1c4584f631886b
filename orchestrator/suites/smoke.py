"""Ten of the paper's hundred scenarios: every behaviour and flow twice, every density, in a minute."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.suites.frozen import Frozen
from orchestrator.suites.paper import BEHAVIOURS, DENSITIES, FLOWS


def smoke() -> Iterator[Frozen]:
    """Each extends the scenario of the same name in `paper`."""
    flows = list(FLOWS)
    for number in range(10):
        behaviour = BEHAVIOURS[number % 5]
        flow = flows[(number + number // 5) % 5]
        count = DENSITIES[number % 4]
        name = f"{behaviour.name}_{flow}_{count:03d}"
        yield Frozen(
            name=name,
            comment="Frozen: written by `crowdcosim generate smoke`.",
            body={
                "extends": f"paper/{name}",
                "description": f"{count} people walk {FLOWS[flow]}: {behaviour.words}.",
            },
        )
