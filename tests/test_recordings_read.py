"""Reading recordings: what a file may hold, and what is said of one that is wrong."""

import gzip
import math

import can
import numpy as np
import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint
from ccgen.recordings.recording import Extent, read_recording
from ccgen.recordings.sensors import recorded_sensors
from ccgen.recordings.table import read_table

ROWS = 40
ANGLES = ["u0", "u1", "v0", "v1"]
STATIONS = "stations = { mid = 0.12, tip = 0.24 }"


def joint(keys="", bits=16):
    """Two segments of 0.12 m with one sensor an axis, and a recording run.csv."""
    return joint_text(
        name="finger",
        segments=2,
        count=1,
        range_of_motion=20.0,
        bits=bits,
        step=2.0e-5,
        tables=f'[[recordings]]\nfile = "run.csv"\n{keys}\n',
    )


def columns(**replaced):
    """Columns of a recording that is right, in its order; None leaves one out."""
    t = np.arange(ROWS) * 0.1
    swing = np.sin(t)
    made = {"t": t, "count_u0": np.rint(500 * swing), "count_v0": np.rint(-300 * swing)}
    for i, name in enumerate(ANGLES):
        made[name] = (10 + i) * swing
    made.update(replaced)
    return {name: column for name, column in made.items() if column is not None}


def bodies(scale=1.0, **replaced):
    """The same with two bodies in place of the angles; `scale` is of their positions."""
    t = np.arange(ROWS) * 0.1
    swing = np.sin(t)
    placed = dict.fromkeys(ANGLES)
    for body, at in (("mid", 0.12), ("tip", 0.24)):
        placed |= {
            f"{body}_x": scale * 0.5 * at * swing,
            f"{body}_y": scale * 0.1 * at * swing,
            f"{body}_z": scale * at * np.cos(0.5 * swing),
        }
    return columns(**(placed | replaced))


def text(made):
    """A CSV file of these columns: text as it is, numbers in full, NaN as an empty cell."""

    def cell(value):
        if isinstance(value, str):
            return value
        return "" if math.isnan(value) else repr(float(value))

    rows = zip(*made.values(), strict=True)
    return "\n".join([",".join(made), *(",".join(map(cell, row)) for row in rows)]) + "\n"


def read(folder, made, keys="", bits=16, name="run.csv", others=()):
    """Read a recording of a folder; `made` is its columns, its text, or its bytes."""
    data = text(made) if isinstance(made, dict) else made
    (folder / name).write_bytes(data.encode() if isinstance(data, str) else data)
    for other, content in others:
        (folder / other).write_text(text(content))
    parsed = parse_joint(joint(keys, bits), "finger.toml", folder)
    g = parsed.geometry
    extent = Extent(g.segments, 1, g.length, g.range_of_motion)
    return read_recording(parsed.recordings[0], recorded_sensors(parsed), extent)


def changed(column, row, value):
    column = column.astype(object)
    column[row] = value
    return column


# ---- what is read ----------------------------------------------------------------------------


def test_columns_come_by_name_in_the_joint_s_order_and_units(tmp_path):
    made = columns()
    shuffled = {name: made[name] for name in sorted(made, reverse=True)}
    it = read(tmp_path, shuffled)
    np.testing.assert_array_equal(it.t, made["t"])
    np.testing.assert_allclose(it.u, np.radians(np.stack([made["u0"], made["u1"]], axis=1)))
    np.testing.assert_allclose(it.v, np.radians(np.stack([made["v0"], made["v1"]], axis=1)))
    np.testing.assert_array_equal(it.counts.values[:, 1], made["count_v0"])
    assert (it.timed, it.dense, it.h, it.bodies, it.notes) == (True, True, None, (), ())


def test_packed_with_gzip_it_reads_the_same(tmp_path):
    plain = read(tmp_path, columns())
    packed = read(tmp_path, gzip.compress(text(columns()).encode()))
    np.testing.assert_array_equal(plain.u, packed.u)
    assert plain.hashes != packed.hashes


def test_an_empty_cell_is_no_value_and_a_missing_axis_is_unknown(tmp_path):
    made = columns(v0=None, v1=None)
    made["u1"][3] = np.nan
    made["count_v0"][5] = np.nan
    it = read(tmp_path, made)
    assert np.argwhere(np.isnan(it.u)).tolist() == [[3, 1]]
    assert np.isnan(it.v).all()
    assert np.argwhere(np.isnan(it.counts.values)).tolist() == [[5, 1]]


