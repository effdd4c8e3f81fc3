"""Acceptance filters of a controller with two masks: the MCP2515."""

from collections.abc import Iterable
from itertools import combinations

from ccgen.can.layout import LARGEST_ID, FrameLayout

PLACES = (2, 4)
"""Filters that share the mask of each receive buffer."""


def two_masks(layout: FrameLayout) -> list[tuple[int, int]]:
    """Identifiers and masks that let a node's own frames in: two with one mask, four with another.

    Of all that are possible, those that let in fewest others; then those that pass most LENGTHS
    through the first two, whose frames have the FIFO of two buffers.
    """
    lengths, wanted = _lengths(layout), _wanted(layout)
    sizes = [2**k for k in range(max(1, max(wanted).bit_length()))]
    sizes = [size for size in sizes if size <= 2 * (max(wanted) - min(wanted) + 1)]
    found = []
    for first_size in sizes:
        starts = _starts(wanted, first_size)
        for number in range(1, PLACES[0] + 1):
            for first in combinations(starts, number):
                within = {i for start in first for i in range(start, start + first_size)}
                rest = wanted - within
                for second_size in sizes:
                    second = _starts(rest, second_size)
                    if len(second) <= PLACES[1]:
                        let_in = within | {i for s in second for i in range(s, s + second_size)}
                        cost = (len(let_in - wanted), len(lengths - within), first_size)
                        found.append((cost, (first, first_size), (tuple(second), second_size)))
    _, first_bank, second_bank = min(found)
    if not second_bank[0]:
        second_bank = first_bank
    masks = LARGEST_ID[layout.extended]
    return [
        (starts[min(k, len(starts) - 1)], masks & ~(size - 1))
        for (starts, size), places in zip((first_bank, second_bank), PLACES, strict=True)
        for k in range(places)
    ]


def strangers(layout: FrameLayout, masks: Iterable[tuple[int, int]]) -> list[str]:
    """Identifiers of others that the masks let in."""
    size = LARGEST_ID[layout.extended] + 1
    let_in = {i for first, mask in masks for i in range(first, first + size - mask)}
    return [f"0x{i:X}" for i in sorted(let_in - _wanted(layout))]


def _lengths(layout: FrameLayout) -> set[int]:
    return set(range(layout.base_id, layout.base_id + layout.lengths_frames))


def _wanted(layout: FrameLayout) -> set[int]:
    return _lengths(layout) | ({layout.last_id} if layout.commands else set())


def _starts(ids: Iterable[int], size: int) -> list[int]:
    """Where the blocks of a size begin that hold the identifiers."""
    return sorted({i - i % size for i in ids})
