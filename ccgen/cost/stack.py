"""Worst-case stack of a function: frames from -fstack-usage along the disassembly's call graph.

Functions of the compiler's library have no record of their frame; theirs is the sum of all that
their code takes from the stack, which is never too little. A computed jump that is no return is
taken for a switch inside its function.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ccgen.errors import CheckError

_FUNCTION = re.compile(r"^[0-9a-f]+ <(?P<name>[^>+]+)>:$")
_INSTRUCTION = re.compile(r"^\s+[0-9a-f]+:\t[0-9a-f ]+\t(?P<word>\S+)\s*(?P<rest>.*)$")
_TARGET = re.compile(r"<(?P<name>[^>+]+)(?P<inside>\+0x[0-9a-f]+)?>")
_INDIRECT = re.compile(r"^(blx\s+(r\d+|ip|lr)\b|jalr\b|icall|eicall|callq?\s+\*)")
_CALLS = frozenset(("bl", "blx", "jal", "call", "callq", "rcall"))
_TRANSFERS = re.compile(
    r"^(b|bl|blx|b[a-z]{2}|cb|j[a-z]{1,3}|j|jal|callq?|rcall|jmp|rjmp|br[a-z]+|tail)\b"
)


@dataclass
class Function:
    """A function as it was linked: where it calls and jumps, and what it takes from the stack."""

    calls: set[str] = field(default_factory=set)
    jumps: set[str] = field(default_factory=set)
    taken: int = 0
    indirect: bool = False


def read_disassembly(text: str, return_bytes: int = 0) -> dict[str, Function]:
    """Functions by name.

    Args:
        text: what `objdump -d` prints.
        return_bytes: what a call puts on the stack.
    """
    functions: dict[str, Function] = {}
    current, name = Function(), ""
    for line in text.splitlines():
        header, instruction = _FUNCTION.match(line), _INSTRUCTION.match(line)
        if header:
            name = header["name"]
            current = functions.setdefault(name, Function(taken=return_bytes))
        elif instruction:
            _read_instruction(current, name, instruction["word"], instruction["rest"])
    return functions


def read_frames(folder: Path) -> dict[str, int]:
    """Frames by function from the compiler's .su files; of equal names the largest.

    Raises:
        CheckError: a frame that is known at run time only.
    """
    frames: dict[str, int] = {}
    for file in sorted(folder.glob("*.su")):
        for line in file.read_text(encoding="utf-8").splitlines():
            place, size, kind = line.split("\t")
            name = _plain(place.rsplit(":", 1)[1])
            if kind != "static":
                raise CheckError(f"{name}: its frame is {kind}, no bound of the stack can be given")
            frames[name] = max(frames.get(name, 0), int(size))
    return frames


def worst_case(
    root: str, functions: Mapping[str, Function], frames: Mapping[str, int]
) -> tuple[int, Sequence[str]]:
    """Most bytes of stack that a call of `root` takes, and the calls that take it.

    Raises:
        CheckError: recursion, or a call through a pointer.
    """
    known: dict[str, tuple[int, tuple[str, ...]]] = {}
    functions = _with_parts_joined(functions, frames)

    def visit(name: str, path: tuple[str, ...]) -> tuple[int, tuple[str, ...]]:
        if name in path:
            raise CheckError(f"{name}: recursion ({' calls '.join((*path, name))})")
        if name not in known:
            function = functions[name]
            if function.indirect:
                raise CheckError(f"{name}: calls through a pointer, its stack has no bound")
            callees = sorted((function.calls | function.jumps) & functions.keys())
            called = [visit(callee, (*path, name)) for callee in callees]
            deepest, calls = max(called, default=(0, ()))
            known[name] = (frames.get(_plain(name), function.taken) + deepest, (name, *calls))
        return known[name]

    return visit(root, ())


def _with_parts_joined(
    functions: Mapping[str, Function], frames: Mapping[str, int]
) -> dict[str, Function]:
    """Join the library's functions in assembly with the parts that they jump to.

    Such jumps lead back and forth without being calls. Calls between joined parts, which do not
    nest in each other, count once.
    """
    assembly = {name for name in functions if _plain(name) not in frames}
    joined = dict(functions)
    for name in assembly:
        parts, new = {name}, {name}
        while new:
            new = {to for part in new for to in functions[part].jumps & assembly} - parts
            parts |= new
        members = [functions[part] for part in parts]
        calls: set[str] = set().union(*(m.calls for m in members))
        taken = sum(m.taken for m in members)
        joined[name] = Function(
            calls=calls - parts,
            jumps=set().union(*(m.jumps for m in members)) - parts,
            taken=2 * taken if calls & parts else taken,
            indirect=any(m.indirect for m in members),
        )
    return joined


def _plain(name: str) -> str:
    """A function's name without what the compiler adds for a specialised copy."""
    return name.split(".", 1)[0]


def _read_instruction(function: Function, name: str, word: str, rest: str) -> None:
    if _INDIRECT.match(f"{word} {rest}"):
        function.indirect = True
    target = _TARGET.search(rest)
    transfers = _TRANSFERS.match(word.removesuffix(".n").removesuffix(".w"))
    if transfers and target and target["name"] != name:
        (function.calls if word in _CALLS else function.jumps).add(target["name"])
    function.taken += _taken(word, rest)


def _taken(word: str, rest: str) -> int:
    """Bytes that one instruction takes from the stack."""
    if word in ("push", "stmdb", "vpush", "vstmdb") and "{" in rest:
        return _registers(rest) * (8 if re.search(r"\bd\d", rest) else 4)
    if word == "push":  # one register of AVR
        return 1
    amount = re.match(r"sp, (?:sp, )?#(\d+)", rest) if word.startswith("sub") else None
    amount = amount or re.match(r"sp,\s*sp,\s*-(\d+)", rest)
    amount = amount or re.search(r"\[sp, #-(\d+)\]!", rest)
    return int(amount[1]) if amount else 0


def _registers(rest: str) -> int:
    listed = rest[rest.index("{") + 1 : rest.index("}")].split(",")
    ends = [re.findall(r"\d+", entry) for entry in listed if "-" in entry]
    return len(listed) - len(ends) + sum(int(b) - int(a) + 1 for a, b in ends)
