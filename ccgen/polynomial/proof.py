"""What a plan is proven to do: no integer leaves its type, and how far outputs may be off.

The plan with every rounding as an unknown within its bounds is a polynomial in inputs and
roundings. By the mean value theorem an output's error is the sum of the roundings, each times the
output's derivative by it at some point between; derivatives are bounded by intervals, backwards
through the plan, so that errors which cancel do. Beside it goes the sum of errors forwards, and the
narrower of both counts. All of it is interval arithmetic with ends rounded outward.

The inputs' ranges are cut into pieces, each proven for itself, which narrows what intervals take
for granted too much.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ccgen.errors import CheckError
from ccgen.polynomial.enclosures import PIECES, Enclosure, Ends
from ccgen.polynomial.enclosures import pieces as input_pieces
from ccgen.polynomial.intervals import ONE, ZERO, Interval, hull
from ccgen.polynomial.plan import PRODUCTS, Plan, Step

INT32 = (-(2**31), 2**31 - 1)
"""Least and greatest integer of 32 bits."""


@dataclass(frozen=True)
class Proof:
    """What holds for all inputs in range.

    Attributes:
        integers: least and greatest integer of every step.
        errors: of every output element, what its integer stands for less the exact value.
    """

    integers: tuple[Ends, ...]
    errors: tuple[Interval, ...]

    def bounds(self) -> list[Fraction]:
        """Largest distance of every output element from the exact value."""
        return [error.magnitude for error in self.errors]


def prove(plan: Plan, most: int = PIECES) -> Proof:
    """Prove a plan.

    Args:
        plan: the plan.
        most: pieces that its inputs' ranges are cut into.

    Raises:
        CheckError: a format does not fit its operation, or an integer may leave its type.
    """
    check_formats(plan.steps)
    pieces = [
        _Piece.of(plan.steps, ends, enclosures)
        for ends, enclosures in input_pieces(plan.inputs, plan.steps, most)
    ]
    integers = tuple(
        (min(low for low, _ in found), max(high for _, high in found))
        for found in zip(*(piece.integers for piece in pieces), strict=True)
    )
    check_widths(plan, integers)
    followed = [(piece, piece.factors(plan.steps)) for piece in pieces]
    errors = tuple(
        hull(piece.error(plan.steps, factors, step) for piece, factors in followed)
        for _, step in plan.outputs
    )
    return Proof(integers, errors)


def check_formats(steps: Sequence[Step]) -> None:
    """Refuse a step whose format is not what its operation gives.

    Raises:
        CheckError: naming the step.
    """
    for number, step in enumerate(steps):
        formats = [steps[k].fraction_bits for k in step.operands]
        if step.kind in ("add", "subtract", "negate"):
            fits = all(one == step.fraction_bits for one in formats)
        elif step.kind in PRODUCTS:
            fits = sum(formats) - PRODUCTS[step.kind] == step.fraction_bits
        elif step.kind == "left":
            fits = step.shift >= 0 and formats[0] + step.shift == step.fraction_bits
        elif step.kind in ("right", "view"):
            fits = formats[0] - step.shift == step.fraction_bits
        else:
            fits = True
        if not fits or (step.kind in ("left", "right") and not 0 <= step.shift < 32):
            raise CheckError(f"step {number}, {step.kind}: its format is not its operands'")


def check_widths(plan: Plan, integers: Sequence[Ends]) -> None:
    """Refuse a plan in which an integer may leave its type.

    Raises:
        CheckError: naming the step or the output.
    """
    for number, (step, (low, high)) in enumerate(zip(plan.steps, integers, strict=True)):
        if step.kind == "right":
            first = integers[step.operands[0]]
            low, high = min(low, first[0] + step.value), max(high, first[1] + step.value)
        if low < INT32[0] or high > INT32[1]:
            raise CheckError(f"step {number}, {step.kind}: may leave 32 bits")
        if step.kind == "word" and not _fits(integers[step.operands[1]], 16):
            raise CheckError(f"step {number}, word: its second operand may leave 16 bits")
    for variable, number in plan.outputs:
        if not _fits(integers[number], variable.bits):
            raise CheckError(f"output {variable.name}: may leave {variable.bits} bits")


def _fits(ends: Ends, bits: int) -> bool:
    return -(1 << (bits - 1)) <= ends[0] and ends[1] < 1 << (bits - 1)


@dataclass(frozen=True)
class _Piece:
    """One piece of the inputs' ranges, followed forwards.

    Attributes:
        meant: what every step stands for if nothing is ever rounded.
        off: how far a step may be from that, for roundings of any size up to their own.
        integers: least and greatest integer of every step.
    """

    meant: list[Interval]
    off: list[Interval]
    integers: list[Ends]

    @classmethod
    def of(
        cls, steps: Sequence[Step], ends: Sequence[Ends], inputs: Sequence[Enclosure]
    ) -> "_Piece":
        piece = cls([one.value for one in inputs], [ZERO] * len(inputs), list(ends))
        known = list(inputs)
        for step in steps[len(inputs) :]:
            known.append(_enclosed(step, known))
            piece.follow(step, known[-1].value)
        return piece

    def follow(self, step: Step, meant: Interval) -> None:
        """Add a step and what it stands for."""
        off = forward_error(step, self.meant, self.off)
        counted = step.integers([self.integers[k] for k in step.operands])
        judged = (meant + off).steps(step.fraction_bits)
        self.meant.append(meant)
        self.off.append(off)
        self.integers.append((max(counted[0], judged[0]), min(counted[1], judged[1])))

    def factors(self, steps: Sequence[Step]) -> list[list[Interval]]:
        """Derivatives of steps by their operands, for any roundings between none and all."""
        rounded = [meant + off for meant, off in zip(self.meant, self.off, strict=True)]
        return [_factors(step, rounded) for step in steps]

    def error(
        self, steps: Sequence[Step], factors: Sequence[Sequence[Interval]], output: int
    ) -> Interval:
        """What an output's step may be off, by the derivatives that `factors` gives."""
        slopes: list[Interval | None] = [None] * output + [ONE]
        total = ZERO
        for number in range(output, -1, -1):
            slope = slopes[number]
            if slope is None:
                continue
            step = steps[number]
            if step.rounding is not ZERO:
                total += slope * step.rounding
            for operand, factor in zip(step.operands, factors[number], strict=True):
                own = slope if factor is ONE else slope * factor
                before = slopes[operand]
                slopes[operand] = own if before is None else before + own
        return total.within(self.off[output])


