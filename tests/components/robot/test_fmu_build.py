"""The built-in wheel drive as an FMU: valid, equal to the native model, and true to its reference trajectory."""

from __future__ import annotations

import csv
import ctypes
import io
import re
import shutil
import zipfile
from itertools import pairwise

import numpy as np
import pytest

from components.robot import fmu_build
from components.robot.fmu_build import REFERENCE, built_in, file_name, find_compiler, source_files
from components.robot.fmu_file import HEADERS, FmuError, describe, problems_of
from components.robot.fmu_instance import FmuInstance
from components.robot.motor import BATTERY, SPEED, TORQUE, TURTLEBOT2, Motor, NativeMotors

pytestmark = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="building an FMU needs a C compiler"
)
# What ten decimals of the frozen values, and machines that round in other ways, may leave over 4 s.
AGREE = 1e-6
INPUTS = ["left_command", "right_command", "left_load", "right_load"]


@pytest.fixture(scope="module", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        patch.delenv("CC", raising=False)
        yield


@pytest.fixture(scope="module", params=["2", "3"])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def fmu(version, _own_cache):
    return built_in(version)


def table(text):
    rows = list(csv.reader(io.StringIO(text)))
    return rows[0], np.array(rows[1:], float)


def reference(fmu):
    with zipfile.ZipFile(fmu) as archive:
        parts = [archive.read(f"{REFERENCE}/reference_{side}.csv").decode() for side in ("in", "out")]
    return [table(text) for text in parts]


def test_it_keeps_the_standard(fmu):
    assert problems_of(fmu) == []


def test_it_says_what_it_is(fmu, version):
    about = describe(fmu)
    assert about.fmi_version == f"{version}.0"
    assert about.kinds == ("co-simulation",)
    assert about.runs_here
    assert about.has_sources
    speed = about.variable("left_speed")
    assert (speed.causality, speed.unit, speed.type) == ("output", "rad/s", {"2": "Real", "3": "Float64"}[version])
    gear = about.variable("gear_ratio")
    assert (gear.causality, gear.unit, float(gear.start)) == ("parameter", "", Motor().gear_ratio)


def test_it_replays_its_reference_trajectory(fmu):
    (in_names, inputs), (out_names, outputs) = reference(fmu)
    instance = FmuInstance(fmu, "replay")
    instance.start({})
    write, read = instance.access(in_names[1:]), instance.access(out_names[1:])
    assert read.get() == pytest.approx(outputs[0, 1:], abs=AGREE)
    for row, expected, following in zip(inputs, outputs[1:], pairwise(outputs[:, 0]), strict=True):
        assert row[0] == following[0]
        write.set(row[1:])
        instance.step(row[0], following[1] - following[0])
        assert read.get() == pytest.approx(expected[1:], abs=AGREE)


def test_the_native_model_replays_the_same_trajectory(fmu):
    (_, inputs), (_, outputs) = reference(fmu)
    motors = NativeMotors(Motor(), TURTLEBOT2)
    for row, expected in zip(inputs, outputs[1:], strict=True):
        speeds = motors.step(tuple(row[1:3]), tuple(row[3:]), 0.05)
        assert speeds == pytest.approx(expected[1:3], abs=AGREE)
        assert list(motors.ticks) == expected[-2:].tolist()


def test_native_and_fmu_agree_under_random_commands_and_other_parameters(fmu):
    motor = Motor(gear_ratio=30.0, friction_torque=0.05, proportional_gain=0.7, battery_resistance=0.2)
    native, instance = NativeMotors(motor, TURTLEBOT2), FmuInstance(fmu, "random")
    instance.start({"gear_ratio": 30.0, "friction_torque": 0.05, "proportional_gain": 0.7, "battery_resistance": 0.2})
    names = ["left_speed", "right_speed", "left_torque", "right_torque", "battery_voltage"]
    write, read = instance.access(INPUTS), instance.access(names)
    rng = np.random.default_rng(5)
    worst = 0.0
    for k in range(400):
        if k % 7 == 0:
            row = [*rng.uniform(-40, 40, 2).tolist(), *rng.uniform(-3, 3, 2).tolist()]
        native.step(tuple(row[:2]), tuple(row[2:]), 0.01)
        write.set(row)
        instance.step(k * 0.01, 0.01)
        state = [*native.state[SPEED : SPEED + 2], *native.state[TORQUE : TORQUE + 2], native.state[BATTERY]]
        worst = max(worst, np.abs(np.array(state) - read.get()).max())
    assert worst < AGREE


def test_a_second_start_begins_anew(fmu):
    instance = FmuInstance(fmu, "twice")
    write, read = instance.access(INPUTS), instance.access(["left_speed", "left_angle"])
    seen = []
    for _ in range(2):
        instance.start({})
        write.set([10.0, 10.0, 0.0, 0.0])
        for k in range(20):
            instance.step(k * 0.01, 0.01)
        seen.append(read.get())
    assert seen[0] == seen[1]


def test_two_instances_do_not_know_of_each_other(fmu):
    one, other = FmuInstance(fmu, "one"), FmuInstance(fmu, "other")
    for instance, speed in ((one, 10.0), (other, -10.0)):
        instance.start({})
        instance.access(INPUTS).set([speed, speed, 0.0, 0.0])
    for k in range(300):
        one.step(k * 0.01, 0.01)
        other.step(k * 0.01, 0.01)
    assert one.access(["left_speed"]).get() == [-x for x in other.access(["left_speed"]).get()]


@pytest.mark.parametrize(
    ("parameters", "words"),
    [
        ({"gear_ratio": 0.0}, ["a parameter is not a positive number"]),
        ({"gear_ration": 1.0}, ["no variable 'gear_ration'", "did you mean 'gear_ratio'?", "fmu inspect"]),
        ({"gear_ratio": "high"}, ["'gear_ratio'", "'high'", "expected a number"]),
        ({"left_speed": 1.0}, ["only inputs and parameters can be set"]),
    ],
)
def test_wrong_parameters_are_refused(fmu, parameters, words):
    with pytest.raises(FmuError) as error:
        FmuInstance(fmu, "wrong").start(parameters)
    for word in [*words, str(fmu)]:
        assert word in str(error.value)


def test_an_input_that_is_not_finite_is_not_stepped_over(fmu):
    instance = FmuInstance(fmu, "nan")
    instance.start({})
    instance.access(["left_command"]).set([float("nan")])
    with pytest.raises(FmuError, match=r"DoStep returned Discard; it said: .*an input is not a finite number"):
        instance.step(0.0, 0.01)


def test_it_is_built_once_per_content(version, monkeypatch):
    path = built_in(version)
    before = path.stat().st_mtime_ns
    monkeypatch.setattr(fmu_build, "compile_library", None)
    assert built_in(version) == path
    assert path.stat().st_mtime_ns == before
    assert path.name == file_name(version)


def test_other_sources_are_another_fmu(version, monkeypatch):
    path = built_in(version)
    monkeypatch.setattr(fmu_build, "INNER_STEP", 1e-4)
    assert built_in(version) != path


def test_the_same_sources_give_the_same_bytes(version, tmp_path, monkeypatch):
    first = built_in(version).read_bytes()
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert built_in(version).read_bytes() == first


def test_every_function_of_the_standard_is_there(version, fmu, tmp_path):
    about = describe(fmu)
    with zipfile.ZipFile(fmu) as archive:
        archive.extractall(tmp_path)
    (library,) = tmp_path.glob(f"binaries/*/{about.identifier}*")
    names = re.findall(
        rf"_Export fmi{version}\w+TYPE\s+(fmi{version}\w+);", (HEADERS / f"fmi{version}Functions.h").read_text()
    )
    assert len(names) == {"2": 44, "3": 75}[version]
    loaded = ctypes.CDLL(str(library))
    assert [name for name in names if not hasattr(loaded, name)] == []


def test_without_a_compiler_it_says_what_to_do(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(FmuError, match=r"needs a C compiler.*apt install gcc.*leave out `fmu`"):
        built_in("3")
    monkeypatch.setenv("CC", "no-such-cc")
    with pytest.raises(FmuError, match="none of no-such-cc is on the PATH"):
        find_compiler()


def test_a_compiler_that_fails_is_quoted(monkeypatch, tmp_path):
    compiler = tmp_path / "cc"
    compiler.write_text("#!/bin/sh\necho 'stdint.h: no such file' >&2\nexit 3\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("CC", str(compiler))
    with pytest.raises(FmuError, match=r"ended with code 3: stdint.h: no such file"):
        built_in("3")


def test_the_c_code_compiles_without_a_warning(version, monkeypatch):
    monkeypatch.setattr(fmu_build, "_FLAGS", (*fmu_build._FLAGS, "-Wall", "-Wextra", "-Wpedantic", "-Werror"))
    assert fmu_build.compile_library(source_files(version), version, find_compiler())
