"""`ccgen check`: joints of one bus that do not go together, folders that are old or edited."""

import json
import shutil
from pathlib import Path
from xml.etree import ElementTree

import pytest
from joint_files import joint_text

from ccgen.check.report import check, junit
from ccgen.cli.main import main
from ccgen.export.package import export
from ccgen.fixedpoint import fit
from ccgen.joint.file import load

EXAMPLES = Path(__file__).parent.parent / "examples"
LISTED = """name = "{name}"
[geometry]
segments = 4
length = 0.1
range_of_motion = 5.0
{sensors}
[can]
base_id = {base}
"""
SENSOR = """[[sensor]]
name = "{name}"
span = [0, 3]
angle = {angle}
radius = 0.02
metres_per_count = 1e-5
bits = 14
"""


def ccgen(*arguments: object) -> int:
    with pytest.raises(SystemExit) as end:
        main([str(argument) for argument in arguments])
    return int(end.value.code or 0)


def joint_file(path: Path, name: str, can: str = "", **options) -> Path:
    path.write_text(joint_text(name, segments=4, count=2, tables=f"[can]\n{can}", **options))
    return path


def kinds(checked):
    return [problem.kind for problem in checked.problems]


@pytest.fixture(scope="module")
def arm(tmp_path_factory):
    """A joint file beside the folder that was exported of it."""
    folder = tmp_path_factory.mktemp("arm")
    source = joint_file(folder / "arm.toml", "arm", "base_id = 0x100")
    export(source, folder / "arm")
    return folder


@pytest.fixture
def own(arm, tmp_path):
    """A copy to spoil."""
    return shutil.copytree(arm, tmp_path / "own")


