"""The SLCAN codec in C: every command, every kind of frame, and garbage."""

import ctypes
import queue
import random

import pytest
from can import Message
from can.interfaces.slcan import slcanBus
from hypothesis import given, settings
from hypothesis import strategies as st
from runtime_c import Frame, frame, junk, load

ARGUMENT, FORMAT, RANGE = -1, -3, -5
LENGTHS = (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 16, 20, 24, 32, 48, 64)
OK, BELL = b"\r", b"\a"


class Slcan:
    """The C state; `reply_max` and the fields' places as in slcan.h."""

    def __init__(self) -> None:
        self.c = load()
        self.size = self.c.probe_size(4)
        self.state = junk(self.size + 8)
        assert self.c.ccgen_slcan_init(self.state) == 0

    def feed(self, data: bytes) -> tuple[bytes, list[Frame], int]:
        """Answers, frames, and how many lines were refused."""
        replies, frames, refused = b"", [], 0
        for byte in data:
            decoded = Frame()
            result = self.c.ccgen_slcan_feed(self.state, byte, ctypes.byref(decoded))
            replies += self.state.raw[: self.state.raw[6]]
            if result == 1:
                frames.append(decoded)
            refused += result == FORMAT
        return replies, frames, refused

    @property
    def open(self) -> bool:
        return self.state.raw[7] == 1

    @property
    def listen_only(self) -> bool:
        return self.state.raw[8] == 1

    @property
    def beyond(self) -> bytes:
        """What lies behind the state."""
        return self.state.raw[self.size :]


def opened() -> Slcan:
    slcan = Slcan()
    assert slcan.feed(b"O\r") == (OK, [], 0)
    return slcan


def encode(sent: Frame) -> bytes:
    buffer = ctypes.create_string_buffer(139)
    length = load().ccgen_slcan_encode(ctypes.byref(sent), buffer, 139)
    assert length > 0
    return buffer.raw[:length]


def same(a: Frame, b: Frame) -> bool:
    fields = ("id", "extended", "fd", "remote", "rate_switch", "length")
    return all(getattr(a, name) == getattr(b, name) for name in fields) and (
        a.remote or a.payload() == b.payload()
    )


@st.composite
def frames(draw: st.DrawFn) -> Frame:
    extended, fd = draw(st.booleans()), draw(st.booleans())
    length = draw(st.sampled_from(LENGTHS if fd else LENGTHS[:9]))
    return frame(
        draw(st.integers(0, 0x1FFFFFFF if extended else 0x7FF)),
        draw(st.binary(min_size=length, max_size=length)),
        fd=fd,
        extended=extended,
        remote=not fd and draw(st.booleans()),
        rate_switch=fd and draw(st.booleans()),
    )


@given(frames())
def test_every_frame_survives_the_round_trip(sent):
    replies, received, refused = opened().feed(encode(sent))
    assert (replies, refused, len(received)) == (OK, 0, 1)
    assert same(received[0], sent)


@given(frames())
def test_lines_are_what_python_can_reads_and_writes(sent):
    """python-can's own reader and writer stand for the other end of the line."""
    lines: list[str] = []
    bus = slcanBus.__new__(slcanBus)
    bus._queue = queue.SimpleQueue()
    bus._write = lines.append
    bus.serialPortOrig = type("Port", (), {"write_timeout": None})()
    bus._queue.put(encode(sent).decode())
    message, _ = bus._recv_internal(None)
    assert isinstance(message, Message)
    assert message.arbitration_id == sent.id
    assert (message.is_extended_id, message.is_fd) == (sent.extended, sent.fd)
    assert (message.is_remote_frame, message.bitrate_switch) == (sent.remote, sent.rate_switch)
    assert message.dlc == sent.length
    assert sent.remote or bytes(message.data) == sent.payload()
    bus.send(message)
    assert lines == [encode(sent).decode().rstrip("\r")]
    bus._is_shutdown = True


