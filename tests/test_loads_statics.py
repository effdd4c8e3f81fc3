"""Statics of a joint under loads: against closed forms, published tables and other solvers."""

import casadi as ca
import numpy as np
import pytest
from test_beam import equilibrium

from ccgen.errors import ReachError
from ccgen.joint.loads import Contact, StatedLoads
from ccgen.shapes.loads import mesh as meshes
from ccgen.shapes.loads import planar, spatial
from ccgen.shapes.loads.continuation import LIMITED, LOST, REACHED, Limit, raise_loads
from ccgen.shapes.loads.equilibrium import DeadLoads, Rods
from ccgen.shapes.loads.stated import shape_under


def bend(segments=12, length=1.0, sections=None, **loads):
    """Segment angles u and v in radians of a joint with EI = 1 unless stated."""
    stated = StatedLoads(**{"stiffness": 1.0, "source": "loads.toml", **loads})
    shape = shape_under(stated, sections or (segments,), length)
    return shape.u[0], shape.v[0]


# Planar rod, backward shooting to 1e-11; length 1, EI 1, degrees.
REFERENCES = [
    (
        {"tip_force": (2.598076, 0.0, 1.5)},
        "7.18051 6.22957 5.36213 4.57491 3.86167 3.21447 2.62453 2.08274 1.57999 1.10732 0.65593"
        " 0.21724",
    ),
    (
        {"actuation": (0.0, 1.0), "distributed": (0.0, 0.0, -4.0)},
        "9.73300 9.49110 9.05953 8.49888 7.86794 7.21912 6.59601 6.03292 5.55562 5.18265 4.92684"
        " 4.79656",
    ),
    (
        {"contacts": (Contact(0.4, (5.0, 0.0, 0.0)),)},
        "8.19199 6.22465 4.29784 2.41240 0.59183 0 0 0 0 0 0 0",
    ),
    (
        {
            "stiffness_profile": tuple(1.5 - (np.arange(600) + 0.5) / 600),
            "tip_force": (2.0, 0.0, 0.0),
        },
        "5.45637 5.21121 4.94221 4.64892 4.32975 3.98139 3.59810 3.17045 2.68336 2.11260 1.41843"
        " 0.53296",
    ),
    (
        {"actuation": (0.0, 0.5), "tip_moment": (0.0, 1.0), "tip_force": (1.5, 0.0, -1.0)},
        "13.04068 12.37246 11.66534 10.95157 10.25842 9.60756 9.01529 8.49323 8.04921 7.68824"
        " 7.41332 7.22611",
    ),
]


@pytest.mark.parametrize(("loads", "degrees"), REFERENCES)
def test_planar_reference_shapes_are_met_to_a_ten_thousandth(loads, degrees):
    expected = np.radians([float(x) for x in degrees.split()])
    u, v = bend(**loads)
    assert np.abs(v - expected).max() < 1e-4 * expected.max()
    assert np.abs(u).max() < 1e-14


@pytest.mark.parametrize(("force", "uniform", "moment"), [(20, 0, 0), (0, 10, 0), (5, 0, -2.5)])
def test_the_collocated_beam_bends_alike(force, uniform, moment):
    """`ccgen.shapes.beam` solves theta'' = -(F + q (1 - s)) cos(theta), theta'(1) = M."""
    other = equilibrium(force, uniform, moment)
    expected = np.diff(other.angles(np.arange(13) / 12))
    _, v = bend(
        tip_force=(force, 0.0, 0.0), distributed=(uniform, 0.0, 0.0), tip_moment=(0.0, moment)
    )
    assert np.abs(v - expected).max() < 1e-4 * np.abs(expected).max()


def turned(vector, angle):
    x, y = vector[:2]
    c, s = np.cos(angle), np.sin(angle)
    return (c * x - s * y, s * x + c * y, *vector[2:])


def test_loads_that_turn_about_z_turn_the_shape():
    loads = {
        "tip_force": (3.0, -1.0, -0.7),
        "tip_moment": (0.2, 0.5),
        "distributed": (-1.0, 2.0, 0.5),
        "actuation": (0.6, -0.3),
    }
    contact = Contact(0.37, (-2.0, 4.0, 1.0))
    profile = {"stiffness_profile": (2.0, 1.0, 1.0, 2.5, 1.1)}
    u, v = bend(**loads, contacts=(contact,), **profile)
    # u turns about x and v about y: (u, v) is a vector across the axis like any other.
    for angle in (0.3, np.pi / 2, 2.9):
        moved = {name: turned(vector, angle) for name, vector in loads.items()}
        touched = Contact(0.37, turned(contact.force, angle))
        pair = np.array(bend(**moved, contacts=(touched,), **profile))
        assert np.abs(pair - np.array(turned((u, v), angle))).max() < 1e-11


