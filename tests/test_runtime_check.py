"""The C check of sensors, the watch over it and what serves, against the reference model."""

import ctypes
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import HERE, UNDEFINED, compile_c

from ccgen.fixedpoint.consistency import (
    BOX_BITS,
    NOBODY,
    GroupCheck,
    largest_value,
    sizes_of_kept,
)
from ccgen.fixedpoint.watch import BACK_AFTER, OUT_AFTER, Watch

UNNAMED, QUIET = 0xFE, 0xFF
LAYOUTS = (("-DCCGEN_HALVES=0",), ("-DCCGEN_HALVES=1",))


@cache
def probe(*flags):
    library = ctypes.CDLL(
        str(compile_c([HERE / "check.c"], ("-shared", "-fPIC", "-O1", *UNDEFINED, *flags)))
    )
    library.probe_check16.restype = library.probe_check32.restype = ctypes.c_uint8
    return library


def pointer(values, kind):
    dense = np.ascontiguousarray(values, dtype=kind)
    return dense, ctypes.c_void_p(dense.ctypes.data)


def tables_of(group, zero, counts):
    bits = group.precision
    sizes = (group.sensors, group.kept, group.quiet_bits, group.shift)
    tables = {
        "sizes": (sizes, "uint8"), "weights": (group.weights, f"int{bits}"),
        "directions": (group.directions, "int16"), "threshold": (group.threshold, "int32"),
        "margin": (group.margin, "int32"), "zero": (zero, f"int{bits}"),
        "counts": (counts, f"int{bits}"),
    }  # fmt: skip
    return {name: pointer(*table) for name, table in tables.items()}


def called(what, group, names, zero, counts, *flags):
    kept = tables_of(group, zero, counts)
    sizes, *others = [kept[name][1] for name in ("sizes", *names, "zero", "counts")]
    if group.precision == 16:
        others.insert(0, int(np.abs(np.subtract(counts, zero)).max() < 2**15))
    return getattr(probe(*flags), f"probe_{what}{group.precision}")(sizes, *others)


def verdict(group, zero, counts, *flags):
    """The C's verdict of one snapshot that is examined; 0xFD where it is quiet all the same."""
    names = ("weights", "directions", "threshold", "margin")
    return called("check", group, names, zero, counts, *flags)


def quiet(group, zero, counts, *flags):
    """Whether the C is done with a snapshot."""
    return bool(called("quiet", group, ("weights",), zero, counts, *flags))


def expected(group, zero, counts):
    alarm, named = group.verdicts(np.subtract(counts, zero, dtype=np.int64)[None])
    if not alarm[0]:
        return QUIET
    return UNNAMED if named[0] == NOBODY else int(named[0])


def boxed(group, zero, counts):
    values = group.weights[: group.kept] @ np.subtract(counts, zero, dtype=np.int64)
    edge = 2**group.quiet_bits
    return bool(((values >= -edge) & (values < edge)).all())


def drawn_group(rng, sensors, precision):
    """Tables of any size without a flaw, thresholds among the residuals."""
    limit = 2 ** (precision - 1) - 1
    span = rng.integers(1, (2 * limit if precision == 16 else limit) + 1, sensors)
    weights = rng.integers(-limit, limit + 1, (sensors, sensors))
    weights >>= rng.integers(0, precision - 2, (sensors, 1))
    while largest_value(weights, span) > 2 ** (2 * precision - 2) - 1:
        weights >>= 1
    kept = int(rng.integers(1, sensors + 1))
    largest = largest_value(weights[:kept], span)
    quiet_bits = min(2 * precision - 2, max(1, int(largest * rng.uniform(0.01, 0.6)).bit_length()))
    directions = rng.integers(-(2**15) + 1, 2**15, (sensors, sensors))
    directions = directions * min(1.0, (2**16 - 1) / np.abs(directions).sum(axis=1).max())
    directions = directions.astype(np.int64)
    box = sizes_of_kept(directions, kept) << (quiet_bits - max(0, quiet_bits - BOX_BITS))
    threshold = box + (box * rng.choice([0.0, 0.3, 3.0])).astype(np.int64)
    margin = (box * rng.choice([0.0, 0.2])).astype(np.int64)
    group = GroupCheck(
        0, precision, weights.astype(np.int64), kept, quiet_bits, directions, threshold, margin
    )
    return group, span


@pytest.mark.parametrize("precision", [16, 32])
@pytest.mark.parametrize("flags", LAYOUTS)
@given(seed=st.integers(0, 2**32 - 1), sensors=st.integers(1, 16))
def test_verdicts_are_the_models_whatever_counts_and_tables(precision, flags, seed, sensors):
    rng = np.random.default_rng(seed)
    group, span = drawn_group(rng, sensors, precision)
    assert group.flaw(span) is None
    limit = 2 ** (precision - 1) - 1
    for _ in range(20):
        far = (rng.integers(-span, span + 1) * rng.choice([1.0, 0.1, 1e-2])).astype(np.int64)
        if rng.random() < 0.2:
            far = rng.choice([-1, 1], sensors) * span
        low, high = np.maximum(-limit, -limit - far), np.minimum(limit, limit - far)
        zero = rng.integers(low, high + 1)
        counts = zero + far
        assert verdict(group, zero, counts, *flags) == expected(group, zero, counts)
        assert quiet(group, zero, counts, *flags) == boxed(group, zero, counts)


def simple(precision, threshold=0, margin=0, kept=3, quiet_bits=0):
    """Three sensors whose residuals are their differences."""
    unit, limits = np.eye(3, dtype=np.int64), (np.full(3, threshold), np.full(3, margin))
    return GroupCheck(0, precision, unit, kept, quiet_bits, unit, *limits)


