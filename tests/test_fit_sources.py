"""Weights fitted to shapes of several sources, of sensors that stand anywhere."""

from dataclasses import replace

import numpy as np
import pytest
from joint_files import joint_text
from scipy.optimize import least_squares

from ccgen.estimation.fit import Task, fit_joint, fit_task, weights_of
from ccgen.estimation.soft_l1 import minimise
from ccgen.estimation.sources import (
    Source,
    ideal_readings,
    simulated_sources,
    source_weights,
    weighed_rows,
)
from ccgen.fixedpoint import fit
from ccgen.joint.file import parse_joint
from ccgen.sensing.noise import length_variance
from ccgen.sensing.readings import normaliser, response
from ccgen.shapes import Shapes

SPANS = ([0, 3], [0, 7], [0, 11])
STRINGS = "\n".join(
    f'[[sensor]]\nname = "s{angle}_{span[1]}"\nspan = {span}\nangle = {angle}.0\nradius = 0.03'
    for angle in (90, 210, 330)
    for span in SPANS
)
LOADS = "[loads]\nsamples = 40\nstiffness = 0.4\nactuation = [-20.0, 20.0]\ntip_force = [0.0, 2.0]"


def anywhere(tables="", elongation="elongation = [0.0, 0.04]", method="noise-aware"):
    """Nine strings at 120 degrees of a joint that may elongate."""
    return parse_joint(
        f"""
name = "round"
[geometry]
segments = 12
length = 0.21
range_of_motion = 5.0
{elongation}
[sensors.transducer]
bits = 13
metres_per_count = 2.4e-5
noise = 1e-4
[estimator]
method = "{method}"
{STRINGS}
{tables}
""",
        "round.toml",
    )


def paper(**text):
    return parse_joint(joint_text(transducer="noise = 2e-5", **text), "shoulder.toml")


def drawn(joint, count=60, seed=1):
    random = np.random.default_rng(seed)
    m, sections = joint.geometry.segments, len(joint.geometry.sections)
    smooth = np.cumsum(random.standard_normal((2, count, m)), axis=-1) / 100
    return Shapes(*smooth, random.uniform(0, 0.04, (count, sections)), ("drawn",) * count)


def test_a_source_counts_as_a_whole_however_long_it_is():
    joint = paper()
    short, long = drawn(joint, 20), drawn(joint, 200, seed=2)
    thrice = Source("a", Shapes(*(np.tile(x, (3, 1)) for x in (short.u, short.v, short.h)),
                                ("a",) * 60), 1.0)  # fmt: skip
    once = Source("a", short, 1.0)
    other = Source("b", long, 0.5)
    for method in ("wam", "noise-aware"):
        first = fit_task(Task(joint, [once, other]), method)["u"].matrix
        second = fit_task(Task(joint, [thrice, other]), method)["u"].matrix
        np.testing.assert_allclose(first, second, rtol=1e-8, atol=1e-10)
        heavier = fit_task(Task(joint, [once, replace(other, weight=5.0)]), method)["u"].matrix
        assert np.abs(heavier - first).max() > 1e-3


def test_weights_of_sources_multiply_the_loss():
    joint = paper()
    near, far = drawn(joint, 30), drawn(joint, 50, seed=3)
    far = Shapes(20 * far.u, 20 * far.v, far.h, far.source)  # residuals where the loss is linear
    found = fit_task(Task(joint, [Source("a", near, 1.0), Source("b", far, 0.3)]), "wam")[
        "v"
    ].matrix
    x = np.concatenate([near.v, far.v])
    y = np.concatenate([ideal_readings(joint, s)[:, joint.own("v")] for s in (near, far)])
    weight = np.repeat([1.0 / 30, 0.3 / 50], [30, 50])

    def loss(z):
        # SciPy weighs no samples, but a loss of its own may do so.
        root = np.sqrt(1 + z)
        return weight * np.array([2 * (root - 1), 1 / root, -0.5 / root**3])

    for i in (0, 7):
        best = least_squares(
            lambda w, i=i: y @ w - x[:, i], found[i] + 0.1, loss=loss, f_scale=0.1,
            xtol=1e-15, ftol=1e-15, gtol=1e-15,
        )  # fmt: skip
        np.testing.assert_allclose(found[i], best.x, rtol=1e-5, atol=1e-6)


