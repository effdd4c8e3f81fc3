import json
import re
import sys
from pathlib import Path

import pytest
from test_joint_checks import loaded
from typer.testing import CliRunner

import ccgen
from ccgen.cli.main import app
from ccgen.cost import costs
from ccgen.cost.readme import BEGIN, END, has_table
from ccgen.export.manifest import changed_files, replace_file
from ccgen.export.package import export

JOINT = Path(__file__).resolve().parent.parent / "examples" / "shoulder.toml"


@pytest.fixture
def folder(tmp_path):
    export(JOINT, tmp_path / "shoulder")
    return tmp_path / "shoulder"


@pytest.fixture
def one_core(monkeypatch):
    monkeypatch.setattr(costs, "COUNTED", ("avr", "cortex-m4"))
    missing = {"avr": ["gcc-avr"], "cortex-m4": []}
    monkeypatch.setattr(costs, "missing_tools", lambda core, to_run: missing[core.name])


def run(*arguments, status=0):
    result = CliRunner().invoke(app, [*map(str, arguments)])
    assert result.exit_code == status, result.stderr
    return result


def readme(folder):
    return (folder / "README.md").read_text()


def test_a_plain_export_says_how_to_measure(folder):
    text = readme(folder)
    section = text.partition(BEGIN)[2].partition(END)[0]
    assert section.startswith("\n## What it costs\n\nNot measured yet")
    assert "`ccgen cost . --write`" in section
    assert "\nccgen cost . --write" in text.partition("## Check it")[2].partition("\n```\n")[0]
    assert not has_table(folder)


def test_the_table_in_the_readme_is_replaced_and_counts_as_exported(folder):
    for target in ("cortex-m4", "cortex-m3"):
        run("cost", folder, "--target", target, "--write")
        text = readme(folder)
        assert (text.count(BEGIN), text.count(END), text.count("## What it costs")) == (1, 1, 1)
        assert "Not measured" not in text
        assert f"\n| {target} | " in text
        assert text.index(f"\n| {target} | ") < text.index("## Check it")
        assert changed_files(folder) == []
        assert has_table(folder)
    assert "| cortex-m4 | " not in text


def test_a_checked_joint_has_a_column_of_its_check_and_what_an_examined_snapshot_takes(tmp_path):
    export(ccgen.fit(ccgen.parse(loaded())), tmp_path / "joint")
    run("cost", tmp_path / "joint", "--target", "cortex-m4", "--write")
    section = readme(tmp_path / "joint").partition(BEGIN)[2].partition(END)[0]
    assert "| estimate | check | pose |" in section
    assert re.search(r"contradict each other it takes up to [\d,]+ \(cortex-m4\) instead", section)
    titles, rule, row = (line for line in section.splitlines() if line.startswith("|"))
    assert titles.count("|") == rule.count("|") == row.count("|")


def test_a_readme_without_the_section_gets_it_at_its_end(folder):
    replace_file(folder, "README.md", b"# mine\n")
    run("cost", folder, "--target", "cortex-m4", "--write")
    assert readme(folder).startswith(f"# mine\n\n{BEGIN}\n## What it costs\n")
    assert readme(folder).endswith(f"|\n{END}\n")


@pytest.mark.usefixtures("one_core")
def test_export_measures_what_has_its_tools_where_asked_to(tmp_path):
    out = tmp_path / "out"
    result = run("export", JOINT, "-o", out, "--cost")
    assert "left out: avr: needs gcc-avr" in result.stderr
    row = next(line for line in readme(out).splitlines() if line.startswith("| cortex-m4 | "))
    assert " ".join(row.replace("|", " ").split()) in " ".join(result.stdout.split())
    assert changed_files(out) == []
    assert f"Next: ccgen verify {out}\n" in result.stdout
    answer = json.loads(run("export", JOINT, "-o", out, "--cost", "--json").stdout)
    measured = json.loads(run("cost", out, "--json").stdout)
    assert answer["targets"] == measured["targets"]
    assert row in readme(out).splitlines()


def test_a_plain_export_tells_that_a_measured_table_is_gone(folder):
    quiet = run("export", JOINT, "-o", folder)
    assert quiet.stderr == ""
    assert f"Next: ccgen verify {folder}, ccgen cost {folder} --write\n" in quiet.stdout
    before = readme(folder)
    run("cost", folder, "--target", "cortex-m4", "--write")
    lost = run("export", JOINT, "-o", folder, "--json")
    assert f"{folder / 'README.md'}: the table of costs that was in it is gone" in lost.stderr
    assert f"`ccgen cost {folder} --write` measures again" in lost.stderr
    assert "targets" not in json.loads(lost.stdout)
    assert readme(folder) == before


@pytest.mark.usefixtures("one_core")
def test_export_replaces_a_table_without_a_word_where_it_measures_again(folder):
    run("cost", folder, "--write")
    again = run("export", JOINT, "-o", folder, "--cost")
    assert "is gone" not in again.stderr
    assert has_table(folder)


def test_export_writes_nothing_where_it_cannot_measure(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "unicorn", None)
    result = run("export", JOINT, "-o", tmp_path / "out", "--cost", status=2)
    assert "counting needs unicorn; install it with `pip install 'ccgen[cost]'`" in result.stderr
    monkeypatch.undo()
    monkeypatch.setattr(costs, "missing_tools", lambda core, to_run: ["gcc-nowhere"])
    result = run("export", JOINT, "-o", tmp_path / "out", "--cost", status=2)
    assert "no target is left to measure" in result.stderr
    assert not (tmp_path / "out").exists()
