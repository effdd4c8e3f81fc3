"""Random joint files for tests, legal and not, and the files that they name.

Most of the files are as a user may write them, some of them with numbers at the ends of what is
allowed; in the others something is wrong: a value of another kind, a number that is huge, tiny or
none, a key that is missing, unknown or in the wrong table, bytes that are no text.
"""

import datetime
import gzip
import json
import math
import random
from dataclasses import dataclass, field
from typing import Any

Document = dict[str, Any]


@dataclass(frozen=True)
class RandomJoint:
    """A joint file and what stands beside it.

    Attributes:
        content: of the joint file.
        beside: contents of other files, by name; some that are named are not there.
        loads: content of a file of stated loads.
        words: options of `simulate` and `place`, by command.
    """

    content: bytes
    beside: dict[str, bytes]
    loads: bytes
    words: dict[str, list[str]] = field(default_factory=dict)


def random_joint(seed: int) -> RandomJoint:
    """The random joint of that number: the same number, the same files."""
    drawn = random.Random(seed)
    document = _document(drawn)
    beside = _beside(drawn, document)
    words = {"simulate": _case(drawn, document), "place": _placing(drawn)}
    if _some(drawn, 0.4):
        for _ in range(drawn.choice((1, 1, 2))):
            _spoil(drawn, document)
    _wire(random.Random(f"wire {seed}"), document, beside)
    content = toml_text(document).encode("utf-8", "surrogatepass")
    if drawn.random() < 0.05:
        content = _damaged(drawn, content)
    loads = _stated_loads(drawn)
    if drawn.random() < 0.4:
        _spoil(drawn, loads)
    return RandomJoint(content, beside, toml_text(loads).encode("utf-8", "surrogatepass"), words)


# Numbers


def _log(drawn: random.Random, low: float, high: float) -> float:
    return float(f"{math.exp(drawn.uniform(math.log(low), math.log(high))):.4g}")


def _number(drawn: random.Random, low: float, high: float, *ends: float) -> float:
    """A usual number; now and then one at the ends of what is allowed."""
    if ends and drawn.random() < 0.06:
        return drawn.choice(ends)
    return _log(drawn, low, high)


def _some(drawn: random.Random, share: float) -> bool:
    return drawn.random() < share


# A document as a user may write it


def _document(drawn: random.Random) -> Document:
    segments = drawn.choice((1, 2, 3, 4, 5, 6, 8, 10, 12, 12, 16, 20, 24, 33, 48, 64))
    geometry = _geometry(drawn, segments)
    document: Document = {"name": drawn.choice(("finger", "arm_2", "x", "Shoulder", "leg"))}
    document["geometry"] = geometry
    precision = drawn.choice((16, 16, 32))
    if _some(drawn, 0.7):
        document["sensors"] = _sensors(drawn, geometry, segments, precision)
    else:
        shared = _transducer(drawn, geometry, 0.03, segments, precision)
        document["sensors"] = {"transducer": shared}
        document["sensor"] = _listed(drawn, geometry, segments)
    if _some(drawn, 0.3):
        document["loads"] = _loads(drawn, geometry)
    if _some(drawn, 0.6):
        document["shapes"] = _shapes(drawn, document)
    if _some(drawn, 0.1):
        document["recordings"] = [_recording(drawn, geometry) for _ in range(drawn.randint(1, 2))]
    document["estimator"] = _estimator(drawn, document)
    document["fixed_point"] = {"precision": precision}
    if _some(drawn, 0.5):
        document["can"] = _can(drawn)
    return document


