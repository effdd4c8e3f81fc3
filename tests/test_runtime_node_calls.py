"""The node's own functions, called with layouts and values that no exported joint hands them."""

import ctypes
from collections.abc import Iterable

import pytest
from runtime_c import NO_READING, Frame, Layout, completed, junk, load
from test_runtime_snapshot import CLASSIC, FD, frames_of, profile_of

ARGUMENT = -1


def lists_of(axes: Iterable[ctypes.Array]) -> ctypes.Array:
    """Angles of u and v as transmit takes them, without elongation."""
    held = list(axes)
    lists = (ctypes.c_void_p * 3)(*map(ctypes.addressof, held), None)
    lists.held = held  # as long as the list lives
    return lists


class Bare:
    """A node's state without a joint around it."""

    def __init__(self, layout: Layout = CLASSIC) -> None:
        self.c, self.layout = load(), layout
        self.state = junk(self.c.probe_size(5))
        assert self.c.ccgen_node_init(ctypes.byref(layout), self.state) == 0

    def receive(self, counts: list[int]) -> None:
        """A whole snapshot."""
        layout = ctypes.byref(self.layout)
        results = [
            self.c.ccgen_node_receive(layout, self.state, ctypes.byref(sent), 0)
            for sent in frames_of(self.layout, 0, counts)
        ]
        assert results[-1] == 1

    def counts(self, precision: int) -> list[int]:
        kind = ctypes.c_int16 if precision == 16 else ctypes.c_int32
        first, rest = (kind * 2)(), (kind * (self.layout.sensors - 2))()
        function = getattr(self.c, f"ccgen_node_counts{precision}")
        assert function(self.state, 0, 2, first) == 0
        assert function(self.state, 2, self.layout.sensors - 2, rest) == 0
        return [*first, *rest]

    @property
    def overruns(self) -> int:
        return self.c.probe_overruns(self.state)

    def transmit(self, u: list[int], v: list[int], now: int = 0) -> list[Frame]:
        """All that is due."""
        layout, sent = ctypes.byref(self.layout), Frame()
        wide = self.layout.angle_bytes == 4
        kind = ctypes.c_int32 if wide else ctypes.c_int16
        angles = lists_of((kind * len(axis))(*axis) for axis in (u, v))
        function = getattr(self.c, f"ccgen_node_transmit{32 if wide else 16}")
        frames = []
        while function(layout, self.state, angles, now, ctypes.byref(sent)):
            frames.append(Frame.from_buffer_copy(sent))
            assert len(frames) < 1000
        return frames

    def publish(self, result: int, missing: int, tip: object) -> int:
        layout = ctypes.byref(self.layout)
        return self.c.ccgen_node_publish(layout, self.state, result, ctypes.c_int32(missing), tip)


@pytest.mark.parametrize("rows", [(12, 12, 0), (0, 4, 1), (3, 0, 0), (0, 0, 2), (5, 4, 3)])
def test_a_node_begins_without_an_estimate_with_the_models_zero_and_no_command(rows):
    layout = completed(CLASSIC, publish=8, fingerprint=0x1234, rows=rows)
    some, sent = (ctypes.c_int16 * 64)(), Frame()
    node, angles = Bare(layout), lists_of([some, some])
    angles[2] = ctypes.addressof(some)
    arguments = (ctypes.byref(layout), node.state, angles, 0, ctypes.byref(sent))
    assert node.c.ccgen_node_transmit16(*arguments) == 1
    lost, absent = 2, 3
    axes = sum((lost if n else absent) << 2 * axis for axis, n in enumerate(rows))
    assert sent.payload()[2:] == bytes((0x34, 0x12, 0, 0, axes, 0))
    all_lost = sum(lost << 2 * axis for axis, n in enumerate(rows) if n)
    assert node.c.ccgen_health_all_lost(ctypes.byref(layout)) == all_lost
    assert node.c.ccgen_node_transmit16(*arguments) == 0


@pytest.mark.parametrize(("origin", "values"), [(CLASSIC, 15), (FD, 256)])
def test_the_counter_of_health_runs_through_all_values(origin, values):
    layout = completed(origin, publish=8)
    node, zeros = Bare(layout), [0] * layout.rows[0]
    for k in range(2 * values + 2):
        (health,) = node.transmit(zeros, zeros, now=100_000 * k)
        checked = profile_of(layout).check(health.id & 0xFFFF, health.payload())
        assert checked == k % values


@pytest.mark.parametrize("width", [3, 4])
def test_a_count_of_the_bus_that_16_bits_do_not_hold_is_no_reading(width):
    layout = completed(CLASSIC, count_bytes=width)
    node = Bare(layout)
    node.receive([32767, 32768, -32767, -32768, -32769, 2**23 - 1, -(2 ** (8 * width - 1))])
    assert node.counts(16) == [32767, -32768, -32767, -32768, -32768, -32768, -32768]
    assert node.counts(32) == [32767, 32768, -32767, -32768, -32769, 2**23 - 1, NO_READING]