@pytest.mark.parametrize("precision", [16, 32])
def test_the_largest_residual_that_there_may_be_is_held_and_compared(precision):
    unit, sizes = np.eye(2, dtype=np.int64), np.array([[2**15 - 1, 2**15 - 1], [0, 1]])
    top = 2**31 - 1
    for threshold, said in ((top, QUIET), (2**30, UNNAMED), (0, UNNAMED)):
        limits = np.full(2, threshold), np.full(2, top)
        group = GroupCheck(0, precision, unit, 2, 0, sizes, *limits)
        for far in (2**15 - 1, -(2**15 - 1)):
            counts = np.array([far, far])
            assert verdict(group, [0, 0], counts) == expected(group, [0, 0], counts) == said


@pytest.mark.parametrize("precision", [16, 32])
def test_equal_residuals_name_nobody_and_limits_must_be_exceeded(precision):
    for threshold, margin, said in ((5, 0, 1), (11, 9, 1), (12, 0, QUIET), (5, 10, UNNAMED)):
        group = simple(precision, threshold, margin)
        assert verdict(group, [0, 0, 0], [2, 12, -2]) == said
    assert verdict(group, [0, 0, 0], [12, -12, 0]) == UNNAMED


@pytest.mark.parametrize("precision", [16, 32])
def test_values_that_do_not_decide_on_alarms_decide_on_names(precision):
    group = simple(precision, threshold=5, kept=1)
    assert verdict(group, [0, 0, 0], [0, 100, 0]) == QUIET
    assert verdict(group, [0, 0, 0], [6, 0, 0]) == 0
    assert verdict(group, [0, 0, 0], [6, 0, -7]) == 2


@pytest.mark.parametrize("precision", [16, 32])
def test_limits_lose_the_bits_that_large_values_lose(precision):
    zero, counts = np.full(3, -(2**15) + 1), np.array([2**15 - 1, 1 - 2**15, 1 - 2**15])
    for threshold, margin, said in ((2**15, 0, 0), (2**15, 2**16 - 3, 0), (0, 2**16, UNNAMED)):
        group = simple(precision, threshold, margin)
        assert verdict(group, zero, counts) == expected(group, zero, counts) == said


@pytest.mark.parametrize("precision", [16, 32])
def test_the_quiet_box_ends_where_it_is_told_to(precision):
    group = simple(precision, threshold=8, quiet_bits=3, kept=2)
    for counts, said in (([7, -8, 99], True), ([8, 0, 0], False), ([0, -9, 0], False)):
        assert quiet(group, [0, 0, 0], counts) is said


names = st.sampled_from((0, 0, 0, 1, 2, UNNAMED, QUIET, QUIET))


@given(st.lists(st.tuples(st.booleans() | st.just(True), names), max_size=80))
def test_the_watch_follows_verdicts_as_the_model_does(history):
    state, masks = (ctypes.c_uint8 * 3)(), (ctypes.c_uint16 * 2)()
    probe().probe_watch_init(state)
    watch = Watch()
    for complete, said in history:
        named = NOBODY if said in (UNNAMED, QUIET) else said
        watch = watch.after(complete, complete and said != QUIET, named if complete else NOBODY)
        probe().probe_watch_follow(state, int(complete), said, masks)
        sensor = 0xFF if watch.sensor == NOBODY else watch.sensor
        assert tuple(state) == (sensor, watch.run, int(watch.out))
        suspected = watch.sensor if watch.out else (named if complete else NOBODY)
        assert masks[0] == (1 << watch.sensor if watch.out else 0)
        assert masks[1] == (0 if suspected == NOBODY else 1 << suspected)


def test_a_sensor_goes_and_comes_back_after_the_stated_numbers():
    state, masks = (ctypes.c_uint8 * 3)(), (ctypes.c_uint16 * 2)()
    probe().probe_watch_init(state)
    out = []
    for said in [2] * OUT_AFTER + [QUIET] * BACK_AFTER:
        probe().probe_watch_follow(state, 1, said, masks)
        out.append(masks[0])
    assert out == [0] * (OUT_AFTER - 1) + [4] * BACK_AFTER + [0]


def test_who_is_left_out_stays_out_while_another_has_no_reading():
    state, masks = (ctypes.c_uint8 * 3)(), (ctypes.c_uint16 * 2)()
    probe().probe_watch_init(state)
    history = [(1, 2)] * OUT_AFTER + [(1, QUIET)] * 5 + [(0, QUIET)]
    for complete, said in history:
        probe().probe_watch_follow(state, complete, said, masks)
    assert (list(state), list(masks)) == ([2, 0, 1], [4, 4])


@pytest.mark.parametrize("precision", [16, 32])
def test_rows_without_a_sensor_serve_while_it_alone_is_absent(precision):
    serving = getattr(probe(), f"probe_serving{precision}")
    for sensors in (1, 5, 16):
        every = 2**sensors - 1
        assert serving(sensors, every, 0) == -1
        for j in range(sensors):
            assert serving(sensors, every, 1 << j) == j
            assert serving(sensors, every ^ 1 << j, 1 << j) == -2
            for other in range(j):
                assert serving(sensors, every, 1 << j | 1 << other) == -2


@pytest.mark.parametrize("precision", [16, 32])
def test_all_values_of_a_lost_axis_are_no_reading(precision):
    angles, at = pointer(np.zeros(8), f"int{precision}")
    getattr(probe(), f"probe_blank{precision}")(7, at)
    assert angles.tolist() == [-(2 ** (precision - 1))] * 7 + [0]