def _factors(step: Step, rounded: Sequence[Interval]) -> list[Interval]:
    if step.kind in PRODUCTS:
        a, b = step.operands
        return [rounded[b], rounded[a]]
    if step.kind == "view":
        return [ONE.times_power(step.shift)]
    signs = {"subtract": [ONE, -ONE], "negate": [-ONE]}
    return signs.get(step.kind, [ONE] * len(step.operands))


def _enclosed(step: Step, known: list[Enclosure]) -> Enclosure:
    if step.kind == "constant":
        return known[0].constant(Interval.of(step.exact))
    return step.meant([known[k] for k in step.operands])


def forward_error(step: Step, meant: Sequence[Interval], off: Sequence[Interval]) -> Interval:
    """How far a step may be from what it stands for, from how far its operands may be.

    Roundings count from nothing to their own, so that 0 always lies within.
    """
    own = step.rounding
    own = Interval(min(own.low, 0), max(own.high, 0))
    if step.kind in PRODUCTS:
        (a, b), (da, db) = ([table[k] for k in step.operands] for table in (meant, off))
        return a * db + da * b + da * db + own
    moved = [off[k] for k in step.operands]
    if not moved:
        return own
    if step.kind == "view":
        return moved[0].times_power(step.shift)
    if step.kind == "negate":
        return -moved[0]
    if step.kind == "subtract":
        return moved[0] - moved[1] + own
    return (moved[0] + moved[1] if step.kind == "add" else moved[0]) + own
