"""The wheel alone, in a clean environment, and what happens when another package has taken our names."""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import venv
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent.parent


def python(
    executable: Path | str, *arguments: str, folder: Path, **environment: str
) -> subprocess.CompletedProcess[str]:
    clean = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "PYTHONHOME")}
    return subprocess.run(
        [str(executable), *arguments],
        cwd=folder,
        env=clean | environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.fixture(scope="module")
def installed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The interpreter of an environment that has our wheel, and of all else only what the wheel depends on."""
    folder = tmp_path_factory.mktemp("wheel")
    built = python(sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), folder=ROOT)
    assert built.returncode == 0, built.stdout + built.stderr
    (wheel,) = folder.glob("*.whl")
    environment = folder / "environment"
    venv.create(environment, with_pip=False)
    site = next((environment / "lib").glob("python*")) / "site-packages"
    unpacked = python(sys.executable, "-m", "zipfile", "-e", str(wheel), str(site), folder=folder)
    assert unpacked.returncode == 0, unpacked.stderr
    # The dependencies are those of the running environment; a plain path line leaves its editable installs behind.
    (site / "dependencies.pth").write_text(sysconfig.get_path("purelib") + "\n")
    return environment / "bin" / "python"


@pytest.mark.slow
def test_the_wheel_runs_shipped_scenarios_by_name_from_any_folder(installed: Path, tmp_path: Path) -> None:
    place = python(installed, "-c", "import orchestrator; print(orchestrator.__file__)", folder=tmp_path)
    assert str(installed.parent.parent) in place.stdout
    run = python(
        installed, "-m", "crowdcosim", "run", "corridor", "--set", "end.time_limit=2", "--out", "out", folder=tmp_path
    )
    assert run.returncode == 0, run.stdout + run.stderr
    assert (tmp_path / "out" / "episode.mcap").exists()
    listed = python(installed, "-m", "crowdcosim", "list", folder=tmp_path)
    assert "turtlebot2" in listed.stdout


@pytest.mark.parametrize("package", ["components", "orchestrator"])
def test_the_start_says_so_when_another_package_has_taken_our_name(tmp_path: Path, package: str) -> None:
    (tmp_path / package).mkdir()
    (tmp_path / package / "__init__.py").write_text("")
    outcome = python(sys.executable, "-m", "crowdcosim", "list", folder=tmp_path)
    assert outcome.returncode == 2
    assert f"the package '{package}' of crowdcosim was found at {tmp_path}" in outcome.stderr
    assert "Traceback" not in outcome.stderr
