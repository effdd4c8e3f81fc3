"""What a page of `ccgen.view` is to its browser: a client of viser's socket."""

import time
from contextlib import contextmanager

import msgspec
import viser
import zstandard
from waiting import PATIENCE, becomes
from websockets.exceptions import WebSocketException
from websockets.sync.client import connect

_CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 1.0),
    "fov": 0.8, "near": 0.01, "far": 10.0, "image_height": 900, "image_width": 1400,
    "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip


@contextmanager
def viewer(url):
    """Look at a page; give what tells its next batch of messages, a list of dictionaries.

    A page that only just begins may not be there yet, or close again at once.
    """
    data, socket = [], None

    def looks():
        nonlocal socket
        try:
            socket = _open(url.replace("http://", "ws://"))
            data.append(socket.recv(timeout=PATIENCE))
        except (OSError, WebSocketException):
            return False
        return True

    assert becomes(looks), f"{url} is not there"

    def batch(timeout=30.0):
        block = data.pop() if data else socket.recv(timeout=timeout)
        size = int.from_bytes(block[8:16], "little")
        plain = zstandard.ZstdDecompressor().decompress(block[16 : 16 + size])
        return msgspec.msgpack.decode(plain)["messages"]

    with socket:
        yield batch


def _open(address):
    socket = connect(address, subprotocols=[f"viser-v{viser.__version__}"], max_size=None)
    socket.send(msgspec.msgpack.encode(_CAMERA))
    return socket


def until(batch, holds, seconds=30.0):
    """The first message for which something holds."""
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        for message in batch(max(0.1, end - time.monotonic())):
            if holds(message):
                return message
    raise TimeoutError


def moves(message, name="/backbone"):
    """Whether a message gives an object of the scene other points."""
    return message["type"] == "SceneNodeUpdateMessage" and message["name"] == name
