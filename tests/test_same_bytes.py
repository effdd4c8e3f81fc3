"""The same joint file gives the same bytes, whatever kernels and vector units there are."""

import subprocess
import sys
from pathlib import Path

import pytest
from benchmarks import same_bytes

EXAMPLES = Path(__file__).parent.parent / "examples"

PLAIN = {
    key: value
    for name in ("OpenBLAS for Prescott", "NumPy of today without AVX", "libm without AVX and FMA")
    for key, value in same_bytes.ENVIRONMENTS[name].items()
}


@pytest.fixture(scope="module")
def texts():
    examples = [(EXAMPLES / f"{name}.toml").read_text() for name in ("shoulder", "wrist")]
    return examples + same_bytes.joint_texts(4, seed=1)


@pytest.fixture(scope="module")
def reference(texts):
    return same_bytes.exported(texts)


@pytest.mark.parametrize(
    "given", [PLAIN, same_bytes.ENVIRONMENTS["OpenBLAS for Zen"]], ids=["no vector units", "Zen"]
)
def test_exported_folders_are_the_same_bytes(texts, reference, given):
    assert sum(name.endswith("model.json") for name in reference) == len(texts)
    assert same_bytes.differences(reference, same_bytes.elsewhere(texts, given)) == []


def test_a_difference_is_found(reference):
    changed = {**reference, "0/model.json": "another", "0/more": ""}
    del changed["1/README.md"]
    assert same_bytes.differences(reference, changed) == ["0/model.json", "0/more", "1/README.md"]


@pytest.mark.parametrize("arguments", [("fit",), ("export", "-o")])
def test_neither_fit_nor_export_waits_for_scipy(tmp_path, arguments):
    program = (
        "import sys\nfrom ccgen.cli.main import main\n"
        "try: main(sys.argv[1:])\n"
        "except SystemExit as end: print(end.code, 'scipy' in sys.modules)\n"
    )
    folder = [str(tmp_path / "shoulder")] if "-o" in arguments else []
    command, *rest = arguments
    done = subprocess.run(
        [sys.executable, "-c", program, command, str(EXAMPLES / "shoulder.toml"), *rest, *folder],
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert done.stdout.splitlines()[-1] in ("0 False", "None False")
