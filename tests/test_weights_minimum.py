"""Weights at the minimum in twice the precision: the nearest doubles, whatever the data's shape."""

from fractions import Fraction

import numpy as np
import pytest

from ccgen.double_double import DoubleDouble, matmul, square_root
from ccgen.estimation import noise_aware, wam
from ccgen.estimation.minimum import minimum
from ccgen.estimation.soft_l1 import minimise
from ccgen.joint.layouts import heuristic
from ccgen.sensing.readings import exact_readings
from ccgen.shapes import shape_library

F_SCALE = 0.1


def rational_least_squares(readings, targets):
    """Weights by the normal equations in exact arithmetic, rounded; shape (m, n)."""
    a = [[Fraction(x) for x in row] for row in readings.tolist()]
    b = [[Fraction(x) for x in row] for row in targets.tolist()]
    n, m = len(a[0]), len(b[0])
    rows = [
        [sum(r[i] * r[j] for r in a) for j in range(n)]
        + [sum(r[i] * t[k] for r, t in zip(a, b, strict=True)) for k in range(m)]
        for i in range(n)
    ]
    for j in range(n):
        rows[j] = [x / rows[j][j] for x in rows[j]]
        for i in range(n):
            if i != j:
                rows[i] = [x - rows[i][j] * y for x, y in zip(rows[i], rows[j], strict=True)]
    return np.array([[float(row[n + k]) for row in rows] for k in range(m)])


@pytest.mark.parametrize("condition", [1e1, 1e6, 1e12])
def test_without_outliers_they_are_the_nearest_doubles_of_least_squares(condition):
    random = np.random.default_rng(int(np.log10(condition)))
    spread = np.diag(np.geomspace(1, 1 / condition, 4))
    readings = random.normal(size=(20, 4)) @ spread @ random.normal(size=(4, 4))
    targets = readings @ random.normal(size=(4, 3)) + 1e-6 * random.normal(size=(20, 3))
    # A scale so large leaves the loss quadratic to all digits.
    found = minimum(DoubleDouble.of(readings), targets, 1e12)
    np.testing.assert_array_equal(found, rational_least_squares(readings, targets))


@pytest.mark.parametrize("share", [0.0, 0.05, 0.3])
def test_the_gradient_of_the_loss_vanishes_to_twice_the_precision(share):
    random = np.random.default_rng(3)
    readings = random.normal(size=(200, 3))
    targets = readings @ random.normal(size=(3, 2)) + 0.01 * random.normal(size=(200, 2))
    targets[random.random(targets.shape) < share] += 20.0
    found = minimum(DoubleDouble.of(readings), targets, F_SCALE)
    residuals = matmul(readings, found.T) - targets
    pulls = residuals / square_root(1 + (residuals / F_SCALE) * (residuals / F_SCALE))
    gradient = np.abs(matmul(readings.T, pulls).hi)
    # Half a last digit of the weights, times the curvature, is left.
    assert gradient.max() < 4 * len(readings) * np.spacing(np.abs(found).max())


@pytest.mark.parametrize("sensors", [1, 2, 3, 5, 8])
def test_they_agree_with_the_fast_fit_of_populations(sensors):
    library = shape_library(12, np.radians(3), 30)
    spans = heuristic(12, sensors)
    read = exact_readings(library.angles, spans)
    fast = minimise(read.hi, library.angles, F_SCALE)
    found = minimum(read, library.angles, F_SCALE)
    np.testing.assert_allclose(found, fast, rtol=0, atol=1e-6 * np.abs(found).max())


def test_a_unit_of_the_angles_does_not_show():
    library = shape_library(12, np.radians(3), 30)
    spans = heuristic(12, 4)
    whole = wam(library, spans).matrix
    scaled = exact_readings(library.angles * 2.0**-40, spans)
    np.testing.assert_array_equal(
        minimum(scaled, library.angles * 2.0**-40, F_SCALE * 2.0**-40), whole
    )


def test_nothing_to_read_gives_no_weight():
    assert not minimum(DoubleDouble.of(np.zeros((8, 2))), np.ones((8, 5)), F_SCALE).any()


def test_noise_aware_weights_are_the_nearest_doubles():
    library = shape_library(6, np.radians(4), 8)
    spans = ((0, 2), (2, 5), (1, 4))
    noise = np.array([2.0**-9, 2.0**-10, 2.0**-8])
    roots = library.angles / np.sqrt(len(library.angles))
    lengths = [b - a + 1 for a, b in spans]
    sums = [[sum(map(Fraction, row[a : b + 1])) for a, b in spans] for row in roots.tolist()]
    system = [[x / p for x, p in zip(row, lengths, strict=True)] for row in sums]
    system += [[Fraction(x) if i == j else Fraction(0) for j in range(3)]
               for i, x in enumerate(noise.tolist())]  # fmt: skip
    wanted = np.vstack([roots, np.zeros((3, 6))])
    exact = rational_least_squares(np.array(system, dtype=object), wanted)
    np.testing.assert_array_equal(noise_aware(library, spans, noise).matrix, exact)
