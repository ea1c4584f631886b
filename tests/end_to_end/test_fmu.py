"""Motors as FMUs, from the command line: built, inspected, driven with, and what happens when one is broken."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from components.robot.fmu_build import MODEL, compile_library, find_compiler, source_files, write_archive
from components.robot.fmu_file import LIBRARY_SUFFIX, PLATFORM
from orchestrator.log.reader import read_log

HERE = Path(__file__).parent
FAULTY = HERE.parent / "components" / "robot" / "faulty_drive.c"
has_compiler = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="building an FMU needs a C compiler"
)


@pytest.fixture(scope="module")
def cache(tmp_path_factory):
    return tmp_path_factory.mktemp("cache")


@pytest.fixture(autouse=True)
def _own_cache(crowdcosim, cache):
    crowdcosim.environment["XDG_CACHE_HOME"] = str(cache)


def drive(config="", host=""):
    return f'robots: {{robot: {{drive: {{use: "components.robot.wheels:Wheels", config: {{{config}}}{host}}}}}}}\n'


def faulty(folder, fault, at, version="3"):
    """Writes an FMU that drives well until step `at`."""
    files = source_files(version)
    files["sources/wheel_drive.c"] = f'#define FAULT "{fault}"\n#define AT {at}\n{FAULTY.read_text()}'.encode()
    library = compile_library(files, version, find_compiler())
    write_archive(folder / "broken.fmu", files | {f"binaries/{PLATFORM[version]}/{MODEL}{LIBRARY_SUFFIX}": library})


def failed(outcome, *words):
    assert outcome.code == 1, outcome.stderr
    assert "Traceback" not in outcome.stderr
    for word in ("component 'robot'", *words):
        assert word in outcome.stderr


@has_compiler
def test_build_and_inspect(crowdcosim) -> None:
    built = crowdcosim("fmu", "build", "--out", "fmus", "--json")
    assert built.code == 0, built.stderr
    assert sorted(built.json["files"]) == ["2.0", "3.0"]
    for version, file in built.json["files"].items():
        about = crowdcosim("fmu", "inspect", file, "--json")
        assert about.code == 0, about.stderr
        assert (about.json["fmi_version"], about.json["problems"], about.json["usable"]) == (version, [], True)
        speed = next(v for v in about.json["variables"] if v["name"] == "left_speed")
        assert (speed["causality"], speed["unit"]) == ("output", "rad/s")
    shown = crowdcosim("fmu", "inspect", "fmus/WheelDrive_fmi3.fmu")
    assert "FMI 3.0, co-simulation" in shown.stdout
    assert "left_command" in shown.stdout


def test_inspecting_what_is_no_fmu(crowdcosim) -> None:
    (crowdcosim.folder / "text.fmu").write_text("hello")
    outcome = crowdcosim("fmu", "inspect", "text.fmu")
    assert outcome.code == 2
    assert "text.fmu is not an FMU" in outcome.stderr
    assert "Traceback" not in outcome.stderr


def test_building_without_a_compiler(crowdcosim) -> None:
    crowdcosim.environment["PATH"] = str(crowdcosim.folder)
    outcome = crowdcosim("fmu", "build", "--out", "fmus")
    assert outcome.code == 2
    assert "needs a C compiler" in outcome.stderr
    assert "Traceback" not in outcome.stderr


@pytest.mark.slow
@has_compiler
def test_native_motors_and_both_fmus_give_the_same_log(crowdcosim, scenario) -> None:
    """Also in a process of its own, and with a file in the place of the built-in one."""
    assert crowdcosim("fmu", "build", "--out", "fmus").code == 0
    variants = {
        "native": drive(),
        "built-in": drive("fmu: built-in"),
        "process": drive("fmu: built-in", ", host: process"),
        "file": drive("fmu: ./fmus/WheelDrive_fmi2.fmu, parameters: {yaw_inertia: 0.31328999999999996}"),
    }
    hashes = {}
    for name, text in variants.items():
        path = scenario(f"host: inline\nend: {{time_limit: 3}}\n{text}", name.replace("-", "_"))
        outcome = crowdcosim("run", path, "--out", f"out-{name}", "--json")
        assert outcome.code == 0, outcome.stderr
        hashes[name] = outcome.json["data_hash"]
    carried = read_log(crowdcosim.folder / "out-file" / "episode.mcap").attachments["robot/WheelDrive_fmi2.fmu"]
    assert carried == (crowdcosim.folder / "fmus" / "WheelDrive_fmi2.fmu").read_bytes()
    # On machines that round in other ways, they agree to 1e-6 and no further.
    assert len(set(hashes.values())) == 1, hashes


@has_compiler
def test_an_fmu_is_a_controller_inline_and_in_a_process(crowdcosim, scenario) -> None:
    """A wheel as a filter: what it is asked for is the goal's x, and the speed that it reaches becomes the command."""
    assert crowdcosim("fmu", "build", "--out", "fmus").code == 0
    controller = """
robots:
  robot:
    controller:
      use: components.robot.fmu_component:FmuController
      host: HOST
      config:
        file: ./fmus/WheelDrive_fmi3.fmu
        inputs:
          left_command: goal.position[0]
          right_command: odometry.twist.twist.linear.x
        outputs: {left_speed: {field: twist.linear.x, factor: 0.02}}
"""
    hashes = set()
    for host in ("inline", "process"):
        text = "host: inline\nreference: false\nend: {time_limit: 2}\n" + controller.replace("HOST", host)
        outcome = crowdcosim("run", scenario(text, host), "--out", f"out-{host}", "--json")
        assert outcome.code == 0, outcome.stderr
        hashes.add(outcome.json["data_hash"])
    log = read_log(crowdcosim.folder / "out-process" / "episode.mcap")
    assert "robot/controller/WheelDrive_fmi3.fmu" in log.attachments
    assert len(hashes) == 1


