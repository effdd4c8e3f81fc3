"""Runs `on_vcan.py` in user-mode Linux, whose kernel has vcan whatever the host's has.

Joints are exported and their SocketCAN nodes compiled on the host. Ends with status 1 if anything
fails inside, 2 if the kernel does not run to its end. Debian: user-mode-linux kmod iproute2
can-utils.
"""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
from itertools import product
from pathlib import Path

from ccgen.export.package import export
from ccgen.targets.compiler import compiler, sources
from ccgen.targets.host import FLAGS

HERE = Path(__file__).resolve().parent
EXAMPLES = HERE.parents[1] / "examples"
KERNEL = "linux.uml"
SECONDS = 600

FINE = {"precision = 16": "precision = 32", "bits = 16": "bits = 24", "2.0e-6": "1.0e-7"}
FD = {"fd = false": "fd = true"}
EXTENDED = {"extended = false": "extended = true", "0x300": "0x18DA0000"}


def variants() -> dict[str, str]:
    """Joint files by name: the shoulder in every kind of frame, precision and identifier."""
    found = {}
    for fd, fine, extended in product((False, True), repeat=3):
        name = f"{'fd' if fd else 'classic'}-{32 if fine else 16}-{29 if extended else 11}"
        changes = (FD if fd else {}) | (FINE if fine else {}) | (EXTENDED if extended else {})
        found[name] = changed("shoulder", changes)
    return found


def large() -> dict[str, str]:
    """The spine on classic CAN: 98 frames an answer, on a bus that carries them in a cycle."""
    return {
        "large": changed("spine", {"fd = true": "fd = false", "cycle_ms = 10": "cycle_ms = 100"})
    }


def changed(example: str, changes: dict[str, str]) -> str:
    """An example's joint file with replacements that must find their place."""
    text = (EXAMPLES / f"{example}.toml").read_text(encoding="utf-8")
    for old, new in changes.items():
        assert text.count(old) == 1, f"{example}.toml: {old}"
        text = text.replace(old, new)
    return text


def build(name: str, text: str, folder: Path) -> None:
    """Export a joint into `folder/name` and compile its node beside it."""
    directory = folder / name
    joint = folder / f"{name}.toml"
    joint.write_text(text, encoding="utf-8")
    export(joint, directory)
    include = [f"-I{directory / 'src'}", f"-I{directory / 'ports'}"]
    files = [*sources(directory), directory / "ports" / "socketcan" / "main.c"]
    node = folder / f"{name}.node"
    subprocess.run(
        [*compiler(), *FLAGS, "-O2", *include, *map(str, files), "-o", str(node)], check=True
    )


def boot(folder: Path) -> str:
    """Run the kernel to its end; returns what it printed itself."""
    preload = folder / "ptrace_xstate.so"
    source = HERE / "ptrace_xstate.c"
    subprocess.run([*compiler(), "-shared", "-fPIC", source, "-o", preload, "-ldl"], check=True)
    command = [
        KERNEL, "mem=512M", "rootfstype=hostfs", "rootflags=/", "ro", f"init={HERE / 'init.sh'}",
        "con=null", "con0=null,fd:1", "ssl=null", "quiet", f"uml_dir={folder / 'uml'}",
        f"OUTSIDE={folder}", f"PYTHON={sys.executable}", f"REPOSITORY={HERE.parents[1]}",
    ]  # fmt: skip
    kernel = subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        env=os.environ | {"LD_PRELOAD": str(preload)}, start_new_session=True,
    )  # fmt: skip
    try:
        printed, _ = kernel.communicate(timeout=SECONDS)
    except BaseException as error:
        os.killpg(kernel.pid, signal.SIGKILL)
        printed, _ = kernel.communicate()
        if not isinstance(error, subprocess.TimeoutExpired):
            raise
    return printed.decode(errors="replace")


def main() -> int:
    if shutil.which(KERNEL) is None:
        print(f"{KERNEL} not found; `apt-get install user-mode-linux kmod iproute2 can-utils`")
        return 2
    with tempfile.TemporaryDirectory(prefix="ccgen-vcan-") as name:
        folder = Path(name)
        for joint, text in (variants() | large()).items():
            build(joint, text, folder)
        printed = boot(folder)
        log, status = folder / "log", folder / "status"
        if log.exists():
            print(log.read_text(encoding="utf-8", errors="replace"))
        if not status.exists():
            print(f"{printed}\n{KERNEL} did not run to its end")
            return 2
        return int(status.read_text(encoding="utf-8") != "0\n")


if __name__ == "__main__":
    sys.exit(main())
