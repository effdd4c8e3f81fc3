"""A node in this process: the C as a shared library, served on python-can's virtual bus.

The node's clock is not the machine's: it advances by one cycle with each snapshot and with each
silence of at least a tenth of a second, and a snapshot's frames have the widest window that there
is. What the node publishes therefore depends on the frames alone, not on how the operating system
shares out the processor.
"""

import ctypes
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

import can
from can.interfaces.virtual import VirtualBus

from ccgen.can.layout import FrameLayout
from ccgen.can.transports import not_run
from ccgen.errors import ToolError

_CYCLE_US = 100_000
"""Silence that counts as a cycle at least: a busy machine may hold up the sender between two frames
for many times a real one, and the widest window has a hundred."""

_GLANCE = 0.02
"""Longest time, seconds, until the server looks whether it is to stop."""

_CAPACITY = 64
_channels = count()


@contextmanager
def library_node(library: Path, layout: FrameLayout) -> Iterator[can.BusABC]:
    """Serve the library built from an exported folder's ports/shared; gives the host's bus.

    Raises:
        ToolError: the library cannot be loaded, or the node failed while it was served.
    """
    channel = f"ccgen-{next(_channels)}"
    node = _Node(library, layout)
    with VirtualBus(channel) as host, VirtualBus(channel) as served:
        server = _Server(node, served, layout)
        server.start()
        try:
            yield host
        finally:
            server.stop()
        if server.failure is not None:
            raise ToolError(f"{library}: the node failed: {server.failure}") from server.failure


class _Node:
    """The node's functions; calls hold the interpreter lock, for they take microseconds."""

    def __init__(self, library: Path, layout: FrameLayout) -> None:
        try:
            self._functions = ctypes.PyDLL(str(library))
            size = self._functions.ccgen_shared_node_size
            size.restype = ctypes.c_size_t
            self._receive = self._functions.ccgen_shared_node_receive
            self._transmit = self._functions.ccgen_shared_node_transmit
            self._state = ctypes.create_string_buffer(size())
            result = self._functions.ccgen_shared_node_init(self._state)
            set_window = self._functions.ccgen_shared_node_set_window
            set_window.argtypes = (ctypes.c_char_p, ctypes.c_uint32)
        except OSError as error:
            raise ToolError(f"{library}: cannot be loaded: {not_run(library, error)}") from error
        except AttributeError as error:
            raise ToolError(f"{library}: is no node's library: {error}") from error
        if result != 0:
            raise ToolError(f"{library}: the node does not start: error {result}")
        if set_window(self._state, layout.window_max_us) != 0:
            raise ToolError(f"{library}: is not of this joint: it takes no window of its layout")
        self._receive.argtypes = (
            ctypes.c_char_p, ctypes.c_uint32, ctypes.c_int, ctypes.c_int, ctypes.c_size_t,
            ctypes.c_char_p, ctypes.c_uint32,
        )  # fmt: skip
        self._transmit.argtypes = (ctypes.c_char_p, ctypes.c_uint32, *(ctypes.c_void_p,) * 5)
        self._id = ctypes.c_uint32()
        self._extended, self._fd, self._length = (ctypes.c_uint8() for _ in range(3))
        self._data = ctypes.create_string_buffer(_CAPACITY)
        parts = (self._id, self._extended, self._fd, self._length, self._data)
        self._out = [ctypes.addressof(part) for part in parts]

    def receive(self, message: can.Message, now_us: int) -> bool:
        """Hand a frame to the node; returns whether it completed a snapshot."""
        if message.is_remote_frame or message.is_error_frame:
            return False
        data = bytes(message.data)
        result: int = self._receive(
            self._state, message.arbitration_id, message.is_extended_id, message.is_fd,
            len(data), data, now_us,
        )  # fmt: skip
        return result != 0

    def transmit(self, now_us: int) -> can.Message | None:
        """Fetch the next frame that the node has to send."""
        if self._transmit(self._state, now_us, *self._out) != 1:
            return None
        return _FreshMessage(
            arbitration_id=self._id.value,
            is_extended_id=bool(self._extended.value),
            is_fd=bool(self._fd.value),
            data=self._data.raw[: self._length.value],
        )


class _FreshMessage(can.Message):
    """A frame that its sender forgets: the virtual bus hands it on instead of a copy.

    Copying would be the largest part of a virtual transmission.
    """

    __slots__ = ()

    def __deepcopy__(self, memo: dict[int, Any] | None) -> "_FreshMessage":
        return self


class _Server:
    """A thread that moves frames between a bus and a node."""

    def __init__(self, node: _Node, bus: can.BusABC, layout: FrameLayout) -> None:
        self._node, self._bus, self._cycle_us = node, bus, layout.cycle_us
        self._silent_cycle_us = max(_CYCLE_US, layout.cycle_us)
        self._now_us = self._idle_us = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._serve, name="ccgen node")
        self.failure: Exception | None = None

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def stop(self) -> None:
        """End the thread and wait for its end."""
        self._stopping.set()
        self._thread.join()

    def _serve(self) -> None:
        try:
            while not self._stopping.is_set():
                message = self._bus.recv(_GLANCE)
                if message is None:
                    self._idle(round(1e6 * _GLANCE))
                elif self._node.receive(message, self._now_us):
                    self._advance(self._cycle_us)
                while (answer := self._node.transmit(self._now_us)) is not None:
                    self._bus.send(answer)
        except Exception as error:  # told to the one who waits for answers
            self.failure = error

    def _idle(self, microseconds: int) -> None:
        """Let the machine's time pass; the node's goes on by whole cycles."""
        self._idle_us += microseconds
        cycles, self._idle_us = divmod(self._idle_us, self._silent_cycle_us)
        self._advance(cycles * self._cycle_us)

    def _advance(self, microseconds: int) -> None:
        self._now_us = (self._now_us + microseconds) & 0xFFFFFFFF