@has_compiler
def test_an_fmu_that_crashes_is_named_with_its_signal(crowdcosim, scenario) -> None:
    faulty(crowdcosim.folder, "crash", 205)  # ten communication steps per tick
    path = scenario(drive("fmu: ./broken.fmu") + "reference: false\n")
    failed(crowdcosim("run", path, "--out", "out"), "component 'robot' at tick 20", "killed by SIGSEGV")
    log = crowdcosim("inspect", "out", "--json")
    assert log.json["complete"]
    assert log.json["outcome"]["reason"] == "failed"


@has_compiler
@pytest.mark.parametrize(("version", "host"), [("2", "process"), ("3", "inline")])
def test_an_fmu_that_gives_up_is_quoted(crowdcosim, scenario, version, host) -> None:
    faulty(crowdcosim.folder, "discard", 205, version)
    path = scenario(drive("fmu: ./broken.fmu", f", host: {host}") + "reference: false\n")
    failed(crowdcosim("run", path, "--out", "out"), "at tick 20", "broken.fmu", "Discard", "the solver gave up")


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ("fmu: ./gone.fmu", ["there is no FMU", "gone.fmu"]),
        ("fmu: ./text.fmu", ["text.fmu is not an FMU"]),
        pytest.param(
            "fmu: ./good.fmu, parameters: {gear_ration: 1}", ["did you mean 'gear_ratio'?"], marks=has_compiler
        ),
    ],
)
def test_an_fmu_that_cannot_be_used_is_refused_at_the_start(crowdcosim, scenario, config, words) -> None:
    (crowdcosim.folder / "text.fmu").write_text("hello")
    if "good" in config:
        faulty(crowdcosim.folder, "none", 0)
        (crowdcosim.folder / "broken.fmu").rename(crowdcosim.folder / "good.fmu")
    failed(crowdcosim("run", scenario(drive(config)), "--out", "out"), *words)


def test_without_a_compiler_the_built_in_fmu_says_what_to_do(crowdcosim, scenario) -> None:
    crowdcosim.environment["PATH"] = str(crowdcosim.folder)
    outcome = crowdcosim("run", scenario(drive("fmu: built-in", ", host: inline")), "--out", "out")
    failed(outcome, "needs a C compiler", "leave out `fmu`")


@pytest.mark.parametrize(
    ("config", "words"),
    [
        ("fmu: ./a.fmu, variables: {left_comand: {name: a}}", ["left_comand", "did you mean 'left_command'?"]),
        ("motor: {resistance: 0}", ["resistance is 0.0, expected more than zero"]),
    ],
)
def test_wrong_options_are_refused_with_file_and_line(crowdcosim, scenario, config, words) -> None:
    outcome = crowdcosim("validate", scenario(drive(config)))
    assert outcome.code == 2
    for word in ["small.yaml:3", *words]:
        assert word in outcome.stderr


def test_the_shipped_scenario_with_motors_is_valid(crowdcosim) -> None:
    assert crowdcosim("validate", "corridor_motors").code == 0
