"""Options of cost functions that differ from person to person.

Costs are computed for many people at once, with the same options: a policy with an option that is distributed becomes
`VARIANTS` policies, each with another quantile of the distribution, and everybody follows one of them, drawn with the
seed. Where several options are distributed, the quantiles of each are shifted by the golden ratio against those of the
one before (a rank-1 lattice), so that all values are met by some combination with the others.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from components.crowd.distributions import Bell, Normal, Uniform, quantile

VARIANTS = 8
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0
FORMS = "{uniform: [LEAST, GREATEST]} or {normal: {mean, deviation, limits}}"
MANY = 16
"""options of one cost before those of the next"""


def varies(options: Mapping[str, Any]) -> bool:
    """True if an option is distributed."""
    return any(_is_distributed(value) for value in options.values())


def of_variant(options: Mapping[str, Any], variant: int, cost: int) -> dict[str, Any]:
    """The options of a recipe's n-th cost, with one value for each that is distributed.

    Raises:
        ValueError: if a distribution is not one, with the name of the option.
    """
    settled = {}
    for number, (name, value) in enumerate(options.items()):
        if _is_distributed(value):
            share = ((variant + 0.5) / VARIANTS + (cost * MANY + number) * GOLDEN) % 1.0
            try:
                settled[name] = quantile(_distribution(value), share)
            except (KeyError, TypeError, ValueError) as error:
                raise ValueError(f"{name}: {error}; expected {FORMS}") from None
        else:
            settled[name] = value
    return settled


def _is_distributed(value: Any) -> bool:
    return isinstance(value, Mapping) and ("normal" in value or "uniform" in value)


def _distribution(value: Mapping[str, Any]) -> Normal | Uniform:
    if "uniform" in value:
        low, high = value["uniform"]
        return Uniform(uniform=(float(low), float(high)), **{k: v for k, v in value.items() if k != "uniform"})
    bell = dict(value["normal"])
    low, high = bell.pop("limits")
    return Normal(
        normal=Bell(limits=(float(low), float(high)), **bell), **{k: v for k, v in value.items() if k != "normal"}
    )
