"""crowdcosim: how a robot behaves in a human crowd, before it meets one."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from crowdcosim.component import Component, Controller, Evaluator, Mover, Sensor
from crowdcosim.setup import Setup

if TYPE_CHECKING:
    from orchestrator.session import Session

__version__ = "0.1.0"

__all__ = ["Component", "Controller", "Evaluator", "Mover", "Sensor", "Session", "Setup", "__version__"]


def __getattr__(name: str) -> Any:
    """`Session` comes from the orchestrator, and only for those who ask for it: components must not load it."""
    if name == "Session":
        return importlib.import_module("orchestrator.session").Session
    raise AttributeError(f"module 'crowdcosim' has no attribute '{name}'")
