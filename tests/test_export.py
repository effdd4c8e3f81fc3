import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from joint_files import joint_text
from waiting import PATIENCE

from ccgen.errors import InputError
from ccgen.export import vectors
from ccgen.export.manifest import changed_files
from ccgen.export.package import export
from ccgen.fixedpoint import load_model
from ccgen.targets.compiler import WARNINGS

SMALL = {
    "name": "finger", "segments": 5, "count": 2, "bits": 16, "step": 2e-6, "precision": 16,
}  # fmt: skip
WIDE = {
    "name": "trunk", "segments": 48, "count": 6, "bits": 28, "step": 1e-8, "precision": 32,
}  # fmt: skip
CPP_WARNINGS = [flag for flag in WARNINGS if flag != "-Wmissing-prototypes"]
COMPILERS = {
    "gcc": ["gcc", "-std=c99", *WARNINGS],
    "clang": ["clang", "-std=c99", *WARNINGS],
    "g++": ["g++", "-xc++", "-std=c++14", *CPP_WARNINGS],
    "clang++": ["clang++", "-xc++", "-std=c++14", *CPP_WARNINGS],
}


def write_joint(folder: Path, options: dict, extra: str = "") -> Path:
    path = folder / f"{options['name']}.toml"
    path.write_text(joint_text(**options, tables=extra))
    return path


def contents(folder: Path) -> dict[str, bytes]:
    files = (f for f in folder.rglob("*") if f.is_file())
    return {f.relative_to(folder).as_posix(): f.read_bytes() for f in files}


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("export")
    cases = ((SMALL, ""), (WIDE, "[can]\nfd = true\nextended = true\nbase_id = 0x10000\n"))
    for options, extra in cases:
        export(write_joint(folder, options, extra), folder / options["name"])
    return folder


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", ["finger", "trunk"])
def test_every_file_compiles_without_a_warning(exported, name, compiler):
    assert shutil.which(COMPILERS[compiler][0]), f"{compiler} is needed for this test"
    root = exported / name
    files = [*root.glob("src/**/*.c"), *root.glob("selftest/*.c")]
    assert len(files) > 6
    for file in files:
        for level in ("-O0", "-O2"):
            command = [
                *COMPILERS[compiler], level, "-I", root / "src", "-I", root / "selftest",
                "-c", file, "-o", os.devnull,
            ]  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["finger", "trunk"])
def test_headers_are_free_of_casts_that_a_project_in_cxx_refuses(exported, name, tmp_path):
    root = exported / name
    headers = [*root.glob("src/*.h"), *root.glob("selftest/*.h"), *root.glob("ports/*.h")]
    file = tmp_path / "all.cpp"
    file.write_text("".join(f'#include "{header.name}"\n' for header in headers))
    command = [
        "g++", *CPP_WARNINGS, "-Wold-style-cast", "-Wuseless-cast", "-Wextra-semi",
        *(f"-I{root / folder}" for folder in ("src", "selftest", "ports")),
        "-c", file, "-o", os.devnull,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["finger", "trunk"])
@pytest.mark.parametrize("level", ["-O0", "-Os", "-O2", "-O3"])
def test_the_selftest_passes_and_a_wrong_weight_fails_it(exported, name, level, tmp_path):
    root = exported / name
    assert run_selftest(root, tmp_path, level) == 0
    damaged = tmp_path / "damaged"
    shutil.copytree(root, damaged)
    source = damaged / "src" / f"{name}.c"
    lines = source.read_text().splitlines()
    rows = [i for i, line in enumerate(lines) if "/* segment 2 */" in line]
    digits = lines[rows[-1]]
    for digit in "123456789":
        if f"({digit}" in digits:
            lines[rows[-1]] = digits.replace(f"({digit}", f"({int(digit) % 9 + 1}", 1)
            break
    source.write_text("\n".join(lines))
    assert run_selftest(damaged, tmp_path, level) == 1


