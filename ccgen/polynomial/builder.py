"""Writes a plan's steps: each operation of the graph in the cheapest form that is exact enough.

Every choice is among forms that fit 32 bits; how exact each is, is estimated here and proven later
(`ccgen.polynomial.proof`). Costs are instructions of a core without long products (Cortex-M0),
where they differ most.
"""

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from ccgen.polynomial.enclosures import Ends
from ccgen.polynomial.intervals import Interval, power_of_two
from ccgen.polynomial.plan import PRODUCTS, Step
from ccgen.polynomial.proof import INT32, forward_error

COST = {"low": 1, "word": 6, "high": 17}
_HALF = 0.5  # more or less where other cores save: a shift by 16, a product of 16 bits
_SHORT = 2**15 - 1
_SLACK = 1 << 12  # units that roundings may add to a sum
_FARTHEST = 31  # bits that one shift drops
_LIMITS = {"low": 32, "word": 16, "high": 32}  # bits of the second operand


@dataclass(frozen=True)
class _Form:
    """One way to multiply: shifts of the operands (to the right, or negative), then the product.

    Shifts to the right round down, or to the nearest, which takes a sum more.
    """

    kind: str
    shifts: tuple[int, int]
    nearest: bool
    fraction_bits: int
    error: float
    cost: float


@dataclass(frozen=True)
class _Scaled:
    """One way to multiply by a constant: its integer, whether it comes first, and the product."""

    value: int
    digits: int
    first: bool
    form: _Form


