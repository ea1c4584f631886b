"""FMUs as files: what they say of themselves, whether they can be used, and their libraries; the one to import fmpy."""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import tempfile
import zipfile
from collections.abc import Callable, Iterator
from ctypes import byref
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import fmpy
from fmpy import fmi2, fmi3
from fmpy.fmi1 import FMICallException, calloc, free
from fmpy.validation import validate_fmu

from components.robot.cache import cache_folder
from crowdcosim.component import ComponentError

HEADERS = Path(fmpy.__file__).parent / "c-code"
"""Folder of the standard's C headers."""

PLATFORM = {"2": fmpy.platform, "3": fmpy.platform_tuple}
"""FMI major version -> the name of this machine's folder in `binaries/`."""

LIBRARY_SUFFIX = fmpy.sharedLibraryExtension

CallFailed = FMICallException
"""What a call of the library raises that returns Discard or worse, with `function` and `status`."""


class FmuError(ComponentError):
    """An FMU cannot be used, or failed; the message says which, why, and what to do."""


@dataclass(frozen=True, kw_only=True)
class FmuVariable:
    """One variable, as the model description has it."""

    name: str
    causality: str
    variability: str
    type: str
    unit: str
    """empty if it has none"""
    start: str
    """as it is written, empty if it has none"""
    description: str
    reference: int
    scalar: bool


@dataclass(frozen=True, kw_only=True)
class Description:
    """What an FMU says of itself."""

    file: Path
    fmi_version: str
    model: str
    description: str
    tool: str
    kinds: tuple[str, ...]
    """`co-simulation`, `model exchange`, `scheduled execution`"""
    platforms: tuple[str, ...]
    """folders in `binaries/` that hold anything"""
    has_sources: bool
    runs_here: bool
    """has a binary for this machine"""
    variables: tuple[FmuVariable, ...]
    token: str
    """GUID or instantiation token"""
    identifier: str
    """name of the library, empty without co-simulation"""
    once_per_process: bool
    fixed_step: float | None
    """communication steps must be multiples of this [s]"""

    def variable(self, name: str) -> FmuVariable:
        """The variable of that name.

        Raises:
            FmuError: if there is none.
        """
        for variable in self.variables:
            if variable.name == name:
                return variable
        names = {v.name.lower(): v.name for v in self.variables}
        near = get_close_matches(name.lower(), names, 1)
        hint = f" (did you mean '{names[near[0]]}'?)" if near else ""
        raise FmuError(f"{self.file} has no variable '{name}'{hint}; list them: crowdcosim fmu inspect {self.file}")


def describe(file: Path) -> Description:
    """Read the model description of any FMU.

    Raises:
        FmuError: if there is no such file, or it is no FMU.
    """
    names = _names_in(file)
    if "modelDescription.xml" not in names:
        raise FmuError(f"{file} is a zip archive without modelDescription.xml, expected an FMU: export it again")
    try:
        with file.open("rb") as stream:  # given a path, fmpy leaves it open when it fails
            model = fmpy.read_model_description(stream, validate=False)
    except Exception as error:  # fmpy raises anything, lxml's errors among them
        raise FmuError(f"the modelDescription.xml in {file} cannot be read: {error}; export the FMU again") from None
    binaries = sorted({n.split("/")[1] for n in names if n.startswith("binaries/") and not n.endswith("/")})
    kinds = {
        "co-simulation": model.coSimulation,
        "model exchange": model.modelExchange,
        "scheduled execution": getattr(model, "scheduledExecution", None),
    }
    part = model.coSimulation
    identifier = part.modelIdentifier if part is not None else ""
    folder = PLATFORM.get(model.fmiVersion.partition(".")[0], "")
    step = getattr(part, "fixedInternalStepSize", None)
    return Description(
        file=file,
        fmi_version=model.fmiVersion,
        model=model.modelName,
        description=model.description or "",
        tool=model.generationTool or "",
        kinds=tuple(kind for kind, has in kinds.items() if has is not None),
        platforms=tuple(binaries),
        has_sources=any(n.startswith("sources/") and n.endswith((".c", ".cpp")) for n in names),
        runs_here=f"binaries/{folder}/{identifier}{LIBRARY_SUFFIX}" in names,
        variables=tuple(_variable(v) for v in model.modelVariables),
        token=model.guid,
        identifier=identifier,
        once_per_process=bool(getattr(part, "canBeInstantiatedOnlyOncePerProcess", False)),
        fixed_step=float(step) if step else None,
    )


