"""Checks that the options of several controllers share."""

from __future__ import annotations

import math


def require_positive(config: object, *names: str) -> None:
    """Raise ValueError that names the first of these fields of `config` that is not positive and finite."""
    for name in names:
        if not 0 < getattr(config, name) < math.inf:
            raise ValueError(f"{name} is {getattr(config, name)}, expected a positive number")


def require_not_negative(config: object, *names: str) -> None:
    """Raise ValueError that names the first of these fields of `config` that is negative or not finite."""
    for name in names:
        if not 0 <= getattr(config, name) < math.inf:
            raise ValueError(f"{name} is {getattr(config, name)}, expected zero or more")