@pytest.mark.parametrize("name", ["finger", "trunk"])
def test_a_wrong_step_of_a_pose_fails_the_selftest(exported, name, tmp_path):
    damaged = Path(shutil.copytree(exported / name, tmp_path / "damaged"))
    source = damaged / "src" / f"{name}_pose.c"
    place = re.search(r"position\[0\] = ", source.read_text())
    assert place is not None
    source.write_text(source.read_text().replace(place[0], f"{place[0]}1 + ", 1))
    assert run_selftest(damaged, tmp_path, "-O2") == 1


def run_selftest(root: Path, out: Path, level: str) -> int:
    name = root.name if root.name != "damaged" else next(root.glob("*.dbc")).stem
    command = [
        "gcc", "-std=c99", level, "-fsanitize=undefined", "-fno-sanitize-recover=all",
        "-I", root / "src", "-I", root / "selftest",
        *root.glob("selftest/*.c"), root / "src" / f"{name}.c", root / "src" / f"{name}_pose.c",
        *root.glob("src/ccgen/*.c"),
        "-o", out / "selftest",
    ]  # fmt: skip
    subprocess.run(command, check=True)
    return subprocess.run([out / "selftest"], stdout=subprocess.DEVNULL, check=False).returncode


BOARD = """
void board_init(void);
void board_read_counts({name}_count_t *u, {name}_count_t *v);
void board_alarm(void);
void board_use(float bending, const float *position);
bool board_can_read(ccgen_frame_t *frame);
bool board_can_write(const ccgen_frame_t *frame);
void board_can_interrupt(void);
uint32_t board_time_us(void);
"""


@pytest.mark.parametrize("compiler", COMPILERS)
@pytest.mark.parametrize("name", ["finger", "trunk"])
def test_the_main_loops_in_the_readme_compile(exported, name, compiler, tmp_path):
    loops = re.findall(r"```c\n(.*?)```", (exported / name / "README.md").read_text(), re.DOTALL)
    assert len(loops) == 5
    for loop in loops:
        headers, rest = re.match(r"((?:#include [^\n]*\n)+)(.*)", loop, re.DOTALL).groups()
        board = f'#include "{name}_can.h"\n' + BOARD.format(name=name)
        (tmp_path / "main.c").write_text(headers + board + rest)
        command = [*COMPILERS[compiler], f"-I{exported / name / 'src'}", "-c", "main.c"]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr


def test_the_same_input_gives_the_same_bytes_wherever_it_lies(exported, tmp_path):
    export(write_joint(tmp_path, SMALL), tmp_path / "elsewhere")
    assert contents(tmp_path / "elsewhere") == contents(exported / "finger")


def test_the_manifest_lists_every_file_with_its_fingerprint(exported):
    files = contents(exported / "finger")
    manifest = json.loads(files.pop("manifest.json"))
    assert manifest["files"] == {f: hashlib.sha256(files[f]).hexdigest() for f in files}
    source = (exported / "finger.toml").read_bytes()
    assert manifest["inputs"] == {"joint.toml": hashlib.sha256(source).hexdigest()}
    assert changed_files(exported / "finger") == []


def test_the_exported_model_is_the_one_in_the_header(exported):
    model = load_model(exported / "finger" / "model.json")
    source = (exported / "finger" / "src" / "finger.c").read_text()
    for row in model.u.weights.tolist():
        assert f"CCGEN_PAIR({row[0]}, {row[1]})" in source


def test_equal_axes_share_their_tables(exported, tmp_path):
    assert "v_rows" not in (exported / "finger" / "src" / "finger.c").read_text()
    joint = write_joint(tmp_path, SMALL, "[sensors.v]\ncount = 3\n")
    export(joint, tmp_path / "out")
    assert "v_rows" in (tmp_path / "out" / "src" / "finger.c").read_text()