def test_two_joints_of_init_on_one_bus_are_a_problem_with_both_names(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert ccgen("init", "arm") == ccgen("init", "leg") == 0
    assert ccgen("check", "arm.toml", "leg.toml", "--json") == 1
    record = json.loads(capsys.readouterr().out)
    assert record["joints"] == ["arm", "leg"]
    (problem,) = record["problems"]
    assert (problem["file"], problem["kind"]) == ("leg.toml", "identifiers")
    assert "leg has identifiers 0x300 to 0x30d, arm (arm.toml)" in problem["text"]
    assert 0.3 < record["bus_load"] < 0.35


def test_the_remedy_that_is_told_is_one(tmp_path):
    first = joint_file(tmp_path / "a.toml", "a", "base_id = 0x100")
    second = joint_file(tmp_path / "b.toml", "b", "base_id = 0x105")
    (problem,) = check([first, second]).problems
    base = problem.text.rpartition("base_id = ")[2]
    assert base == "0x110"
    joint_file(second, "b", f"base_id = {base}")
    assert kinds(check([first, second])) == []


def test_identifiers_that_only_touch_do_not_overlap(tmp_path):
    first = joint_file(tmp_path / "a.toml", "a", "base_id = 0x100")
    last = check([first]).joints[0].layout.last_id
    beside = joint_file(tmp_path / "b.toml", "b", f"base_id = {last + 1}")
    over = joint_file(tmp_path / "d.toml", "d", f"base_id = {last}")
    assert kinds(check([first, beside])) == []
    assert kinds(check([first, over])) == ["identifiers"]


@pytest.mark.parametrize("base", ["0x10100", "0x100"])
def test_extended_identifiers_whose_low_16_bits_are_anothers_share_data_ids(tmp_path, base):
    first = joint_file(tmp_path / "a.toml", "a", "base_id = 0x100")
    second = joint_file(tmp_path / "b.toml", "b", f"base_id = {base}\nextended = true")
    (problem,) = check([first, second]).problems
    assert problem.kind == "data-ids"
    assert "a (" in problem.text
    assert "b has extended identifiers" in problem.text
    assert "data ID 0x0100" in problem.text


def test_data_ids_that_come_round_are_those_of_the_first_identifiers(tmp_path):
    first = joint_file(tmp_path / "a.toml", "a", "base_id = 0x3")
    second = joint_file(tmp_path / "b.toml", "b", "base_id = 0x1FFFB\nextended = true")
    assert kinds(check([first, second])) == ["data-ids"]


def test_frames_of_all_joints_are_counted_together(tmp_path):
    files = [
        joint_file(tmp_path / f"j{k}.toml", f"j{k}", f"base_id = {16 * k}\ncycle_ms = 4")
        for k in range(1, 4)
    ]
    alone = [check([file]).bus_load for file in files]
    checked = check(files)
    assert checked.bus_load == pytest.approx(sum(alone))
    assert checked.bus_load > 0.7 > max(alone)
    assert kinds(checked) == ["bus-load"]
    assert all(f"j{k} " in checked.problems[0].text for k in range(1, 4))


def test_one_bus_has_one_bit_rate(tmp_path):
    first = joint_file(tmp_path / "a.toml", "a", "base_id = 0x100")
    slow = joint_file(tmp_path / "b.toml", "b", "base_id = 0x200\nbitrate = 500_000")
    (problem,) = check([first, slow]).problems
    assert (problem.kind, problem.file) == ("bit-rate", slow)
    assert "b states 500,000 bit/s, a (" in problem.text


@pytest.mark.parametrize("name", ["arm", "Arm"])
def test_names_that_are_one_but_for_capitals_meet(tmp_path, name):
    first = joint_file(tmp_path / "a.toml", "arm", "base_id = 0x100")
    second = joint_file(tmp_path / "b.toml", name, "base_id = 0x200")
    checked = check([first, second])
    assert kinds(checked) == ["names"]
    assert len(checked.joints) == 2


def test_sensors_whose_constants_look_like_another_joints_meet_it(tmp_path):
    sensors = "".join(
        SENSOR.format(name=name, angle=angle)
        for name, angle in (("left_segments", 0.0), ("far", 90.0))
    )
    first, second = tmp_path / "a.toml", tmp_path / "b.toml"
    first.write_text(LISTED.format(name="arm", sensors=sensors, base=0x100))
    joint_file(second, "arm_sensor_left", "base_id = 0x200")
    (problem,) = check([second, first]).problems
    assert (problem.kind, problem.file) == ("names", first)
    assert "ARM_SENSOR_LEFT_SEGMENTS of arm" in problem.text


def test_a_file_with_its_folder_a_copy_and_a_path_told_twice_are_one_joint(own):
    shutil.copytree(own / "arm", own / "copy")
    checked = check([own / "arm.toml", own / "arm", own / "copy", own / ".." / "own" / "arm"])
    assert kinds(checked) == []
    assert [joint.name for joint in checked.joints] == ["arm"]
    assert len(checked.members) == 3


def test_a_folder_stands_for_its_joint_where_its_file_is_not_given(arm, tmp_path):
    other = joint_file(tmp_path / "leg.toml", "leg", "base_id = 0x100")
    assert kinds(check([arm / "arm", other])) == ["identifiers"]


def test_a_folder_is_older_than_a_file_that_has_changed_since(own):
    joint_file(own / "arm.toml", "arm", "base_id = 0x200")
    (problem,) = check([own / "arm", own / "arm.toml"]).problems
    assert (problem.kind, problem.file) == ("older", own / "arm")
    assert "arm was exported before" in problem.text


def test_a_folder_is_older_than_a_fit_that_is_kept_since(own):
    from ccgen.fixedpoint.kept import rounded, write_fit

    write_fit(rounded(fit(load(own / "arm.toml"))))
    (problem,) = check([own / "arm", own / "arm.toml"]).problems
    assert problem.kind == "older"
    assert "arm.fit.json" in problem.text
    export(own / "arm.toml", own / "arm")
    assert kinds(check([own / "arm", own / "arm.toml"])) == []


def test_files_of_a_folder_that_were_edited_or_are_gone_are_named(own):
    source = own / "arm" / "src" / "arm.c"
    source.write_text(source.read_text() + "/* better */\n")
    (own / "arm" / "README.md").unlink()
    (problem,) = check([own / "arm"]).problems
    assert (problem.kind, problem.file) == ("edited", own / "arm")
    assert problem.text == (
        "arm: src/arm.c is not as exported and README.md is gone; export it again to undo"
    )


@pytest.mark.parametrize("file", ["model.json", "joint.toml"])
def test_a_folder_whose_description_was_spoilt_is_edited_and_the_rest_is_checked(own, file):
    (own / "arm" / file).write_text("{")
    other = joint_file(own / "leg.toml", "leg", "base_id = 0x200")
    checked = check([own / "arm", other])
    assert kinds(checked) == ["edited"]
    assert file in checked.problems[0].text
    assert [joint.name for joint in checked.joints] == ["leg"]


def test_a_folder_of_another_format_is_to_be_exported_again(own):
    manifest = own / "arm" / "manifest.json"
    record = json.loads(manifest.read_text())
    manifest.write_text(json.dumps(record | {"format": 1}))
    (problem,) = check([own / "arm"]).problems
    assert problem.kind == "older"
    assert "is of format 1" in problem.text


def test_frames_that_depend_on_the_fit_are_those_that_are_exported(tmp_path):
    source = joint_file(
        tmp_path / "fine.toml", "fine", "base_id = 0x100", precision=32, bits=32, step=1e-10
    )
    exported = export(source, tmp_path / "fine")
    assert check([source]).joints[0].layout == exported.layout


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda folder: (folder / "arm.toml").unlink(), "no such file"),
        (lambda folder: (folder / "arm.toml").write_text("name = 3\n"), "arm.toml: name: "),
        (lambda folder: (folder / "arm" / "manifest.json").unlink(), "ccgen export"),
        (lambda folder: (folder / "arm" / "manifest.json").write_text("[]"), "damaged"),
        (lambda folder: (folder / "arm" / "manifest.json").write_text("[" * 10**5), "damaged"),
    ],
)
def test_what_is_no_joint_ends_with_status_2_in_one_line(own, capsys, spoil, said):
    spoil(own)
    report = own / "check.xml"
    assert ccgen("check", own / "arm.toml", own / "arm", "--junit", report) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert len(captured.err.splitlines()) == 1
    assert said in captured.err
    assert not report.exists()