def test_a_sample_of_weight_two_is_two_samples():
    random = np.random.default_rng(0)
    readings, targets = random.standard_normal((30, 3)), random.standard_normal((30, 2))
    root = np.sqrt(np.where(np.arange(30) < 10, 2.0, 1.0))
    twice = np.concatenate([readings, readings[:10]]), np.concatenate([targets, targets[:10]])
    np.testing.assert_allclose(
        minimise(readings * root[:, None], targets * root[:, None], 0.1 * root),
        minimise(*twice, 0.1),
        rtol=1e-9,
    )


def test_noise_aware_weights_of_coupled_sensors_are_the_wiener_estimator():
    joint = anywhere()
    sources = [Source("a", drawn(joint), 1.0), Source("b", drawn(joint, 90, 5), 0.2)]
    rows = weighed_rows(joint, sources)
    C, H = rows.second_moment, response(joint)
    R = np.diag(length_variance(joint))
    G = C @ H.T @ np.linalg.inv(H @ C @ H.T + R)
    for axis, weights in fit_task(Task(joint, sources)).items():
        found = weights.matrix / normaliser(joint)
        np.testing.assert_allclose(found, G[joint.rows(axis)], rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize(
    ("tables", "recorded", "expected"),
    [
        ("", False, {"cases": 1.0, "loads": 0.0, "recordings": 0.0}),
        (LOADS, False, {"cases": 0.0, "loads": 1.0, "recordings": 0.0}),
        (LOADS, True, {"cases": 0.0, "loads": 0.05, "recordings": 1.0}),
        (f"{LOADS}\n[shapes]\nweight = {{ cases = 0.5 }}", False,
         {"cases": 0.5, "loads": 1.0, "recordings": 0.0}),
    ],
)  # fmt: skip
def test_what_is_not_weighed_has_the_usual_weight(tables, recorded, expected):
    assert source_weights(paper(tables=tables), recorded) == expected


def test_loads_are_fitted_to_where_they_are_stated():
    joint = paper(tables=LOADS)
    found = fit(joint, "noise-aware")
    assert [(source.name, source.weight) for source in found.task.sources] == [
        ("loads", 1.0),
    ]
    held = {row.source: row.held_out for row in found.errors}
    assert held == {"cases": True, "loads": False, "other loads": True}
    only = fit_joint(joint, "noise-aware", found.shapes)
    np.testing.assert_array_equal(found.weights["u"].matrix, only["u"].matrix)


def test_an_axis_left_out_does_not_bend():
    planar = parse_joint(
        joint_text(tables=f'[estimator]\naxes = ["v"]\n{LOADS}', transducer="noise = 1e-5"),
        "p.toml",
    )
    found = fit(planar, "wam")
    assert set(found.weights) == {"v"}
    for source in found.told:
        assert not source.shapes.u.any()
        assert source.shapes.v.any()


@pytest.mark.parametrize("method", ["wam", "noise-aware", "equal"])
def test_weights_without_a_sensor_take_no_reading_of_it(method):
    joint = paper(count=4)
    task = Task(joint, simulated_sources(joint))
    whole = weights_of(task, "v", method)
    for j in range(4):
        lost = weights_of(task, "v", method, 4 + j)
        assert lost.spans == whole.spans
        assert not lost.matrix[:, j].any()
        assert np.delete(lost.matrix, j, axis=1).all(axis=1).any()


def test_the_last_sensor_of_an_axis_leaves_nothing():
    joint = paper(count=1)
    lost = weights_of(Task(joint, simulated_sources(joint)), "u", "wam", 0)
    assert not lost.matrix.any()