def problems_of(file: Path) -> list[str]:
    """What breaks the standard in an FMU's model description, and in the structure of its archive."""
    with file.open("rb") as stream:
        return list(validate_fmu(stream))


def _variable(variable: Any) -> FmuVariable:
    unit = variable.unit or (variable.declaredType.unit if variable.declaredType is not None else "")
    return FmuVariable(
        name=variable.name,
        causality=variable.causality or "local",
        variability=variable.variability or "",
        type=variable.type,
        unit=unit or "",
        start="" if variable.start is None else str(variable.start),
        description=variable.description or "",
        reference=int(variable.valueReference),
        scalar=not variable.dimensions,
    )


def _names_in(file: Path) -> list[str]:
    if not file.is_file():
        raise FmuError(f"there is no FMU {file}; a path in a scenario begins with ./ and counts from that file")
    try:
        with zipfile.ZipFile(file) as archive:
            return archive.namelist()
    except (zipfile.BadZipFile, OSError) as error:
        raise FmuError(f"{file} is not an FMU: {error}; an FMU is a zip archive: copy or export it again") from None


def check_usable(about: Description) -> None:
    """That it is for co-simulation, of a version and for a platform that we can run.

    Raises:
        FmuError: if it is not.
    """
    if about.fmi_version[:2] not in ("2.", "3."):
        raise FmuError(
            f"{about.file} is of FMI version {about.fmi_version}, expected 2.0 or 3.0: export it for co-simulation in "
            "one of these"
        )
    if "co-simulation" not in about.kinds:
        raise FmuError(
            f"{about.file} is for {' and '.join(about.kinds) or 'nothing'} only, expected co-simulation: export it as "
            "a co-simulation FMU, which brings its own solver"
        )
    if not about.runs_here:
        here = PLATFORM[about.fmi_version[0]]
        advice = "export it for this machine"
        if about.has_sources:
            advice += f", or compile its sources: fmpy compile {about.file}"
        raise FmuError(
            f"{about.file} has no binary for this machine, binaries/{here}/{about.identifier}{LIBRARY_SUFFIX}; "
            f"it has {', '.join(about.platforms) or 'none at all'}: {advice}"
        )


def _extracted(file: Path) -> Path:
    """The folder with the files of this FMU; made once per content, so that no run leaves one behind."""
    content = hashlib.sha256(file.read_bytes()).hexdigest()[:32]
    folder = cache_folder("fmu") / content
    if not folder.is_dir():
        fresh = Path(tempfile.mkdtemp(dir=folder.parent))
        try:
            fmpy.extract(str(file), str(fresh))
            with contextlib.suppress(OSError):  # another process was quicker
                fresh.rename(folder)
        finally:
            shutil.rmtree(fresh, ignore_errors=True)
    return folder


def load_library(about: Description, name: str) -> Any:
    """The FMU's library as fmpy binds it: a class with a method for each function of FMI.

    Raises:
        FmuError: if it cannot be loaded, or lacks a function.
    """
    with same_folder():
        try:
            return (fmi2.FMU2Slave if about.fmi_version[0] == "2" else fmi3.FMU3Slave)(
                guid=about.token,
                modelIdentifier=about.identifier,
                unzipDirectory=str(_extracted(about.file)),
                instanceName=name,
            )
        except AttributeError as error:
            text = f"{error}; FMI requires every function of the standard: ask its maker for a complete one"
        except Exception as error:  # fmpy raises Exception itself
            text = f"{error}; does it need libraries that this machine does not have? See: ldd"
    raise FmuError(f"the library of {about.file} cannot be loaded: {text}")


def callbacks_of_fmi2(note: Callable[[int, bytes], None]) -> Any:
    """The callbacks that an FMI 2.0 instance gets; `note` takes status and text of each message."""
    callbacks = fmi2.fmi2CallbackFunctions()
    callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(lambda _, name, status, category, text: note(status, text))
    callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
    with contextlib.suppress(Exception):  # without the proxy, messages keep their % signs
        from fmpy.logging import addLoggerProxy

        addLoggerProxy(byref(callbacks))
    return callbacks


@contextlib.contextmanager
def same_folder() -> Iterator[None]:
    """FMUs, and what loads them, change the working directory of the process: go back."""
    before = os.getcwd()
    try:
        yield
    finally:
        os.chdir(before)
