"""Shapes of joints that bend far, from many markers or from a few of them, without any readings."""

import numpy as np
import pytest
from joint_files import joint_text

from ccgen.joint.file import parse_joint
from ccgen.kinematics.rotations import exponential
from ccgen.kinematics.stations import places, seen_from_base
from ccgen.recordings.reading import read_recordings
from ccgen.recordings.references import references

M, LENGTH, FINE, ROWS = 10, 0.3, 120, 50
AT = np.round(np.linspace(0.0, LENGTH, 14), 5)
"""Stations of the markers m0 to m13, metres."""
NOISE = 1e-4
TURN = exponential(np.array([np.pi / 2, 0.0, 0.0]))


def curvature():
    """Bends u and v of 120 pieces under moments of several waves, shape (rows, 2, pieces)."""
    random = np.random.default_rng(5)
    along = (np.arange(FINE) + 0.5) / FINE
    waves = np.cos(np.pi * np.outer(np.arange(5), along))
    sizes = np.radians([60.0, 60.0, 50.0, 40.0, 25.0])
    return (random.standard_normal((ROWS, 2, 5)) * sizes) @ waves / FINE


def written(folder, seen_markers, keys):
    """Write what markers show of such a joint, whose base lies along -y; return where all were."""
    state = np.concatenate([curvature().reshape(ROWS, -1), np.zeros((ROWS, 2))], axis=1)
    place = seen_from_base(state, places(AT, (FINE,), LENGTH / FINE)).position @ TURN.T
    random = np.random.default_rng(6)
    seen = place + NOISE * random.standard_normal(place.shape)
    names = [f"m{b}" for b in seen_markers]
    header = ",".join(f"{name}_{axis}" for name in names for axis in "xyz")
    values = seen[:, seen_markers].reshape(ROWS, -1)
    np.savetxt(folder / "run.csv", values, "%.6f", ",", header=header, comments="")
    stations = ", ".join(f"m{b} = {AT[b]}" for b in seen_markers)
    tables = (
        f'[[recordings]]\nfile = "run.csv"\nstations = {{ {stations} }}\n'
        f"position_noise = {NOISE}\n{keys}\n"
    )
    text = joint_text("fibre", M, 3, length=LENGTH, range_of_motion=40.0, radius=0.01,
                      tables=tables)  # fmt: skip
    joint = parse_joint(text, "fibre.toml", folder)
    return place, joint


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


@pytest.fixture(scope="module")
def dense(tmp_path_factory):
    """Where markers were, and the reference that all of them give with a chord as base."""
    folder = tmp_path_factory.mktemp("dense")
    place, joint = written(folder, list(range(14)), 'base = ["m0", "m1"]')
    return place, references(joint, read_recordings(joint))[0]


def test_many_markers_tell_bends_that_count_from_the_middle_of_the_chord(dense):
    _, it = dense
    start = AT[1] / 2
    borders = np.linspace(start, LENGTH, M + 1) * FINE / LENGTH
    bent = np.cumsum(np.pad(curvature(), ((0, 0), (0, 0), (1, 0))), axis=2)
    sums = np.stack([[np.interp(borders, np.arange(FINE + 1), b) for b in row] for row in bent])
    true = np.diff(sums, axis=2)
    found = it.state[:, : 2 * M].reshape(ROWS, 2, M)
    # A chord leaves open how the joint is turned about it, so sizes are compared.
    size, expected = np.hypot(*np.moveaxis(found, 1, 0)), np.hypot(*np.moveaxis(true, 1, 0))
    assert rms(size - expected) < np.radians(1.5)
    assert rms(expected) > np.radians(9.0)
    assert it.sighting.sights.start == pytest.approx(start, rel=1e-2)


def test_places_between_markers_are_told_in_the_recordings_frame(dense):
    place, it = dense
    apart = np.linalg.norm(it.sighting.positions(AT) - place, axis=2)
    assert rms(apart) < 4e-4


def test_an_estimate_that_bends_before_the_chord_does_is_off(dense):
    _, it = dense
    told = it.stations(it.state)
    assert list(told) == [f"m{b}" for b in range(1, 14)]
    # From the joint's base on, the same bends lead elsewhere than from the chord's middle on.
    assert 3e-4 < told["m13"].position_rms_m < AT[1]
    assert max(told["m6"].bend_rms_deg.values()) < 1.5


def test_few_markers_tell_where_the_others_were(tmp_path):
    some = [0, 2, 5, 8, 11, 13]
    place, joint = written(tmp_path, some, "")
    (it,) = references(joint, read_recordings(joint))
    apart = np.linalg.norm(it.sighting.positions(AT) - place, axis=2)
    others = np.setdiff1d(np.arange(14), some)
    assert rms(apart[:, others]) < 1.5e-3
    assert rms(apart[:, some]) < 5e-4
