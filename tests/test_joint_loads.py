"""[loads] of a joint file and files of stated loads: what they may hold, and what is refused."""

import math

import pytest
from joint_files import joint_text

from ccgen.errors import InputError
from ccgen.joint.file import parse_joint
from ccgen.joint.load_files import parse_loads, read_loads
from ccgen.joint.load_tables import ContactTable, LoadsTable, StatedLoadsTable
from ccgen.joint.loads import Contact, LoadRanges, StatedLoads

EVERY_KEY = """
[loads]
samples = 200
stiffness = 0.4
stiffness_profile = [2.0, 1, 1.0, 2.5]
stiffness_tolerance = 0.1
actuation = [-90.0, 90]
mass = 0.4
mounting = 60
payload = [0.0, 0.25]
tip_force = [1.0, 6.0]
tip_moment = [0.0, 0.2]
contact = [0.0, 5.0]
contact_from = 0.05
elongation = [-0.01, 0.03]
"""


def ranges(lines):
    return parse_joint(joint_text(tables=lines), "finger.toml").loads


def stated(lines, **changes):
    geometry = parse_joint(joint_text(**changes), "finger.toml").geometry
    return parse_loads(lines, "push.toml", geometry)


def test_every_key_of_the_ranges_is_read():
    assert ranges(EVERY_KEY) == LoadRanges(
        samples=200,
        stiffness=0.4,
        stiffness_profile=(2.0, 1.0, 1.0, 2.5),
        stiffness_tolerance=0.1,
        actuation=(-math.pi / 2, math.pi / 2),
        mass=0.4,
        mounting=math.pi / 3,
        payload=(0.0, 0.25),
        tip_force=(1.0, 6.0),
        tip_moment=(0.0, 0.2),
        contact=(0.0, 5.0),
        contact_from=0.05,
        elongation=(-0.01, 0.03),
    )


def test_a_joint_without_the_table_states_no_loads():
    assert ranges("") is None


def test_what_is_left_out_is_zero_and_mounting_any():
    assert ranges("[loads]\nstiffness = 2\npayload = [0.1, 0.1]\n") == LoadRanges(
        samples=300, stiffness=2.0, payload=(0.1, 0.1)
    )
    assert ranges("[loads]\nstiffness = 2\nmass = 1\nmounting = 'any'\n").mounting is None


def test_actuation_alone_bends_whatever_the_stiffness():
    assert ranges("[loads]\nactuation = [0, 20.0]\n").stiffness == 1.0
    assert stated("actuation_u = 20").stiffness == 1.0


LOADS = "[loads]\nstiffness = 0.4\n"
REFUSED_RANGES = [
    (
        "[loads]\n",
        "loads: states no load; write one of actuation, mass, payload, tip_force, tip_moment, "
        "contact, such as actuation = [-90.0, 90.0]",
    ),
    (
        "[loads]\nmass = 0.3\n",
        "loads.stiffness: missing, but mass bends the joint by it; write stiffness = 0.4 (N m^2, "
        "the bending stiffness)",
    ),
    (
        LOADS + "payload = [0.25, 0.1]\n",
        "loads.payload: [0.25, 0.1] is reversed; write [0.1, 0.25]",
    ),
    (
        LOADS + "actuation = [90, -90.0]\n",
        "loads.actuation: [90.0, -90.0] is reversed; write [-90.0, 90.0]",
    ),
    (
        LOADS + "payload = []\n",
        "loads.payload: [] has 0 items; write the least and the most mass at the tip in kg, 0 or "
        "more, such as payload = [0.0, 0.25]",
    ),
    (
        LOADS + "tip_force = 3.0\n",
        "loads.tip_force: 3.0 is a decimal number; write the least and the most force across the "
        "tip in N, 0 or more, such as tip_force = [0.0, 6.0]",
    ),
    (
        LOADS + "contact = [-1.0, 6.0]\n",
        "loads.contact[0]: -1.0 is too small; write the least and the most force of a contact in "
        "N, 0 or more, such as contact = [0.0, 6.0]",
    ),
    (
        LOADS + "contact = [0.0, 6.0]\ncontact_from = 0.3\n",
        "loads.contact_from: 0.3 m lies beyond the tip; write metres from 0 at the base to 0.24 at "
        "the tip (geometry.length)",
    ),
    (
        "[loads]\nstiffness = 0.0\nmass = 1.0\n",
        "loads.stiffness: 0.0 is too small; write the bending stiffness in N m^2, from 1e-12 to "
        "1e12, such as stiffness = 0.4",
    ),
    (
        LOADS + "mass = nan\n",
        "loads.mass: nan is not finite; write the joint's mass in kg, 0 or more, such as "
        "mass = 0.4",
    ),
    (
        LOADS + "stiffness_profile = [1.0, 0.0]\nmass = 1.0\n",
        "loads.stiffness_profile[1]: 0.0 is too small; write the relative stiffness of equal parts "
        "from the base, from 1e-6 to 1e6 each, such as stiffness_profile = [2.0, 1.0, 1.0, 2.5]",
    ),
    (
        LOADS + "mass = 1.0\nmounting = 'wall'\n",
        'loads.mounting: "wall" is a string; write "any", or the degrees between gravity and the '
        'unbent axis, from 0 to 180, such as mounting = "any"',
    ),
    (
        LOADS + "mass = 1.0\nmounting = 270\n",
        'loads.mounting: 270 is too large; write "any", or the degrees between gravity and the '
        'unbent axis, from 0 to 180, such as mounting = "any"',
    ),
    (
        LOADS + "payloads = [0.0, 0.1]\n",
        "loads.payloads: unknown key; did you mean payload?",
    ),
    (
        "[can]\ncontact_from = 0.1\n",
        "can.contact_from: unknown key here; write it in [loads]",
    ),
    (
        LOADS + "mass = 1.0\nsamples = 0\n",
        "loads.samples: 0 is too small; write how many shapes to draw, from 1 to 10000, such as "
        "samples = 300",
    ),
]


