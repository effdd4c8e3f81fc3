"""Calls functions of a linked program in an emulated core and counts their instructions exactly."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import unicorn
from elftools.elf.elffile import ELFFile
from unicorn import arm_const, riscv_const, x86_const

from ccgen.errors import CheckError

RAM = 0x20000000
RAM_BYTES = 0x40000
STACK_BYTES = 0x8000
FLASH_BYTES = 0x400000
RETURN = 0x3F0000
"""Where a call returns to: mapped, but never executed."""

_PUSHED = 8
"""Bytes of a return address where a call pushes it."""

_SSE = 1 << 5 | 1 << 9 | 1 << 10
"""Bits of an x86-64's register CR4: 64-bit addresses, and floats with their exceptions."""

TIME_LIMIT_US = 60_000_000


@dataclass(frozen=True)
class Core:
    """How the emulator imitates a processor.

    Attributes:
        architecture, mode, model: the emulator's names of it.
        arguments: registers of a call's first arguments.
        result: register of what a call returns.
        stack, program_counter: stack pointer, address of the next instruction.
        link: register of the return address; None where a call pushes it.
        code_bit: what marks an address as code of the instruction set.
        has_fpu: whether the floating-point unit must be switched on.
    """

    architecture: int
    mode: int
    model: int
    arguments: tuple[int, ...]
    result: int
    stack: int
    link: int | None
    program_counter: int
    code_bit: int = 0
    has_fpu: bool = False


def _cortex_m(model: int, has_fpu: bool = False) -> Core:
    return Core(
        architecture=unicorn.UC_ARCH_ARM,
        mode=unicorn.UC_MODE_THUMB | unicorn.UC_MODE_MCLASS,
        model=model,
        arguments=tuple(getattr(arm_const, f"UC_ARM_REG_R{i}") for i in range(4)),
        result=arm_const.UC_ARM_REG_R0,
        stack=arm_const.UC_ARM_REG_SP,
        link=arm_const.UC_ARM_REG_LR,
        program_counter=arm_const.UC_ARM_REG_PC,
        code_bit=1,
        has_fpu=has_fpu,
    )


CORES = {
    "cortex-m0": _cortex_m(arm_const.UC_CPU_ARM_CORTEX_M0),
    "cortex-m3": _cortex_m(arm_const.UC_CPU_ARM_CORTEX_M3),
    "cortex-m4": _cortex_m(arm_const.UC_CPU_ARM_CORTEX_M4, has_fpu=True),
    "cortex-m7": _cortex_m(arm_const.UC_CPU_ARM_CORTEX_M7, has_fpu=True),
    "riscv32": Core(
        architecture=unicorn.UC_ARCH_RISCV,
        mode=unicorn.UC_MODE_RISCV32,
        model=riscv_const.UC_CPU_RISCV32_ANY,
        arguments=tuple(getattr(riscv_const, f"UC_RISCV_REG_A{i}") for i in range(8)),
        result=riscv_const.UC_RISCV_REG_A0,
        stack=riscv_const.UC_RISCV_REG_SP,
        link=riscv_const.UC_RISCV_REG_RA,
        program_counter=riscv_const.UC_RISCV_REG_PC,
    ),
    "host": Core(
        architecture=unicorn.UC_ARCH_X86,
        mode=unicorn.UC_MODE_64,
        model=x86_const.UC_CPU_X86_QEMU64,
        arguments=(
            x86_const.UC_X86_REG_RDI,
            x86_const.UC_X86_REG_RSI,
            x86_const.UC_X86_REG_RDX,
            x86_const.UC_X86_REG_RCX,
            x86_const.UC_X86_REG_R8,
            x86_const.UC_X86_REG_R9,
        ),
        result=x86_const.UC_X86_REG_RAX,
        stack=x86_const.UC_X86_REG_RSP,
        link=None,
        program_counter=x86_const.UC_X86_REG_RIP,
    ),
}


@dataclass(frozen=True)
class Call:
    """What one call did.

    Attributes:
        result: its return value as a signed 32-bit number.
        instructions: executed, the return included.
        stack_bytes: how deep in the stack something was written.
    """

    result: int
    instructions: int
    stack_bytes: int


