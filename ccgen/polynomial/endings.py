"""How a plan ends: outputs brought to their formats, and steps that nothing uses left out."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

from ccgen.polynomial.builder import Builder
from ccgen.polynomial.intervals import Interval, power_of_two
from ccgen.polynomial.plan import Plan, Step


def output_format(build: Builder, steps: Sequence[int], bits: int) -> int:
    """Fraction bits of an output's elements: as many as they have, and as fit so many bits."""
    most = min(_most(build, step, bits) for step in steps)
    have = [build.fraction_bits(k) for k in steps if build.steps[k].kind != "constant"]
    return min(most, max(have, default=most))


def _most(build: Builder, step: int, bits: int) -> int:
    """Fraction bits with which a step, rounded, fits so many bits."""
    limit = (1 << (bits - 1)) - 2
    if build.steps[step].kind == "constant":
        size, have = abs(build.steps[step].exact), 0
    else:
        size, have = Fraction(build.size(step)), build.fraction_bits(step)
    most = have + bits - 1 - size.numerator.bit_length() + size.denominator.bit_length()
    while size * power_of_two(most - have) > limit:
        most -= 1
    return most


def rounded(
    build: Builder, step: int, fraction_bits: int, error: Interval, wanted: Fraction
) -> int:
    """A step in an output's format, rounded, less the middle of what it is off.

    Where nothing is rounded, the middle stays unless the error exceeds the one that is wanted.
    """
    if build.steps[step].kind == "constant":
        return build.constant(build.steps[step].exact, fraction_bits)
    bits = build.fraction_bits(step) - fraction_bits
    if bits < 0:
        return build.shifted(step, bits)
    if bits == 0 and error.magnitude <= wanted:
        return step
    low, high = error.ends
    middle = round((low + high) / 2 * power_of_two(build.fraction_bits(step)))
    added = (1 << bits >> 1) - middle
    return build.put(Step("right", (step,), fraction_bits, bits, added))


def without_idle(plan: Plan) -> Plan:
    """The plan without steps that no output needs; inputs stay.

    Outputs follow each other so that each takes up most of what is computed already, and then
    needs fewest steps more: so few numbers wait at the same time.
    """
    steps = plan.steps
    needs: list[set[int]] = []
    for number, step in enumerate(steps):
        needs.append({number}.union(*(needs[k] for k in step.operands)))
    kept = list(range(len(plan.inputs)))
    given = set(kept)
    done, left = set(kept), [step for _, step in plan.outputs]

    def judged(output: int) -> tuple[int, int]:
        more = needs[output] - done
        taken = {k for number in more for k in steps[number].operands} & done - given
        return -len(taken), len(more)

    while left:
        nearest = min(left, key=judged)
        left.remove(nearest)
        kept += sorted(needs[nearest] - done)
        done |= needs[nearest]
    places = {old: new for new, old in enumerate(kept)}
    moved = tuple(
        replace(steps[k], operands=tuple(places[x] for x in steps[k].operands)) for k in kept
    )
    return Plan(plan.inputs, moved, tuple((one, places[step]) for one, step in plan.outputs))
