"""Whatever standard output is: any encoding, any width, full, closed, or a pipe nobody reads."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from rich.table import Table

from ccgen.cli.main import main
from ccgen.cli.output import show_table
from ccgen.cli.terminal import in_ascii
from ccgen.export.package import export

ROOT = Path(__file__).resolve().parent.parent
SHOULDER = str(ROOT / "examples" / "shoulder.toml")


@pytest.fixture(scope="module")
def exported(tmp_path_factory):
    folder = tmp_path_factory.mktemp("terminal") / "shoulder"
    export(Path(SHOULDER), folder)
    return str(folder)


def shell(
    command: str, encoding: str = "utf-8", **environment: str
) -> subprocess.CompletedProcess[str]:
    """Run a command line of bash in which `ccgen` is the program of these sources."""
    program = f'ccgen() {{ "{sys.executable}" -m ccgen "$@"; }}; {command}'
    return subprocess.run(
        ["bash", "-c", program], capture_output=True, encoding=encoding, check=False,
        env={**os.environ, **environment},
    )  # fmt: skip


@pytest.mark.parametrize("encoding", ["ascii", "cp932", "latin-1"])
def test_what_an_encoding_lacks_is_written_in_ascii(exported, encoding):
    words = f"ccgen verify {exported} --snapshots 20 --values 1000"
    done = shell(words, encoding, PYTHONIOENCODING=encoding)
    assert (done.returncode, done.stderr) == (0, "")
    assert f"pose / {'µ' if encoding == 'latin-1' else 'u'}m" in done.stdout


def test_the_c_locale_is_no_error(tmp_path):
    shell(f"ccgen init arm -o {tmp_path}/ärm.toml")
    done = shell(
        f"ccgen fit {tmp_path}/ärm.toml; ccgen fit {tmp_path}/örm.toml",
        LC_ALL="C", PYTHONUTF8="0", PYTHONCOERCECLOCALE="0",
    )  # fmt: skip
    assert done.returncode == 2
    assert "arm: wam" in done.stdout
    assert "rm.toml: no such file" in done.stderr
    warning, error = done.stderr.splitlines()
    assert warning.startswith("ccgen: warning: the weights are fitted to the load cases alone")
    assert error.startswith("ccgen: error: ")


def test_every_sign_that_the_program_writes_has_a_meaning_in_ascii():
    templates = (path for path in (ROOT / "templates").rglob("*") if path.is_file())
    sources = [*(ROOT / "ccgen").rglob("*.py"), *templates]
    signs = {sign for file in sources for sign in file.read_text() if not sign.isascii()}
    signs -= set("┏━┳┓┃┡╇┩│├┤└┘┌┐┬┴┼─■")  # of tables, which rich draws in ASCII itself
    assert {"µ", "°"} <= signs
    assert {sign for sign in signs if "\\" in in_ascii(sign)} == set()
    assert in_ascii("ärm µm 3° ▁█ \udcff") == "arm um 3 deg _# \\udcff"


@pytest.mark.parametrize(
    "words", ["--help", "--version", "fit --help", f"fit {SHOULDER}", f"fit {SHOULDER} --json"]
)
def test_a_full_disk_is_one_line_and_status_2(words):
    done = shell(f"ccgen {words} > /dev/full")
    said = "ccgen: error: standard output: no space left on device\n"
    assert (done.returncode, done.stderr) == (2, said)


@pytest.mark.parametrize("words", ["--help", f"fit {SHOULDER}", f"fit {SHOULDER} --json"])
def test_a_closed_pipe_ends_quietly(words):
    done = shell(f"set -o pipefail; ccgen {words} | true")
    assert (done.returncode, done.stdout) == (0, "")
    # What the fit warns of is no word about the pipe: it stands there without one, too.
    assert done.stderr in ("", shell(f"ccgen {words} > /dev/null").stderr)


def test_a_check_that_fails_is_told_by_the_status_behind_a_closed_pipe_too(exported):
    done = shell(f"set -o pipefail; ccgen cost {exported} --target host --max-flash 1 | true")
    assert done.returncode == 1
    assert done.stderr.startswith("ccgen: over budget: ")


@pytest.mark.parametrize("closed", [">&-", "<&-", "2>&-", "<&- >&- 2>&-", "2>/dev/full"])
def test_closed_outputs_change_nothing(tmp_path, closed):
    done = shell(f"ccgen fit {SHOULDER} --json --plot {tmp_path}/p.svg {closed}")
    assert done.returncode == 0
    assert (tmp_path / "p.svg").read_bytes().startswith(b"<?xml")
    assert shell(f"ccgen fit nothing.toml {closed}").returncode == 2


def ccgen(*words: str) -> int:
    with pytest.raises(SystemExit) as end:
        main(words)
    return int(end.value.code or 0)


@pytest.mark.parametrize("columns", ["60", "40"])
def test_place_keeps_its_spans_on_a_narrow_terminal(capsys, monkeypatch, columns):
    words = ("place", SHOULDER, "--sensors", "8", "--method", "heuristic")
    assert ccgen(*words) == 0
    whole = capsys.readouterr().out
    spans = [f"{a}-{b}" for a, b in re.findall(r"\[(\d+), (\d+)\]", whole)]
    assert len(spans) == 8
    monkeypatch.setenv("COLUMNS", columns)
    assert ccgen(*words) == 0
    narrow = capsys.readouterr().out.partition("[sensors]")[0]
    assert [word for word in narrow.split() if re.fullmatch(r"\d+-\d+", word)] == spans
    assert max(map(len, narrow.splitlines())) <= int(columns)
    told = whole.partition("[sensors]")[0]
    assert set(re.findall(r"\d\.\d+", told)) <= set(re.findall(r"\d\.\d+", narrow))


@pytest.mark.parametrize("columns", ["60", "40"])
def test_verify_and_cost_never_cut_digits(capsys, monkeypatch, exported, columns):
    monkeypatch.setenv("COLUMNS", columns)
    assert ccgen("verify", exported, "--snapshots", "1000", "--values", "30000") == 0
    said = capsys.readouterr().out
    assert re.findall(r"snapshots +([\d,]+)\n", said) == ["1,250", "1,000", "1,000"]
    assert re.findall(r"angles +([\d,]+)\n", said) == ["30,000", "24,000", "24,000"]
    assert ccgen("cost", exported, "--target", "host") == 0
    told = capsys.readouterr().out
    monkeypatch.setenv("COLUMNS", "200")
    assert ccgen("cost", exported, "--target", "host") == 0
    numbers = re.findall(r"(?<= )[\d,]+(?= |\n)", capsys.readouterr().out.splitlines()[1] + "\n")
    assert len(numbers) == 8
    assert set(numbers) <= set(told.split())


def table() -> Table:
    made = Table("name", title="numbers")
    made.add_column("spans")
    made.add_column("a long heading", justify="right", no_wrap=True)
    made.add_row("first", "0-4 3-8 7-11", "1,234,567")
    made.add_row("second", "0-1", "-0.000123")
    return made


@pytest.mark.parametrize("columns", [*range(1, 60), 80, 500])
def test_a_table_keeps_every_word_at_any_width(capsys, monkeypatch, columns):
    monkeypatch.setenv("COLUMNS", str(columns))
    show_table(table())
    words = set(re.split(r"[\s│┃]+", capsys.readouterr().out))
    assert {"first", "0-4", "3-8", "7-11", "1,234,567", "second", "0-1", "-0.000123"} <= words


def test_a_table_in_a_file_is_as_wide_as_it_is(capsys, monkeypatch):
    monkeypatch.delenv("COLUMNS", raising=False)
    wide = table()
    wide.add_row("third", " ".join(f"{i}-{i + 1}" for i in range(50)), "1")
    show_table(wide)
    assert " 48-49 49-50 " in capsys.readouterr().out


def test_names_of_files_are_no_markup(capsys, tmp_path):
    folder = tmp_path / "[red]:smile:[/red]"
    assert ccgen("export", SHOULDER, "-o", str(folder)) == 0
    assert f"files in {folder}; README.md" in capsys.readouterr().out


def test_what_nobody_foresaw_is_one_line_with_status_3(capsys, monkeypatch):
    def fail(path):
        raise ZeroDivisionError("float division\nby zero")

    monkeypatch.setattr("ccgen.joint.file.read_joint", fail)
    assert ccgen("fit", "x.toml") == 3
    out, err = capsys.readouterr()
    assert out == ""
    assert re.fullmatch(
        r"ccgen: error: a fault of ccgen's own, not of yours: ZeroDivisionError: float division by "
        r"zero \(ccgen \S+, ccgen/\S+\.py, line \d+\); please report it with this line, the "
        r"command and its files, and what `ccgen --debug` prints before the line\n",
        err,
    )
    assert ccgen("--debug", "fit", "x.toml") == 3
    assert capsys.readouterr().err.startswith("Traceback (most recent call last):")
