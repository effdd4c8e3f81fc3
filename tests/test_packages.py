"""The exported folder as a package of CMake, PlatformIO, Arduino, Zephyr and ESP-IDF.

CMake, Arduino's builder and the packers of PlatformIO and ESP-IDF are the real ones. Zephyr and
ESP-IDF as a whole are too large to install for a test: here their CMake functions are stand-ins
that do what their documentation says, in as few lines as the folder needs.
"""

import json
import os
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import kconfiglib
import pytest
import yaml

from ccgen.export.package import export

EXAMPLES = Path(__file__).parent.parent / "examples"
JOINTS = ("shoulder", "wrist")
NEEDED = {
    "cmake": "cmake", "arm-none-eabi-gcc": "gcc-arm-none-eabi", "avr-gcc": "gcc-avr",
    "riscv64-unknown-elf-gcc": "gcc-riscv64-unknown-elf", "arduino-builder": "arduino-builder",
}  # fmt: skip
NM = {
    "host": "nm", "cortex-m0": "arm-none-eabi-nm", "cortex-m4": "arm-none-eabi-nm",
    "riscv32": "riscv64-unknown-elf-nm", "avr": "avr-nm",
}  # fmt: skip
PROGRAM = """
#include "shoulder_can.h"
#include "wrist_can.h"
static shoulder_node_t shoulder;
static wrist_node_t wrist;
int main(void) {
    ccgen_frame_t frame;
    if (shoulder_node_init(&shoulder) != CCGEN_OK || wrist_node_init(&wrist) != CCGEN_OK) return 1;
    if (shoulder_node_transmit(&shoulder, 1000000u, &frame) != 1) return 2;
    if (frame.id != SHOULDER_ID_HEALTH || wrist_node_receive(&wrist, &frame, 0u) != 0) return 3;
    if (wrist_node_transmit(&wrist, 1000000u, &frame) != 1) return 4;
    if (frame.id != WRIST_ID_HEALTH || shoulder_node_receive(&shoulder, &frame, 0u) != 0) return 5;
    return 0;
}
"""
CONSUMERS = {
    "add_subdirectory": "add_subdirectory({joint} {joint})",
    "FetchContent": "FetchContent_Declare({joint} SOURCE_DIR ${{CMAKE_SOURCE_DIR}}/{joint})\n"
    "FetchContent_MakeAvailable({joint})",
    "find_package": "find_package({joint} 0.1 REQUIRED)",
}
ZEPHYR = """
cmake_minimum_required(VERSION 3.20)
project(stand_in C)
add_library(zephyr_interface INTERFACE)
macro(zephyr_library_named name)
  set(ZEPHYR_CURRENT_LIBRARY ${name})
  add_library(${name} STATIC)
  set_property(GLOBAL APPEND PROPERTY ZEPHYR_LIBS ${name})
  target_link_libraries(${name} PUBLIC zephyr_interface)
endmacro()
function(zephyr_library_sources)
  target_sources(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_library_include_directories)
  target_include_directories(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_library_compile_options)
  target_compile_options(${ZEPHYR_CURRENT_LIBRARY} PRIVATE ${ARGN})
endfunction()
function(zephyr_include_directories)
  target_include_directories(zephyr_interface INTERFACE ${ARGN})
endfunction()
set(CONFIG_CCGEN_SHOULDER y)
set(CONFIG_CCGEN_WRIST ${WITH_WRIST})
add_subdirectory(shoulder/zephyr)
add_subdirectory(wrist/zephyr)
get_property(libraries GLOBAL PROPERTY ZEPHYR_LIBS)
add_executable(app main.c)
target_link_libraries(app
  zephyr_interface -Wl,--whole-archive ${libraries} -Wl,--no-whole-archive)
"""
ESP_IDF = """
cmake_minimum_required(VERSION 3.16)
project(stand_in C)
function(idf_component_register)
  cmake_parse_arguments(_ "" "" "SRCS;INCLUDE_DIRS" ${ARGN})
  get_filename_component(folder ${CMAKE_CURRENT_SOURCE_DIR} NAME)
  set(COMPONENT_LIB __idf_${folder} PARENT_SCOPE)
  add_library(__idf_${folder} STATIC ${__SRCS})
  target_include_directories(__idf_${folder} PUBLIC ${__INCLUDE_DIRS})
endfunction()
set(ESP_PLATFORM 1)
add_subdirectory(shoulder)
add_subdirectory(wrist)
add_executable(app main.c)
target_link_libraries(app __idf_shoulder __idf_wrist)
"""


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Two exported joints, beside a program that uses both."""
    for program, package in NEEDED.items():
        assert shutil.which(program), f"needs {program}; install the Debian package {package}"
    folder = tmp_path_factory.mktemp("packages")
    for name in JOINTS:
        export(EXAMPLES / f"{name}.toml", folder / name)
    (folder / "main.c").write_text(PROGRAM)
    return folder


def run(*command: object, **options: object) -> str:
    done = subprocess.run(
        [str(part) for part in command], capture_output=True, text=True, check=False, **options
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def cmake(source: Path, build: Path, *options: str) -> Path:
    run("cmake", "-S", source, "-B", build, "-DCMAKE_BUILD_TYPE=MinSizeRel", *options)
    run("cmake", "--build", build, "--parallel", "2")
    return build


def toolchain(core: str) -> list[str]:
    if core == "host":
        return []
    specs = ["-DCMAKE_EXE_LINKER_FLAGS=--specs=nosys.specs"] if core.startswith("cortex") else []
    file = EXAMPLES / "cmake" / f"{core}.cmake"
    return [f"-DCMAKE_TOOLCHAIN_FILE={file}", "-DCMAKE_BUILD_TYPE=MinSizeRel", *specs]


def consumer(exported: Path, folder: Path, way: str) -> Path:
    """Write a project that takes in both joints one way or another."""
    for name in JOINTS:
        (folder / name).symlink_to(exported / name)
    (folder / "main.c").write_text(PROGRAM)
    lines = [CONSUMERS[way].format(joint=name) for name in JOINTS]
    (folder / "CMakeLists.txt").write_text(
        "\n".join(
            [
                "cmake_minimum_required(VERSION 3.16)\nproject(consumer C)\ninclude(FetchContent)",
                *lines,
                "add_executable(app main.c)",
                "target_link_libraries(app PRIVATE shoulder::shoulder wrist::wrist)",
            ]
        )
    )
    return folder


def defined_once(program: Path, nm: str, *symbols: str) -> bool:
    names = [line.split()[-1] for line in run(nm, "--defined-only", program).splitlines()]
    return all(names.count(symbol) == 1 for symbol in symbols)


def files_below(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in folder.rglob("*") if f.is_file()}


@pytest.mark.parametrize("way", CONSUMERS)
@pytest.mark.parametrize("core", NM)
def test_two_joints_link_into_one_cmake_program(exported, tmp_path, core, way):
    options = toolchain(core)
    if way == "find_package":
        prefix = tmp_path / "installed"
        for name in JOINTS:
            build = cmake(exported / name, tmp_path / f"build_{name}", *options)
            run("cmake", "--install", build, "--prefix", prefix)
        options += [f"-D{name}_DIR={prefix}/lib/cmake/{name}" for name in JOINTS]
    project = tmp_path / "project"
    project.mkdir()
    build = cmake(consumer(exported, project, way), tmp_path / "build", *options)
    symbols = ("ccgen_crc8_table", "shoulder_estimate", "wrist_estimate")
    assert defined_once(build / "app", NM[core], *symbols)
    if core == "host":
        run(build / "app")


def test_installing_a_second_joint_leaves_the_first_one_as_it_was(exported, tmp_path):
    builds = {name: cmake(exported / name, tmp_path / name) for name in JOINTS}
    run("cmake", "--install", builds["shoulder"], "--prefix", tmp_path / "installed")
    before = files_below(tmp_path / "installed")
    run("cmake", "--install", builds["wrist"], "--prefix", tmp_path / "installed")
    after = files_below(tmp_path / "installed")
    assert {name: after[name] for name in before} == before
    assert "include/wrist/wrist.h" in after.keys() - before.keys()


def test_two_joints_of_one_build_install_together(exported, tmp_path):
    project = consumer(exported, tmp_path, "add_subdirectory")
    build = cmake(project, tmp_path / "build", "-DCCGEN_INSTALL=ON")
    run("cmake", "--install", build, "--prefix", tmp_path / "installed")
    (tmp_path / "other").mkdir()
    other = consumer(exported, tmp_path / "other", "find_package")
    found = cmake(other, tmp_path / "found", f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}")
    run(found / "app")


def test_a_joint_in_a_larger_project_installs_nothing_of_itself(exported, tmp_path):
    build = cmake(consumer(exported, tmp_path, "add_subdirectory"), tmp_path / "build")
    run("cmake", "--install", build, "--prefix", tmp_path / "installed")
    assert files_below(tmp_path / "installed") == {}


def test_a_package_of_another_version_is_not_taken(exported, tmp_path):
    build = cmake(exported / "shoulder", tmp_path / "build")
    run("cmake", "--install", build, "--prefix", tmp_path / "installed")
    (tmp_path / "CMakeLists.txt").write_text(
        "cmake_minimum_required(VERSION 3.16)\nproject(c C)\nfind_package(shoulder 0.2 REQUIRED)"
    )
    done = subprocess.run(
        [
            "cmake", "-S", tmp_path, "-B", tmp_path / "c",
            f"-DCMAKE_PREFIX_PATH={tmp_path / 'installed'}",
        ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode != 0
    assert 'compatible with requested version "0.2"' in done.stderr


@pytest.mark.parametrize("with_wrist", ["y", ""])
def test_zephyr_modules_define_the_runtime_once_in_whole_archives(exported, tmp_path, with_wrist):
    consumer(exported, tmp_path, "add_subdirectory")
    program = PROGRAM if with_wrist else '#include "shoulder_can.h"\nint main(void) { return 0; }'
    (tmp_path / "main.c").write_text(program)
    (tmp_path / "CMakeLists.txt").write_text(ZEPHYR)
    build = cmake(tmp_path, tmp_path / "build", f"-DWITH_WRIST={with_wrist}")
    assert defined_once(build / "app", "nm", "ccgen_crc8_table", "shoulder_estimate")
    assert defined_once(build / "app", "nm", "wrist_estimate") == bool(with_wrist)
    run(build / "app")


def test_the_zephyr_module_names_files_that_exist_and_an_option_that_parses(exported):
    for name in JOINTS:
        module = yaml.safe_load((exported / name / "zephyr" / "module.yml").read_text())
        build = {"cmake": "zephyr", "kconfig": "zephyr/Kconfig"}
        assert module == {"name": f"ccgen_{name}", "build": build}
        assert (exported / name / build["cmake"] / "CMakeLists.txt").is_file()
        option = kconfiglib.Kconfig(str(exported / name / build["kconfig"])).syms[
            f"CCGEN_{name.upper()}"
        ]
        assert option.orig_type == kconfiglib.BOOL
        assert option.str_value == "n"
        assert option.nodes[0].help


def test_esp_idf_components_link_into_one_program(exported, tmp_path):
    consumer(exported, tmp_path, "add_subdirectory")
    (tmp_path / "CMakeLists.txt").write_text(ESP_IDF)
    build = cmake(tmp_path, tmp_path / "build")
    assert defined_once(build / "app", "nm", "ccgen_crc8_table", "wrist_estimate")
    run(build / "app")


def compote(folder: Path) -> subprocess.CompletedProcess:
    """Pack a folder as a component; the packer checks the manifest's fields."""
    return subprocess.run(
        [Path(sys.executable).with_name("compote"), "component", "pack", "--name", "shoulder"],
        cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_the_esp_idf_component_packs_and_a_wrong_field_does_not(exported, tmp_path):
    component = shutil.copytree(exported / "shoulder", tmp_path / "shoulder")
    done = compote(component)
    assert done.returncode == 0, done.stdout + done.stderr
    with tarfile.open(component / "dist" / "shoulder_0.1.0.tgz") as archive:
        assert "src/shoulder.c" in {name.removeprefix("./") for name in archive.getnames()}
    manifest = component / "idf_component.yml"
    manifest.write_text(manifest.read_text().replace("version:", "versoin:"))
    assert compote(component).returncode != 0


def pio_pack(folder: Path, out: Path) -> subprocess.CompletedProcess:
    """Pack a folder as PlatformIO would publish it; the packer checks the manifest's fields."""
    quiet = {
        "PLATFORMIO_CORE_DIR": str(out / "core"), "PLATFORMIO_SETTING_ENABLE_TELEMETRY": "no",
    }  # fmt: skip
    return subprocess.run(
        [sys.executable, "-m", "platformio", "pkg", "pack", folder, "-o", out],
        env=os.environ | quiet, capture_output=True, text=True, check=False,
    )  # fmt: skip


def test_the_platformio_library_packs_and_a_wrong_field_does_not(exported, tmp_path):
    done = pio_pack(exported / "shoulder", tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    with tarfile.open(tmp_path / "shoulder-0.1.0.tar.gz") as archive:
        assert {"library.json", "src/shoulder.c", "src/ccgen/slcan.c"} <= set(archive.getnames())
    damaged = shutil.copytree(exported / "shoulder", tmp_path / "damaged")
    manifest = json.loads((damaged / "library.json").read_text())
    (damaged / "library.json").write_text(json.dumps(manifest | {"version": "first"}))
    assert pio_pack(damaged, tmp_path).returncode != 0


def test_the_platformio_library_compiles_src_alone_and_as_an_archive(exported):
    for name in JOINTS:
        manifest = json.loads((exported / name / "library.json").read_text())
        assert manifest["name"] == name
        assert (manifest["build"]["srcDir"], manifest["build"]["includeDir"]) == ("src", "src")
        assert manifest["build"]["libArchive"] is True
        assert all((exported / name / "src" / header).is_file() for header in manifest["headers"])


def test_the_arduino_properties_hold_every_required_field(exported):
    required = {
        "name", "version", "author", "maintainer", "sentence", "paragraph", "category", "url",
        "architectures",
    }  # fmt: skip
    for name in JOINTS:
        lines = (exported / name / "library.properties").read_text().splitlines()
        fields = dict(line.split("=", 1) for line in lines)
        assert len(fields) == len(lines)
        assert all(fields[key].strip() for key in required)
        assert fields["name"] == name
        assert fields["category"] == "Data Processing"
        assert (exported / name / "src" / fields["includes"]).is_file()
        assert fields["dot_a_linkage"] == "true"