@pytest.mark.parametrize(
    ("loads", "buckling"),
    [({"tip_force": (0.0, 0.0, -1.0)}, np.pi**2 / 4), ({"distributed": (0.0, 0.0, -1.0)}, 7.8373)],
)
def test_a_straight_joint_buckles_where_euler_and_greenhill_say(loads, buckling):
    (name, unit), *_ = loads.items()
    below = {name: tuple(0.999 * buckling * np.array(unit))}
    assert np.all(bend(**below) == np.zeros((2, 12)))
    with pytest.raises(ReachError) as error:
        bend(**{name: tuple(2.0 * buckling * np.array(unit))})
    assert str(error.value) == (
        "loads.toml: at 0.5 of these loads the joint buckles; lower them or raise stiffness"
    )


def test_an_imperfect_column_bends_on_beyond_its_buckling_load():
    u, v = bend(tip_force=(1e-3, 0.0, -1.15 * np.pi**2 / 4))
    # The elastica: tip at 60 degrees under 1.152 times the critical load.
    assert np.degrees(v.sum()) == pytest.approx(60.0, abs=0.6)
    assert np.all(u == 0.0)


def test_a_force_that_bends_a_segment_beyond_a_quarter_turn_is_refused():
    with pytest.raises(ReachError, match=r"of these loads segment 0 is bent by 90 degrees; lower"):
        bend(tip_force=(1e6, 0.0, 0.0))
    _, v = bend(tip_force=(1e6, 0.0, 1e6))
    assert np.degrees(v.sum()) == pytest.approx(45.0, abs=1e-3)


def test_actuation_bends_by_inverse_stiffness():
    u, v = bend(4, actuation=(0.3, -0.6), stiffness=7.0, stiffness_profile=(1.0, 2.0, 4.0, 4.0))
    share = np.array([4.0, 2.0, 1.0, 1.0]) / 8
    np.testing.assert_allclose(u, 0.3 * share, rtol=1e-12)
    np.testing.assert_allclose(v, -0.6 * share, rtol=1e-12)


def test_units_are_those_of_the_joint():
    """The shape depends on F L^2 / EI alone."""
    u, v = bend(tip_force=(1.0, 2.0, 0.5), distributed=(0.5, 0.0, 1.0))
    small = bend(
        length=0.1,
        stiffness=1e-3,
        tip_force=(0.1, 0.2, 0.05),
        distributed=(0.5, 0.0, 1.0),
    )
    np.testing.assert_allclose(small, (u, v), rtol=1e-10)


def test_an_elongated_joint_is_a_longer_one():
    """Weight and contacts stay with the material; the force per metre of it does not change."""
    loads = {"tip_force": (1.0, 0.0, 0.0), "actuation": (0.2, 0.1)}
    stretched = bend(
        **loads,
        elongation=(0.2,),
        distributed=(0.6, 0.0, 0.0),
        contacts=(Contact(0.5, (0.0, 2.0, 0.0)),),
    )
    longer = bend(
        **loads, length=1.2, distributed=(0.5, 0.0, 0.0), contacts=(Contact(0.6, (0.0, 2.0, 0.0)),)
    )
    np.testing.assert_allclose(stretched, longer, rtol=1e-9)


def test_sections_elongate_by_themselves():
    _, v = bend(sections=(1, 1), tip_moment=(0.0, 1.0), elongation=(0.0, 0.5))
    np.testing.assert_allclose(v, [0.5, 0.75], rtol=1e-12)


def test_a_contact_at_the_tip_is_a_tip_force_and_at_the_base_nothing():
    force = (1.0, -2.0, 0.3)
    np.testing.assert_allclose(
        bend(contacts=(Contact(1.0, force),)), bend(tip_force=force), rtol=1e-12
    )
    assert np.all(np.array(bend(contacts=(Contact(0.0, force),))) == 0.0)


@pytest.mark.parametrize("segments", [1, 2, 7, 64])
def test_the_whole_bend_does_not_depend_on_the_segments(segments):
    loads = {
        "tip_force": (2.0, -1.0, -0.5),
        "contacts": (Contact(0.33, (0.0, 3.0, 1.0)),),
        "stiffness_profile": (1.0, 0.5, 2.0),
    }
    fine, one = bend(60, **loads), bend(segments, **loads)
    np.testing.assert_allclose(np.sum(one, axis=1), np.sum(fine, axis=1), rtol=1e-4)


def random_joints(samples, elements=6, seed=0):
    random = np.random.default_rng(seed)
    rods = Rods(
        random.uniform(0.1, 0.3, (elements, samples)), random.uniform(0.1, 0.3, (elements, samples))
    )
    loads = [
        DeadLoads(
            random.normal(size=(2, samples)),
            random.normal(size=(elements, 3, samples)),
            random.normal(size=(elements, 3, samples)),
        )
        for _ in range(2)
    ]
    return random, rods, *loads


