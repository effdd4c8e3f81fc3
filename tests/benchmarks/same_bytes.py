"""The same joint files give the same bytes on every processor and with every library's version.

Exports random joints (every method, both precisions, all placements, classic CAN and CAN FD) in
processes that differ in the kernels of the BLAS, in NumPy's vector units, in the C library's, and
in the interpreter whose libraries they use, and compares what is written, file by file:

    python tests/benchmarks/same_bytes.py [--joints N] [--python /low/bin/python] ...

Status 1 where a byte differs.
"""

import argparse
import hashlib
import json
import math
import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

CORES = ("Haswell", "SkylakeX", "Zen", "Sandybridge", "Prescott")
"""Kernels of OpenBLAS; what a processor cannot run it replaces by itself."""

NO_VECTORS = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL AVX512_SPR AVX2 FMA3"

ENVIRONMENTS: dict[str, dict[str, str]] = {
    "as it is": {},
    **{f"OpenBLAS for {core}": {"OPENBLAS_CORETYPE": core} for core in CORES},
    "NumPy without AVX-512": {"NPY_DISABLE_CPU_FEATURES": NO_VECTORS.split(" AVX2")[0]},
    "NumPy without AVX": {"NPY_DISABLE_CPU_FEATURES": NO_VECTORS},
    "NumPy of today without AVX-512": {"NPY_DISABLE_CPU_FEATURES": "X86_V4 AVX512_ICL AVX512_SPR"},
    "NumPy of today without AVX": {
        "NPY_DISABLE_CPU_FEATURES": "X86_V3 X86_V4 AVX512_ICL AVX512_SPR"
    },
    "libm without AVX and FMA": {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX512F,-FMA4"},
}
"""What a process is given, by name; names of units that a NumPy does not know do no harm."""

PRINTED = "import sys; sys.path.insert(0, {root!r}); import same_bytes; same_bytes.main_export()"


def joint_texts(count: int, seed: int = 0) -> list[str]:
    """Texts of random joint files, all of them legal; the same seed gives the same texts."""
    drawn = random.Random(seed)
    return [_joint_text(drawn, number) for number in range(count)]


def _joint_text(drawn: random.Random, number: int) -> str:
    segments = drawn.choice((1, 2, 3, 5, 8, 12, 16, 24, 33, 48, 64))
    method = drawn.choice(("wam", "wam", "noise-aware", "noise-aware", "equal", "direct"))
    precision = drawn.choice((16, 32))
    degrees = round(drawn.uniform(0.05, 8.0), drawn.choice((0, 1, 3))) or 0.5
    radius = round(drawn.uniform(0.004, 0.08), 3)
    layout = "end-to-end" if method == "direct" else drawn.choice(("heuristic", "end-to-end"))
    count = drawn.randint(1, min(8, segments))
    # A tendon along the whole joint moves so many counts.
    bits, counts = (24, (1e5, 5e6)) if precision == 32 else (16, (1e3, 2.4e4))
    step = segments * math.radians(degrees) * radius / drawn.uniform(*counts)
    sensors = f'placement = "{layout}"\ncount = {count}'
    if method == "wam" and drawn.random() < 0.4:
        sensors = f"spans = {_spans(drawn, segments)}"
    fd = drawn.random() < 0.3
    return f"""name = "joint{number}"

[geometry]
segments = {segments}
length = {round(drawn.uniform(0.05, 1.2), 3)}
range_of_motion = {degrees}

[sensors]
{sensors}
radius = {radius}

[sensors.transducer]
bits = {bits}
metres_per_count = {step:.4g}
noise = {drawn.uniform(0.1, 30) * step:.4g}

[shapes]
fit_samples = {drawn.choice((10, 30, 30, 57))}

[estimator]
method = "{method}"

[fixed_point]
precision = {precision}

[can]
base_id = {drawn.choice((0x100, 0x300))}
fd = {"true" if fd else "false"}
cycle_ms = 1000
"""


def _spans(drawn: random.Random, segments: int) -> list[list[int]]:
    """Spans that cover the joint, some of them twice: readings that depend on each other."""
    spans = []
    for _ in range(drawn.randint(1, 8)):
        spans.append(sorted(drawn.choices(range(segments), k=2)))
    return [[0, segments - 1], *spans][:8]


def exported(texts: list[str]) -> dict[str, str]:
    """Fingerprint of every file of every joint's folder; of the message where one is refused."""
    from ccgen.errors import CcgenError
    from ccgen.export.package import export

    found = {}
    with tempfile.TemporaryDirectory() as directory:
        for number, text in enumerate(texts):
            joint = Path(directory, f"joint{number}.toml")
            joint.write_text(text, encoding="utf-8")
            folder = Path(directory, f"joint{number}")
            try:
                export(joint, folder)
            except CcgenError as error:
                found[f"{number}"] = "refused: " + str(error).replace(directory, "")
                continue
            for file in sorted(path for path in folder.rglob("*") if path.is_file()):
                name = f"{number}/{file.relative_to(folder).as_posix()}"
                found[name] = hashlib.sha256(file.read_bytes()).hexdigest()
    return found


def main_export() -> None:
    """Read joint files' texts from stdin as JSON, and print the fingerprints of their exports."""
    json.dump(exported(json.load(sys.stdin)), sys.stdout)


def elsewhere(
    texts: list[str], environment: dict[str, str], python: str = sys.executable
) -> dict[str, str]:
    """`exported` in a process of its own."""
    program = PRINTED.format(root=str(Path(__file__).parent))
    done = subprocess.run(
        [python, "-c", program],
        input=json.dumps(texts), capture_output=True, text=True, check=False,
        env={**os.environ, "PYTHONPATH": str(ROOT), "PYTHONWARNINGS": "ignore", **environment},
    )  # fmt: skip
    if done.returncode:
        raise RuntimeError(f"{python} with {environment}: {done.stderr[-2000:]}")
    found: dict[str, str] = json.loads(done.stdout)
    return found


def differences(first: dict[str, str], other: dict[str, str]) -> list[str]:
    """Files whose bytes differ, or that only one of them has."""
    return sorted(
        name for name in first.keys() | other.keys() if first.get(name) != other.get(name)
    )


def main() -> int:
    """Compare, and print what differs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--joints", type=int, default=200)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--python", action="append", default=[], help="one more interpreter")
    options = parser.parse_args()
    texts = joint_texts(options.joints, options.seed)
    reference = elsewhere(texts, {})
    refused = sum(value.startswith("refused") for value in reference.values())
    print(f"{len(texts)} joints, {refused} refused, {len(reference) - refused} files")
    ways = [(name, sys.executable, given) for name, given in ENVIRONMENTS.items()]
    ways += [
        (f"{python}, {name}", python, given)
        for python in options.python
        for name, given in ENVIRONMENTS.items()
        if name in ("as it is", "OpenBLAS for Zen", "NumPy without AVX")
    ]
    failed = False
    for name, python, given in ways:
        different = differences(reference, elsewhere(texts, given, python))
        failed |= bool(different)
        print(f"{name}: {len(different)} files differ {' '.join(different[:5])}", flush=True)
    return int(failed)


if __name__ == "__main__":
    raise SystemExit(main())