@pytest.mark.parametrize(
    ("line", "id_", "extended", "fd", "data"),
    [
        (b"t1230\r", 0x123, False, False, b""),
        (b"t7FF80123456789ABCDEF\r", 0x7FF, False, False, b"\x01\x23\x45\x67\x89\xab\xcd\xef"),
        (b"t7ff2abCD\r", 0x7FF, False, False, b"\xab\xcd"),
        (b"T1FFFFFFF1AA\r", 0x1FFFFFFF, True, False, b"\xaa"),
        (b"d001F" + b"5A" * 64 + OK, 1, False, True, b"\x5a" * 64),
        (b"D000180009" + b"11" * 12 + OK, 0x18000, True, True, b"\x11" * 12),
        (b"B00018000A" + b"22" * 16 + OK, 0x18000, True, True, b"\x22" * 16),
    ],
)  # fmt: skip
def test_frames_are_decoded(line, id_, extended, fd, data):
    replies, received, refused = opened().feed(line)
    assert (replies, refused) == (OK, 0)
    assert (received[0].id, received[0].extended, received[0].fd) == (id_, extended, fd)
    assert received[0].payload() == data


def test_remote_frames_ask_for_a_length_and_carry_nothing():
    _, received, _ = opened().feed(b"r3218\rR000000FF0\r")
    assert [(f.id, f.extended, f.remote, f.length) for f in received] == [
        (0x321, False, True, 8), (0xFF, True, True, 0),
    ]  # fmt: skip


def test_the_opening_of_python_can_is_accepted():
    slcan = Slcan()
    assert slcan.feed(b"C\rS6\r\rO\rO\r") == (OK * 5, [], 0)
    assert slcan.open
    assert slcan.feed(b"C\rC\r") == (OK * 2, [], 0)
    assert not slcan.open


@pytest.mark.parametrize(
    ("line", "reply"),
    [
        (b"\r", b"\r"), (b"V\r", b"V0101\r"), (b"N\r", b"NCCGN\r"), (b"F\r", b"F00\r"),
        (b"Z0\r", b"\r"), (b"s0304\r", b"\r"), (b"Y2\r", b"\r"),
        *((b"S%d\r" % k, b"\r") for k in range(9)),
    ],
)  # fmt: skip
def test_commands_are_answered_while_closed(line, reply):
    assert Slcan().feed(line) == (reply, [], 0)


@pytest.mark.parametrize(
    "line",
    [
        b"S9", b"S/", b"S", b"S66", b"Sx", b"Y6", b"Y", b"Z1", b"Z", b"s030", b"s03040", b"s03g4",
        b"X", b"OO", b"CC", b"VV", b" O", b"O ", b"\0", b"\x80", b"t1230", b"T000001230", b"o",
        b"v",
    ],
)  # fmt: skip
def test_what_is_unknown_or_impossible_while_closed_is_refused(line):
    assert Slcan().feed(line + OK) == (BELL, [], 1)


@pytest.mark.parametrize(
    "line",
    [
        b"S6", b"s0304", b"Y2", b"t", b"t12", b"t123", b"t1239", b"t1231", b"t12310", b"t1231001",
        b"t123100 ", b"t1231g0", b"t12g0", b"t8000", b"T200000000", b"T0000012", b"t123 0",
        b"t123F" + b"00" * 64, b"d1239" + b"00" * 11, b"d1239" + b"00" * 13, b"d123G", b"r1239",
        b"r123100", b"x1230", b"t-120", b"t1231+1", b"t12300", b"k",
    ],
)  # fmt: skip
def test_malformed_lines_are_refused_while_open_and_the_next_one_is_read(line):
    slcan = opened()
    assert slcan.feed(line + OK) == (BELL, [], 1)
    replies, received, refused = slcan.feed(b"t1230\r")
    assert (replies, len(received), refused) == (OK, 1, 0)


