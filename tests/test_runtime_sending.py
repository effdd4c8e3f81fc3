"""A board that only measures: its LENGTHS frames, their numbers, and when they are due."""

import ctypes

import pytest
from runtime_c import NO_READING, Frame, Layout, completed, junk, load
from test_runtime_snapshot import CLASSIC, CYCLE, FD, WINDOW, Snapshot, profile_of

ARGUMENT = -1
WITHOUT_TURN = completed(CLASSIC, turn=False)


class State(ctypes.Structure):
    """What is for reading of `ccgen_sending_t`."""

    _fields_ = (
        ("sendings", ctypes.c_uint32),
        ("overruns", ctypes.c_uint32),
        ("number", ctypes.c_uint8),
    )


class Board:
    """The C state."""

    def __init__(self, layout: Layout = CLASSIC) -> None:
        self.c, self.layout = load(), layout
        self.pointer = ctypes.byref(layout)
        self.state = junk(self.c.probe_size(6))
        assert self.c.ccgen_sending_init(self.pointer, self.state) == 0
        self.read = State.from_buffer(self.state)
        counts = self.c.probe_size(6)
        assert counts > ctypes.sizeof(State)

    def begin(self, now: int) -> int:
        return self.c.ccgen_sending_begin(self.pointer, self.state, ctypes.c_uint32(now))

    def resume(self, number: int) -> int:
        return self.c.ccgen_sending_resume(self.pointer, self.state, ctypes.c_uint8(number))

    def window(self, window_us: int) -> int:
        return self.c.ccgen_sending_set_window(self.state, ctypes.c_uint32(window_us))

    def put(self, counts: list[int], precision: int = 32) -> None:
        kind = ctypes.c_int16 if precision == 16 else ctypes.c_int32
        function = getattr(self.c, f"ccgen_put_counts{precision}")
        all_counts = ctypes.byref(self.state, 12)  # behind what is for reading
        first = (kind * 2)(*counts[:2])
        rest = (kind * len(counts[2:]))(*counts[2:])
        assert function(all_counts, 0, 2, first) == 0
        assert function(all_counts, 2, len(rest), rest) == 0

    def transmit(self) -> Frame | None:
        sent = Frame()
        result = self.c.ccgen_sending_transmit(self.pointer, self.state, ctypes.byref(sent))
        return sent if result == 1 else None

    def unsent(self) -> int:
        return self.c.ccgen_sending_unsent(self.state)

    def frames(self) -> list[Frame]:
        frames = []
        while (sent := self.transmit()) is not None:
            frames.append(sent)
            assert len(frames) <= 16
        return frames


def begun(layout: Layout = CLASSIC, number: int | None = None) -> Board:
    """A board whose first sending has begun, at 0."""
    board = Board(layout)
    last = board.read.number if number is None else number
    assert board.resume(last) == 0
    assert board.begin(0) == 1
    return board


@pytest.mark.parametrize("layout", [CLASSIC, FD, WITHOUT_TURN], ids=["classic", "fd", "no turn"])
def test_a_node_takes_every_sending_of_a_board_whole_whatever_its_number(layout):
    board, node = begun(layout), Snapshot(layout)
    for k in range(550):
        if k:
            assert board.begin(k * CYCLE) == 1
        counts = [(37 * k + 11 * j) % 4001 - 2000 for j in range(layout.sensors)]
        board.put(counts)
        results = [node.receive(sent, k * CYCLE) for sent in board.frames()]
        assert results == [0] * (len(results) - 1) + [1]
        assert node.counts == counts
    assert board.read.sendings == 550
    assert node.faults() == node.counters.get("lost", 0) == board.read.overruns == 0


@pytest.mark.parametrize(("layout", "numbers"), [(CLASSIC, 240), (FD, 256), (WITHOUT_TURN, 15)])
def test_numbers_begin_at_0_and_advance_by_one_through_all_of_them(layout, numbers):
    board, seen = begun(layout), []
    for k in range(numbers + 3):
        if k:
            board.begin(k * CYCLE)
        checked = {profile_of(layout).check(f.id & 0xFFFF, f.payload()) for f in board.frames()}
        counter = board.read.number if layout.fd else board.read.number % 15
        assert checked == {counter}
        seen.append(board.read.number)
    assert seen == [k % numbers for k in range(numbers + 3)]


