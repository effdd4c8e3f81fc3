import numpy as np
import pytest
from scipy.integrate import solve_ivp

from ccgen.errors import ReachError
from ccgen.shapes.beam import (
    END_FORCE,
    LOAD_CASES,
    S_SHAPE,
    UNIFORM,
    bend,
    first_crossings,
    fold,
    follow,
)
from ccgen.shapes.elastica import NODES, QUADRATURE, LoadCase, load_row

# Dead end force: tip deflection, tip shortening, tip angle by elliptic integrals in 40 digits;
# the first lines agree with Mattiasson (1981).
END_FORCE_TABLE = {
    0.5: (0.162143575658, 0.0159189624708, 0.244533647133),
    1: (0.3017207738, 0.0564332362834, 0.461351949712),
    2: (0.493457480397, 0.160641720825, 0.781749831557),
    5: (0.713791523612, 0.387628360724, 1.21536811761),
    10: (0.81060902488, 0.554995597754, 1.4302855388),
    20: (0.868695898285, 0.683885567566, 1.5329349563),
}
# Uniform dead load: the same, and the base curvature.
UNIFORM_TABLE = {
    1: (0.12347140198335, 0.0087536046533648, 0.16511556050244, 0.49693339993072),
    5: (0.4959050446224, 0.15334282004574, 0.69700477753648, 2.2268925538121),
    10: (0.70019971551431, 0.3436462387614, 1.0526431171968, 3.7421911108716),
}
# End force with an opposing moment.
OPPOSED_TABLE = {
    (1, -0.5): (0.081753171458, 0.004036145308, -0.002009928773, 0.495963854692),
    (2, -1): (0.155175438173, 0.014812863306, -0.014593960427, 0.970374273389),
    (5, -2.5): (0.300900606626, 0.062219876955, -0.146393746855, 2.188900615223),
}


def under_load(case, loads):
    """States at each of the loads, which are raised from zero."""
    return first_crossings(follow(case), load_row(), np.asarray(loads, dtype=np.float64))


def equilibrium(force, uniform=0.0, moment=0.0):
    """The state under an end force, a uniform load and a tip moment, raised together from zero."""
    size = max(abs(force), abs(uniform), abs(moment)) or 1.0
    case = LoadCase("given loads", force / size, uniform / size, moment / size, limit=size)
    return under_load(case, [size if force or uniform or moment else 0.0])


def tip(state):
    """Deflection and shortening of the tip, shares of the length, and its angle."""
    angles = state.states[0, :NODES]
    return [np.sin(angles) @ QUADRATURE, (1 - np.cos(angles)) @ QUADRATURE, tip_angle(state)[0]]


def tip_angle(state):
    return state.angles([1.0])[..., 0]


def base_curvature(state):
    per_load = (np.cos(state.states[..., :NODES]) * state.case.density()) @ QUADRATURE
    return state.moment + state.load * per_load


@pytest.mark.parametrize("force", END_FORCE_TABLE)
def test_an_end_force_bends_as_elliptic_integrals_say(force):
    np.testing.assert_allclose(tip(equilibrium(force)), END_FORCE_TABLE[force], rtol=1e-10)


@pytest.mark.parametrize("uniform", UNIFORM_TABLE)
def test_a_uniform_load_bends_as_published(uniform):
    state = equilibrium(0, uniform)
    found = [*tip(state), base_curvature(state)[0]]
    np.testing.assert_allclose(found, UNIFORM_TABLE[uniform], rtol=1e-12)


@pytest.mark.parametrize(("force", "moment"), OPPOSED_TABLE)
def test_a_force_against_a_moment_bends_as_published(force, moment):
    state = equilibrium(force, 0, moment)
    found = [*tip(state), base_curvature(state)[0]]
    np.testing.assert_allclose(found, OPPOSED_TABLE[force, moment], rtol=1e-9)


@pytest.mark.parametrize("t", [-2.0, 0.1, 1.0, np.pi, 8.0])
def test_a_moment_alone_bends_into_a_circle(t):
    expected = [(1 - np.cos(t)) / t, 1 - np.sin(t) / t, t]
    np.testing.assert_allclose(tip(equilibrium(0, 0, t)), expected, rtol=1e-13, atol=1e-13)


def test_without_load_the_joint_is_straight():
    assert tip(equilibrium(0)) == [0, 0, 0]


def test_opposite_loads_bend_into_mirror_images():
    ahead, back = equilibrium(3, 2, -1), equilibrium(-3, -2, 1)
    positions = np.linspace(0, 1, 7)
    np.testing.assert_allclose(back.angles(positions), -ahead.angles(positions), atol=1e-14)


@pytest.mark.parametrize("case", [END_FORCE, S_SHAPE], ids=lambda case: case.name)
def test_every_state_conserves_the_energy_of_the_pendulum(case):
    # theta'^2 / 2 + F sin theta is the same at the base, where theta = 0, and at the tip.
    branch = follow(case)
    base = base_curvature(branch) ** 2 / 2
    at_tip = branch.moment**2 / 2 + branch.load * np.sin(tip_angle(branch))
    error = np.abs(base - at_tip) / (1 + base)
    assert np.max(error[branch.load < 50]) < 1e-12
    assert np.max(error) < 1e-9


