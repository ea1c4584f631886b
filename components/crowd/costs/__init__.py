"""The cost functions, one a file, and from what a policy writes as `name` to one of them."""

from __future__ import annotations

import dataclasses
import hashlib
import importlib
import importlib.util
import inspect
import json
import math
import sys
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType
from typing import Any

from pydantic import ConfigDict, TypeAdapter, ValidationError

from components.crowd.costs.cost import Cost

SHIPPED = {
    "foe": "foe:Foe",
    "generic": "generic:Generic",
    "goal_reaching": "goal_reaching:GoalReaching",
    "karamouzas": "karamouzas:Karamouzas",
    "moussaid": "moussaid:Moussaid",
    "orca": "orca:OrcaCost",
    "paris": "paris:Paris",
    "pledestrians": "pledestrians:Pledestrians",
    "power_law": "power_law:PowerLaw",
    "random": "random_cost:RandomCost",
    "rvo": "rvo:Rvo",
    "social_force": "social_force:SocialForceCost",
    "ttca_dca": "ttca_dca:TtcaDca",
    "van_toll": "van_toll:VanToll",
    "wall_repulsion": "wall_repulsion:WallRepulsion",
}
"""name -> module and class; a module is imported when it is asked for, since its kernels take time to load"""


class CostError(ValueError):
    """A policy names a cost that is not there, or gives it options that it does not have."""


def make_cost(entry: Mapping[str, Any]) -> tuple[float, Cost]:
    """Coefficient and cost function from an entry of a policy: `name`, `coefficient`, and the cost's options.

    Raises:
        CostError: if there is no such cost, it cannot be imported, or its options do not fit.
    """
    options = dict(entry)
    name = options.pop("name", None)
    if not isinstance(name, str):
        raise CostError(f"name is {name!r}, expected {', '.join(SHIPPED)}, or './my_cost.py:MyCost'")
    coefficient = options.pop("coefficient", 1.0)
    if isinstance(coefficient, bool) or not isinstance(coefficient, int | float) or not math.isfinite(coefficient):
        raise CostError(f"{name}: coefficient is {coefficient!r}, expected a number")
    cls = _cost_class(name)
    if not dataclasses.is_dataclass(cls):
        if options:
            raise CostError(f"{name} has no options (it is no dataclass), found {', '.join(options)}")
        return float(coefficient), cls()
    try:
        return float(coefficient), _adapter(cls).validate_json(json.dumps(options), strict=True)
    except ValidationError as error:
        known = ", ".join(field.name for field in dataclasses.fields(cls)) or "no options"
        what = "; ".join(f"{'.'.join(map(str, e['loc'])) or name}: {e['msg']}" for e in error.errors())
        raise CostError(f"{name}: {what} (it has {known})") from None


def _adapter(cls: type) -> TypeAdapter[Any]:
    """Validator of a cost's options; unknown keys and lossy conversions are refused."""
    if not hasattr(cls, "__pydantic_config__"):
        setattr(cls, "__pydantic_config__", ConfigDict(extra="forbid", allow_inf_nan=False))  # noqa: B010
    return TypeAdapter(cls)


def _cost_class(name: str) -> type[Cost]:
    source, separator, class_name = name.rpartition(":")
    if not separator:
        if name not in SHIPPED:
            near = get_close_matches(name, SHIPPED, 1)
            hint = f"did you mean '{near[0]}'?" if near else "write your own as './my_cost.py:MyCost'"
            raise CostError(f"there is no cost '{name}': {hint} (shipped: {', '.join(SHIPPED)})")
        source, _, class_name = SHIPPED[name].partition(":")
        source = f"{__name__}.{source}"
    module = _from_file(Path(source)) if source.endswith(".py") else _from_name(source)
    cls = getattr(module, class_name, None)
    if not (inspect.isclass(cls) and issubclass(cls, Cost)):
        raise CostError(f"'{source}' has no class '{class_name}' that is a components.crowd.costs.cost.Cost")
    if inspect.isabstract(cls):
        raise CostError(f"'{name}' must define {', '.join(sorted(cls.__abstractmethods__))}()")
    return cls


def _from_name(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise CostError(f"there is no module '{error.name}', asked for by '{name}'") from None
    except Exception as error:
        raise CostError(f"importing '{name}' failed: {type(error).__name__}: {error}") from error


def _from_file(path: Path) -> ModuleType:
    path = path.resolve()
    if not path.is_file():
        raise CostError(f"there is no file {path}")
    # The same file twice is one module, so that its kernels are compiled once.
    name = f"crowdcosim_cost_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except Exception as error:
        del sys.modules[name]
        raise CostError(f"importing {path} failed: {type(error).__name__}: {error}") from error
    return module
