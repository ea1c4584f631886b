"""FMUs that cannot be used, or fail, say so: what, why, and what to do."""

from __future__ import annotations

import os
import shutil
import zipfile
from pathlib import Path

import pytest

from components.robot.fmu_build import MODEL, compile_library, find_compiler, source_files, write_archive
from components.robot.fmu_file import LIBRARY_SUFFIX, PLATFORM, FmuError, describe
from components.robot.fmu_instance import FmuInstance

pytestmark = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="building an FMU needs a C compiler"
)
FAULTY = (Path(__file__).parent / "faulty_drive.c").read_text()


@pytest.fixture(scope="module", autouse=True)
def _own_cache(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(scope="module", params=["2", "3"])
def version(request):
    return request.param


@pytest.fixture(scope="module")
def make(version, tmp_path_factory):
    """Writes an FMU whose wheels follow at once, with a fault, or with other words in its model description."""
    libraries = {}

    def write(fault="none", at=0, *, replace=(), without=None):
        files = source_files(version)
        text = f'#define FAULT "{fault}"\n#define AT {at}\n{FAULTY}'
        files["sources/wheel_drive.c"] = text.encode()
        if (fault, at) not in libraries:
            libraries[fault, at] = compile_library(files, version, find_compiler())
        files[f"binaries/{PLATFORM[version]}/{MODEL}{LIBRARY_SUFFIX}"] = libraries[fault, at]
        xml = files["modelDescription.xml"].decode()
        for old, new in replace:
            assert old in xml
            xml = xml.replace(old, new)
        files["modelDescription.xml"] = xml.encode()
        path = tmp_path_factory.mktemp("fmu") / "Faulty.fmu"
        write_archive(path, {n: c for n, c in files.items() if without is None or not n.startswith(without)})
        return path

    return write


def refused(file, *words):
    with pytest.raises(FmuError) as error:
        FmuInstance(file, "test").start({})
    for word in (str(file), *words):
        assert word in str(error.value)


def test_a_missing_file(tmp_path):
    refused(tmp_path / "gone.fmu", "there is no FMU", "counts from that file")


def test_a_file_that_is_no_zip(tmp_path):
    (tmp_path / "text.fmu").write_text("hello")
    refused(tmp_path / "text.fmu", "is not an FMU", "an FMU is a zip archive")


def test_a_zip_without_model_description(tmp_path):
    with zipfile.ZipFile(tmp_path / "zip.fmu", "w") as archive:
        archive.writestr("readme.txt", "hello")
    refused(tmp_path / "zip.fmu", "without modelDescription.xml")


@pytest.mark.parametrize("text", ["<fmiModelDescription", "<other/>", ""])
def test_a_model_description_that_cannot_be_read(tmp_path, text):
    with zipfile.ZipFile(tmp_path / "bad.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", text)
    refused(tmp_path / "bad.fmu", "modelDescription.xml", "cannot be read", "export the FMU again")


def test_fmi_1_is_named_and_refused(tmp_path):
    with zipfile.ZipFile(tmp_path / "old.fmu", "w") as archive:
        archive.writestr(
            "modelDescription.xml",
            '<?xml version="1.0"?><fmiModelDescription fmiVersion="1.0" modelName="m" modelIdentifier="m" guid="g" '
            'numberOfContinuousStates="0" numberOfEventIndicators="0"><ModelVariables/></fmiModelDescription>',
        )
    assert describe(tmp_path / "old.fmu").fmi_version == "1.0"
    refused(tmp_path / "old.fmu", "FMI version 1.0", "expected 2.0 or 3.0")


def test_no_binary_for_this_platform(make):
    refused(make(without="binaries/"), "no binary for this machine", "it has none at all", "fmpy compile")


def test_model_exchange_only(make, version):
    me = '<ModelExchange modelIdentifier="WheelDrive"/>'
    file = make()
    with zipfile.ZipFile(file) as archive:
        xml = archive.read("modelDescription.xml").decode()
    begin = xml.index("<CoSimulation")
    end = xml.index("<UnitDefinitions>")
    refused(make(replace=[(xml[begin:end], me)]), "is for model exchange only", "export it as a co-simulation FMU")


def test_a_binary_that_is_no_library(make, version, tmp_path):
    file = tmp_path / "garbage.fmu"
    with zipfile.ZipFile(make()) as source, zipfile.ZipFile(file, "w") as target:
        for name in source.namelist():
            target.writestr(name, b"garbage" if name.startswith("binaries/") else source.read(name))
    refused(file, "the library of", "cannot be loaded")


def test_a_binary_that_lacks_a_function(make, version, tmp_path):
    files = source_files(version)
    name = f"sources/fmi{version}.c"
    files[name] = (
        files[name].replace(f"fmi{version}GetString".encode(), b"fmiOther").replace(b"NO_VARIABLES(String)", b"")
    )
    library = compile_library(files, version, find_compiler())
    path = tmp_path / "lacking.fmu"
    write_archive(path, files | {f"binaries/{PLATFORM[version]}/{MODEL}{LIBRARY_SUFFIX}": library})
    refused(path, f"fmi{version}GetString", "every function of the standard")


def test_an_fmu_of_another_token(make):
    file = make()
    refused(
        make(replace=[(f'="{describe(file).token}"', '="other"')]), "failed to initialize", "is not that of this binary"
    )


def test_an_fmu_that_refuses_to_start(make):
    refused(make("start"), "failed to initialize", "ExitInitializationMode returned Error", "no battery found")


def test_a_step_that_is_discarded(make):
    instance = FmuInstance(make("discard", 3), "test")
    instance.start({})
    for k in range(3):
        instance.step(k * 0.01, 0.01)
    with pytest.raises(
        FmuError, match=r"step from t = 0.03 s to 0.04 s: .*DoStep returned Discard.*the solver gave up"
    ):
        instance.step(0.03, 0.01)


def test_an_instance_can_start_again_after_it_failed(make):
    instance = FmuInstance(make("discard", 0), "test")
    for _ in range(2):
        instance.start({})
        with pytest.raises(FmuError, match="the solver gave up"):
            instance.step(0.0, 0.01)


def test_variables_that_are_no_numbers_cannot_be_parts(make):
    with pytest.raises(FmuError, match=r"no variable 'left_sped' \(did you mean 'left_speed'\?\)"):
        FmuInstance(make(), "test").access(["left_sped"])


def test_integers_are_numbers_too(make):
    instance = FmuInstance(make(), "test")
    instance.start({})
    read = instance.access(["left_ticks", "left_speed", "right_ticks"])
    instance.access(["left_command"]).set([2.5])
    instance.step(0.0, 0.01)
    assert read.get() == [1, 2.5, 2]


def test_one_instance_per_process_is_respected(make):
    file = make(replace=[("canHandleVar", 'canBeInstantiatedOnlyOncePerProcess="true" canHandleVar')])
    first = FmuInstance(file, "first")
    first.start({})
    first.start({})
    with pytest.raises(FmuError, match=r"allows one instance per process.*host: process"):
        FmuInstance(file, "second").start({})


def test_the_working_directory_stays(make):
    before = os.getcwd()
    FmuInstance(make(), "test").start({})
    assert os.getcwd() == before


def test_an_fmu_is_extracted_once_per_content(make):
    file = make()
    cache = Path(os.environ["XDG_CACHE_HOME"]) / "crowdcosim" / "fmu"
    FmuInstance(file, "first")
    folders = sorted(cache.iterdir())
    FmuInstance(file, "second")
    assert sorted(cache.iterdir()) == folders
