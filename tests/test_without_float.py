"""`[kinematics] float = false`: an exported folder whose kinematics are in integers alone."""

import json
import os
import re
import subprocess

import numpy as np
import pytest
from joint_files import joint_text
from test_export import COMPILERS
from test_export_examples import JOINTS as OTHERS
from test_export_examples import build
from typer.testing import CliRunner

from ccgen.cli.main import app
from ccgen.errors import InputError
from ccgen.export.package import export
from ccgen.joint.file import parse_joint
from ccgen.targets.compiler import WARNINGS
from ccgen.targets.exported import open_exported
from ccgen.verify.compare import integer_tips

WITHOUT = "[kinematics]\nfloat = false\n"
JOINTS = {
    "finger": joint_text("finger", segments=5, count=2, tables=WITHOUT),
    "bellows": OTHERS["bellows"] + WITHOUT,
}
BOARD = """
void board_init(void);
void board_read_counts(finger_count_t *u, finger_count_t *v);
void board_alarm(void);
void board_use(int32_t bending, const int32_t *position);
"""


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    folder = tmp_path_factory.mktemp("without")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name, examples=("cmake", "cortex-m"))
    return folder


def ccgen(*arguments):
    return CliRunner().invoke(app, [*map(str, arguments)])


def test_the_functions_are_exported_unless_the_file_says_otherwise(tmp_path):
    text = joint_text("finger", segments=5, count=2)
    assert parse_joint(text, "a") == parse_joint(f"{text}[kinematics]\nfloat = true\n", "b")
    assert not parse_joint(text + WITHOUT, "c").float_kinematics
    export(parse_joint(text, "finger.toml"), tmp_path / "finger")
    assert (tmp_path / "finger" / "src" / "finger_kinematics.c").is_file()
    assert "INTEGERS_ONLY" not in (tmp_path / "finger" / "ports" / "port_joint.h").read_text()


@pytest.mark.parametrize(
    ("table", "says"),
    [
        ("flaot = false", "a: kinematics.flaot: unknown key; did you mean float?"),
        (
            'float = "no"',
            'a: kinematics.float: "no" is a string; write true or false, such as float = false',
        ),
    ],
)
def test_other_keys_and_values_are_refused(table, says):
    with pytest.raises(InputError) as refused:
        parse_joint(f"{joint_text()}[kinematics]\n{table}\n", "a")
    assert str(refused.value) == says


@pytest.mark.parametrize("name", JOINTS)
def test_no_file_is_there_or_named(folders, name):
    files = [file for file in (folders / name).rglob("*") if file.is_file()]
    assert not [file for file in files if "_kinematics" in file.name]
    texts = {file: file.read_text() for file in files}
    assert not [file for file, text in texts.items() if f"{name}_kinematics" in text]
    calls = re.compile(rf"{name}_(segment_pose|tip_pose|tip_jacobian|pose_t)\b")
    assert not [file for file, text in texts.items() if calls.search(text)]


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", JOINTS)
def test_every_file_compiles_without_a_warning(folders, name, compiler):
    root = folders / name
    for file in (*root.glob("src/*.c"), *root.glob("selftest/*.c"), root / "ports/shared/shared.c"):
        command = [
            *COMPILERS[compiler], "-O2", "-I", root / "src", "-I", root / "selftest",
            "-I", root / "ports", "-c", file, "-o", os.devnull,
        ]  # fmt: skip
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", JOINTS)
def test_no_source_needs_a_float_where_the_core_has_none(folders, name, tmp_path):
    root = folders / name
    sources = [*root.glob("src/*.c"), *root.glob("src/ccgen/*.c")]
    command = ["arm-none-eabi-gcc", "-mcpu=cortex-m0", "-mthumb", "-std=c99", "-O2", *WARNINGS]
    subprocess.run([*command, "-I", root / "src", "-c", *sources], cwd=tmp_path, check=True)
    objects = sorted(tmp_path.glob("*.o"))
    assert len(objects) == len(sources)
    listing = ["arm-none-eabi-nm", *objects]
    symbols = subprocess.run(listing, capture_output=True, text=True, check=True).stdout
    assert f"T {name}_integer_tip_pose" in symbols
    # Of the run-time ABI, all that converts, compares or computes in single or double precision.
    assert re.findall(r"__aeabi_(?:[df]|c[df]|\w+2[df])\w*|__\w+[sd]f[123]", symbols) == []


def test_the_main_loop_in_the_readme_compiles(folders, tmp_path):
    text = (folders / "finger" / "README.md").read_text()
    assert "it uses no floating point" in text
    loop = next(x for x in re.findall(r"```c\n(.*?)```", text, re.DOTALL) if "board_use" in x)
    headers, rest = re.match(r"((?:#include [^\n]*\n)+)(.*)", loop, re.DOTALL).groups()
    (tmp_path / "main.c").write_text(headers + BOARD + rest)
    source = folders / "finger" / "src"
    command = [*COMPILERS["gcc"], f"-I{source}", "-c", "main.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", JOINTS)
def test_it_is_verified_without_poses_in_floating_point(folders, name):
    quick = ("--snapshots", 60, "--values", 5000)
    done = ccgen("verify", folders / name, "--target", "host", *quick, "--json")
    for run in json.loads(done.stdout)["runs"]:
        assert run["passed"]
        assert run["compared_poses"] >= 60
        assert run["pose_mismatches"] == 0
        assert run["pose_max_error_m"] is None
        assert run["pose_bound_m"] is None


def test_it_is_verified_on_a_core(folders):
    quick = ("--snapshots", 20, "--values", 5000)
    told = ccgen("verify", folders / "finger", "--target", "cortex-m0", *quick)
    assert told.exit_code == 0, told.output
    assert told.stdout.count("no float") == 2


@pytest.mark.parametrize("name", JOINTS)
def test_the_cmake_example_prints_the_integer_tip(folders, tmp_path, name):
    exported = open_exported(folders / name)
    build(folders / name / "examples" / "cmake", tmp_path)
    counts = exported.model.readings.zero + np.arange(len(exported.joint.sensors)) + 3
    done = subprocess.run(
        [tmp_path / "build" / "angles"], input=" ".join(map(str, counts)), capture_output=True,
        text=True, check=True,
    )  # fmt: skip
    lines = dict(line.split(" ", 1) for line in done.stdout.splitlines())
    tip = integer_tips(exported, exported.model.estimate(counts[None]))[0, 9:]
    expected = tip * 2.0**-exported.poses.position_bits
    assert np.allclose(np.array(lines["tip"].split(), dtype=float), expected, atol=6e-6)


def test_the_cortex_m_example_builds(folders, tmp_path):
    build(folders / "finger" / "examples" / "cortex-m", tmp_path)
    assert (tmp_path / "build" / "firmware.elf").is_file()


def test_what_it_costs_names_no_floating_point(folders):
    done = ccgen("cost", folders / "finger", "--target", "cortex-m0", "--write")
    assert done.exit_code == 0, done.output
    text = (folders / "finger" / "README.md").read_text()
    assert "what only other calls link (SLCAN), RAM" in text