def _geometry(drawn: random.Random, segments: int) -> Document:
    degrees = min(_number(drawn, 0.02, 60.0 / segments + 1.0, 1e-6, 1e-3, 45.0, 90.0), 90.0)
    geometry: Document = {
        "segments": segments,
        "length": _number(drawn, 0.03, 3.0, 1e-6, 1e3, 114.76),
        "range_of_motion": degrees,
    }
    if _some(drawn, 0.1):
        geometry["total_range_of_motion"] = geometry.pop("range_of_motion") * segments
    if _some(drawn, 0.2):
        low = drawn.choice((0.0, 0.0, -0.1, -0.5))
        geometry["elongation"] = [low, low + _number(drawn, 0.01, 0.3, 1e-6, 2.0 - low)]
        if segments > 1 and _some(drawn, 0.5):
            first = drawn.randint(1, segments - 1)
            geometry["sections"] = [first, segments - first]
    return geometry


def _degrees(geometry: Document) -> float:
    """Range of motion of a segment."""
    total = geometry.get("total_range_of_motion", 0.0) / geometry["segments"]
    return float(geometry.get("range_of_motion", total))


def _transducer(
    drawn: random.Random, geometry: Document, radius: float, covered: float, precision: int
) -> Document:
    moves = covered * math.radians(_degrees(geometry)) * radius
    bits, most = (drawn.choice((20, 24, 32)), 3e5) if precision == 32 else (16, 2.4e4)
    step = moves / drawn.uniform(most / 30, most)
    transducer: Document = {
        "bits": bits,
        "metres_per_count": min(max(float(f"{step:.3g}"), 1e-12), 1.0),
    }
    if _some(drawn, 0.04):
        transducer["metres_per_count"] = drawn.choice((1e-12, 1.0, 1e-9, 0.1))
    if _some(drawn, 0.6):
        noise = min(max(step * drawn.uniform(0.1, 30), 1e-12), 1e3)
        transducer["noise"] = drawn.choice((0.0, 1e-12, 1e3)) if _some(drawn, 0.05) else noise
    if _some(drawn, 0.15):
        transducer["gain_tolerance"] = _number(drawn, 0.001, 0.2, 0.0, 1.0, 1e-9)
    if _some(drawn, 0.15):
        transducer |= {"signed": False, "bits": bits - 1, "zero": 2 ** (bits - 2)}
    elif _some(drawn, 0.2):
        widest = 2 ** (bits - 1) - 1
        transducer["range"] = drawn.choice(([-widest, widest], [-1, 1], [-widest // 2, widest]))
    if _some(drawn, 0.1):
        transducer["metres_per_count"] *= -1
    return transducer


def _sensors(drawn: random.Random, geometry: Document, segments: int, precision: int) -> Document:
    radius = _number(drawn, 0.004, 0.1, 1e-6, 1e3, 50.0)
    sensors: Document = {"radius": radius}
    count = drawn.randint(1, min(8, segments))
    layout = drawn.random()
    if layout < 0.6:
        sensors |= {"placement": drawn.choice(("heuristic", "end-to-end")), "count": count}
    elif layout < 0.7:
        sensors["placement"] = "single"
        count = 1
    elif layout < 0.85:
        spans = [sorted(drawn.choices(range(segments), k=2)) for _ in range(count - 1)]
        sensors["spans"] = [[0, segments - 1], *spans]
    else:
        length = geometry["length"]
        spans = [sorted(drawn.uniform(0, length) for _ in range(2)) for _ in range(count - 1)]
        sensors["spans_m"] = [[0.0, length], *spans]
    if _some(drawn, 0.1):
        sensors["radius"] = [radius * drawn.uniform(0.5, 1.5) for _ in range(count)]
    sensors["transducer"] = _transducer(drawn, geometry, radius, segments / 2, precision)
    if _some(drawn, 0.2):
        axis = drawn.choice("uv")
        sensors[axis] = {"radius": 0.7 * radius, "placement": "single"}
        if _some(drawn, 0.5):
            sensors[axis]["transducer"] = {"noise": _number(drawn, 1e-6, 1e-3, 0.0)}
    return sensors


def _listed(drawn: random.Random, geometry: Document, segments: int) -> list[Document]:
    sensors = []
    for i in range(drawn.randint(2, 12)):
        angle = drawn.choice((0.0, 90.0, 180.0, 270.0, drawn.uniform(-360.0, 360.0)))
        sensor: Document = {
            "name": f"s{i}",
            "angle": (0.0, 90.0)[i] if i < 2 else angle,
            "radius": _number(drawn, 0.01, 0.05, 1e-6, 1e3),
        }
        whole = i < 4 or _some(drawn, 0.5)
        ends = [0, segments - 1] if whole else sorted(drawn.choices(range(segments), k=2))
        if _some(drawn, 0.7):
            sensor["span"] = ends
        else:
            step = geometry["length"] / segments
            sensor["span_m"] = [ends[0] * step, (ends[1] + drawn.uniform(0.1, 1.0)) * step]
        if _some(drawn, 0.2):
            sensor["noise"] = _number(drawn, 1e-6, 1e-3, 0.0, 1e3)
        if _some(drawn, 0.1):
            sensor["metres_per_count"] = _number(drawn, 1e-6, 1e-4, -1e-5, 1.0, 1e-12)
        sensors.append(sensor)
    return sensors


_STATED_LOADS = ("mass", "payload", "tip_force", "tip_moment", "contact", "actuation")


def _loads(drawn: random.Random, geometry: Document) -> Document:
    loads: Document = {
        "samples": drawn.choice((1, 5, 20, 40, 300)),
        "stiffness": _number(drawn, 0.01, 10.0, 1e-12, 1e12),
    }
    for key in drawn.sample(_STATED_LOADS, drawn.randint(1, 3)):
        most = _number(drawn, 0.01, 5.0, 0.0, 1e-300, 1e6)
        if key == "actuation":
            most = min(_log(drawn, 1.0, 100.0), 5760.0)
            loads[key] = [-most, most]
        else:
            loads[key] = most if key == "mass" else [0.0, most]
    if _some(drawn, 0.3):
        loads["stiffness_tolerance"] = _number(drawn, 0.01, 0.3, 1.0, 1e-9)
    if _some(drawn, 0.3):
        loads["stiffness_profile"] = [_number(drawn, 0.2, 5.0, 1e-6, 1e6) for _ in range(3)]
    if _some(drawn, 0.5):
        loads["mounting"] = drawn.choice(("any", 0.0, 90.0, 180.0, 33.3))
    if _some(drawn, 0.2):
        loads["contact_from"] = drawn.uniform(0.0, geometry["length"])
    if _some(drawn, 0.2):
        loads["elongation"] = [0.0, _number(drawn, 0.01, 0.2, 1e-6, 2.0)]
    return loads


_CASES = ("end-force", "uniform", "s-shape", "constant-curvature")


def _shapes(drawn: random.Random, document: Document) -> Document:
    shapes: Document = {
        "fit_samples": drawn.choice((1, 2, 3, 10, 30)),
        "score_samples": drawn.choice((1, 2, 7, 10)),
    }
    if _some(drawn, 0.5):
        shapes["cases"] = drawn.sample(_CASES, drawn.randint(1, 4))
    if "loads" in document and _some(drawn, 0.4):
        weights = (0.0, 1.0, 0.05, 1e-6, 1e6)
        shapes["weight"] = {key: drawn.choice(weights) for key in ("cases", "loads")}
    return shapes


def _estimator(drawn: random.Random, document: Document) -> Document:
    knows = "noise" in document["sensors"].get("transducer", {}) or _some(drawn, 0.05)
    methods = ("direct", "equal", "wam", "wam", *("noise-aware",) * 3 * knows)
    estimator: Document = {"method": drawn.choice(methods)}
    if _some(drawn, 0.15):
        axes = ["u", "v", "h"] if "elongation" in document["geometry"] else ["u", "v"]
        estimator["axes"] = drawn.sample(axes, drawn.randint(1, len(axes)))
    if _some(drawn, 0.2):
        estimator["fallback"] = drawn.choice((True, False))
    if _some(drawn, 0.2):
        estimator["check"] = drawn.choice((True, False))
    if _some(drawn, 0.2):
        estimator["false_alarms"] = _number(drawn, 1e-7, 1e-2, 1e-9, 0.1)
    return estimator


def _can(drawn: random.Random) -> Document:
    can: Document = {"base_id": drawn.choice((0x100, 0x300, 0, 0x7D0))}
    if _some(drawn, 0.3):
        can |= {"extended": True, "base_id": drawn.choice((0x18FF0000, 0x1FFFFF00, 0))}
    for key, values in (
        ("fd", (True, False)),
        ("bitrate", (10_000, 125_000, 500_000, 1_000_000)),
        ("cycle_ms", (1, 10, 1000)),
        ("turn", (True, False)),
    ):
        if _some(drawn, 0.3):
            can[key] = drawn.choice(values)
    return can


# Files beside it


def _recording(drawn: random.Random, geometry: Document) -> Document:
    recording: Document = {
        "file": drawn.choice(("run.csv", "run.csv.gz", "nowhere.csv", "ä b.csv"))
    }
    if _some(drawn, 0.3):
        recording["use"] = drawn.choice(("fit", "score"))
    if _some(drawn, 0.3):
        recording["stations"] = {"tip": geometry["length"], "mid": geometry["length"] / 2}
    if _some(drawn, 0.3):
        recording["straight"] = [0.0, drawn.choice((0.5, 1e9, 5e-324))]
    if _some(drawn, 0.2):
        recording["rows"] = drawn.choice(([0, 5], [3, 3], [0, 10**9]))
    if _some(drawn, 0.2):
        recording["counts"] = drawn.choice(("run.csv", "log.blf", "log.asc"))
        recording["dbc"] = "joint.dbc"
    if _some(drawn, 0.2):
        recording["delay"] = drawn.choice(("estimate", 0.01, -1e300, 0.0))
    return recording


_ODD_FILES = (
    b"",
    b"\n",
    b"t\n",
    b"t,u0\n0.0",
    b"t,u0,u0\n0,1,2\n",
    b"t;u0\n0;1\n",
    b"t,u0\n0,nan\n1,inf\n2,1e400\n",
    b"t,u0\n1,1\n0,2\n",
    b"t,u0\n" + b"0,1\n" * 50,
    b"t,tip_x,tip_y,tip_z\n0,0,0,0.2\n1,0,0,0.2\n",
    b"\xff\xfe\x00",
    b"\x1f\x8b\x08\x00",
    b"a" * 100_000,
)


def _beside(drawn: random.Random, document: Document) -> dict[str, bytes]:
    if "recordings" not in document:
        return {}
    good = _recorded(drawn, document["geometry"]["segments"])
    content = good if _some(drawn, 0.5) else drawn.choice(_ODD_FILES)
    files = dict.fromkeys(("run.csv", "ä b.csv", "log.blf", "log.asc", "joint.dbc"), content)
    packed = gzip.compress(content, mtime=0)
    files["run.csv.gz"] = packed[: len(packed) // 2] if _some(drawn, 0.3) else packed
    return files


def _recorded(drawn: random.Random, segments: int) -> bytes:
    """Segment angles and counts of the first two sensors over some seconds."""
    names = [f"{axis}{i}" for axis in "uv" for i in range(segments)]
    names += [f"count_{name}" for name in ("u0", "v0", "s0", "s1")]
    rows = [",".join(("t", *names))]
    for k in range(drawn.choice((5, 60))):
        cells = (f"{drawn.gauss(0.0, 1.0):.3f}" for _ in range(2 * segments))
        counts = (str(drawn.randint(-900, 900)) if _some(drawn, 0.9) else "" for _ in range(4))
        rows.append(",".join((f"{0.02 * k:.2f}", *cells, *counts)))
    return "\n".join(rows).encode() + b"\n"


def _stated_loads(drawn: random.Random) -> Document:
    loads: Document = {"stiffness": _number(drawn, 0.01, 10.0, 1e-12, 1e12)}
    ends = (0.0, 1e6, -1e6, 1e-300)
    if _some(drawn, 0.5):
        loads["tip_force"] = [_number(drawn, 0.01, 2.0, *ends) for _ in range(3)]
    if _some(drawn, 0.3):
        loads["distributed"] = [0.0, 0.0, _number(drawn, 0.1, 5.0, *ends)]
    if _some(drawn, 0.3):
        loads["tip_moment"] = [_number(drawn, 0.01, 0.2, *ends), 0.0]
    if _some(drawn, 0.3):
        loads["actuation_u"] = _number(drawn, 1.0, 50.0, 5760.0, -5760.0, 1e-300)
    if _some(drawn, 0.2):
        loads["elongation"] = drawn.choice((0.02, [0.02], [0.0, 0.1], -0.5, 2.0))
    if _some(drawn, 0.2):
        loads["contacts"] = [{"at": drawn.choice((0.0, 0.01, 5.0)), "force": [1.0, 0.0, 0.0]}]
    return loads


def _wire(drawn: random.Random, document: Document, beside: dict[str, bytes]) -> None:
    """Keys of the bus and of a calibration, which depend on no other."""
    if _some(drawn, 0.1):
        document["calibration"] = drawn.choice(("c.toml", "nowhere.toml", "", 1))
        beside["c.toml"] = drawn.choice((_CALIBRATION, *_ODD_FILES))
    can = document.get("can")
    if isinstance(can, dict) and _some(drawn, 0.4):
        kinds = ("angles", "tip", "status", "health")
        can["publish"] = drawn.sample(kinds, drawn.randint(0, 4))
        can["commands"] = drawn.choice((True, False))


_CALIBRATION = b"""format = 1
joint = "finger"
fingerprint = "0123456789abcdef"
[[sensor]]
name = "u0"
metres_per_count = 2e-6
zero = 12.5
noise = 1e-5
"""


# Options


def _case(drawn: random.Random, document: Document) -> list[str]:
    degrees = f"{_degrees(document['geometry']) * drawn.uniform(-1.0, 1.0):.4g}"
    if _some(drawn, 0.25):
        degrees = drawn.choice(("0", "30", "90", "1e-300", "nan", "inf", "-91", "1e3"))
    words = ["--case", drawn.choice(_CASES), f"--first-segment={degrees}"]
    return words + (["--axis", drawn.choice("uv")] if _some(drawn, 0.3) else [])


def _placing(drawn: random.Random) -> list[str]:
    words = []
    for share, word, values in (
        (0.5, "--sensors", ("1", "2", "3", "4", "8", "0")),
        (0.1, "--axis", ("u", "v")),
        (0.1, "--objective", ("paper", "angles", "tip")),
        (0.05, "--min-span", ("1", "2", "70")),
        (0.05, "--max-span", ("1", "5", "0")),
        (0.05, "--max-stacked", ("1", "2")),
        (0.05, "--forbid", ("3", "0-1", "99")),
        (0.05, "--fix", ("0-1", "5-3")),
    ):
        if _some(drawn, share):
            words += [word, drawn.choice(values)]
    return words


# What goes wrong

_ODD: tuple[Any, ...] = (
    *(0, -1, 1, 2, 17, 65, 2**31, 2**63, -(2**63), 10**30, 10**400),
    *(0.0, -0.0, 5e-324, 1e-323, 1e-300, 1e-12, 1e-6, 0.5, 90.0, 1e6, 1e300, 1.7e308),
    *(math.nan, math.inf, -math.inf),
    *("", "u", "ä", "\u202eabc", "a\nb", "\x00", "a" * 3000, "noise-aware", "\ud800"),
    *(True, False, [], [[]], {}, [1, 2, 3], [0.0] * 17, [math.nan, 1.0], ["u", "u"], [[0, 0]]),
    *({"x": 1}, [{"x": 1}], [None], datetime.date(2020, 1, 1), datetime.time(1, 2)),
)


def _tables(value: Any) -> list[Document]:
    """All tables of a document, itself among them."""
    inside = value.values() if isinstance(value, dict) else value
    found = [value] if isinstance(value, dict) else []
    for one in inside:
        if isinstance(one, dict | list):
            found += _tables(one)
    return found


def _spoil(drawn: random.Random, document: Document) -> None:
    tables = [table for table in _tables(document) if table]
    table = drawn.choice(tables)
    key = drawn.choice(list(table))
    how = drawn.random()
    if how < 0.45:
        table[key] = drawn.choice(_ODD)
    elif how < 0.75:
        table[key] = _scaled(drawn, table[key])
    elif how < 0.85:
        del table[key]
    elif how < 0.93:
        other = drawn.choice(tables)
        other[key] = table[key]
    else:
        table[drawn.choice(("ä", "radiu", "__class__", "a b", 'q"', "length", "can"))] = 1


def _scaled(drawn: random.Random, value: Any) -> Any:
    """The value with numbers in it scaled by orders of magnitude."""
    if isinstance(value, list):
        return [_scaled(drawn, one) for one in value]
    if isinstance(value, bool) or not isinstance(value, int | float):
        return drawn.choice(_ODD)
    try:
        scaled = value * drawn.choice((-1, 1, 1, 1)) * 10.0 ** drawn.uniform(-9, 9)
    except OverflowError:
        return value
    return int(scaled) if isinstance(value, int) and math.isfinite(scaled) else scaled


def _damaged(drawn: random.Random, content: bytes) -> bytes:
    at = drawn.randrange(len(content))
    how = drawn.random()
    if how < 0.4:
        return content[:at]
    if how < 0.7:
        return content[:at] + bytes(drawn.randrange(256) for _ in range(3)) + content[at:]
    return drawn.choice(
        (b"", b"\xef\xbb\xbf" + content, content.replace(b"\n", b"\r\n"), b"[" * 999)
    )


# TOML


def toml_text(document: Document) -> str:
    """A document as TOML; keys of tables within lists and of odd places stand inline."""
    lines = [f"{_key(k)} = {_value(v)}" for k, v in document.items() if not _own_table(v)]
    for name, value in document.items():
        if isinstance(value, dict):
            lines += _table_lines(_key(name), value)
        elif _own_table(value):
            for one in value:
                lines += [
                    "",
                    f"[[{_key(name)}]]",
                    *(f"{_key(k)} = {_value(v)}" for k, v in one.items()),
                ]
    return "\n".join(lines) + "\n"


def _own_table(value: Any) -> bool:
    every = isinstance(value, list) and bool(value) and all(isinstance(x, dict) for x in value)
    return isinstance(value, dict) or every


def _table_lines(path: str, table: Document) -> list[str]:
    nested = {
        k: v for k, v in table.items() if isinstance(v, dict) and k in ("transducer", "u", "v")
    }
    lines = ["", f"[{path}]"]
    lines += [f"{_key(k)} = {_value(v)}" for k, v in table.items() if k not in nested]
    for name, inner in nested.items():
        lines += _table_lines(f"{path}.{name}", inner)
    return lines


def _key(name: str) -> str:
    bare = name.isascii() and name.replace("_", "").isalnum()
    return name if bare else json.dumps(name, ensure_ascii=False)


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(k)} = {_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if isinstance(value, bool) or value is None:
        return json.dumps(value)
    if isinstance(value, datetime.date | datetime.time):
        return value.isoformat()
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return str(value) if isinstance(value, int) else repr(value)