def test_a_report_that_is_not_named_as_xml_is_refused_before_it_replaces_a_file(own, capsys):
    before = (own / "arm.toml").read_bytes()
    assert ccgen("check", own / "arm", "--junit", own / "arm.toml") == 2
    assert "ends in .xml" in capsys.readouterr().err
    assert (own / "arm.toml").read_bytes() == before


def test_what_is_right_ends_with_status_0_and_says_so(arm, capsys):
    assert ccgen("check", arm / "arm.toml", arm / "arm") == 0
    assert "No problem found." in capsys.readouterr().out


def test_the_junit_report_has_a_case_a_check_and_a_failure_a_problem(own):
    (own / "arm" / "src" / "arm.c").unlink()
    other = joint_file(own / "l\u0001eg & <co>.toml", "leg", "base_id = 0x100")
    checked = check([own / "arm.toml", own / "arm", other])
    suite = ElementTree.fromstring(junit(checked)).find("testsuite")
    failed = [case for case in suite if case.find("failure") is not None]
    assert suite.attrib["tests"] == str(len(suite)) == str(3 + 5 + 3 + 2)
    assert suite.attrib["failures"] == "2"
    assert [case.attrib["classname"] for case in failed] == [
        "ccgen.check.edited", "ccgen.check.identifiers",
    ]  # fmt: skip
    assert "leg has identifiers" in failed[1].find("failure").text
    assert junit(checked) == junit(check([own / "arm.toml", own / "arm", other]))


def test_the_examples_go_together_but_all_three_fill_a_bus():
    shoulder, wrist, spine = (EXAMPLES / f"{n}.toml" for n in ("shoulder", "wrist", "spine"))
    assert kinds(check([shoulder, wrist])) == kinds(check([spine])) == []
    assert kinds(check([shoulder, wrist, spine])) == ["bus-load"]
