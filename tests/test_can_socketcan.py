"""SocketCAN on the host's side, as far as no CAN interface is needed; `make vcan` has one."""

import errno
import socket
from pathlib import Path

import can
import pytest
from can.interfaces.socketcan import SocketcanBus

from ccgen.can.transports.socketcan import PatientSocketcanBus, _require_usable
from ccgen.cli.main import main

EXAMPLE = Path(__file__).parent.parent / "examples" / "shoulder.toml"


@pytest.fixture
def bus(monkeypatch):
    """A bus without a socket whose queue has room after `bus.full` frames were refused."""

    def send(self, msg, timeout=None):
        if self.full > 0:
            self.full -= 1
            raise can.CanOperationError("refused", self.code)
        self.sent.append(msg)

    monkeypatch.setattr(SocketcanBus, "send", send)
    made = PatientSocketcanBus.__new__(PatientSocketcanBus)
    made.full, made.code, made.sent = 3, errno.ENOBUFS, []
    made._is_shutdown = True
    return made


def test_a_full_queue_is_waited_for(bus):
    frame = can.Message(arbitration_id=0x300)
    bus.send(frame, timeout=10.0)
    assert bus.sent == [frame]


def test_a_queue_that_stays_full_is_an_error_after_the_time_given(bus):
    bus.full = 10**9
    with pytest.raises(can.CanOperationError, match="refused"):
        bus.send(can.Message(), timeout=0.02)
    assert 10**9 - 60 <= bus.full < 10**9 - 1


def test_any_other_refusal_is_an_error_at_once(bus):
    bus.code = errno.ENETDOWN
    with pytest.raises(can.CanOperationError, match="refused"):
        bus.send(can.Message(), timeout=10.0)
    assert bus.full == 2


def test_the_kernel_is_asked_about_the_interface():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as any_socket:
        _require_usable(any_socket, "lo", fd=True)
        with pytest.raises(OSError, match="No such device"):
            _require_usable(any_socket, "vcan_none", fd=False)


def test_socketcan_needs_the_name_of_an_interface(capsys):
    with pytest.raises(SystemExit) as end:
        main(["bridge", str(EXAMPLE), "--interface", "socketcan"])
    assert end.value.code == 2
    assert "name a network interface, such as can0, as channel" in capsys.readouterr().err
