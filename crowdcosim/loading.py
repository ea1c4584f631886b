"""From a component's import string, such as `package.module:Class` or `./mine.py:Mine`, to its class."""

from __future__ import annotations

import hashlib
import importlib
import importlib.util
import inspect
import sys
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType
from typing import Any

from crowdcosim.component import Component, ComponentError


def load_class(use: str) -> type[Component]:
    """The component class that `use` names: `package.module:Class`, or `path/to/file.py:Class`.

    Raises:
        ComponentError: if there is no such file, module or class, if importing it fails, or it is no component.
    """
    cls = load_attribute(use)
    if not (inspect.isclass(cls) and issubclass(cls, Component)):
        raise ComponentError(
            f"'{use}' is not a subclass of crowdcosim.Component (Controller, Sensor, Mover, Evaluator)"
        )
    return cls


def load_attribute(use: str) -> Any:
    """What `use` names: `package.module:name`, or `path/to/file.py:name`.

    Raises:
        ComponentError: if there is no such file, module or name, or if importing it fails.
    """
    source, separator, name = use.rpartition(":")
    if not separator or not source or not name:
        raise ComponentError(f"'{use}' is not a component: expected 'package.module:Class' or './file.py:Class'")
    module = load_file(Path(source)) if source.endswith(".py") else _from_name(source)
    found = getattr(module, name, None)
    if found is None:
        classes = [n for n, c in vars(module).items() if inspect.isclass(c) and c.__module__ == module.__name__]
        near = get_close_matches(name, classes, 1)
        hint = f"did you mean '{near[0]}'?" if near else f"it has {', '.join(classes) or 'no classes'}"
        raise ComponentError(f"'{source}' has no class '{name}': {hint}")
    return found


def _from_name(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        raise ComponentError(f"there is no module '{error.name}', asked for by '{name}'") from None
    except (Exception, SystemExit) as error:
        raise ComponentError(f"importing '{name}' failed: {type(error).__name__}: {error}") from error


def load_file(path: Path) -> ModuleType:
    """The module in a file; asked for twice, it is the same one.

    Raises:
        ComponentError: if there is no such file, or importing it fails.
    """
    path = path.resolve()
    if not path.is_file():
        raise ComponentError(f"there is no file {path}")
    # Two files of one name in different folders are different modules; the same file twice is one.
    name = f"crowdcosim_file_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    if name in sys.modules:
        return sys.modules[name]
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise ComponentError(f"importing {path} failed: {type(error).__name__}: {error}") from error
    return module
