"""What a page of `ccgen.view` is to its browser: a client of viser's socket."""

import time
from contextlib import contextmanager

import msgspec
import viser
import zstandard
from websockets.sync.client import connect

_CAMERA = {
    "type": "ViewerCameraMessage", "wxyz": (1.0, 0.0, 0.0, 0.0), "position": (0.0, 0.0, 1.0),
    "fov": 0.8, "near": 0.01, "far": 10.0, "image_height": 900, "image_width": 1400,
    "look_at": (0.0, 0.0, 0.0), "up_direction": (0.0, 0.0, 1.0),
}  # fmt: skip


@contextmanager
def viewer(url):
    """Look at a page; give what tells its next batch of messages, a list of dictionaries."""
    address = url.replace("http://", "ws://")
    with connect(address, subprotocols=[f"viser-v{viser.__version__}"], max_size=None) as socket:
        socket.send(msgspec.msgpack.encode(_CAMERA))

        def batch(timeout=30.0):
            data = socket.recv(timeout=timeout)
            size = int.from_bytes(data[8:16], "little")
            plain = zstandard.ZstdDecompressor().decompress(data[16 : 16 + size])
            return msgspec.msgpack.decode(plain)["messages"]

        yield batch


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
