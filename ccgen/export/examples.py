"""Complete projects for a joint, written into its folder when they are asked for."""

import difflib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from ccgen import resources
from ccgen.can.layout import LARGEST_ID, FrameLayout
from ccgen.errors import ArgumentError, InputError
from ccgen.export.banks import strangers, two_masks

FOLDER = "examples"
"""Where they go in the exported folder, each into a folder of its kind's name."""


@dataclass(frozen=True)
class Example:
    """A kind of example: its files and, of templates/examples, what they are made from.

    Attributes:
        files: paths in the project's folder, each with its template's name but for the ending; a
            name with a folder is another kind's.
        classic_only: what its controller is, where that does not speak CAN FD.
        copies: paths in the project's folder, each with the file of the C runtime that it is.
    """

    files: Mapping[str, str]
    classic_only: str = ""
    copies: Mapping[str, str] = field(default_factory=dict)


EXAMPLES: dict[str, Example] = {
    "cmake": Example({name: name for name in ("CMakeLists.txt", "main.c", "README.md")}),
    "cortex-m": Example(
        {name: name for name in ("CMakeLists.txt", "cortex-m4.cmake", "main.c", "README.md")}
    ),
    "stm32": Example(
        {
            **{
                name: name
                for name in (
                    "CMakeLists.txt",
                    "main.c",
                    "board.h",
                    "board_g4.c",
                    "board_f4.c",
                    "README.md",
                )
            },
            "cortex-m4.cmake": "cortex-m/cortex-m4.cmake",
        }
    ),
    "esp-idf": Example(
        {
            "CMakeLists.txt": "CMakeLists.txt",
            "sdkconfig.defaults": "sdkconfig.defaults",
            "main/CMakeLists.txt": "main_CMakeLists.txt",
            "main/main.c": "main.c",
            "README.md": "README.md",
        },
        "the TWAI controller of ESP32",
    ),
    "arduino": Example({name: name for name in ("arduino.ino", "README.md")}),
    "mcp2515": Example(
        {
            name: name
            for name in ("CMakeLists.txt", "avr.cmake", "main.c", "board.h", "board.c", "README.md")
        },
        "the MCP2515",
    ),
    "platformio": Example(
        {
            "platformio.ini": "platformio.ini",
            "src/main.cpp": "main.cpp",
            "README.md": "README.md",
        },
        "the MCP2515",
        {
            "src/can_mcp2515.h": "ports/mcp2515/can_mcp2515.h",
            "src/can_mcp2515.c": "ports/mcp2515/can_mcp2515.c",
            "src/can_port.h": "ports/can/can_port.h",
            "src/can_timing.h": "ports/can/can_timing.h",
            "src/can_timing.c": "ports/can/can_timing.c",
        },
    ),
    "zephyr": Example(
        {
            "CMakeLists.txt": "CMakeLists.txt",
            "prj.conf": "prj.conf",
            "src/main.c": "main.c",
            "README.md": "README.md",
        }
    ),
}
"""The kinds, as they are asked for."""


def check_kinds(kinds: Iterable[str]) -> None:
    """Check that there are examples of these kinds.

    Raises:
        ArgumentError: there is none of that kind.
    """
    for kind in kinds:
        if kind not in EXAMPLES:
            near = difflib.get_close_matches(kind, EXAMPLES, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"known: {', '.join(EXAMPLES)}"
            raise ArgumentError(f"{kind} is unknown; {remedy}", "examples")


def example_files(
    kinds: Iterable[str], layout: FrameLayout, source: str, values: Mapping[str, Any]
) -> dict[str, bytes]:
    """Render examples; content by path in the exported folder.

    Args:
        kinds: as `check_kinds` accepts them.
        layout: the joint's frames.
        source: names the joint's file in messages.
        values: what templates are filled with.

    Raises:
        InputError: the controller of a kind does not speak CAN FD, and the joint does.
    """
    files, masks = {}, two_masks(layout)
    for kind in dict.fromkeys(kinds):
        example = EXAMPLES[kind]
        if layout.fd and example.classic_only:
            raise InputError(
                f"{source}: can.fd: true, but {example.classic_only} of the example {kind} speaks "
                "classic CAN alone; write fd = false, or take another controller"
            )
        for path, template in example.files.items():
            name = template if "/" in template else f"{kind}/{template}"
            text = resources.template(f"examples/{name}.j2").render(
                values,
                filters=filters(layout),
                length_filters=_length_filters(layout),
                command_filters=_command_filters(layout),
                two_masks=masks,
                strangers=strangers(layout, masks),
            )
            files[f"{FOLDER}/{kind}/{path}"] = text.encode("utf-8")
        for path, source_path in example.copies.items():
            copied = resources.firmware() / source_path
            files[f"{FOLDER}/{kind}/{path}"] = copied.read_bytes()
    return files


def filters(layout: FrameLayout) -> list[tuple[int, int]]:
    """Identifiers and masks that let a node's own frames in, and no others."""
    return _length_filters(layout) + _command_filters(layout)


def _length_filters(layout: FrameLayout) -> list[tuple[int, int]]:
    largest, first = LARGEST_ID[layout.extended], layout.base_id
    blocks = _blocks(range(first, first + layout.lengths_frames))
    return [(block, largest & ~(size - 1)) for block, size in blocks]


def _command_filters(layout: FrameLayout) -> list[tuple[int, int]]:
    return [(layout.last_id, LARGEST_ID[layout.extended])] if layout.commands else []


def _blocks(ids: range) -> Iterator[tuple[int, int]]:
    """Cut a range into as few pieces as masks can tell: powers of two that begin at a multiple."""
    first = ids.start
    while first < ids.stop:
        size = 1
        while first % (2 * size) == 0 and first + 2 * size <= ids.stop:
            size *= 2
        yield first, size
        first += size
