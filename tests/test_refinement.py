"""Shapes in twice the precision: what rounding and the starting point leave as it is."""

import numpy as np
import pytest
from scipy.special import ellipkinc

from ccgen.errors import ReachError
from ccgen.shapes import beam
from ccgen.shapes.collocation import collocation, legendre
from ccgen.shapes.elastica import NODES
from ccgen.shapes.refinement import segment_angles

CASES = list(beam.LOAD_CASES.values())


def names(case):
    return case.name


@pytest.mark.parametrize("nodes", [1, 2, 7, NODES])
def test_the_quadrature_is_exact_for_polynomials(nodes):
    matrices = collocation(nodes)
    x = 2 * matrices.positions - 1
    values = legendre(x, 2 * nodes)
    integrals = (values * matrices.quadrature[:, None]).sum(axis=0).hi
    np.testing.assert_allclose(integrals[0], 1, rtol=1e-30)
    np.testing.assert_allclose(integrals[1:], 0, atol=1e-28)
    np.testing.assert_array_equal(matrices.positions.hi, np.sort(matrices.positions.hi))


def test_the_double_integral_of_one_is_a_parabola():
    matrices = collocation(NODES)
    s = matrices.positions
    twice = matrices.twice_integrated.sum(axis=1)
    np.testing.assert_allclose((twice - (s - s * s / 2.0)).hi, 0, atol=1e-29)


def test_interpolation_meets_the_nodes():
    matrices = collocation(NODES)
    rows = matrices.at(matrices.positions)
    np.testing.assert_allclose((rows - np.eye(NODES)).hi, 0, atol=1e-28)


@pytest.mark.parametrize("case", CASES, ids=names)
@pytest.mark.parametrize(("segments", "degrees"), [(1, 20.0), (12, 3.0), (12, 34.4), (48, 8.0)])
def test_where_the_refinement_starts_does_not_show_in_the_last_bit(case, segments, degrees):
    wanted = np.radians([degrees * share for share in (1e-9, 1e-4, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0)])
    states = beam.bend(case, segments, wanted).states
    angles = segment_angles(case, states, segments, wanted)
    random = np.random.default_rng(1)
    for size in (1e-15, 1e-12, 1e-9):
        moved = states * (1 + size * random.normal(size=states.shape))
        np.testing.assert_array_equal(segment_angles(case, moved, segments, wanted), angles)
    np.testing.assert_array_equal(angles[:, 0], wanted)


@pytest.mark.parametrize("distance", [1e-3, 1e-6, 1e-9])
def test_just_below_the_reach_too(distance):
    with pytest.raises(ReachError) as error:
        beam.bend(beam.S_SHAPE, 12, [np.radians(45)])
    named = float(str(error.value).split("reaches ")[1].split()[0])
    # The message tells six digits; between them and the reach lies the last start that works.
    wanted = np.radians([named - 1e-4 - distance])
    states = beam.bend(beam.S_SHAPE, 12, wanted).states
    again = states * (1 + 1e-12)
    np.testing.assert_array_equal(
        segment_angles(beam.S_SHAPE, states, 12, wanted),
        segment_angles(beam.S_SHAPE, again, 12, wanted),
    )


def test_the_straight_joint_is_straight():
    for case in CASES:
        states = beam.bend(case, 12, [0.0]).states
        assert not segment_angles(case, states, 12, np.zeros(1)).any()


def test_an_end_force_bends_as_elliptic_integrals_say_to_the_last_digits():
    # theta'^2 = 2 F (sin a - sin theta) with a at the tip: s is an elliptic integral of theta.
    wanted = np.radians([0.5, 3.0, 8.0])
    states = beam.bend(beam.END_FORCE, 12, wanted)
    angles = np.cumsum(segment_angles(beam.END_FORCE, states.states, 12, wanted), axis=1)
    square = (1 + np.sin(angles[:, -1])) / 2

    def along(theta):
        reach = np.arcsin(np.minimum(np.sqrt((1 + np.sin(theta)) / 2 / square[:, None]), 1))
        return ellipkinc(reach, square[:, None])

    share = (along(angles) - along(np.zeros((3, 1)))) / (along(angles[:, -1:]) - along(0.0))
    # Towards the tip the integral's upper end turns rounding into its square root.
    np.testing.assert_allclose(share[:, :6], np.tile(np.arange(1, 7) / 12, (3, 1)), rtol=1e-13)
