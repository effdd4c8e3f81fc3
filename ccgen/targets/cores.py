"""The cores that a folder is compiled for: compiler, flags, port and emulator of each."""

import functools
import platform
import shutil
import subprocess
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from ccgen.errors import ArgumentError, ToolError
from ccgen.targets.compiler import compiler, run_compiler

HOST = "host"
"""Name of this machine as a target."""


@dataclass(frozen=True)
class Tool:
    """A program, or a file that a compiler finds, and the Debian package that has it."""

    package: str
    command: tuple[str, ...]
    file: str = ""
    runs_only: bool = False
    """Whether firmware takes it to run, but not to be compiled and counted."""

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
        return_bytes: what a call puts on the stack, where -fstack-usage leaves it out of the frame.
    """

    name: str
    compile: tuple[str, ...]
    link: tuple[str, ...]
    board: tuple[str, ...]
    emulate: Callable[[Path, Path, Path], list[str]]
    tools: tuple[Tool, ...]
    constants_in_flash: bool = True
    return_bytes: int = 0

    def binutils(self, program: str) -> str:
        """Name of a program of the target's binutils, such as "objdump"."""
        return program if self.name == HOST else self.compile[0].removesuffix("gcc") + program


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
            Tool("qemu-system-arm", ("qemu-system-arm",), runs_only=True),
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
            Tool("qemu-system-misc", ("qemu-system-riscv32",), runs_only=True),
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
        return_bytes=2,
    )


def _simavr(mcu: str, hertz: int, program: Path, ports: Path, out: Path) -> list[str]:
    """Compile the host's program around simavr, which the folder brings along."""
    emulator = out / "simavr_uart"
    source = ports / "avr" / "host" / "simavr_uart.c"
    command = [*compiler(), "-O2", str(source), "-lsimavr", "-o", str(emulator)]
    run_compiler(command, out, f"{source}: {command[0]}")
    return [str(emulator), mcu, str(hertz), str(program)]


def _host() -> Core:
    """This machine's gcc, without what its system adds around functions and into calls."""
    plain = (
        "-m64",
        "-fno-pie",
        "-fno-stack-protector",
        "-fcf-protection=none",
        "-fno-reorder-blocks-and-partition",
        "-minline-all-stringops",
        "-ffreestanding",
    )
    return Core(
        name=HOST,
        compile=("gcc", *plain),
        link=("-static", "-no-pie"),
        board=(),
        emulate=lambda program, ports, out: [str(program)],
        tools=(Tool("gcc", ("gcc",)), Tool("binutils", ("objdump",))),
    )


MICROCONTROLLERS = {
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


_COUNTABLE = ("x86_64", "AMD64")
"""Names of the processor that is imitated where this machine is meant."""

VERIFIED = (HOST, *MICROCONTROLLERS)
"""Targets on which a folder can be verified."""

COUNTED = (*((HOST,) if platform.machine() in _COUNTABLE else ()), *MICROCONTROLLERS)
"""Targets whose instructions can be counted."""


def core_named(target: str, known: Iterable[str] = MICROCONTROLLERS) -> Core:
    """Return a target by its name.

    Args:
        target: its name.
        known: the names that are asked for.

    Raises:
        ArgumentError: it is none of them.
    """
    require_known(target, known)
    return _host() if target == HOST else MICROCONTROLLERS[target]


def require_known(target: str, known: Iterable[str]) -> None:
    """Refuse a target that is none of some names.

    Raises:
        ArgumentError: naming those that are known.
    """
    if target not in known:
        raise ArgumentError(f"{target} is unknown; known: {', '.join(known)}", "target")


def missing_tools(core: Core, to_run: bool = True) -> list[str]:
    """Debian packages that a target needs and that are not installed.

    Args:
        core: the target.
        to_run: whether firmware is to run in an emulator; else only to be compiled and counted.
    """
    needed = (tool for tool in core.tools if to_run or not tool.runs_only)
    return list(dict.fromkeys(tool.package for tool in needed if not tool.present()))


def require_tools(core: Core) -> None:
    """Make sure that everything a target needs to run firmware is installed.

    Raises:
        ToolError: something is not; names the packages.
    """
    missing = " ".join(missing_tools(core))
    if missing:
        raise ToolError(f"{core.name}: needs {missing}; install with `apt-get install {missing}`")


@functools.cache
def _knows_file(command: tuple[str, ...], file: str) -> bool:
    """Whether a compiler finds a file: it then names it in full."""
    done = subprocess.run(
        [*command, f"-print-file-name={file}"], capture_output=True, text=True, check=False
    )
    return Path(done.stdout.strip()).is_absolute()
