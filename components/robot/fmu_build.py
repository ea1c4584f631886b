"""Builds the wheel drive of `motor.py` as a co-simulation FMU with this machine's C compiler, once per content."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import tempfile
import zipfile
from collections.abc import Mapping
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Literal

from jinja2 import Environment, StrictUndefined

import crowdcosim
from components.robot.cache import cache_folder
from components.robot.fmu_file import HEADERS, LIBRARY_SUFFIX, PLATFORM, FmuError
from components.robot.fmu_variables import UNITS, variables
from components.robot.motor import INNER_STEP, SWEEPS

Version = Literal["2", "3"]

MODEL = "WheelDrive"
REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"
"""folder of the reference trajectory in the FMU: `reference_in.csv` and `reference_out.csv`"""

_SOURCES = ("wheel_drive.c", "fmi{version}.c")
_OWN_HEADERS = ("wheel_drive.h", "instance.h")
_COMPILERS = ("cc", "gcc", "clang")
# No contraction and no fast math: the same bits as the native model.
_FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-fvisibility=hidden", "-shared")
# One date for all: the archive's bytes depend on its content alone.
_DATE = (1980, 1, 1, 0, 0, 0)


def built_in(version: Version = "3") -> Path:
    """The wheel drive FMU of that version of FMI, from the cache, or built now.

    Raises:
        FmuError: if there is no C compiler, or it fails.
    """
    compiler = find_compiler()
    files = source_files(version)
    content = hashlib.sha256(repr([files, PLATFORM[version], _FLAGS, compiler, _stamp(compiler)]).encode()).hexdigest()
    path = cache_folder("fmu-build") / f"{content[:32]}" / file_name(version)
    if not path.is_file():
        library = compile_library(files, version, compiler)
        path.parent.mkdir(exist_ok=True)
        write_archive(path, files | {f"binaries/{PLATFORM[version]}/{MODEL}{LIBRARY_SUFFIX}": library})
    return path


def file_name(version: Version) -> str:
    """`WheelDrive_fmi3.fmu`"""
    return f"{MODEL}_fmi{version}.fmu"


def find_compiler() -> str:
    """Path of the C compiler: `$CC`, or the first of cc, gcc and clang on the PATH.

    Raises:
        FmuError: if there is none.
    """
    wanted = [os.environ["CC"]] if os.environ.get("CC") else _COMPILERS
    for name in wanted:
        if found := shutil.which(name):
            return found
    raise FmuError(
        f"building an FMU needs a C compiler, and none of {', '.join(wanted)} is on the PATH: install one (Debian and "
        "Ubuntu: apt install gcc; Fedora: dnf install gcc; macOS: xcode-select --install; conda: c-compiler), name "
        "another in the environment variable CC, or drive with the same motors without FMU: leave out `fmu`"
    )


def source_files(version: Version) -> dict[str, bytes]:
    """All files of the FMU but its binary: path in the archive -> content."""
    sources = [name.format(version=version) for name in _SOURCES]
    files = {f"sources/{name}": _read(name).encode() for name in (*sources, *_OWN_HEADERS)}
    token = hashlib.sha256(repr([files, _facts("", sources)]).encode()).hexdigest()[:32]
    facts = _facts(f"{{{token[:8]}-{token[8:12]}-{token[12:16]}-{token[16:20]}-{token[20:]}}}", sources)
    files["sources/variables.h"] = _rendered("variables.h", facts)
    files["modelDescription.xml"] = _rendered(f"modelDescription_{version}.xml", facts)
    if version == "3":
        files["sources/buildDescription.xml"] = _rendered("buildDescription.xml", facts)
    for name in ("fmi-ls-manifest.xml", "reference_in.csv", "reference_out.csv"):
        files[f"{REFERENCE}/{name}"] = _read(name).encode()
    return files


def compile_library(files: Mapping[str, bytes], version: Version, compiler: str) -> bytes:
    """The shared library of the C files among `files`.

    Raises:
        FmuError: if the compiler fails.
    """
    with tempfile.TemporaryDirectory() as folder:
        names = [name.removeprefix("sources/") for name in files if name.startswith("sources/")]
        for name in names:
            Path(folder, name).write_bytes(files[f"sources/{name}"])
        library = Path(folder, f"{MODEL}{LIBRARY_SUFFIX}")
        command = [
            compiler,
            *_FLAGS,
            f"-I{HEADERS}",
            *(n for n in names if n.endswith(".c")),
            "-o",
            str(library),
            "-lm",
        ]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise FmuError(
                f"building the FMU of version {version}.0 failed: {compiler} ended with code {done.returncode}: "
                f"{done.stderr.strip() or 'no message'}; is it a C compiler with its C library's headers? "
                "Another can be named in the environment variable CC"
            )
        return library.read_bytes()


def write_archive(path: Path, files: Mapping[str, bytes]) -> None:
    """Write the FMU; the same files give the same bytes, and nobody ever reads half of one."""
    handle, fresh = tempfile.mkstemp(dir=path.parent, suffix=".part")
    try:
        with os.fdopen(handle, "wb") as stream, zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
            for name in sorted(files):
                entry = zipfile.ZipInfo(name, _DATE)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                archive.writestr(entry, files[name])
        os.chmod(fresh, 0o644)
        os.replace(fresh, path)
    finally:
        Path(fresh).unlink(missing_ok=True)


def _facts(token: str, sources: list[str]) -> dict[str, object]:
    """What the templates say."""
    table = variables()
    return {
        "model": MODEL,
        "token": token,
        "version": crowdcosim.__version__,
        "description": "Two wheels on geared DC motors with regulator, battery and encoders",
        "variables": table,
        "reals": [v for v in table if not v.integer],
        "outputs": [v for v in table if v.causality == "output"],
        "first": {c: next(v.reference for v in table if v.causality == c) for c in ("input", "parameter", "output")},
        "units": UNITS,
        "sources": sources,
        "inner_step": INNER_STEP,
        "sweeps": SWEEPS,
        "experiment": {"stop": 4, "step": 0.05},
    }


def _rendered(template: str, facts: dict[str, object]) -> bytes:
    environment = Environment(
        autoescape=template.endswith(".xml"), undefined=StrictUndefined, keep_trailing_newline=True
    )
    return environment.from_string(_read(f"{template}.jinja")).render(facts).encode()


def _read(name: str) -> str:
    return resources.files("components.robot").joinpath("fmu", name).read_text("utf-8")


@cache
def _stamp(compiler: str) -> str:
    """What the compiler says of its version."""
    return subprocess.run([compiler, "--version"], capture_output=True, text=True, check=False).stdout
