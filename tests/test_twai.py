"""The port for ESP32's TWAI and its example, on a model of both drivers of ESP-IDF."""

import subprocess
from pathlib import Path

import pytest
from runtime_c import HERE, WARNINGS
from test_controllers import (
    SANITIZED,
    OnController,
    counts_a_full_queue,
    joint_objects,
    waits_for_nobody,
)
from test_example_projects import run
from test_export_examples import JOINTS

from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.joint.file import parse_joint

CLASSIC = ("shoulder", "wrist", "odd")
DRIVERS = ("node", "legacy")  # of ESP-IDF 5.5, and of what came before
BOTH = [("shoulder", "node"), ("shoulder", "legacy"), ("odd", "node"), ("odd", "legacy")]
IDF, FAKES = HERE / "esp_idf", HERE / "controllers"
VERSIONS = {"node": "ESP_IDF_VERSION_VAL(5,5,0)", "legacy": "ESP_IDF_VERSION_VAL(5,4,2)"}


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("twai")
    for name in CLASSIC:
        export(parse_joint(JOINTS[name], f"{name}.toml"), folder / name, examples=["esp-idf"])
    return folder


class OnTwai(OnController):
    """The example with one of the drivers."""

    def build(self, folder: Path, out: Path) -> Path:
        ports, main = folder / "ports", folder / "examples" / "esp-idf" / "main" / "main.c"
        out = folder.parent / "-".join((folder.name, self.controller, *self.definitions))
        program = out / "node"
        if program.exists():
            return program
        out.mkdir()
        flags = (
            "-std=c11", *WARNINGS, *SANITIZED, *self.definitions,
            f"-DESP_IDF_VERSION={VERSIONS[self.controller]}", f"-I{IDF}", f"-I{HERE}",
            f"-I{FAKES}", f"-I{folder / 'src'}", f"-I{ports / 'can'}", f"-I{ports / 'twai'}",
        )  # fmt: skip
        run("gcc", *flags, "-c", main, "-o", out / "main.o")
        run("objcopy", "--globalize-symbol=can", out / "main.o")  # its counters are printed
        run(
            "gcc", *flags, out / "main.o", ports / "twai" / "can_twai.c", IDF / "fake.c",
            FAKES / "bus.c", *joint_objects(folder), "-o", program,
        )  # fmt: skip
        return program


@pytest.mark.parametrize("driver", DRIVERS)
@pytest.mark.parametrize("name", CLASSIC)
def test_twai_brings_every_snapshot_and_its_answer(folders, tmp_path, name, driver):
    node = OnTwai(folders / name, tmp_path, driver, 14)
    assert node.check(node.run(node.incoming())) == set(range(14))
    own = {k: v for k, v in node.counters.items() if k not in ("received", "sent")}
    assert set(own.values()) == {0}


@pytest.mark.parametrize(("name", "driver"), BOTH)
def test_nothing_waits_for_a_node_that_acknowledges(folders, tmp_path, name, driver):
    node = OnTwai(folders / name, tmp_path, driver, 40)
    waits_for_nobody(node)


@pytest.mark.parametrize(("name", "driver"), BOTH)
def test_twai_is_back_within_three_cycles_after_bus_off(folders, tmp_path, name, driver):
    node = OnTwai(folders / name, tmp_path, driver, 30)
    off = 50 + 10 * node.cycle
    sent = node.run(node.incoming(), FAKE_OFF=f"{off}-{off + 4 * node.cycle}")
    assert set(range(14 + 3, 30)) | set(range(9)) <= node.check(sent)
    assert node.counters["bus_off"] >= 1


@pytest.mark.parametrize(("name", "driver"), BOTH)
def test_a_full_queue_is_counted_and_leaves_nothing_wrong(folders, tmp_path, name, driver):
    node = OnTwai(folders / name, tmp_path, driver, 60)
    counts_a_full_queue(node)


class Straight(OnTwai):
    """The example as it is without options: it estimates from its own readings."""

    definitions = ()


@pytest.mark.parametrize(("name", "driver"), BOTH)
def test_the_esp_idf_example_publishes_a_straight_joint(folders, tmp_path, name, driver):
    node = Straight(folders / name, tmp_path, driver, 1)
    angles = list(node.angles(node.run(node.incoming(), 0.2)).values())
    assert len(angles) >= int(200 / node.cycle) - 2
    assert {value for values in angles for value in values.values()} == {0}
    assert node.counters["received"] == 0


def test_a_can_fd_joint_is_refused_with_the_controller_and_the_key(tmp_path):
    joint = parse_joint(JOINTS["spine"], "spine.toml")
    said = r"spine.toml: can.fd: true, but the TWAI controller of ESP32 of the example esp-idf"
    with pytest.raises(InputError, match=said):
        export(joint, tmp_path / "spine", examples=["esp-idf"])
    assert not (tmp_path / "spine").exists()


PROJECT = """
set(ENV{IDF_PATH} ${CMAKE_CURRENT_LIST_DIR})
function(idf_component_register)
  cmake_parse_arguments(own "" "" "SRCS;INCLUDE_DIRS;REQUIRES" ${ARGN})
  foreach(path ${own_SRCS} ${own_INCLUDE_DIRS})
    get_filename_component(path ${path} ABSOLUTE)
    if(NOT EXISTS ${path})
      message(FATAL_ERROR "${path} is not there")
    endif()
  endforeach()
  message(STATUS "requires ${own_REQUIRES}")
endfunction()
macro(project name)
  _project(${name} LANGUAGES NONE)
  message(STATUS "components ${EXTRA_COMPONENT_DIRS}")
  add_subdirectory(main)
endmacro()
"""


def test_the_esp_idf_project_names_files_and_a_component_that_are_there(folders, tmp_path):
    tools = tmp_path / "idf" / "tools" / "cmake"
    tools.mkdir(parents=True)
    (tools / "project.cmake").write_text(PROJECT)
    done = subprocess.run(
        ["cmake", "-S", folders / "wrist" / "examples" / "esp-idf", "-B", tmp_path / "build"],
        capture_output=True, text=True, check=False, env={"PATH": "/usr/bin:/bin",
        "IDF_PATH": str(tmp_path / "idf")},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert "requires wrist;driver;esp_timer" in done.stdout
    component = done.stdout.partition("components ")[2].splitlines()[0]
    assert Path(component).resolve() == folders / "wrist"
