"""Snapshots of a node's own converter, and what its angles are worth as time passes."""

import ctypes

import pytest
from runtime_c import Frame, completed
from test_runtime_node_calls import Bare, lists_of
from test_runtime_snapshot import CLASSIC, CYCLE, FD, LOST, STALE, Snapshot, frames_of

GOOD, DEGRADED, GONE, AGED = range(4)
ARGUMENT = -1
WITHOUT_TURN = completed(CLASSIC, turn=False)
TIP = (ctypes.c_int16 * 3)(1, 2, 3)


class Own(Snapshot):
    """A snapshot that the chip's converter completes."""

    def own(self, now: int) -> int:
        return self.c.ccgen_snapshot_own(
            ctypes.byref(self.layout), self.state, ctypes.c_uint32(now)
        )

    def stale(self, now: int) -> bool:
        return self.c.ccgen_snapshot_is_stale(self.state, ctypes.c_uint32(now))


class Node(Bare):
    """A node that estimates from its own converter."""

    def own(self, now: int, result: int = 0) -> None:
        layout = ctypes.byref(self.layout)
        assert self.c.ccgen_node_own(layout, self.state, ctypes.c_uint32(now)) == 1
        assert self.publish(result, 0 if result == 0 else 1, TIP) == (1 if result == 0 else result)

    def worth(self, now: int) -> int:
        return self.c.ccgen_node_worth(self.state, ctypes.c_uint32(now))

    def forgets(self) -> bool:
        return self.c.ccgen_node_forgets(ctypes.byref(self.layout), self.state)

    def transmit(self, now: int) -> Frame | None:
        angles = (ctypes.c_int16 * 12)(*range(12))
        lists, sent = lists_of([angles, angles]), Frame()
        layout, frame = ctypes.byref(self.layout), ctypes.byref(sent)
        result = self.c.ccgen_node_transmit16(
            layout, self.state, lists, ctypes.c_uint32(now), frame
        )
        return sent if result == 1 else None

    def drain(self, now: int) -> int:
        frames = 0
        while self.transmit(now) is not None:
            frames += 1
        return frames


@pytest.mark.parametrize(
    ("layout", "numbers"), [(CLASSIC, 240), (FD, 256), (WITHOUT_TURN, 15)],
    ids=["classic", "fd", "no turn"],
)  # fmt: skip
def test_snapshots_of_the_own_converter_are_numbered_from_0_and_nothing_is_lost(layout, numbers):
    snapshot, seen = Own(layout), []
    for k in range(numbers + 2):
        assert snapshot.own(k * CYCLE) == 1
        seen.append(snapshot.number)
    assert seen == [k % numbers for k in range(numbers + 2)]
    assert snapshot.counters == {"snapshots": numbers + 2}
    assert snapshot.faults() == 0


def test_a_snapshot_of_frames_that_the_converter_interrupts_is_lost_and_none_is_mixed():
    snapshot = Own()
    first, second, third = frames_of(CLASSIC, 7, [1, 2, 3, 4, 5, 6, 7])
    snapshot.receive(first, 0)
    snapshot.receive(second, 0)
    assert snapshot.own(100) == 1
    assert snapshot.counters == {"snapshots": 1, "lost": 1}
    assert snapshot.faults() == LOST
    assert snapshot.receive(third, 200) == 0
    assert snapshot.counters["snapshots"] == 1


def test_frames_after_the_own_snapshot_are_held_against_its_number():
    snapshot, began = Own(), 100 * CYCLE
    snapshot.own(began)
    snapshot.own(began + CYCLE)  # number 1
    old, *_ = frames_of(CLASSIC, 0, [0] * 7)
    snapshot.receive(old, began + 4 * CYCLE)  # not silent yet, for the own one was heard
    assert snapshot.counters == {"snapshots": 2, "reordered": 1}
    for sent in frames_of(CLASSIC, 2, [9] * 7):
        done = snapshot.receive(sent, began + 4 * CYCLE)
    assert (done, snapshot.number) == (1, 2)


