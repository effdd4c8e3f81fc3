"""The C runtime and exported joints under libFuzzer, watched by ASan and UBSan.

Seed and number of runs are fixed, to be over soon. To search for longer, build a driver as below
and give it a folder for its corpus and `-max_total_time=600`.
"""

import shutil
import subprocess
from pathlib import Path

import pytest
from reference_c import reference
from runtime_c import C99, HERE, WARNINGS

from ccgen.export.package import export
from ccgen.targets.compiler import sources

DRIVERS = HERE / "fuzz"
EXAMPLES = Path(__file__).parent.parent / "examples"
# At a fixed address: one that a kernel draws with many bits may be in the sanitizer's memory.
SANITIZERS = (
    "-g", "-O1", "-fno-pie", "-no-pie", "-fsanitize=fuzzer,address,undefined",
    "-fno-sanitize-recover=all",
)  # fmt: skip
NEEDED = "needs clang with its runtime (Debian packages: clang libclang-rt-dev)"


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    """Classic CAN with 16 bits, two axes that differ, CAN FD with 32 bits."""
    root = tmp_path_factory.mktemp("exported")
    for name in ("shoulder", "wrist", "spine"):
        export(EXAMPLES / f"{name}.toml", root / name)
    return root


def build(driver: str, folder: Path, out: Path, *flags: str) -> Path:
    """A driver with what it needs of an exported folder."""
    assert shutil.which("clang"), NEEDED
    joint = folder.name
    linked = {
        "slcan": [folder / "src" / "ccgen" / "slcan.c"],
        "estimator": [],
    }.get(driver, sources(folder))
    (out / "fuzz_reference.h").write_text(reference(folder))
    command = [
        "clang", *C99, *WARNINGS, *SANITIZERS, f"-DFUZZ_LAYOUT={joint}_layout", *flags,
        f"-I{folder / 'src'}", f"-I{folder / 'ports'}", f"-I{out}",
        DRIVERS / f"{driver}.c", *linked, "-o", out / driver,
    ]  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stderr}\n{NEEDED}"
    return out / driver


def fuzz(program: Path, runs: int, seed: int = 1) -> subprocess.CompletedProcess[str]:
    """Long inputs from the start, as most steps need some bytes."""
    options = (f"-seed={seed}", f"-runs={runs}", "-max_len=512", "-len_control=0", "-timeout=60")
    artifacts = f"-artifact_prefix={program.parent}/"
    return subprocess.run(
        [program, *options, artifacts],
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
    )


@pytest.mark.parametrize(
    ("driver", "joint", "runs", "flags"),
    [
        ("slcan", "shoulder", 20_000, ()),
        ("estimator", "shoulder", 20_000, ("-DCCGEN_HALVES=0",)),
        ("estimator", "shoulder", 20_000, ("-DCCGEN_HALVES=1",)),
        ("node", "shoulder", 5_000, ()),
        ("node", "wrist", 5_000, ()),
        ("node", "spine", 2_500, ()),
        ("line", "shoulder", 2_000, ()),
        ("line", "spine", 700, ()),
    ],
)
def test_no_input_breaks_what_holds(driver, joint, runs, flags, exported, tmp_path):
    done = fuzz(build(driver, exported / joint, tmp_path, *flags), runs)
    assert done.returncode == 0, done.stderr[-5000:]
    assert f"Done {runs} runs" in done.stderr


@pytest.mark.parametrize(
    ("driver", "joint", "file", "right", "wrong"),
    [
        ("slcan", "shoulder", "src/ccgen/slcan.c",
         "length < CCGEN_SLCAN_LINE_MAX", "length <= CCGEN_SLCAN_LINE_MAX"),
        ("estimator", "shoulder", "src/ccgen/kernel32.h",
         "(steps == 0u) ? 1u : steps", "(steps == 0u) ? 0u : steps"),
        ("node", "shoulder", "src/ccgen/snapshot_inline.h",
         "snapshot->received = 0;\n    snapshot->first_us", "snapshot->first_us"),
        ("node", "shoulder", "src/ccgen/node_inline.h",
         "(estimated ? result :", "(estimated ? 0 :"),
        ("node", "shoulder", "src/ccgen/serving16.h",
         "rest > 1u", "rest > 2u"),
        ("node", "spine", "src/ccgen/serving32.h",
         "absent == 0u", "absent <= 1u"),
        ("node", "shoulder", "src/ccgen/node_inline.h",
         "node->snapshot.faults = node->snapshot.recent;", "node->snapshot.faults = 0;"),
        ("node", "shoulder", "src/ccgen/node_inline.h",
         "node->status_again = node->status_again || ", "node->status_again = false && "),
        ("node", "shoulder", "src/ccgen/layout_inline.h",
         "(turn << CCGEN_LAYOUT_TURN_SHIFT)", "(0u * turn)"),
        ("node", "spine", "src/ccgen/snapshot_inline.h",
         "? now_us : snapshot->now_us", "? now_us : now_us"),
        ("node", "wrist", "src/wrist.c",
         "true, /* saturates */", "false, /* saturates */"),
        ("line", "shoulder", "ports/posix/main.c",
         "output->end -= output->begin;", "output->end = 0;"),
    ],
)  # fmt: skip
def test_a_planted_fault_is_found(driver, joint, file, right, wrong, exported, tmp_path):
    folder = Path(shutil.copytree(exported / joint, tmp_path / joint))
    source = (folder / file).read_text()
    assert right in source
    (folder / file).write_text(source.replace(right, wrong, 1))
    program = build(driver, folder, tmp_path)
    # The same seed draws other inputs in another run: what leads it includes addresses.
    runs = (fuzz(program, 4_000, seed) for seed in range(1, 9))
    found = next((done for done in runs if done.returncode), None)
    assert found is not None
    assert "SUMMARY: " in found.stderr