def test_an_export_over_an_older_one_replaces_it(tmp_path):
    export(write_joint(tmp_path, SMALL), tmp_path / "out")
    export(write_joint(tmp_path, {**SMALL, "name": "thumb"}), tmp_path / "out")
    assert (tmp_path / "out" / "src" / "thumb.c").is_file()
    assert not (tmp_path / "out" / "src" / "finger.c").exists()


def test_a_folder_with_foreign_files_is_left_alone(tmp_path):
    export(write_joint(tmp_path, SMALL), tmp_path / "out")
    (tmp_path / "out" / "src" / "notes.txt").write_text("mine")
    before = contents(tmp_path / "out")
    with pytest.raises(InputError, match=r"out: holds src/notes\.txt, which ccgen did not write"):
        export(write_joint(tmp_path, {**SMALL, "name": "thumb"}), tmp_path / "out")
    assert contents(tmp_path / "out") == before


def test_a_folder_without_a_manifest_is_foreign(tmp_path):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match=r"thesis\.tex"):
        export(write_joint(tmp_path, SMALL), tmp_path / "out")
    assert (tmp_path / "out" / "thesis.tex").read_text() == "years of work"


def test_a_place_that_is_a_file_or_lies_below_one_is_refused(tmp_path):
    (tmp_path / "file").write_text("")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        with pytest.raises(InputError, match="file"):
            export(write_joint(tmp_path, SMALL), place)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["file", "finger.toml"]


def test_an_export_that_is_interrupted_leaves_the_old_folder_whole(tmp_path):
    joint = write_joint(tmp_path, SMALL)
    export(joint, tmp_path / "out")
    before = contents(tmp_path / "out")
    joint.write_text(joint.read_text().replace("2e-06", "3e-06"))
    # The writer stops for ever at its tenth file; the signal comes while it does.
    program = f"""
import pathlib, time
from ccgen.export.package import export
write, written = pathlib.Path.write_bytes, []
def slow(path, data):
    written.append(path)
    if len(written) == 10:
        print("writing", flush=True)
        time.sleep(600)
    return write(path, data)
pathlib.Path.write_bytes = slow
export(pathlib.Path({str(joint)!r}), pathlib.Path({str(tmp_path / "out")!r}))
"""
    for interruption in (signal.SIGINT, signal.SIGTERM):
        child = subprocess.Popen(
            [sys.executable, "-c", program],
            stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
        )  # fmt: skip
        assert child.stdout is not None
        assert child.stdout.readline() == "writing\n"
        child.send_signal(interruption)
        assert child.wait(PATIENCE) != 0
        assert contents(tmp_path / "out") == before
        assert sorted(p.name for p in tmp_path.iterdir()) == ["finger.toml", "out"]


def test_drawn_counts_cover_the_range_and_its_ends_but_for_those_lost(exported):
    model = load_model(exported / "finger" / "model.json")
    drawn = vectors.block(model, seed=7, snapshots=4000)
    lost = drawn.counts == -(2 ** (model.precision - 1))
    for number, share in ((0, 0.5), (1, 0.3), (2, 0.15)):
        assert (lost.sum(axis=1) == number).mean() == pytest.approx(share, abs=0.05)
    readings = np.ma.masked_array(drawn.counts, lost)
    ranges = model.readings
    for values, ends in ((readings, ranges), (drawn.zeros, ranges.zeros)):
        low, high = ends.minimum, ends.maximum
        assert np.array_equal(values.min(axis=0), low)
        assert np.array_equal(values.max(axis=0), high)
        inside = (values > low) & (values < high)
        assert np.all(inside.mean(axis=0) > 0.7)


def test_a_single_wrong_value_changes_the_checksum():
    rng = np.random.default_rng(5)
    values = rng.integers(-(2**31), 2**31, size=(20, 6))
    right = vectors.checksum(values)
    for _ in range(50):
        wrong = values.copy()
        wrong[rng.integers(20), rng.integers(6)] ^= 1 << int(rng.integers(32))
        assert vectors.checksum(wrong) != right