@pytest.mark.parametrize("case", LOAD_CASES.values(), ids=LOAD_CASES)
def test_the_load_grows_along_the_whole_branch_to_its_limit(case):
    load = follow(case).load
    assert load[0] == 0
    assert np.all(np.diff(load) > 0)
    assert load[-2] < case.limit <= load[-1]


def test_the_s_shape_passes_its_known_points():
    states = under_load(S_SHAPE, [3.1968, 11.8526, 23.672, 44.6378])
    np.testing.assert_allclose(base_curvature(states), [1.0544, 3.511, 5.5237, 6.5026], rtol=3e-5)
    np.testing.assert_allclose(states.moment, [-2.083, -5.926, -4.352, 8.680], rtol=3e-4)


def test_the_base_curvature_of_the_s_shape_folds():
    found = fold(S_SHAPE)
    assert found is not None
    assert base_curvature(found) == pytest.approx(5.714, abs=5e-4)
    around = under_load(S_SHAPE, found.load + np.array([-0.5, -0.05, 0.05, 0.5]))
    assert np.all(base_curvature(around) < base_curvature(found))
    assert base_curvature(under_load(S_SHAPE, [44.6378]))[0] > base_curvature(found)


def test_the_other_cases_do_not_fold():
    assert fold(END_FORCE) is None
    assert fold(UNIFORM) is None


def test_the_tip_of_an_s_shape_stays_on_the_unbent_axis():
    states = bend(S_SHAPE, 48, np.radians(np.arange(9)))
    assert np.max(np.abs(np.sin(states.states[..., :NODES]) @ QUADRATURE)) < 1e-12


@pytest.mark.parametrize("case", LOAD_CASES.values(), ids=LOAD_CASES)
@pytest.mark.parametrize(("segments", "degrees"), [(12, 3), (48, 8)])
def test_a_shape_solves_the_differential_equation(case, segments, degrees):
    state = bend(case, segments, [np.radians(degrees)])
    load, moment = state.load[0], state.moment[0]

    def slope(s, z):
        return [z[1], -load * (case.force + case.uniform * (1 - s)) * np.cos(z[0]), np.sin(z[0])]

    ends = np.arange(segments + 1) / segments
    start = [0, base_curvature(state)[0], 0]
    found = solve_ivp(slope, (0, 1), start, "DOP853", ends, rtol=1e-13, atol=1e-14).y
    np.testing.assert_allclose(state.angles(ends)[0], found[0], atol=1e-10)
    assert found[1, -1] == pytest.approx(moment, abs=1e-9)
    assert found[2, -1] == pytest.approx(tip(state)[0], abs=1e-11)


@pytest.mark.parametrize("case", LOAD_CASES.values(), ids=LOAD_CASES)
def test_the_first_segment_bends_as_asked(case):
    targets = np.radians(np.linspace(0, 8, 17))
    np.testing.assert_allclose(bend(case, 20, targets).angles([0.05])[:, 0], targets, atol=1e-14)


def test_small_loads_bend_as_the_linear_beam():
    s = np.linspace(0, 1, 9)
    linear = {
        END_FORCE: s - s**2 / 2,
        UNIFORM: (1 - (1 - s) ** 3) / 6,
        S_SHAPE: s / 3 - s**2 / 2,
    }
    for case, expected in linear.items():
        state = under_load(case, [1e-4])
        np.testing.assert_allclose(state.angles(s)[0] / 1e-4, expected, atol=1e-8)
    assert under_load(S_SHAPE, [1e-4]).moment[0] / 1e-4 == pytest.approx(-2 / 3, rel=1e-8)


def test_a_joint_of_one_segment_bends_into_the_mirrored_s_shape():
    state = bend(S_SHAPE, 1, [0.2])
    assert state.load[0] < 0
    assert tip_angle(state)[0] == pytest.approx(0.2, abs=1e-14)


def test_just_below_a_peak_the_earlier_shape_is_found():
    # The angle of the first of 12 segments peaks near a load of 25.7, and rises again past 60.
    loads = np.linspace(25, 26.5, 301)
    angles = under_load(S_SHAPE, loads).angles([1 / 12])[:, 0]
    peak = int(np.argmax(angles))
    assert 0 < peak < len(loads) - 1
    state = bend(S_SHAPE, 12, [angles[peak]])
    assert state.load[0] == pytest.approx(loads[peak], abs=0.01)


def test_an_angle_out_of_reach_names_the_case_the_angle_and_the_reach():
    reach = np.degrees(np.max(follow(S_SHAPE).angles([1 / 12])))
    with pytest.raises(
        ReachError, match=r"load case s-shape: .* at 45 degrees .* reaches"
    ) as error:
        bend(S_SHAPE, 12, np.radians([1, 45]))
    named = float(str(error.value).split("reaches ")[1].split()[0])
    assert reach - 1e-4 < named < reach + 0.1
    assert bend(S_SHAPE, 12, [np.radians(named - 1e-4)]).load[0] > 0
    with pytest.raises(ReachError):
        bend(S_SHAPE, 12, [np.radians(named + 1e-4)])