def test_spaces_a_byte_order_mark_blank_lines_and_crlf_do_no_harm(tmp_path):
    made = columns(u1=changed(columns()["u1"], 2, "  "))
    loose = "\ufeff" + text(made).replace(",", " , ").replace("\n", "\r\n") + "\r\n\r\n"
    it = read(tmp_path, loose)
    assert it.rows == ROWS
    assert np.isnan(it.u[2, 1])


def test_without_times_rows_are_consecutive(tmp_path):
    it = read(tmp_path, columns(t=None))
    assert not it.timed
    np.testing.assert_array_equal(it.t, np.arange(ROWS))


def test_a_count_at_the_end_of_its_range_is_no_value(tmp_path):
    made = columns()
    made["count_u0"][:3] = [2047, -2048, 2046]
    it = read(tmp_path, made, bits=12)
    assert np.isnan(it.counts.values[:3, 0]).tolist() == [True, True, False]
    assert it.notes == (f"{tmp_path / 'run.csv'}: sensor u0: 2 counts at the end of their range",)


def test_a_sensor_without_counts_is_said(tmp_path):
    it = read(tmp_path, columns(count_v0=None))
    assert np.isnan(it.counts.values[:, 1]).all()
    assert it.notes == (f"{tmp_path / 'run.csv'}: sensor v0 has no counts",)


def test_a_sensor_that_never_moves_is_said(tmp_path):
    it = read(tmp_path, columns(count_u0=np.full(ROWS, 7)))
    assert it.notes == (f"{tmp_path / 'run.csv'}: sensor u0 reads 7 throughout",)


def test_elongation_is_of_every_section(tmp_path):
    it = read(tmp_path, columns(elongation=np.full(ROWS, 0.02)))
    np.testing.assert_array_equal(it.h, np.full((ROWS, 1), 0.02))


def test_bodies_come_in_the_order_of_their_stations_and_others_are_left_out(tmp_path):
    made = bodies()
    made |= {f"camera_{axis}": np.zeros(ROWS) for axis in "xyz"}
    it = read(tmp_path, made, "stations = { tip = 0.24, mid = 0.12 }")
    assert [(body.name, body.station) for body in it.bodies] == [("mid", 0.12), ("tip", 0.24)]
    np.testing.assert_array_equal(it.bodies[1].position[:, 2], made["tip_z"])
    assert it.bodies[0].orientation is None
    assert not it.dense


def test_quaternions_become_rotations(tmp_path):
    half = math.sqrt(0.5)
    turn = dict(zip(("qx", "qy", "qz", "qw"), (0, 0, half, half), strict=True))
    made = bodies(**{f"tip_{part}": np.full(ROWS, value) for part, value in turn.items()})
    made["tip_qw"][4] = np.nan
    it = read(tmp_path, made, STATIONS)
    quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    np.testing.assert_allclose(it.bodies[1].orientation[3], quarter, atol=1e-12)
    assert np.isnan(it.bodies[1].orientation[4]).all()


def test_markers_of_the_base_need_no_station(tmp_path):
    made = bodies(**{f"foot_{axis}": np.zeros(ROWS) for axis in "xyz"})
    it = read(tmp_path, made, f'{STATIONS}\nbase = ["foot", "mid"]')
    assert [body.name for body in it.bodies] == ["foot", "mid", "tip"]
    assert it.bodies[0].station is None


def test_rows_choose_a_part(tmp_path):
    it = read(tmp_path, columns(), "rows = [5, 24]")
    np.testing.assert_array_equal(it.t, columns()["t"][5:25])


def test_counts_may_lie_in_a_file_beside_with_a_clock_of_its_own(tmp_path):
    made = columns(count_u0=None, count_v0=None)
    beside = {"t": np.arange(30) * 0.15, "count_v0": np.arange(30.0)}
    it = read(tmp_path, made, 'counts = "log.csv"', others=[("log.csv", beside)])
    np.testing.assert_array_equal(it.counts.t, beside["t"])
    np.testing.assert_array_equal(it.counts.values[:, 1], beside["count_v0"])
    assert it.rows == ROWS
    assert [name for name, _ in it.hashes] == ["run.csv", "log.csv"]