def test_listening_only_refuses_frames_to_the_bus():
    slcan = Slcan()
    assert slcan.feed(b"L\r") == (OK, [], 0)
    assert (slcan.open, slcan.listen_only) == (True, True)
    assert slcan.feed(b"t1230\r") == (BELL, [], 1)
    assert slcan.feed(b"O\rt1230\r")[0] == OK * 2
    assert slcan.feed(b"L\rC\r") == (OK * 2, [], 0)
    assert (slcan.open, slcan.listen_only) == (False, False)


@pytest.mark.parametrize("length", [139, 140, 255, 256, 257, 1000, 70_000])
def test_overlong_lines_are_refused_as_one(length):
    slcan = opened()
    before = slcan.beyond
    assert slcan.feed(b"t" * length + OK) == (BELL, [], 1)
    assert slcan.beyond == before
    assert slcan.feed(b"t1230\r")[0] == OK


def test_the_longest_line_fits_and_one_character_more_does_not():
    longest = b"D1FFFFFFFF" + b"A5" * 64
    _, received, refused = opened().feed(longest + OK)
    assert (len(received), refused) == (1, 0)
    assert opened().feed(longest + b"0" + OK) == (BELL, [], 1)


def test_line_feeds_are_ignored():
    _, received, refused = opened().feed(b"t1230\r\nt1240\r\n\nt\n1250\r")
    assert ([f.id for f in received], refused) == ([0x123, 0x124, 0x125], 0)


@settings(max_examples=150)
@given(st.lists(st.one_of(st.binary(max_size=40), frames().map(encode)), max_size=12))
def test_every_line_of_any_stream_gets_one_answer(pieces):
    slcan = opened()
    data = b"".join(pieces)
    replies, received, refused = slcan.feed(data)
    lines = data.count(b"\r")
    assert replies.count(b"\r") + replies.count(b"\a") == lines
    assert refused + len(received) <= lines
    for decoded in received:
        assert decoded.length in (LENGTHS if decoded.fd else LENGTHS[:9])
        assert decoded.id <= (0x1FFFFFFF if decoded.extended else 0x7FF)


def test_frames_between_garbage_lines_are_all_found():
    draw = random.Random(3)
    slcan = opened()
    for _ in range(300):
        junk = bytes(draw.choices(b"0123456789abcdefg \0\xff~", k=draw.randrange(60)))
        _, received, _ = slcan.feed(b"x" + junk + b"\rt1232ABCD\r")
        assert len(received) == 1


def test_what_cannot_be_encoded_is_refused_and_nothing_is_written():
    c = load()
    buffer = ctypes.create_string_buffer(b"\x55" * 139, 139)

    def result(sent: Frame | None, capacity: int = 139) -> int:
        return c.ccgen_slcan_encode(ctypes.byref(sent) if sent else None, buffer, capacity)

    assert result(None) == ARGUMENT
    assert c.ccgen_slcan_encode(ctypes.byref(frame(1, b"")), None, 139) == ARGUMENT
    assert result(frame(0x800, b"")) == RANGE
    assert result(frame(0x20000000, b"", extended=True)) == RANGE
    assert result(frame(1, b"12345678"), 21) == RANGE
    assert result(frame(1, b"123456789")) == FORMAT
    assert result(frame(1, b"123456789012")) == FORMAT
    assert result(frame(1, b"123456789", fd=True)) == FORMAT
    assert result(frame(1, b"", fd=True, remote=True)) == FORMAT
    assert buffer.raw == b"\x55" * 139
    assert result(frame(1, b"12345678"), 22) == 22


def test_null_pointers_are_refused():
    slcan, c = Slcan(), load()
    assert c.ccgen_slcan_init(None) == ARGUMENT
    assert c.ccgen_slcan_feed(None, 13, ctypes.byref(Frame())) == ARGUMENT
    assert c.ccgen_slcan_feed(slcan.state, 13, None) == ARGUMENT
