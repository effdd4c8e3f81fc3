"""The C check of sensors, the watch over it and what serves, against the reference model."""

import ctypes
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from runtime_c import HERE, UNDEFINED, compile_c

from ccgen.fixedpoint.consistency import NOBODY, GroupCheck, largest_residual
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


def verdict(group, zero, counts, *flags):
    """The C's verdict of one snapshot."""
    bits = group.precision
    wide = f"int{2 * bits}"
    tables = (
        (group.weights, f"int{bits}"), (group.threshold, wide), (group.margin, wide),
        (zero, f"int{bits}"), (counts, f"int{bits}"),
    )  # fmt: skip
    kept = [pointer(*table) for table in tables]
    arguments = [where for _, where in kept]
    if bits == 32:
        return probe(*flags).probe_check32(group.sensors, *arguments)
    narrow = bool(np.abs(np.subtract(counts, zero)).max() < 2**15)
    return probe(*flags).probe_check16(group.sensors, int(narrow), *arguments)


def expected(group, zero, counts):
    alarm, named = group.verdicts(np.subtract(counts, zero, dtype=np.int64)[None])
    if not alarm[0]:
        return QUIET
    return UNNAMED if named[0] == NOBODY else int(named[0])


def drawn_group(rng, sensors, precision):
    """Weights of any size whose residuals stay within the sum, thresholds among the residuals."""
    limit = 2 ** (precision - 1) - 1
    span = rng.integers(1, (2 * limit if precision == 16 else limit) + 1, sensors)
    weights = rng.integers(-limit, limit + 1, (sensors, sensors))
    weights >>= rng.integers(0, precision - 2, (sensors, 1))
    while largest_residual(weights, span) > 2 ** (2 * precision - 1) - 1:
        weights >>= 1
    size = np.array([largest_residual(weights[[j]], span) for j in range(sensors)], dtype=float)
    threshold = (size * rng.uniform(0, 0.7, sensors)).astype(np.int64)
    margin = (size * rng.choice([0.0, 0.2], sensors)).astype(np.int64)
    return GroupCheck(0, precision, weights.astype(np.int64), threshold, margin), span


@pytest.mark.parametrize("precision", [16, 32])
@pytest.mark.parametrize("flags", LAYOUTS)
@given(seed=st.integers(0, 2**32 - 1), sensors=st.integers(1, 16))
def test_verdicts_are_the_models_whatever_counts_and_tables(precision, flags, seed, sensors):
    rng = np.random.default_rng(seed)
    group, span = drawn_group(rng, sensors, precision)
    limit = 2 ** (precision - 1) - 1
    for _ in range(20):
        far = rng.integers(-span, span + 1)
        if rng.random() < 0.2:
            far = rng.choice([-1, 1], sensors) * span
        low, high = np.maximum(-limit, -limit - far), np.minimum(limit, limit - far)
        zero = rng.integers(low, high + 1)
        counts = zero + far
        assert verdict(group, zero, counts, *flags) == expected(group, zero, counts)


@pytest.mark.parametrize("precision", [16, 32])
def test_the_largest_residual_that_there_may_be_is_held_and_compared(precision):
    limit = 2 ** (precision - 1) - 1
    top = 2 ** (2 * precision - 1) - 1
    weights = np.array([[limit, 0], [-limit, 1]])
    for threshold, said in ((top, QUIET), (limit * limit - 1, UNNAMED)):
        group = GroupCheck(0, precision, weights, np.array([threshold] * 2), np.array([top, top]))
        for sign in (-1, 1):
            counts = np.array([sign * limit, 0])
            assert verdict(group, [0, 0], counts) == expected(group, [0, 0], counts) == said


@pytest.mark.parametrize("precision", [16, 32])
def test_equal_residuals_name_nobody_and_limits_must_be_exceeded(precision):
    weights = np.eye(3, dtype=np.int64)
    for threshold, margin, said in ((5, 0, 1), (11, 9, 1), (12, 0, QUIET), (5, 10, UNNAMED)):
        limits = np.full(3, threshold), np.full(3, margin)
        group = GroupCheck(0, precision, weights, *limits)
        assert verdict(group, [0, 0, 0], [2, 12, -2]) == said
    assert verdict(group, [0, 0, 0], [12, -12, 0]) == UNNAMED


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
