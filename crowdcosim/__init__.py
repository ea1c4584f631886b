"""crowdcosim: how a robot behaves in a human crowd, before it meets one."""

from crowdcosim.component import Component, Controller, Evaluator, Mover, Sensor
from crowdcosim.setup import Setup

__version__ = "0.1.0"

__all__ = ["Component", "Controller", "Evaluator", "Mover", "Sensor", "Setup", "__version__"]