@dataclass
class Builder:
    """The steps so far, with what is known of each.

    Attributes:
        steps: in order.
        meant: what each stands for.
        off: how far each may be off.
        integers: least and greatest integer of each.
        lacking: of some products how many bits a cheaper form lacks.
    """

    steps: list[Step] = field(default_factory=list)
    meant: list[Interval] = field(default_factory=list)
    off: list[Interval] = field(default_factory=list)
    integers: list[Ends] = field(default_factory=list)
    lacking: dict[int, int] = field(default_factory=dict)
    _known: dict[Step, int] = field(default_factory=dict)

    def put(self, step: Step, meant: Interval | None = None, ends: Ends | None = None) -> int:
        """Add a step, or find an equal one.

        Args:
            step: the step.
            meant: what it stands for, where that is known better than from its operands.
            ends: the integers of an input.
        """
        if step in self._known and step.kind != "input":
            return self._known[step]
        known = step.meant([self.meant[k] for k in step.operands]) if step.operands else meant
        known = Interval.of(step.exact) if known is None else known
        self.meant.append(known if meant is None else known.within(meant))
        self.off.append(forward_error(step, self.meant, self.off))
        counted = ends or step.integers([self.integers[k] for k in step.operands])
        judged = (self.meant[-1] + self.off[-1]).steps(step.fraction_bits)
        self.integers.append((max(counted[0], judged[0]), min(counted[1], judged[1])))
        self.steps.append(step)
        self._known[step] = len(self.steps) - 1
        return len(self.steps) - 1

    def fraction_bits(self, a: int) -> int:
        """Of a step's format."""
        return self.steps[a].fraction_bits

    def shifted(self, a: int, bits: int) -> int:
        """A step less so many fraction bits, or with more where negative."""
        while bits > _FARTHEST:  # a term that is next to nothing
            a = self.put(Step("right", (a,), self.fraction_bits(a) - _FARTHEST, _FARTHEST))
            bits -= _FARTHEST
        if bits == 0:
            return a
        kind = "right" if bits > 0 else "left"
        return self.put(Step(kind, (a,), self.fraction_bits(a) - bits, abs(bits)))

    def _cut(self, a: int, bits: int, nearest: bool) -> Step | None:
        """The step that brings an operand of a product to fewer bits, or to more; None for none."""
        if bits == 0:
            return None
        half = 1 << bits >> 1 if nearest and bits > 0 else 0
        half = half if self.size(a) + half <= INT32[1] else 0
        kind = "right" if bits > 0 else "left"
        return Step(kind, (a,), self.fraction_bits(a) - bits, abs(bits), half)

    def constant(self, exact: Fraction, fraction_bits: int) -> int:
        """The integer nearest to a constant in a format."""
        value = round(exact * power_of_two(fraction_bits))
        return self.put(Step("constant", (), fraction_bits, 0, value, exact))

    def view(self, a: int, exponent: int) -> int:
        """A step times a power of two."""
        return self.put(Step("view", (a,), self.fraction_bits(a) - exponent, exponent))

    def negated(self, a: int) -> int:
        """A step times -1."""
        return self.put(Step("negate", (a,), self.fraction_bits(a)))

    def sum(self, kind: str, a: int, b: int, need: int, meant: Interval) -> int:
        """A sum or difference of two steps, with at least `need` fraction bits where they fit.

        Args:
            kind: "add" or "subtract".
            a: a step.
            b: another.
            need: fraction bits that make roundings small enough.
            meant: what the result stands for.
        """
        formats = [self.fraction_bits(k) for k in (a, b) if self.steps[k].kind != "constant"]
        most = _room(meant)
        candidates = {min(f, most) for f in (*formats, max(need, min(formats)))}

        def judged(f: int) -> tuple[bool, float, int]:
            parts = [self._alignment(k, f) for k in (a, b)]
            error, cost = sum(part[0] for part in parts), sum(part[1] for part in parts)
            enough = error <= 1.01 * math.ldexp(1.0, -need)
            return (not enough, cost if enough else error, -f)

        best = min(candidates, key=judged)
        return self.put(Step(kind, (self._aligned(a, best), self._aligned(b, best)), best), meant)

    def _alignment(self, a: int, fraction_bits: int) -> tuple[float, int]:
        """Error and cost of bringing a step to a format."""
        step = self.steps[a]
        if step.kind == "constant":
            exact = step.exact * power_of_two(fraction_bits)
            return math.ldexp(float(abs(round(exact) - exact)), -fraction_bits), 0
        bits = step.fraction_bits - fraction_bits
        if bits < -_headroom(self.size(a), 32):
            return math.inf, 1
        return (math.ldexp(1.0, -fraction_bits) if bits > 0 else 0.0), int(bits != 0)

    def _aligned(self, a: int, fraction_bits: int) -> int:
        step = self.steps[a]
        if step.kind == "constant":
            return self.constant(step.exact, fraction_bits)
        return self.shifted(a, step.fraction_bits - fraction_bits)

    def product(self, a: int, b: int, need: int, meant: Interval) -> int:
        """A product of two steps; arguments as for `sum`."""
        sizes = self.size(a), self.size(b)
        formats = self.fraction_bits(a), self.fraction_bits(b)
        turned = (sizes[1], sizes[0]), (formats[1], formats[0])
        forms = [(form, (a, b)) for form in _forms(sizes, formats, need)]
        forms += [(form, (b, a)) for form in _forms(*turned, need) if form.kind == "word"]
        form, (x, y) = min(forms, key=lambda found: self._judged(found[0], found[1], need))
        made = self._multiplied(form, x, y, meant)
        self._note(made, form, [one for one, _ in forms], need)
        return made

    def _note(self, made: int, form: _Form, forms: Sequence[_Form], need: int) -> None:
        """Write down what a cheaper form lacks."""
        errors = [one.error for one in forms if COST[one.kind] < COST[form.kind]]
        if errors:
            self.lacking[made] = max(1, math.ceil(math.log2(min(errors)) + need))

    def _judged(
        self, form: _Form, operands: tuple[int, int], need: int
    ) -> tuple[bool, float, float]:
        if form.error > 1.01 * math.ldexp(1.0, -need):
            return (True, form.error, form.error)
        cost = form.cost + sum(
            self._shift_cost(k, bits, form.nearest)
            for k, bits in zip(operands, form.shifts, strict=True)
        )
        return (False, cost, form.error)

    def _shift_cost(self, a: int, bits: int, nearest: bool) -> float:
        step = self._cut(a, bits, nearest)
        if step is None or step in self._known:
            return 0
        return 3 if step.value else _HALF if bits == 16 else 1

    def _multiplied(self, form: _Form, a: int, b: int, meant: Interval) -> int:
        cuts = [
            self._cut(k, bits, form.nearest) for k, bits in zip((a, b), form.shifts, strict=True)
        ]
        x, y = (k if cut is None else self.put(cut) for k, cut in zip((a, b), cuts, strict=True))
        bits = self.fraction_bits(x) + self.fraction_bits(y) - PRODUCTS[form.kind]
        return self.put(Step(form.kind, (x, y), bits), meant)

    def scaled(self, a: int, factor: Fraction, need: int, meant: Interval) -> int:
        """A step times a constant; arguments as for `sum`."""
        size = abs(factor)
        exponent = size.numerator.bit_length() - size.denominator.bit_length()
        if size == power_of_two(exponent):
            result = self.view(a, exponent)
            return self.negated(result) if factor < 0 else result
        forms = list(self._scaled_forms(a, factor, need))
        found = min(forms, key=lambda one: self._judged_scaled(one, a, need))
        constant = self.constant(factor, found.digits)
        first, second = (constant, a) if found.first else (a, constant)
        made = self._multiplied(found.form, first, second, meant)
        self._note(made, found.form, [one.form for one in forms], need)
        return made

    def _judged_scaled(self, one: _Scaled, a: int, need: int) -> tuple[bool, float, float]:
        if one.form.error > 1.01 * math.ldexp(1.0, -need):
            return (True, one.form.error, one.form.error)
        bits = one.form.shifts[1 if one.first else 0]
        cost = one.form.cost + self._shift_cost(a, bits, one.form.nearest)
        return (False, cost, one.form.error)

    def _scaled_forms(self, a: int, factor: Fraction, need: int) -> Iterator[_Scaled]:
        """Products with the constant in some lengths; it is never shifted."""
        size, bits = self.size(a), self.fraction_bits(a)
        magnitude = math.ldexp(size, -bits)
        for digits in _lengths(factor, math.ldexp(0.25, -need) / max(magnitude, 1e-300)):
            exact = factor * power_of_two(digits)
            value = round(exact)
            lacking = math.ldexp(float(abs(value - exact)), -digits) * magnitude
            for first in (False, True):
                sizes = (abs(value), size) if first else (size, abs(value))
                formats = (digits, bits) if first else (bits, digits)
                for form in _forms(sizes, formats, need):
                    if form.shifts[0 if first else 1] == 0:
                        judged = replace(form, error=form.error + lacking)
                        yield _Scaled(value, digits, first, judged)

    def size(self, a: int) -> int:
        """Largest absolute integer of a step."""
        return max(abs(end) for end in self.integers[a])