def test_a_count_that_its_signal_does_not_hold_is_no_reading():
    for width in (2, 3, 4):
        layout = completed(CLASSIC, count_bytes=width)
        most = 2 ** (8 * width - 1) - 1
        board, node = begun(layout), Snapshot(layout)
        beyond = [] if width == 4 else [most + 1, -most - 2]
        counts = [most, -most, -most - 1, NO_READING, 5, *beyond]
        board.put([*counts, *[0] * (7 - len(counts))])
        for sent in board.frames():
            node.receive(sent, 0)
        kept = [NO_READING] * (2 if beyond else 0)
        assert node.counts[: len(counts)] == [most, -most, NO_READING, NO_READING, 5, *kept]


def test_counts_of_16_bits_keep_their_places_and_their_missing_readings():
    board, node = begun(), Snapshot()
    counts = [32767, -32767, -32768, 1, 2, 3, -4]
    board.put(counts, 16)
    for sent in board.frames():
        node.receive(sent, 0)
    assert node.counts == [NO_READING if c == -32768 else c for c in counts]


def test_what_was_never_put_is_no_reading():
    board, node = begun(FD), Snapshot(FD)
    for sent in board.frames():
        node.receive(sent, 0)
    assert node.counts == [NO_READING] * 16


@pytest.mark.parametrize("precision", [16, 32])
def test_counts_of_sensors_that_no_joint_has_are_refused(precision):
    board, some, every = Board(), (ctypes.c_int32 * 32)(), (ctypes.c_int32 * 16)()
    put = getattr(board.c, f"ccgen_put_counts{precision}")
    for first, sensors in ((0, 17), (16, 1), (17, 0), (255, 2), (2, 255)):
        assert put(every, first, sensors, some) == ARGUMENT
    assert put(every, 0, 16, some) == put(every, 16, 0, some) == 0
    none = (ctypes.c_int16 * 2)(-32768, 7) if precision == 16 else (ctypes.c_int32 * 2)(-(2**31), 7)
    assert put(every, 3, 2, none) == 0
    assert every[2:6] == [0, NO_READING, 7, 0]
    assert put(None, 0, 1, some) == put(every, 0, 1, None) == ARGUMENT