def test_counts_may_lie_in_a_log_of_the_bus(tmp_path):
    (tmp_path / "bus.dbc").write_text(
        'VERSION ""\nBU_: A\nBO_ 16 LENGTHS: 4 A\n'
        ' SG_ length_u0 : 0|16@1- (1,0) [0|0] "" A\n SG_ length_v0 : 16|16@1- (1,0) [0|0] "" A\n'
    )
    with can.Logger(tmp_path / "run.log") as log:
        for i in range(30):
            data = (3 * i).to_bytes(2, "little") + (-i).to_bytes(2, "little", signed=True)
            log.on_message_received(
                can.Message(
                    arbitration_id=16, is_extended_id=False, data=data, timestamp=1e9 + 0.01 * i
                )
            )
    made = columns(count_u0=None, count_v0=None)
    it = read(tmp_path, made, 'counts = "run.log"\ndbc = "bus.dbc"')
    np.testing.assert_array_equal(it.counts.values[:, 0], 3 * np.arange(30))
    np.testing.assert_allclose(it.counts.t, 0.01 * np.arange(30), atol=1e-6)
    assert [name for name, _ in it.hashes] == ["run.csv", "run.log", "bus.dbc"]


def test_a_large_recording_is_read_whole(tmp_path):
    rng = np.random.default_rng(0)
    values = rng.normal(size=(6000, 60)).round(5)
    names = ",".join(f"m{i}_{axis}" for i in range(20) for axis in "xyz")
    np.savetxt(tmp_path / "big.csv", values, fmt="%.5f", delimiter=",", header=names, comments="")
    np.testing.assert_array_equal(read_table(tmp_path / "big.csv").values, values)


# ---- what is wrong ---------------------------------------------------------------------------


WRONG_COLUMNS = [
    (
        columns(),
        {"count_u1": 0.0},
        "",
        "column count_u1: the joint has no sensor u1; its sensors are u0, v0",
    ),
    (
        columns(),
        {"count_arm": 0.0},
        "",
        "column count_arm: the joint has no sensor arm; its sensors are u0, v0",
    ),
    (columns(), {"u2": 0.0}, "", "column u2: the joint has 2 segments; write u0 to u1"),
    (columns(), {"h1": 0.0}, "", "column h1: the joint has 1 section; write h0 to h0"),
    (
        columns(t=None),
        {"T": 0.0},
        "",
        "column T is unknown; write t, count_SENSOR, BODY_x BODY_y BODY_z, BODY_qx "
        "BODY_qy BODY_qz BODY_qw, u0 ..., v0 ..., elongation or h0 ...",
    ),
    (columns(), {"elongaton": 0.0}, "", "column elongaton is unknown; did you mean elongation?"),
    (bodies(tip_y=None), {}, STATIONS, "column tip_y is missing; write all of tip_x, tip_y, tip_z"),
    (
        bodies(),
        {"tip_qx": 0.0},
        STATIONS,
        "column tip_qy is missing; write all of tip_qx, tip_qy, tip_qz, tip_qw",
    ),
    (
        bodies(),
        {},
        "stations = { tipp = 0.24 }",
        "no columns tipp_x, tipp_y, tipp_z, but [[recordings]] names tipp; did you mean tip?",
    ),
    (
        columns(),
        {},
        "stations = { tip = 0.24 }",
        "no columns tip_x, tip_y, tip_z, but [[recordings]] names tip; its bodies are: none",
    ),
    (
        bodies(tip_z=np.full(ROWS, np.nan)),
        {},
        STATIONS,
        "columns tip_x, tip_y, tip_z: tip never appears; remove tip from [[recordings]]",
    ),
    (
        columns(elongation=np.zeros(ROWS)),
        {"h0": 0.0},
        "",
        "columns elongation and h0 say the same; remove one of them",
    ),
]


@pytest.mark.parametrize(("made", "more", "keys", "says"), WRONG_COLUMNS)
def test_columns_that_do_not_fit_are_named_with_what_would(tmp_path, made, more, keys, says):
    added = {name: np.full(ROWS, value) for name, value in more.items()}
    assert failure(tmp_path, made | added, keys) == f"{tmp_path / 'run.csv'}: {says}"


def failure(folder, made, keys="", **named):
    with pytest.raises(InputError) as error:
        read(folder, made, keys, **named)
    said = str(error.value)
    assert "\n" not in said
    return said