@pytest.mark.parametrize(("lines", "says"), REFUSED_RANGES)
def test_wrong_ranges_are_refused_in_one_line(lines, says):
    with pytest.raises(InputError) as error:
        ranges(lines)
    assert str(error.value) == f"finger.toml: {says}"


def test_every_stated_load_is_read():
    assert stated(
        """
        stiffness = 0.4
        stiffness_profile = [1, 2.0]
        actuation_u = 90
        actuation_v = -45.0
        tip_force = [1, 2.0, 3.0]
        tip_moment = [0.1, 0]
        distributed = [0.0, 0.0, -4.0]
        contacts = [{ at = 0.1, force = [1.0, 0.0, 0] }, { at = 0, force = [0, 1, 0] }]
        elongation = [0.02]
        """
    ) == StatedLoads(
        stiffness=0.4,
        stiffness_profile=(1.0, 2.0),
        actuation=(math.pi / 2, -math.pi / 4),
        tip_force=(1.0, 2.0, 3.0),
        tip_moment=(0.1, 0.0),
        distributed=(0.0, 0.0, -4.0),
        contacts=(Contact(0.1, (1.0, 0.0, 0.0)), Contact(0.0, (0.0, 1.0, 0.0))),
        elongation=(0.02,),
        source="push.toml",
    )
    assert stated("elongation = 0.02").elongation == (0.02,)


REFUSED_LOADS = [
    ("", "is empty; write one, such as tip_force = [1.0, 0.0, 0.0]"),
    (
        "tip_force = [1.0, 0.0, 0.0]",
        "stiffness: missing, but tip_force bends the joint by it; write stiffness = 0.4 (N m^2, "
        "the bending stiffness)",
    ),
    (
        "stiffness = 1.0\ntip_force = [1.0, 0.0]",
        "tip_force: [1.0, 0.0] has 2 items; write the force at the tip in N along x, y and z of "
        "the base, such as tip_force = [1.0, 0.0, 0.0]",
    ),
    (
        "stiffness = 1.0\ncontacts = [{ at = 0.25, force = [1.0, 0.0, 0.0] }]",
        "contacts[0].at: 0.25 m lies beyond the tip; write metres from 0 at the base to 0.24 at "
        "the tip",
    ),
    (
        "stiffness = 1.0\ncontacts = [{ at = 0.1 }]",
        "contacts[0].force: missing; write force = [2.0, 0.0, 0.0] (the force in N along x, y and "
        "z of the base)",
    ),
    (
        "stiffness = 1.0\n[[contacts]]\nat = 0.1\nforce = [1.0, 0.0, 0.0]\nwhere = 1",
        "contacts[0].where: unknown key; the known ones are at, force",
    ),
    (
        "elongation = [0.1, 0.2]",
        "elongation: [0.1, 0.2] has 2 numbers; write one for each of the joint's sections, here 1",
    ),
    (
        "elongation = -0.8",
        "elongation[0]: -0.8 is too small; write the elongation of each section, share of its "
        "length, from -0.5 to 2, such as elongation = [0.02]",
    ),
    (
        "stiffness = 1.0\ntip_force = [1e9, 0.0, 0.0]",
        "tip_force[0]: 1000000000.0 is too large; write the force at the tip in N along x, y and z "
        "of the base, such as tip_force = [1.0, 0.0, 0.0]",
    ),
    ("tip_forc = [1.0, 0.0, 0.0]", "tip_forc: unknown key; did you mean tip_force?"),
    (
        "at = 0.1",
        "at: unknown key here; write it in [[contacts]]",
    ),
    (
        "stiffness =",
        "line 1 (the last): invalid value; write TOML, such as stiffness = 0.4",
    ),
]


@pytest.mark.parametrize(("text", "says"), REFUSED_LOADS)
def test_wrong_loads_are_refused_in_one_line(text, says):
    with pytest.raises(InputError) as error:
        stated(text)
    assert str(error.value) == f"push.toml: {says}"


def test_a_file_of_loads_that_is_missing_is_told(tmp_path):
    geometry = parse_joint(joint_text(), "x").geometry
    with pytest.raises(InputError) as error:
        read_loads(tmp_path / "push.toml", geometry)
    assert str(error.value).endswith(
        "push.toml: no such file; write one, such as tip_force = [1.0, 0.0, 0.0]"
    )
    with pytest.raises(InputError, match=r"is a directory; name a file of loads in it$"):
        read_loads(tmp_path, geometry)


@pytest.mark.parametrize("table", [LoadsTable, ContactTable, StatedLoadsTable])
def test_every_key_has_a_description_and_an_example_that_may_be_written(table):
    for name, field in table.model_fields.items():
        assert field.description
        (example,) = field.examples
        if not str(example).startswith("[["):
            required = {"force": [0.0, 0.0, 0.0], "at": 0.0} if table is ContactTable else {}
            table.model_validate({**required, name: example})