class Program:
    """A linked program in the memory of an emulated core.

    Args:
        path: an ELF file, linked with constants in flash (below 4 MB) and variables at `RAM`.
        core: one of `CORES`.
    """

    def __init__(self, path: Path, core: Core) -> None:
        self._core = core
        self._uc = unicorn.Uc(core.architecture, core.mode)
        self._uc.ctl_set_cpu_model(core.model)
        self._uc.mem_map(0, FLASH_BYTES)
        self._uc.mem_map(RAM, RAM_BYTES)
        with path.open("rb") as file:
            elf = ELFFile(file)
            for segment in elf.iter_segments("PT_LOAD"):
                self._uc.mem_write(segment["p_vaddr"], segment.data())
            table: Any = elf.get_section_by_name(".symtab")
            symbols = list(table.iter_symbols())
            self._address = {s.name: int(s["st_value"]) & ~core.code_bit for s in symbols}
            self._size = {s.name: int(s["st_size"]) for s in symbols}
        self._switch_on_floats()
        self._counted = 0
        self._lowest = 0

    def _switch_on_floats(self) -> None:
        if self._core.architecture == unicorn.UC_ARCH_X86:
            self._uc.reg_write(x86_const.UC_X86_REG_CR4, _SSE)
        if self._core.has_fpu:
            self._uc.mem_map(0xE000E000, 0x1000)
            self._uc.reg_write(arm_const.UC_ARM_REG_FPEXC, 1 << 30)

    def address(self, symbol: str) -> int:
        """Return where a symbol lies."""
        return self._address[symbol]

    def size(self, symbol: str) -> int:
        """Return how many bytes a symbol has."""
        return self._size[symbol]

    def write(self, symbol: str, data: bytes, offset: int = 0) -> None:
        """Write bytes to a variable."""
        self._uc.mem_write(self.address(symbol) + offset, data)

    def read(self, symbol: str, size: int, offset: int = 0) -> bytes:
        """Read bytes from a variable."""
        return bytes(self._uc.mem_read(self.address(symbol) + offset, size))

    def call(
        self, function: str, arguments: Iterable[str | int] = (), counted: bool = True
    ) -> Call:
        """Call a function.

        Args:
            function: its symbol.
            arguments: numbers, or symbols for their addresses.
            counted: whether to count instructions and stack, which takes a hundred times longer.

        Raises:
            CheckError: the core faulted or did not return.
        """
        core = self._core
        numbers = [
            self.address(value) if isinstance(value, str) else value & 0xFFFFFFFF
            for value in arguments
        ]
        for register, number in zip(core.arguments, numbers, strict=False):
            self._uc.reg_write(register, number)
        top = self._on_stack(numbers[len(core.arguments) :])
        if core.link is None:
            self._uc.mem_write(top - _PUSHED, RETURN.to_bytes(_PUSHED, "little"))
            self._uc.reg_write(core.stack, top - _PUSHED)
        else:
            self._uc.reg_write(core.link, RETURN | core.code_bit)
            self._uc.reg_write(core.stack, top)
        self._counted, self._lowest = 0, top
        start = self.address(function) | core.code_bit
        hooks = self._hooks() if counted else []
        try:
            self._uc.emu_start(start, RETURN, timeout=TIME_LIMIT_US)
        except unicorn.UcError as error:
            raise CheckError(f"{function}: the emulated core stopped: {error}") from error
        finally:
            for hook in hooks:
                self._uc.hook_del(hook)
        if self._uc.reg_read(core.program_counter) & ~1 != RETURN:
            raise CheckError(f"{function}: did not return within {TIME_LIMIT_US / 1e6:g} s")
        value = int(self._uc.reg_read(core.result)) & 0xFFFFFFFF
        result = value - 2**32 if value >= 2**31 else value
        return Call(result, self._counted, top - self._lowest)

    def _on_stack(self, numbers: list[int]) -> int:
        """Put arguments for which no registers are left where a caller would; the stack's top."""
        size = _PUSHED if self._core.link is None else 4
        top = RAM + RAM_BYTES - -(-size * len(numbers) // 16) * 16
        for place, number in enumerate(numbers):
            self._uc.mem_write(top + size * place, number.to_bytes(size, "little"))
        return top

    def _hooks(self) -> list[Any]:
        stack = (RAM + RAM_BYTES - STACK_BYTES, RAM + RAM_BYTES)
        return [
            self._uc.hook_add(unicorn.UC_HOOK_CODE, self._count),
            self._uc.hook_add(unicorn.UC_HOOK_MEM_WRITE, self._written, None, *stack),
        ]

    def _count(self, *_: object) -> None:
        self._counted += 1

    def _written(self, uc: Any, access: int, address: int, *_: object) -> None:
        self._lowest = min(self._lowest, address)