def test_own_snapshots_that_stop_are_stale_and_old():
    snapshot = Own()
    snapshot.own(0)
    assert not snapshot.stale(3 * CYCLE)
    assert snapshot.stale(3 * CYCLE + 1)
    assert not snapshot.stale(2**32 - 5)  # behind the latest: counts as that
    snapshot.tick(3 * CYCLE + 1)
    assert snapshot.faults() == STALE
    snapshot.tick(2**31 - 1)
    snapshot.tick(2**32 - 2)
    assert snapshot.stale(0)  # the clock has come round
    assert snapshot.age(0) == 255
    snapshot.own(1)
    assert not snapshot.stale(1)
    assert snapshot.age(1) == 0


def test_null_pointers_are_refused():
    snapshot, node = Own(), Node()
    layout = ctypes.byref(CLASSIC)
    assert snapshot.c.ccgen_snapshot_own(None, snapshot.state, 0) == ARGUMENT
    assert snapshot.c.ccgen_snapshot_own(layout, None, 0) == ARGUMENT
    assert node.c.ccgen_node_own(layout, None, 0) == ARGUMENT
    assert node.c.ccgen_node_worth(None, 0) == ARGUMENT


def test_angles_are_lost_until_there_are_any_then_good_and_at_last_stale():
    node = Node()
    assert node.worth(0) == GONE
    node.drain(0)
    assert node.worth(10 * CYCLE) == GONE
    node.own(10 * CYCLE)
    assert node.worth(10 * CYCLE) == node.worth(13 * CYCLE) == GOOD
    assert node.worth(13 * CYCLE + 1) == AGED


def test_angles_of_a_snapshot_without_an_estimate_are_lost_until_the_next():
    node = Node()
    node.own(0)
    node.own(CYCLE, result=-2)
    assert node.worth(CYCLE) == GONE
    assert node.worth(5 * CYCLE) == AGED
    node.own(2 * CYCLE)
    assert node.worth(2 * CYCLE) == GOOD


def test_angles_of_which_an_axis_is_not_good_are_degraded():
    node = Node()
    node.own(0)
    axes = node.c.probe_axes(node.state)
    axes_of = ctypes.c_uint8.from_address(axes)
    assert axes_of.value == 0
    for mask in (1, 2, 4, 8):
        axes_of.value = mask
        assert node.worth(0) == DEGRADED


def test_angles_are_forgotten_once_a_silence_and_only_when_no_frame_needs_them():
    node = Node()
    node.own(0)
    node.drain(0)
    assert not node.forgets()
    node.drain(3 * CYCLE)
    assert not node.forgets()
    node.drain(3 * CYCLE + 1)
    assert node.forgets()
    assert not node.forgets()
    assert node.worth(3 * CYCLE + 1) == AGED
    node.own(9 * CYCLE)
    assert node.worth(9 * CYCLE) == GOOD
    assert not node.forgets()


def test_angles_that_are_not_all_sent_are_kept_through_a_silence():
    node = Node()
    node.own(0)
    first = node.transmit(9 * CYCLE)
    assert first is not None
    assert not node.forgets()
    assert node.c.ccgen_node_unsent(node.state) == 1
    assert not node.forgets()
    again = node.transmit(9 * CYCLE)
    assert again.payload() == first.payload()
    node.drain(9 * CYCLE)
    assert node.forgets()


def test_angles_of_a_frame_that_may_be_taken_back_are_kept():
    layout = completed(
        CLASSIC, publish=3
    )  # ANGLES and TIP: an estimate is the last that is handed out
    node = Node(layout)
    node.own(0)
    for _ in range(9):
        assert node.transmit(9 * CYCLE) is not None
    assert not node.forgets()
    assert node.transmit(9 * CYCLE) is None
    assert node.forgets()
