"""What cost is measured of: the microcontrollers that are verified, and this machine."""

import platform

from ccgen.errors import ArgumentError
from ccgen.targets.cores import CORES as MICROCONTROLLERS
from ccgen.targets.cores import Core, Tool

HOST = "host"

_COUNTABLE = ("x86_64", "AMD64")
"""Names of the processor that is imitated where this machine is meant."""

TARGETS = (*((HOST,) if platform.machine() in _COUNTABLE else ()), *MICROCONTROLLERS)
"""Names of the targets."""

RETURN_BYTES = {"avr": 2}
"""What a call puts on the stack, where -fstack-usage leaves it out of the frame."""

_EMULATORS = ("qemu-system-arm", "qemu-system-misc")
"""Packages that running firmware takes and counting does not."""


def core_named(target: str) -> Core:
    """Return a target by its name.

    Raises:
        ArgumentError: unknown target.
    """
    if target not in TARGETS:
        raise ArgumentError(f"{target} is unknown; known: {', '.join(TARGETS)}", "target")
    return _host() if target == HOST else MICROCONTROLLERS[target]


def missing_tools(target: str) -> list[str]:
    """Debian packages that measuring needs and that are not installed.

    Raises:
        ArgumentError: unknown target.
    """
    needed = (tool for tool in core_named(target).tools if tool.package not in _EMULATORS)
    return list(dict.fromkeys(tool.package for tool in needed if not tool.present()))


def binutils(core: Core, program: str) -> str:
    """Name of a program of the target's binutils."""
    return program if core.name == HOST else core.compile[0].removesuffix("gcc") + program


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