WRONG_VALUES = [
    (
        columns(u1=changed(columns()["u1"], 7, "1,5")),
        "",
        "line 9: 8 cells under 7 columns; write one cell a column, empty where there is no value",
    ),
    (
        columns(u1=changed(columns()["u1"], 7, "wide")),
        "",
        "line 9, column u1: 'wide' is not a number; write one with a decimal point, or "
        "leave the cell empty",
    ),
    (
        columns(u1=changed(columns()["u1"], 7, "1_5")),
        "",
        "line 9, column u1: '1_5' is not a number; write one with a decimal point, or "
        "leave the cell empty",
    ),
    (
        columns(u1=changed(columns()["u1"], 7, "-inf")),
        "",
        "line 9, column u1: '-inf' is not a number; write one with a decimal point, or "
        "leave the cell empty",
    ),
    (
        columns(u1=changed(columns()["u1"], 7, 91.0)),
        "",
        "line 9, column u1: 91 degrees are beyond any reach of a segment; write degrees "
        "from -90 to 90",
    ),
    (
        columns(t=changed(columns()["t"], 7, 0.1)),
        "",
        "line 9, column t: time runs back from 0.6 to 0.1 s; sort the rows, or cut the "
        "file where the clock was set",
    ),
    (
        columns(t=np.full(ROWS, 5.0)),
        "",
        "column t: time stands still at 5 s; write seconds that run on, or leave the column out",
    ),
    (
        columns(t=changed(columns()["t"], 7, "")),
        "",
        "line 9, column t: is empty; every row needs its time",
    ),
    (
        columns(**{a: np.radians(columns()[a]) for a in ANGLES}),
        "",
        "columns u0 ... v0 ...: angles of at most 0.227 look like radians for a range of "
        "motion of 20 degrees; write degrees",
    ),
    (
        columns(**{a: columns()[a] * 0 + 2 for a in ANGLES}),
        "",
        "the joint does not move in it (by 0 m and 0 degrees); record it while it bends",
    ),
    (
        columns(elongation=np.full(ROWS, 3.0)),
        "",
        "line 2, column elongation: 3 is no share of the length; write 0.05 for five per cent",
    ),
    (
        bodies(1000.0),
        STATIONS,
        "mid and tip lie 120 apart where the joint file says 0.12 m: they look like "
        "millimetres; write metres, and check stations and geometry.length",
    ),
    (
        bodies(100.0),
        STATIONS,
        "mid and tip lie 12 apart where the joint file says 0.12 m: they look like "
        "centimetres or inches; write metres, and check stations and geometry.length",
    ),
    (
        bodies(1000.0),
        "stations = { tip = 0.24 }",
        "tip moves by 189 where the joint file says 0.48 m: they look like millimetres; "
        "write metres, and check stations and geometry.length",
    ),
    (
        bodies(**{f"tip_q{a}": np.full(ROWS, 0.7) for a in "xyzw"}),
        STATIONS,
        "line 2, columns tip_qx tip_qy tip_qz tip_qw: a quaternion of norm 1.4 is no "
        "orientation; write unit quaternions, and leave the cells empty where there is "
        "none",
    ),
    (
        bodies(tip_y=changed(bodies()["tip_y"], 3, 1e300)),
        STATIONS,
        "line 5, column tip_y: 1e+300 m is no place of a body; write metres, and leave the cells "
        "empty where tip was not seen",
    ),
    (
        columns(count_u0=np.full(ROWS, 7), count_v0=None),
        "",
        "no count ever changes in it; record the counts while the joint bends, or leave out the "
        "columns count_...",
    ),
    (
        columns(),
        "delay = 500.0",
        "delay = 500 leaves 0 of its rows with counts, which run from 0 to 3.9 s; write the "
        'seconds by which the sensors lag, or "estimate"',
    ),
    (
        columns(),
        "straight = [60.0, 70.0]",
        "0 rows within straight = [60, 70]; the recording runs from 0 to 3.9 s",
    ),
    (
        columns(t=None),
        "straight = [0.0, 2.0]",
        "has no column t, but straight is stated in seconds; add the times, or remove straight",
    ),
    (
        columns(),
        "rows = [5, 40]",
        "rows = [5, 40] asks for more than its 40 rows; write rows from 0 to 39",
    ),
    (
        columns(),
        "rows = [5, 6]",
        "2 rows of samples; a recording needs 10 or more, "
        "so that some can be held out; fewer poses with segment angles calibrate sensors: "
        "`ccgen calibrate`",
    ),
    (
        columns(count_u0=np.full(ROWS, 40000.0)),
        "",
        "column count_u0: most counts lie outside -32768 ... 32767; correct bits or "
        "range of the transducer",
    ),
    (
        columns(count_u0=np.full(ROWS, np.nan), count_v0=np.full(ROWS, np.nan)),
        "",
        "every count_... is empty; write raw counts, or no such column",
    ),
    (
        bodies(count_u0=None, count_v0=None),
        "",
        "has neither angles nor counts, and [[recordings]] names no stations; write "
        "stations = { tip = ... } for the bodies in it",
    ),
    (
        columns(),
        'counts = "log.csv"',
        "holds counts, and so does log.csv; remove counts from [[recordings]], or the "
        "columns from the file",
    ),
]