def _headroom(size: int, bits: int) -> int:
    """How often an integer of at most that size doubles without leaving so many bits."""
    return bits - 1 - max(size, 1).bit_length()


def _room(meant: Interval) -> int:
    """Most fraction bits with which a value fits 32 bits, and a little rounding with it."""
    size = meant.magnitude
    bits = 31 - size.numerator.bit_length() + size.denominator.bit_length()
    while size * power_of_two(bits) > INT32[1] - _SLACK:
        bits -= 1
    return bits


def _lengths(factor: Fraction, enough: float) -> list[int]:
    """Fraction bits for a constant: the fewest that are near enough, all of 16 and of 32 bits."""
    size = abs(factor)
    exponent = size.numerator.bit_length() - size.denominator.bit_length()
    found: list[int] = []
    for length in range(1, 32):
        digits = length - exponent
        value = size * power_of_two(digits)
        if not 0 < round(value) < 2**31:
            continue
        near = math.ldexp(float(abs(value - round(value))), -digits) <= enough
        if (near and not found) or length in (14, 15, 30, 31):
            found.append(digits)
    return found


@functools.lru_cache(maxsize=4096)
def _forms(sizes: tuple[int, int], formats: tuple[int, int], need: int) -> tuple[_Form, ...]:
    """Ways to multiply integers of these largest sizes in these formats.

    Plans for one task differ in few of them.
    """
    return tuple(_every_form(sizes, formats, need))


def _every_form(sizes: Sequence[int], formats: Sequence[int], need: int) -> Iterator[_Form]:
    (a, b), (fa, fb) = sizes, formats
    for ta in range(max(1, a.bit_length())):
        tb = max(0, (a >> ta).bit_length() + b.bit_length() - 31)
        if ((a >> ta) + 1) * ((b >> tb) + 1) <= INT32[1] or (ta == tb == 0 and a * b <= INT32[1]):
            cut = _cut(b, ta, fa + fb) + _cut(a, tb, fa + fb)
            for nearest in (False, True) if ta or tb else (False,):
                error = cut / 2 if nearest else cut
                cost = COST["low"] + (0 if max(a >> ta, b >> tb) < _SHORT else _HALF)
                yield _Form("low", (ta, tb), nearest, fa + fb - ta - tb, error, cost)
    for kind in ("word", "high"):
        limit = _LIMITS[kind]
        drop = max(0, b.bit_length() - (limit - 1))
        bits = fa + fb - drop - PRODUCTS[kind]
        left = min(max(0, need - bits), _headroom(a, 32))
        more = 0 if drop else min(max(0, need - bits - left), _headroom(b, limit))
        bits += left + more
        cut, own = _cut(a, drop, fa + fb), math.ldexp(1.0, -bits)
        for nearest in (False, True) if drop else (False,):
            error = own + (cut / 2 if nearest else cut)
            yield _Form(kind, (-left, drop or -more), nearest, bits, error, COST[kind])


def _cut(other: int, bits: int, fraction_bits: int) -> float:
    """What a product loses where so many bits of one operand are dropped."""
    return math.ldexp(other, bits - fraction_bits) if bits else 0.0
