"""The cores that a folder is compiled for: compiler, flags, port and emulator of each."""

import functools
import shutil
import subprocess
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from ccgen.errors import ArgumentError, ToolError
from ccgen.targets.build import WARNINGS, compiler, run_compiler, sources

FLAGS = ("-std=c99", "-g", "-ffunction-sections", "-fdata-sections", "-ffp-contract=off", *WARNINGS)


@dataclass(frozen=True)
class Tool:
    """A program, or a file that a compiler finds, and the Debian package that has it."""

    package: str
    command: tuple[str, ...]
    file: str = ""

    def present(self) -> bool:
        """Whether it is installed."""
        return shutil.which(self.command[0]) is not None and (
            not self.file or _knows_file(self.command, self.file)
        )


@dataclass(frozen=True)
class Core:
    """A target: how to compile for it and how to run what comes out.

    Attributes:
        name: as on the command line.
        compile: the compiler with the core's flags.
        link: flags for the linker; {ports} stands for the folder's ports/.
        board: sources below ports/.
        emulate: makes the emulator's command from the program and a folder for temporary files;
            the UART is its standard input and output.
        tools: what must be installed.
        constants_in_flash: whether tables stay in flash; else they are copied to RAM.
    """

    name: str
    compile: tuple[str, ...]
    link: tuple[str, ...]
    board: tuple[str, ...]
    emulate: Callable[[Path, Path, Path], list[str]]
    tools: tuple[Tool, ...]
    constants_in_flash: bool = True


def _qemu(*machine: str) -> Callable[[Path, Path, Path], list[str]]:
    common = ("-display", "none", "-monitor", "none", "-serial", "stdio", "-net", "none")

    def command(program: Path, ports: Path, out: Path) -> list[str]:
        return [*machine, *common, "-kernel", str(program)]

    return command


def _cortex_m(name: str, machine: str, board: str, *core: str) -> Core:
    compile_ = ("arm-none-eabi-gcc", "-mthumb", *core)
    semihosting = ("-semihosting-config", "enable=on,target=native")
    return Core(
        name=name,
        compile=compile_,
        link=("-nostartfiles", "-T{ports}/cortex_m/cortex_m.ld"),
        board=("cortex_m/startup.c", "cortex_m/semihosting.c", f"cortex_m/{board}.c"),
        emulate=_qemu("qemu-system-arm", "-M", machine, *semihosting),
        tools=(
            Tool("gcc-arm-none-eabi", ("arm-none-eabi-gcc",)),
            Tool("libnewlib-arm-none-eabi", compile_, "libc.a"),
            Tool("qemu-system-arm", ("qemu-system-arm",)),
        ),
    )


def _riscv32() -> Core:
    compiler = "riscv64-unknown-elf-gcc"
    return Core(
        name="riscv32",
        compile=(
            compiler, "-march=rv32imac", "-mabi=ilp32", "-mcmodel=medany", "--specs=picolibc.specs",
        ),
        link=("-nostartfiles", "-T{ports}/riscv_virt/virt.ld"),
        board=("riscv_virt/startup.S", "riscv_virt/board_virt.c"),
        emulate=_qemu("qemu-system-riscv32", "-M", "virt", "-bios", "none"),
        tools=(
            Tool("gcc-riscv64-unknown-elf", (compiler,)),
            Tool("picolibc-riscv64-unknown-elf", (compiler,), "picolibc.specs"),
            Tool("qemu-system-misc", ("qemu-system-riscv32",)),
        ),
    )  # fmt: skip


def _avr() -> Core:
    mcu, hertz = "atmega1284p", 16_000_000
    return Core(
        name="avr",
        compile=("avr-gcc", f"-mmcu={mcu}"),
        link=("{ports}/avr/ram.ld",),
        board=(f"avr/board_{mcu}.c",),
        emulate=functools.partial(_simavr, mcu, hertz),
        tools=(
            Tool("gcc-avr", ("avr-gcc",)),
            Tool("avr-libc", ("avr-gcc", f"-mmcu={mcu}"), f"crt{mcu}.o"),
            Tool("gcc", ("cc",)),
            Tool("libsimavr-dev", ("cc",), "libsimavr.so"),
        ),
        constants_in_flash=False,
    )


def _simavr(mcu: str, hertz: int, program: Path, ports: Path, out: Path) -> list[str]:
    """Compile the host's program around simavr, which the folder brings along."""
    emulator = out / "simavr_uart"
    source = ports / "avr" / "host" / "simavr_uart.c"
    command = [*compiler(), "-O2", str(source), "-lsimavr", "-o", str(emulator)]
    run_compiler(command, out, f"{source}: {command[0]}")
    return [str(emulator), mcu, str(hertz), str(program)]


CORES = {
    core.name: core
    for core in (
        _cortex_m("cortex-m0", "microbit", "board_microbit", "-mcpu=cortex-m0"),
        _cortex_m("cortex-m3", "mps2-an385", "board_mps2", "-mcpu=cortex-m3"),
        _cortex_m(
            "cortex-m4", "mps2-an386", "board_mps2",
            "-mcpu=cortex-m4", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16",
        ),
        _cortex_m(
            "cortex-m7", "mps2-an500", "board_mps2",
            "-mcpu=cortex-m7", "-mfloat-abi=hard", "-mfpu=fpv5-sp-d16",
        ),
        _riscv32(),
        _avr(),
    )
}  # fmt: skip


def core_named(target: str) -> Core:
    """Return a target by its name.

    Raises:
        ArgumentError: there is none.
    """
    if target not in CORES:
        raise ArgumentError(f"{target} is unknown; known: {', '.join(CORES)}", "target")
    return CORES[target]


def missing_tools(target: str) -> list[str]:
    """Debian packages that a target needs and that are not installed."""
    return list(dict.fromkeys(t.package for t in core_named(target).tools if not t.present()))


def require_tools(target: str) -> None:
    """Make sure that everything a target needs is installed.

    Raises:
        ToolError: something is not; names the packages.
    """
    missing = " ".join(missing_tools(target))
    if missing:
        raise ToolError(f"{target}: needs {missing}; install with `apt-get install {missing}`")


def build(directory: Path, core: Core, program: str, out: Path, options: Sequence[str]) -> Path:
    """Compile one of the bare-metal programs for a core.

    Args:
        directory: an exported folder.
        core: the target.
        program: "node" or "batch".
        out: folder for the program.
        options: further flags, such as the level of optimisation.

    Raises:
        ToolError: the compiler or the linker does not accept the folder.
    """
    ports = directory / "ports"
    files = [
        *sources(directory),
        *(sorted((directory / "selftest").glob("*_selftest.c")) if program == "batch" else ()),
        ports / "bare_metal" / f"{program}.c",
        *(ports / file for file in core.board),
    ]
    folders = (directory / "src", directory / "selftest", ports, ports / "bare_metal")
    target = out / f"{program}.elf"
    command = [
        *core.compile, *FLAGS, *options, *(f"-I{folder}" for folder in folders),
        *map(str, files), *(flag.format(ports=ports) for flag in core.link),
        "-Wl,--gc-sections,--fatal-warnings", "-o", str(target),
    ]  # fmt: skip
    run_compiler(command, out, f"{directory}: {core.compile[0]}")
    return target


@functools.cache
def _knows_file(command: tuple[str, ...], file: str) -> bool:
    """Whether a compiler finds a file: it then names it in full."""
    done = subprocess.run(
        [*command, f"-print-file-name={file}"], capture_output=True, text=True, check=False
    )
    return Path(done.stdout.strip()).is_absolute()
