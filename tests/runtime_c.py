"""Builds the C runtime for tests and gives it to Python through ctypes."""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

from ccgen.resources import firmware

HERE = Path(__file__).parent / "c"
SAMPLE = HERE / "sample"
INCLUDE = (f"-I{firmware() / 'include'}", f"-I{SAMPLE}", f"-I{HERE}")
RUNTIME = tuple(sorted((firmware() / "src").glob("*.c")))
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
    files = (*RUNTIME, *GLUE, HERE / "probe.c", PORTS / "shared" / "shared.c")
    library = ctypes.CDLL(str(compile_c(files, ("-shared", "-fPIC", *flags))))
    library.probe_axis.restype = ctypes.POINTER(Axis16)
    library.probe_sensors.restype = ctypes.POINTER(Sensors16)
    library.probe_sample_layout.restype = ctypes.POINTER(Layout)
    library.probe_size.restype = ctypes.c_size_t
    library.probe_take_faults.restype = ctypes.c_uint8
    library.ccgen_shared_node_size.restype = ctypes.c_size_t
    library.ccgen_e2e_header.restype = ctypes.c_size_t
    library.ccgen_e2e_counter_modulus.restype = ctypes.c_uint16
    library.ccgen_layout_valid.restype = ctypes.c_bool
    library.ccgen_layout_publishes.restype = ctypes.c_bool
    library.ccgen_layout_slots.restype = ctypes.c_uint8
    library.ccgen_layout_lengths_frames.restype = ctypes.c_uint8
    library.ccgen_layout_angles_frames.restype = ctypes.c_uint8
    library.ccgen_layout_status_index.restype = ctypes.c_uint16
    library.ccgen_layout_numbers.restype = ctypes.c_uint16
    library.ccgen_layout_window_max_us.restype = ctypes.c_uint32
    library.ccgen_command_is.restype = ctypes.c_bool
    library.ccgen_snapshot_age_ms.restype = ctypes.c_uint8
    library.ccgen_tip_signal.restype = ctypes.c_int16
    library.ccgen_tip_signal.argtypes = (ctypes.c_float, ctypes.c_uint8)
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
    """`ccgen_layout_t`."""

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
    )


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
