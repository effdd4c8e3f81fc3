"""Other loads: shapes that neither the load cases nor a joint's own loads foresee."""

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.estimation import wam
from ccgen.joint.file import parse_joint
from ccgen.joint.layouts import heuristic
from ccgen.sensing.readings import readings
from ccgen.shapes import shape_library
from ccgen.shapes.loads.library import other_library
from ccgen.shapes.loads.other import KINDS, PER_KIND, other_shapes

ROM = np.radians(3.0)


@pytest.mark.parametrize(("segments", "degrees"), [(1, 30.0), (5, 10.0), (12, 3.0), (48, 8.0)])
def test_six_kinds_stand_in_equal_parts_and_fill_the_range(segments, degrees):
    other = other_shapes(segments, np.radians(degrees))
    assert other.angles.shape == (6 * PER_KIND, segments)
    largest = np.degrees(np.abs(other.angles).max(axis=1))
    for kind in KINDS:
        of_kind = largest[np.array(other.kinds) == kind]
        assert of_kind.size == PER_KIND
        assert of_kind.max() <= degrees
        assert of_kind.mean() == pytest.approx(degrees / 2, rel=0.2)


def test_the_draws_are_the_same_each_time():
    assert other_shapes(12, ROM).angles.tobytes() == other_shapes(12, ROM).angles.tobytes()


def test_each_kind_has_its_signature():
    other = other_shapes(12, ROM)
    of = {kind: other.angles[np.array(other.kinds) == kind] for kind in KINDS}
    # Two constant curvatures; nothing bends beyond the last contact.
    assert np.ptp(of["two chambers"].reshape(-1, 2, 6), axis=2).max() < 1e-15
    assert np.mean(np.abs(of["contact"][:, -1]) < 1e-12) > 0.8
    signs = np.sign(of["two contacts"][:, 0]) * np.sign(of["two contacts"].sum(axis=1))
    assert -1 in signs
    # Without a contact the bend goes on to the tip.
    assert np.abs(of["tapered stiffness"][:, -1]).min() > 0.0


def test_weights_fitted_to_the_cases_miss_each_kind_as_was_measured_elsewhere():
    """Errors in % of ROM of another solver's draws, 3 overlapping sensors, 12 segments."""
    measured = dict(zip(KINDS, (0.27, 0.47, 2.7, 6.1, 0.47, 18.0), strict=True))
    weights = wam(shape_library(12, ROM, 30), heuristic(12, 3))
    other = other_shapes(12, ROM)
    errors = np.abs(weights.estimate(readings(other.angles, weights.spans)) - other.angles)
    percent = 100 * errors.mean(axis=1) / ROM
    for kind, expected in measured.items():
        mean = percent[np.array(other.kinds) == kind].mean()
        assert expected / 2 < mean < 2 * expected, kind
    assert 2.0 < percent.mean() < 9.0


def test_a_joint_meets_two_shapes_of_a_kind_at_once():
    rows = other_library(parse_joint(joint_text(), "finger.toml"))
    other = other_shapes(12, ROM)
    np.testing.assert_array_equal(rows.u, other.angles)
    assert sorted(map(tuple, rows.v)) == sorted(map(tuple, rows.u))
    assert not np.any(np.all(rows.u == rows.v, axis=1))
    chambers = np.array(other.kinds) == "two chambers"
    assert np.ptp(rows.v[chambers].reshape(-1, 2, 6), axis=2).max() < 1e-15
    assert set(rows.source) == {"other loads"}
    assert np.all(rows.h == 0.0)