def energy_derivatives(lengths, compliances, factor, held, raised):
    """Gradient, its rate with the factor, and Hessian of the energy, by CasADi."""
    x, s = ca.SX.sym("x", 2 * len(lengths)), ca.SX.sym("s")
    frame, place, energy = ca.SX.eye(3), ca.SX.zeros(3), 0
    for e, (length, compliance) in enumerate(zip(lengths, compliances, strict=True)):
        u, v = x[2 * e], x[2 * e + 1]
        phi = ca.sqrt(u * u + v * v)
        a, b = ca.sin(phi) / phi, (1 - ca.cos(phi)) / phi**2
        place = place + frame @ (length * ca.vertcat(b * v, -b * u, a))
        cross = ca.skew(ca.vertcat(u, v, 0))
        frame = frame @ (ca.SX.eye(3) + a * cross + b * cross @ cross)
        moment, force, tangent = (h + s * r for h, r in zip(held[e], raised[e], strict=True))
        energy += phi**2 / 2 / compliance - ca.dot(ca.vertcat(u, v), moment)
        energy -= ca.dot(place, force) + ca.dot(frame[:, 2], tangent)
    hessian, gradient = ca.hessian(energy, x)
    rate = ca.jacobian(gradient, s)
    return lambda angles: [
        np.array(part)
        for part in ca.Function("d", [x, s], [gradient, rate, hessian])(angles, factor)
    ]


def test_newtons_step_is_that_of_the_exact_gradient_and_hessian():
    random, rods, held, raised = random_joints(8)
    angles, factor = 0.5 * random.normal(size=(6, 2, 8)), random.uniform(size=8)
    step = spatial.newton(angles, rods, held, raised, factor)
    for n in range(8):
        lists = [
            [(ld.moment[:, n], ld.force[e, :, n], ld.tangent[e, :, n]) for e in range(6)]
            for ld in (held, raised)
        ]
        derivatives = energy_derivatives(
            rods.lengths[:, n], rods.compliances[:, n], factor[n], *lists
        )
        gradient, rate, hessian = derivatives(angles[..., n].ravel())
        assert step.stable[n] == (np.linalg.eigvalsh(hessian).min() > 0)
        if step.stable[n]:
            expected = np.linalg.solve(hessian, -np.hstack([gradient, rate]))
            np.testing.assert_allclose(step.correction[..., n].ravel(), expected[:, 0], atol=1e-11)
            np.testing.assert_allclose(step.tangent[..., n].ravel(), expected[:, 1], atol=1e-11)
    assert 0 < step.stable.sum() < 8


def test_newtons_step_in_the_plane_is_that_in_space():
    random, rods, held, raised = random_joints(20)
    for loads in (held, raised):
        loads.moment[0] = loads.force[:, 1] = loads.tangent[:, 1] = 0.0
    angles, factor = np.zeros((6, 2, 20)), random.uniform(size=20)
    angles[:, 1] = 0.5 * random.normal(size=(6, 20))
    space = spatial.newton(angles, rods, held, raised, factor)
    plane = planar.newton(angles[:, 1:], rods, held, raised, factor)
    both = space.stable
    assert both.sum() > 3
    assert np.all(plane.stable[both])
    for name in ("correction", "tangent"):
        one, other = getattr(space, name)[..., both], getattr(plane, name)[..., both]
        np.testing.assert_allclose(one[:, 1:], other, rtol=1e-9, atol=1e-12)
        assert np.abs(one[:, 0]).max() < 1e-12


def test_loads_are_scaled_back_to_the_limit_and_no_further():
    forces = np.array([[0.5, 8.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, -20.0]])
    mesh = meshes.cut(12, 24, 1.0, np.ones((1, 3)))
    loads = meshes.at_tip(mesh, forces)
    limit = np.full(3, np.radians(5.0))
    raised = raise_loads(
        mesh.rods, meshes.no_loads(mesh), loads, Limit(mesh.starts, limit), mesh.straight
    )
    assert raised.outcome.tolist() == [REACHED, LIMITED, LOST]
    assert raised.factor[2] == pytest.approx(np.pi**2 / 80, rel=1e-3)
    _, v = meshes.segment_angles(mesh, raised.angles)
    assert np.degrees(v[1].max()) == pytest.approx(5.0, rel=2e-9)
    assert v[1].max() <= limit[1]
    scaled = bend(tip_force=tuple(raised.factor[1] * forces[:, 1]))[1]
    np.testing.assert_allclose(v[1], scaled, rtol=1e-3)


def test_a_limit_is_met_in_a_few_steps_of_newton():
    forces = np.array([[2.0, 5.0, 8.0], [0.0, 1.0, 0.0], [0.5, 0.0, -1.0]])
    mesh = meshes.cut(12, 24, 1.0, np.ones((1, 3)))
    steps = []

    def counted(angles, *others):
        steps.append(angles.shape[-1])
        return spatial.newton(angles, *others)

    limit = Limit(mesh.starts, np.full(3, np.radians(1.0)))
    loads = meshes.at_tip(mesh, forces)
    raised = raise_loads(mesh.rods, meshes.no_loads(mesh), loads, limit, mesh.straight, counted)
    assert raised.outcome.tolist() == [LIMITED] * 3
    assert sum(steps) <= 4 * 3
