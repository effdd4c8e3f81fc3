"""Required rules of MISRA C:2012 that exported C does not keep are on record, each at its place."""

import shutil
from pathlib import Path

import pytest
from misra import ADVISORY, RECORD, findings, is_recorded, recorded
from test_both_ends import EXAMPLES, ODD

from ccgen.export.package import export
from ccgen.joint.file import parse_joint

GROWS = """
name = "grows"
[geometry]
segments = 4
length = 0.2
range_of_motion = 4.0
sections = [2, 2]
elongation = [0.0, 0.05]
[sensors.transducer]
bits = 14
signed = false
metres_per_count = 1.0e-5
zero = 8000
noise = 5e-5
""" + "".join(
    f'[[sensor]]\nname = "s{k}"\nspan = {span}\nangle = {120.0 * (k % 3)}\nradius = 0.03\n'
    for k, span in enumerate([[0, 3]] * 3 + [[0, 1]] * 3 + [[1, 3]] * 3)
) + """
[can]
commands = true
[estimator]
axes = ["u", "v", "h"]
"""  # fmt: skip
JOINTS = {
    "shoulder": (EXAMPLES / "shoulder.toml").read_text(),
    "spine": (EXAMPLES / "spine.toml").read_text(),
    "odd": ODD,
    "grows": GROWS,
}
PLANTED = {
    "8.4": "int ccgen_planted(int value);\nint ccgen_planted_more(int value) { return value; }\n"
           "int ccgen_planted(int value) { return ccgen_planted_more(value); }\n",
    "10.1": "int ccgen_planted(int a);\nint ccgen_planted(int a) { return a >> 1; }\n",
    "17.7": "int ccgen_planted(void);\nvoid ccgen_ignores(void);\n"
            "void ccgen_ignores(void) { ccgen_planted(); }\n",
}  # fmt: skip


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """Exported folders, under a name that the addon does not pass over."""
    assert shutil.which("cppcheck"), "needs cppcheck"
    folder = tmp_path_factory.mktemp("record")
    for name, text in JOINTS.items():
        export(parse_joint(text, f"{name}.toml"), folder / name)
    return folder


@pytest.mark.parametrize("name", JOINTS)
def test_required_rules_are_kept_or_on_record_with_a_tag(folders, name):
    found = findings(folders / name)
    assert found, "the addon found nothing at all, so it did not run"
    assert [str(finding) for finding in found if not is_recorded(finding)] == []


@pytest.mark.parametrize("rule", PLANTED)
def test_a_planted_violation_is_caught(tmp_path, rule):
    source = tmp_path / "src" / "ccgen" / "planted.c"
    source.parent.mkdir(parents=True)
    source.write_text(PLANTED[rule])
    caught = {finding.rule for finding in findings(tmp_path) if not is_recorded(finding)}
    assert rule in caught


def test_the_record_has_a_reason_for_required_rules_only():
    rules = recorded()
    assert rules
    assert not set(rules) & ADVISORY
    assert all(len(reason.split()) > 5 for reason in rules.values())
    assert "no claim of compliance" in RECORD.read_text()


def test_tags_in_the_sources_are_of_rules_on_record():
    root = Path(__file__).parent.parent
    files = [*(root / "firmware_c").rglob("*.[ch]"), *(root / "templates").glob("*.j2")]
    used = {
        rule
        for file in files
        for line in file.read_text().splitlines()
        if "MISRA" in line
        for rule in line.partition("MISRA ")[2].replace("*/", " ").replace(",", " ").split()
        if rule[0].isdigit()
    }
    assert {rule.rstrip(".") for rule in used} == set(recorded())