@pytest.mark.parametrize(("made", "keys", "says"), WRONG_VALUES)
def test_values_that_make_no_sense_are_named_with_what_would(tmp_path, made, keys, says):
    said = failure(tmp_path, made, keys)
    assert said.removeprefix(str(tmp_path / "run.csv")).removeprefix(":").strip() == says


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"", "is empty; write a header and a row a sample"),
        (b"\n\n", "is empty; write a header and a row a sample"),
        (b"t,u0\n", "0 rows of samples; a recording needs 10 or more"),
        (b"1,2\n3,4\n", "line 1 holds numbers, not names; write a header such as t,count_u0"),
        (
            b"t;u0\n1;2\n",
            "line 1: the columns are separated by semicolons; write commas between columns "
            "and decimal points in numbers",
        ),
        (
            b"t\tu0\n1\t2\n",
            "line 1: the columns are separated by tabs; write commas between columns and "
            "decimal points in numbers",
        ),
        (b"0,1,1\n2,3,4\n", "line 1 holds numbers, not names; write a header"),
        (b"# by hand\nt,u0\n", "line 1 is a comment; remove it, the first line names columns"),
        (b"t\n1,2\n", "line 2: 2 cells under 1 column; write one cell a column"),
        (b"t,u0,t\n", "column t stands there twice; remove one of them"),
        (b"t,,u0\n", "column 2 has no name; write a header such as t,count_u0"),
        (b't,"u0\n', "line 1: unexpected end of data; write comma-separated numbers"),
        (b"t,u0\n1,\xb5\n", "line 2: byte 0xb5 is not UTF-8; save the file as UTF-8 text"),
        (b"t,u0\n1,\x00\n", "line 2: a zero byte, this is no text; name a CSV file"),
        ("t,u0\n".encode("utf-16"), "is UTF-16; save it as UTF-8 text"),
        (
            gzip.compress(b"t,u0\n" * 99, mtime=0)[:-9],
            "the gzip file is cut off; copy it again, whole",
        ),
        (
            gzip.compress(b"t,u0\n1,2\n", mtime=0)[:10] + b"abcdefghijklmnop",
            "the gzip file is damaged",
        ),
    ],
)
def test_a_file_that_is_no_table_is_named_with_the_remedy(tmp_path, data, says):
    assert failure(tmp_path, data).startswith(f"{tmp_path / 'run.csv'}: {says}")


def test_a_file_that_cannot_be_read_is_named(tmp_path):
    with pytest.raises(InputError, match=r"run\.csv: no such file; a path in \[\[recordings\]\]"):
        read_table(tmp_path / "run.csv")
    with pytest.raises(InputError, match=r"is a directory; name a file in it$"):
        read_table(tmp_path)
    with pytest.raises(InputError, match=r"run\.csv: no such file"):
        read_table(tmp_path / "file.csv" / "run.csv")


def test_a_gzip_file_that_unpacks_without_end_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("ccgen.recordings.table.LARGEST_TEXT", 2**20)
    with pytest.raises(InputError, match="more than 1 MiB of text; cut it into several recordings"):
        read(tmp_path, gzip.compress(b"t,u0\n" + b"0,0\n" * 2**20, mtime=0))


@pytest.mark.parametrize(
    ("beside", "says"),
    [
        ({"count_u0": np.zeros(30)}, "log.csv: has no column t; add the times in seconds"),
        (
            {"t": np.arange(30.0), "u0": np.zeros(30)},
            "log.csv: has no counts; write columns such as count_u0",
        ),
        (
            {"t": -np.arange(30.0), "count_u0": np.zeros(30)},
            "log.csv: line 3, column t: time runs back from -0 to -1 s; sort the rows, or cut "
            "the file where the clock was set",
        ),
    ],
)
def test_counts_beside_must_have_times_and_counts(tmp_path, beside, says):
    made = columns(count_u0=None, count_v0=None)
    said = failure(tmp_path, made, 'counts = "log.csv"', others=[("log.csv", beside)])
    assert said == f"{tmp_path / says.split(':')[0]}{says.removeprefix('log.csv')}"
