import numpy as np
import pytest
from joint_files import joint_text

from ccgen.errors import InputError, ReachError
from ccgen.joint import CASES
from ccgen.joint.file import parse_joint
from ccgen.shapes import (
    amplitudes,
    beyond_fold,
    fit_library,
    score_library,
    shape_library,
    single_shape,
)


def joint(range_of_motion_deg, cases=CASES):
    shapes = f"[shapes]\ncases = {list(cases)}\nfit_samples = 6\nscore_samples = 4"
    text = joint_text(range_of_motion=range_of_motion_deg, bits=32, precision=32, tables=shapes)
    return parse_joint(text, "shoulder.toml")


def test_amplitudes_run_from_one_step_above_the_lowest_to_the_highest():
    np.testing.assert_allclose(amplitudes(3.0, 6), [-2, -1, 0, 1, 2, 3])
    np.testing.assert_allclose(amplitudes(3.0, 3), [-1, 1, 3])
    assert 0 in amplitudes(0.1, 30)
    with pytest.raises(ValueError, match="0 samples give no shape"):
        amplitudes(3.0, 0)


def test_a_library_holds_case_after_case():
    library = shape_library(12, 0.05, 6, ("s-shape", "constant-curvature"))
    assert library.angles.shape == (12, 12)
    assert library.cases == ("s-shape",) * 6 + ("constant-curvature",) * 6
    np.testing.assert_array_equal(library.amplitudes, np.tile(amplitudes(0.05, 6), 2))
    np.testing.assert_allclose(library.angles[:, 0], library.amplitudes, atol=1e-14)
    assert library.range_of_motion == 0.05


def test_constant_curvature_bends_every_segment_alike():
    np.testing.assert_array_equal(single_shape(5, "constant-curvature", -0.1), np.full(5, -0.1))


@pytest.mark.parametrize("case", CASES)
def test_negative_amplitudes_give_mirror_images(case):
    np.testing.assert_array_equal(single_shape(16, case, -0.1), -single_shape(16, case, 0.1))


@pytest.mark.parametrize("case", CASES)
def test_amplitude_zero_is_the_straight_joint(case):
    np.testing.assert_array_equal(single_shape(16, case, 0.0), np.zeros(16))


def test_a_single_shape_is_the_library_s():
    library = shape_library(12, 0.05, 10)
    for row in (3, 13, 29, 39):
        alone = single_shape(12, library.cases[row], library.amplitudes[row])
        np.testing.assert_allclose(alone, library.angles[row], atol=1e-14)


def test_loads_from_the_side_bend_the_base_most():
    for case in ("end-force", "uniform"):
        assert np.all(np.diff(single_shape(12, case, 0.1)) < 0)


def test_one_sensor_over_the_joint_has_its_known_score():
    # 12 segments, 3 degrees: each segment is estimated by the mean over the joint (eq. 12).
    library = shape_library(12, np.radians(3), 10)
    error = np.abs(library.angles - library.angles.mean(axis=1, keepdims=True))
    assert 100 * error.mean() / library.range_of_motion == pytest.approx(17.465, abs=5e-4)


def test_every_joint_of_the_paper_is_reached_and_the_last_four_lie_beyond_the_fold():
    folded = []
    scores = []
    for segments in range(12, 49, 4):
        for degrees in range(1, 9):
            library = shape_library(segments, np.radians(degrees), 10)
            error = np.abs(library.angles - library.angles.mean(axis=1, keepdims=True))
            if beyond_fold(segments, np.radians(degrees)):
                folded.append((segments, degrees))
            else:
                scores.append(100 * error.mean() / library.range_of_motion)
    assert folded == [(40, 8), (44, 8), (48, 7), (48, 8)]
    # Known median over the 76 joints before the fold.
    assert np.median(scores) == pytest.approx(16.32, abs=0.01)


def test_a_joint_s_libraries_take_its_cases_and_samples():
    specified = joint(3, ("uniform", "end-force"))
    fit, score = fit_library(specified), score_library(specified)
    assert fit.cases == ("uniform",) * 6 + ("end-force",) * 6
    assert score.cases == ("uniform",) * 4 + ("end-force",) * 4
    np.testing.assert_allclose(fit.amplitudes[:6], amplitudes(np.radians(3), 6))


def test_a_range_of_motion_out_of_reach_names_file_and_key():
    pattern = (
        r"^shoulder\.toml: geometry\.range_of_motion: load case s-shape: a first segment at 40"
        r" degrees is out of reach; the first of 12 segments reaches 34\.48\d+ degrees"
    )
    with pytest.raises(ReachError, match=pattern):
        fit_library(joint(40))


def test_an_unknown_load_case_names_the_known_ones():
    with pytest.raises(InputError, match="unknown load case 'twist'; known: end-force, uniform"):
        single_shape(12, "twist", 0.1)
