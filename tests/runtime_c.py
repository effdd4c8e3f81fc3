"""Builds the C runtime for tests and gives it to Python through ctypes."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ccgen.e2e import p01_key
from ccgen.resources import firmware

HERE = Path(__file__).parent / "c"
SAMPLE = HERE / "sample"
INCLUDE = (f"-I{firmware() / 'include'}", f"-I{SAMPLE}", f"-I{HERE}")
RUNTIME = tuple(sorted((firmware() / "src").glob("*.c")))
INLINED = tuple(sorted((firmware() / "include" / "ccgen").glob("*_inline.h")))
GLUE = (SAMPLE / "sample_can.c", SAMPLE / "sample_kinematics.c")
PORTS = firmware() / "ports"

WARNINGS = (
    "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wsign-conversion", "-Wdouble-promotion",
    "-Wshadow", "-Wundef", "-Wvla", "-Werror",
)  # fmt: skip
C99 = ("-std=c99", "-Wmissing-prototypes")
CXX14 = ("-x", "c++", "-std=c++14")
COMPILERS = tuple(name for name in ("gcc", "clang") if shutil.which(name))

UNDEFINED = ("-fsanitize=undefined", "-fno-sanitize-recover=all")
# Not position independent: a kernel may draw an address where the sanitizer wants its heap.
ADDRESS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-g", "-fno-pie", "-no-pie")

NO_READING = -(2**31)

_FOLDER = TemporaryDirectory(prefix="ccgen-runtime-")


def compile_c(
    files: Sequence[Path],
    flags: Sequence[str] = (),
    compiler: str = COMPILERS[0],
    target: Path | None = None,
) -> Path:
    """Compile and link with every warning an error; fails the test with the compiler's words."""
    out = target or next_build()
    command = [compiler, *C99, *WARNINGS, *flags, *INCLUDE, *map(str, files), "-o", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}\n{done.stderr}"
    return out


def next_build() -> Path:
    """Where what is compiled next goes."""
    return Path(_FOLDER.name) / f"build{len(list(Path(_FOLDER.name).iterdir()))}"


@cache
def load(flags: tuple[str, ...] = ("-O1", *UNDEFINED)) -> ctypes.CDLL:
    """The runtime, the sample joint, the shared port and the probes as one shared library."""
    externs = (HERE / "externs.c", HERE / "externs_own.c")
    files = (*RUNTIME, *GLUE, HERE / "probe.c", *externs, PORTS / "shared" / "shared.c")
    library = ctypes.CDLL(str(compile_c(files, ("-shared", "-fPIC", *flags))))
    library.probe_axis.restype = ctypes.POINTER(Axis16)
    library.probe_sensors.restype = ctypes.POINTER(Sensors16)
    library.probe_sample_layout.restype = ctypes.POINTER(Layout)
    library.probe_size.restype = ctypes.c_size_t
    library.probe_take_faults.restype = ctypes.c_uint8
    library.ccgen_shared_node_size.restype = ctypes.c_size_t
    library.ccgen_e2e_key.restype = ctypes.c_uint16
    library.ccgen_e2e_counter_modulus.restype = ctypes.c_uint16
    library.ccgen_layout_valid.restype = ctypes.c_bool
    library.ccgen_layout_publishes.restype = ctypes.c_bool
    library.ccgen_layout_frame_length.restype = ctypes.c_uint8
    library.ccgen_get_count.restype = ctypes.c_int32
    library.ccgen_layout_window_max_us.restype = ctypes.c_uint32
    library.probe_axes.restype = ctypes.c_void_p
    library.ccgen_snapshot_is_stale.restype = ctypes.c_bool
    library.ccgen_node_forgets.restype = ctypes.c_bool
    library.ccgen_command_is.restype = ctypes.c_bool
    library.ccgen_snapshot_age_ms.restype = ctypes.c_uint8
    library.ccgen_tip_signal.restype = ctypes.c_int16
    library.ccgen_tip_signal.argtypes = (ctypes.c_int32, ctypes.c_uint8)
    library.ccgen_slcan_encode.argtypes = (
        ctypes.POINTER(Frame), ctypes.c_char_p, ctypes.c_size_t,
    )  # fmt: skip
    for which, structure in enumerate((Frame, Layout, Axis16)):
        assert library.probe_size(which) == ctypes.sizeof(structure)
    return library


@cache
def build_program(port: str, flags: tuple[str, ...] = ("-O2",)) -> Path:
    """A port of the sample joint as a program."""
    return compile_c(
        (*RUNTIME, *GLUE, SAMPLE / "sample.c", PORTS / port / "main.c"), flags, COMPILERS[0]
    )


