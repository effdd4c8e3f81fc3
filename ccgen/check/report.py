"""All that is checked of the joints of one bus, and its report as JUnit XML."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from ccgen.check.bus import bus_load, bus_problems
from ccgen.check.folders import folder_problems
from ccgen.check.member import Member, Resident, read_members, residents
from ccgen.check.names import name_problems
from ccgen.check.problem import KINDS, OF_FOLDERS, OF_THE_BUS, Kind, Problem

_NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML cannot hold in any form."""


@dataclass(frozen=True, eq=False)
class Checked:
    """What was found.

    Attributes:
        members: the paths.
        joints: the joints that stand there.
        problems: what is wrong.
        bus_load: share of the time that the frames of all joints take at most.
    """

    members: Sequence[Member]
    joints: Sequence[Resident]
    problems: Sequence[Problem]
    bus_load: float

    def record(self) -> dict[str, Any]:
        """As it stands in JSON."""
        return {
            "joints": [joint.name for joint in self.joints],
            "frames": [_frames(joint) for joint in self.joints],
            "problems": [problem.record() for problem in self.problems],
            "bus_load": self.bus_load,
        }


def check(paths: Sequence[Path]) -> Checked:
    """Check joint files and exported folders of one bus.

    Args:
        paths: at least one.

    Raises:
        InputError: a joint file is wrong, a folder was not written by ccgen, or a recording that a
            joint names cannot be read.
    """
    members = read_members(paths)
    joints = residents(members)
    problems = [*bus_problems(joints), *name_problems(joints), *folder_problems(members)]
    return Checked(members, joints, problems, bus_load(joints))


def junit(checked: Checked) -> bytes:
    """The report as JUnit XML: a case for each path and kind of check, and those of the bus."""
    suite = ElementTree.Element("testsuite", name="ccgen check")
    for member in checked.members:
        for kind in KINDS:
            if kind in OF_THE_BUS or (kind in OF_FOLDERS and member.manifest is None):
                continue
            told = [p for p in checked.problems if p.kind == kind and p.file == member.path]
            _case(suite, str(member.path), kind, told)
    for kind in OF_THE_BUS:
        _case(suite, "bus", kind, [p for p in checked.problems if p.kind == kind])
    failed = str(len(suite.findall("testcase/failure")))
    suite.attrib.update(tests=str(len(suite)), failures=failed, errors="0", skipped="0")
    root = ElementTree.Element("testsuites")
    root.append(suite)
    ElementTree.indent(root)
    return bytes(ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"


def _case(suite: ElementTree.Element, name: str, kind: Kind, problems: Sequence[Problem]) -> None:
    case = ElementTree.SubElement(
        suite, "testcase", classname=f"ccgen.check.{kind}", name=_xml(f"{name}: {KINDS[kind]}")
    )
    if problems:
        text = "\n".join(f"{problem.file}: {problem.text}" for problem in problems)
        failure = ElementTree.SubElement(case, "failure", type=kind, message=_xml(problems[0].text))
        failure.text = _xml(text)


def _xml(text: str) -> str:
    return _NO_XML.sub(lambda found: repr(found[0])[1:-1], text)


def _frames(joint: Resident) -> dict[str, Any]:
    return {
        "joint": joint.name,
        "file": str(joint.path),
        "first_id": joint.layout.base_id,
        "last_id": joint.layout.last_id,
        "extended": joint.layout.extended,
        "bitrate": joint.joint.can.bitrate,
        "bus_load": joint.load,
    }