def test_a_start_is_silent_for_a_window_from_the_first_call_on():
    board = Board()
    start = 2**32 - 1000  # the clock wraps meanwhile
    assert board.transmit() is None
    assert [board.begin(start + t) for t in (0, 1, WINDOW)] == [0, 0, 0]
    assert board.transmit() is None
    assert board.begin(start + WINDOW + 1) == 1
    assert (board.read.number, board.read.sendings, board.read.overruns) == (0, 1, 0)
    assert board.begin(start + WINDOW + CYCLE // 2) == 0  # and no window after that
    assert board.begin(start + WINDOW + CYCLE + 1) == 1


def test_a_start_is_silent_for_the_window_that_was_set():
    board = Board()
    assert [board.window(w) for w in (0, 100 * CYCLE + 1)] == [ARGUMENT, ARGUMENT]
    assert board.window(100 * CYCLE) == 0
    assert board.begin(7) == 0
    assert board.begin(7 + 100 * CYCLE) == 0
    assert board.begin(8 + 100 * CYCLE) == 1


def test_a_board_that_kept_its_number_goes_on_at_once():
    board = Board()
    assert board.resume(240) == ARGUMENT
    assert board.resume(239) == 0
    assert board.begin(123) == 1
    assert board.read.number == 0
    again = begun(number=41)
    assert again.read.number == 42
    assert again.begin(CYCLE // 4) == 0
    assert again.begin(CYCLE) == 1


def test_the_first_time_may_be_any():
    board = Board()
    assert board.resume(7) == 0
    assert board.begin(2**31 + 5) == 1
    assert board.begin(2**31 + 5 + CYCLE) == 1


def test_sendings_are_due_once_a_cycle_and_half_a_cycle_of_jitter_does_no_harm():
    board = begun()
    half = CYCLE // 2
    assert board.begin(half - 1) == 0
    assert board.begin(half) == 1  # half a cycle ahead
    assert board.begin(2 * CYCLE - half - 1) == 0
    assert board.begin(2 * CYCLE - half) == 1
    assert board.begin(3 * CYCLE) == 1  # on time again
    assert board.begin(4 * CYCLE - half - 1) == 0
    assert board.begin(4 * CYCLE) == 1
    assert board.begin(9 * CYCLE) == 1  # what was missed is not made up for
    assert board.begin(9 * CYCLE + half - 1) == 0
    assert board.read.sendings == 6


@pytest.mark.parametrize("layout", [CLASSIC, FD, WITHOUT_TURN], ids=["classic", "fd", "no turn"])
def test_no_number_comes_round_too_soon_however_often_a_board_calls(layout):
    board, times = begun(layout), {}
    numbers = {True: 256, False: 240 if layout.turn else 15}[bool(layout.fd)]
    gap = numbers - {True: 28, False: 20 if layout.turn else 1}[bool(layout.fd)]
    times[board.read.number] = 0
    for now in range(0, 300 * CYCLE, 777):
        if board.begin(now) == 1:
            before = times.get(board.read.number)
            assert before is None or now - before >= gap * CYCLE
            times[board.read.number] = now
    assert board.read.sendings == pytest.approx(300, abs=1)


def test_a_time_behind_the_latest_counts_as_the_latest():
    board = begun()
    assert board.begin(5 * CYCLE) == 1
    assert board.begin(4 * CYCLE) == 0
    assert board.begin(5 * CYCLE - 2**31) == 0
    assert board.begin(6 * CYCLE) == 1


def test_a_frame_that_was_not_sent_comes_again_and_one_that_was_does_not():
    board = begun()
    board.put([1, 2, 3, 4, 5, 6, 7])
    assert board.unsent() == 0
    first = board.transmit()
    assert board.unsent() == 1
    assert board.unsent() == 0
    again = board.transmit()
    assert (first.id, first.payload()) == (again.id, again.payload())
    assert [sent.id for sent in board.frames()] == [0x301, 0x302]
    assert board.unsent() == 0  # the last fetch found nothing: the frame before was sent
    assert board.transmit() is None


def test_frames_that_a_new_sending_replaces_are_counted_and_do_not_come_back():
    board = begun()
    assert board.transmit() is not None
    assert board.begin(CYCLE) == 1
    assert (board.read.overruns, board.unsent()) == (1, 0)
    assert [sent.id for sent in board.frames()] == [0x300, 0x301, 0x302]
    assert board.begin(2 * CYCLE) == 1
    assert board.read.overruns == 1


def test_a_state_begins_anew_however_it_was():
    board = begun()
    board.put([1] * 7)
    board.transmit()
    board.begin(CYCLE)
    assert board.c.ccgen_sending_init(board.pointer, board.state) == 0
    fresh = Board()
    assert fresh.unsent() == 0
    assert (board.read.sendings, board.read.overruns, board.unsent()) == (0, 0, 0)
    assert board.read.number == fresh.read.number == 239
    assert board.transmit() is None
    assert board.begin(50 * CYCLE) == 0


def test_null_pointers_and_layouts_that_cannot_be_are_refused():
    board, sent = Board(), Frame()
    wrong = Layout.from_buffer_copy(CLASSIC)
    wrong.sensors = 0
    c, frame = board.c, ctypes.byref(sent)
    assert c.ccgen_sending_init(ctypes.byref(wrong), board.state) == ARGUMENT
    assert c.ccgen_sending_init(None, board.state) == ARGUMENT
    assert c.ccgen_sending_init(board.pointer, None) == ARGUMENT
    assert c.ccgen_sending_resume(None, board.state, 0) == ARGUMENT
    assert c.ccgen_sending_resume(board.pointer, None, 0) == ARGUMENT
    assert c.ccgen_sending_set_window(None, 1) == ARGUMENT
    assert c.ccgen_sending_begin(None, board.state, 0) == ARGUMENT
    assert c.ccgen_sending_begin(board.pointer, None, 0) == ARGUMENT
    assert c.ccgen_sending_transmit(None, board.state, frame) == ARGUMENT
    assert c.ccgen_sending_transmit(board.pointer, None, frame) == ARGUMENT
    assert c.ccgen_sending_transmit(board.pointer, board.state, None) == ARGUMENT
    assert c.ccgen_sending_unsent(None) == ARGUMENT