@pytest.mark.parametrize("precision", [16, 32])
def test_counts_of_sensors_that_no_joint_has_are_refused(precision):
    node, some = Bare(), (ctypes.c_int32 * 32)()
    counts = getattr(node.c, f"ccgen_node_counts{precision}")
    for first, sensors in ((0, 17), (16, 1), (17, 0), (255, 2), (2, 255)):
        assert counts(node.state, first, sensors, some) == ARGUMENT
    assert counts(node.state, 0, 16, some) == 0
    assert counts(node.state, 16, 0, some) == 0


@pytest.mark.parametrize("precision", [16, 32])
def test_counts_of_sensors_that_no_snapshot_has_are_refused(precision):
    node, some = Bare(), (ctypes.c_int32 * 300)()
    function = getattr(node.c, f"ccgen_node_counts{precision}")
    for first, sensors, result in (
        (0, 16, 0), (15, 1, 0), (16, 0, 0), (0, 17, ARGUMENT), (1, 16, ARGUMENT),
        (16, 1, ARGUMENT), (17, 0, ARGUMENT), (255, 255, ARGUMENT), (17, 255, ARGUMENT),
    ):  # fmt: skip
        assert function(node.state, first, sensors, some) == result


@pytest.mark.parametrize("precision", [16, 32])
@pytest.mark.parametrize("rows", [(3, 0, 2), (0, 4, 1), (2, 3, 0), (0, 0, 1), (5, 4, 3)])
def test_values_go_out_axis_by_axis_and_an_axis_without_rows_needs_none(rows, precision):
    layout = completed(CLASSIC, rows=rows, angle_bytes=precision // 8, publish=1)
    kind = ctypes.c_int16 if precision == 16 else ctypes.c_int32
    axes = [(kind * n)(*(1000 * axis - k for k in range(n))) for axis, n in enumerate(rows, 1)]
    angles = (ctypes.c_void_p * 3)(*(ctypes.addressof(axis) if axis else None for axis in axes))
    node, sent = Bare(layout), Frame()
    transmit = getattr(node.c, f"ccgen_node_transmit{precision}")
    arguments = (ctypes.byref(layout), node.state, angles, 0, ctypes.byref(sent))
    assert transmit(*arguments) == 0
    node.publish(0, 0, (ctypes.c_int16 * 3)())
    body = b""
    while transmit(*arguments) == 1:
        body += sent.payload()[2 : 8 if precision == 16 else 6]
        assert not any(bytes(sent.data)[len(sent.payload()) :])  # nothing behind the frame's end
        assert len(body) < 1000
    size = precision // 8
    values = [
        int.from_bytes(body[k : k + size], "little", signed=True) for k in range(0, len(body), size)
    ]
    expected = [value for axis in axes for value in axis]
    assert values[: len(expected)] == expected
    assert not any(values[len(expected) :])


@pytest.mark.parametrize(("missing", "taken"), [(-1, False), (0xFFFF, True), (0x10000, False)])
def test_a_mask_of_missing_sensors_has_sixteen_bits(missing, taken):
    node, tip = Bare(), (ctypes.c_int16 * 3)()
    before = node.state.raw
    assert node.publish(0, missing, tip) == (1 if taken else ARGUMENT)
    assert (node.state.raw != before) == taken


def test_an_estimate_needs_a_tip_and_a_failure_does_not():
    node = Bare()
    before = node.state.raw
    assert node.publish(0, 0, None) == ARGUMENT
    assert node.publish(5, 0, None) == ARGUMENT
    assert node.state.raw == before
    assert node.publish(-2, 1, None) == -2
    assert node.publish(5, 0, (ctypes.c_int16 * 3)()) == 1


@pytest.mark.parametrize(("classic", "per_frame"), [(True, 1), (False, 15)])
def test_angles_of_32_bits_go_out_u_then_v_under_their_snapshots_number(classic, per_frame):
    layout = completed(CLASSIC if classic else FD, angle_bytes=4, rows=(11, 11, 0))
    node, header = Bare(layout), 2 if classic else 3
    node.transmit([0] * 11, [0] * 11)
    node.receive([5] * layout.sensors)
    u, v = [10**8 * k - 7 for k in range(11)], [3 - 10**8 * k for k in range(11)]
    for result, missing in ((0, 0), (-2, 1)):
        node.publish(result, missing, (ctypes.c_int16 * 3)(1, -2, 3))
        *angles, tip, _ = node.transmit(u, v)
        assert len(angles) == -(-22 // per_frame)
        sent = b"".join(got.payload()[header : header + 4 * per_frame] for got in angles)
        values = [int.from_bytes(sent[k : k + 4], "little", signed=True) for k in range(0, 88, 4)]
        assert values == ([*u, *v] if result == 0 else [NO_READING] * 22)
        assert not any(sent[88:])
        place = tip.payload()[header : header + 6]
        assert list(memoryview(place).cast("h")) == ([1, -2, 3] if result == 0 else [-32768] * 3)
        for got in (*angles, tip):
            assert profile_of(layout).check(got.id & 0xFFFF, got.payload()) == 0


@pytest.mark.parametrize("segments", [11, 12, 13])
@pytest.mark.parametrize("publish", range(8))
def test_an_answer_has_the_frames_that_are_published_in_their_order(publish, segments):
    """They are fetched one by one, and the next answer replaces none of them."""
    layout = completed(CLASSIC, publish=publish, rows=(segments, segments, 0))
    node, sent = Bare(layout), Frame()
    some = lists_of([(ctypes.c_int16 * segments)()] * 2)
    node.transmit([0] * segments, [0] * segments)
    angles = -(-2 * segments // 3)
    parts = [range(3, 3 + angles), [3 + angles], [4 + angles]]
    expected = [index for bit, part in enumerate(parts) if publish >> bit & 1 for index in part]
    arguments = (ctypes.byref(layout), node.state, some, 0, ctypes.byref(sent))
    for _ in range(2):
        assert node.publish(0, 0, (ctypes.c_int16 * 3)()) == 1
        fetched = []
        for _ in expected:
            assert node.c.ccgen_node_transmit16(*arguments) == 1
            fetched.append(sent.id - layout.base_id)
        assert fetched == expected
    assert node.overruns == 0
    assert node.c.ccgen_node_transmit16(*arguments) == 0


def test_an_answer_of_which_only_the_status_was_not_fetched_is_an_overrun():
    node, tip = Bare(), (ctypes.c_int16 * 3)()
    layout, sent = ctypes.byref(CLASSIC), ctypes.byref(Frame())
    some = lists_of([(ctypes.c_int16 * 12)()] * 2)
    overruns = []
    for fetched in (10, 9, 0):  # 8 of angles, tip, status
        node.publish(0, 0, tip)
        overruns.append(node.overruns)
        for _ in range(fetched):
            assert node.c.ccgen_node_transmit16(layout, node.state, some, 0, sent) == 1
    node.publish(0, 0, tip)
    assert [*overruns, node.overruns] == [0, 0, 1, 2]


@pytest.mark.parametrize("precision", [16, 32])
def test_angles_of_the_other_precision_than_the_layouts_are_refused(precision):
    layout = completed(CLASSIC, angle_bytes=6 - precision // 8)
    node, some, sent = Bare(layout), (ctypes.c_int32 * 64)(), Frame()
    before = node.state.raw
    transmit = getattr(node.c, f"ccgen_node_transmit{precision}")
    arguments = (ctypes.byref(layout), node.state, lists_of([some, some]), 0, ctypes.byref(sent))
    assert transmit(*arguments) == ARGUMENT
    assert node.state.raw == before


def test_null_pointers_are_refused():
    node, layout, some = Bare(), ctypes.byref(CLASSIC), (ctypes.c_int32 * 64)()
    c, state, sent = node.c, node.state, ctypes.byref(Frame())
    before = state.raw
    assert c.ccgen_node_init(None, state) == ARGUMENT
    assert c.ccgen_node_init(layout, None) == ARGUMENT
    for arguments in ((None, state, sent), (layout, None, sent), (layout, state, None)):
        assert c.ccgen_node_receive(*arguments, 0) == ARGUMENT
    for precision in (16, 32):
        layout = ctypes.byref(completed(CLASSIC, angle_bytes=precision // 8))
        counts = getattr(c, f"ccgen_node_counts{precision}")
        transmit = getattr(c, f"ccgen_node_transmit{precision}")
        assert counts(None, 0, 7, some) == ARGUMENT
        assert counts(state, 0, 7, None) == ARGUMENT
        lists = lists_of([some, some])
        for absent in (0, 1, 2, 4):
            arguments = [layout, state, lists, 0, sent]
            arguments[absent] = None
            assert transmit(*arguments) == ARGUMENT
        for axis in (0, 1):
            lists = lists_of([some, some])
            lists[axis] = None
            assert transmit(layout, state, lists, 0, sent) == ARGUMENT
    assert c.ccgen_node_publish(None, state, -2, 0, some) == ARGUMENT
    assert c.ccgen_node_publish(layout, None, -2, 0, some) == ARGUMENT
    assert c.ccgen_node_unsent(None) == ARGUMENT
    assert (state.raw, any(some)) == (before, False)