class Frame(ctypes.Structure):
    """`ccgen_frame_t`."""

    _fields_ = (
        ("id", ctypes.c_uint32),
        ("extended", ctypes.c_bool),
        ("fd", ctypes.c_bool),
        ("remote", ctypes.c_bool),
        ("rate_switch", ctypes.c_bool),
        ("length", ctypes.c_uint8),
        ("data", ctypes.c_uint8 * 64),
    )

    def payload(self) -> bytes:
        """The data bytes that count."""
        return bytes(self.data[: self.length])


class Layout(ctypes.Structure):
    """`ccgen_layout_t`; `completed` fills in what follows from the rest."""

    _fields_ = (
        ("base_id", ctypes.c_uint32),
        ("extended", ctypes.c_bool),
        ("fd", ctypes.c_bool),
        ("turn", ctypes.c_bool),
        ("sensors", ctypes.c_uint8),
        ("rows", ctypes.c_uint8 * 3),
        ("count_bytes", ctypes.c_uint8),
        ("angle_bytes", ctypes.c_uint8),
        ("cycle_us", ctypes.c_uint32),
        ("window_us", ctypes.c_uint32),
        ("fingerprint", ctypes.c_uint16),
        ("publish", ctypes.c_uint8),
        ("rate_switch", ctypes.c_bool),
        ("commands", ctypes.c_bool),
        ("numbers", ctypes.c_uint16),
        ("values", ctypes.c_uint8),
        ("counts_per_frame", ctypes.c_uint8),
        ("angles_per_frame", ctypes.c_uint8),
        ("lengths_frames", ctypes.c_uint8),
        ("angles_frames", ctypes.c_uint8),
        ("frame_bytes", ctypes.c_uint8),
        ("last_lengths_bytes", ctypes.c_uint8),
        ("last_angles_bytes", ctypes.c_uint8),
        ("single_bytes", ctypes.c_uint8),
        ("keys", ctypes.POINTER(ctypes.c_uint8)),
    )


LENGTHS_OF_FD = (12, 16, 20, 24, 32, 48, 64)


def frame_length(fd: bool, payload: int) -> int:
    """Bytes of a frame with so many behind its header."""
    return next(n for n in LENGTHS_OF_FD if n >= 3 + payload) if fd else 8


def completed(origin: Layout, **changes: object) -> Layout:
    """The layout with changes, and with what then follows from the rest."""
    layout = Layout.from_buffer_copy(origin)
    for name, value in changes.items():
        if name == "rows":
            layout.rows[:] = value
        else:
            setattr(layout, name, value)
    fd, capacity = layout.fd, 61 if layout.fd else 6
    layout.numbers = 256 if fd else 240 if layout.turn else 15
    values = sum(layout.rows)
    layout.values = values & 0xFF
    counts, angles = capacity // layout.count_bytes, capacity // layout.angle_bytes
    layout.counts_per_frame, layout.angles_per_frame = counts, angles
    layout.lengths_frames = -(-layout.sensors // counts)
    layout.angles_frames = -(-values // angles)
    layout.frame_bytes = 64 if fd else 8
    last = (layout.sensors - 1) % counts + 1, (values - 1) % angles + 1
    layout.last_lengths_bytes = frame_length(fd, last[0] * layout.count_bytes)
    layout.last_angles_bytes = frame_length(fd, last[1] * layout.angle_bytes)
    layout.single_bytes = frame_length(fd, 6)
    frames = layout.lengths_frames + layout.angles_frames + 4
    ids = ((layout.base_id + index) & 0xFFFF for index in range(frames))
    layout.keys = (ctypes.c_uint8 * frames)(*map(p01_key, ids))
    return layout


class Axis16(ctypes.Structure):
    """`ccgen_axis16_t`."""

    _fields_ = (
        ("segments", ctypes.c_uint16),
        ("sensors", ctypes.c_uint8),
        ("shift", ctypes.c_uint8),
        ("fraction_bits", ctypes.c_uint8),
        ("saturates", ctypes.c_bool),
        ("narrow", ctypes.c_bool),
        ("bias", ctypes.c_int32),
        ("biases", ctypes.POINTER(ctypes.c_int32)),
        ("rows", ctypes.POINTER(ctypes.c_uint32)),
    )


def junk(size: int) -> ctypes.Array[ctypes.c_char]:
    """Memory that has held anything, as a state that is to be initialised has."""
    return ctypes.create_string_buffer(b"\xa5" * size, size)


class Sensors16(ctypes.Structure):
    """`ccgen_sensors16_t`, without what is relative to a zero."""

    _fields_ = (
        ("sensors", ctypes.c_uint8),
        ("minimum", ctypes.POINTER(ctypes.c_int16)),
        ("maximum", ctypes.POINTER(ctypes.c_int16)),
        ("zero", ctypes.POINTER(ctypes.c_int16)),
    )


def frame(id_: int, data: bytes, fd: bool = False, **fields: bool) -> Frame:
    """A frame of these bytes."""
    made = Frame(id=id_, fd=fd, length=len(data), **fields)
    ctypes.memmove(made.data, data, len(data))
    return made
