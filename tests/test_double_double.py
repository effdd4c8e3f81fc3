"""Double-double arithmetic against exact rationals."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ccgen.double_double import (
    DoubleDouble,
    OrthonormalBasis,
    concatenate,
    least_squares,
    matmul,
    reproducible_matmul,
    sine_and_versine,
    square_root,
)

UNIT = Fraction(1, 2**104)
"""Four rounding units of a double-double number."""

numbers = st.floats(-1e60, 1e60, allow_subnormal=False).filter(lambda x: x == 0 or abs(x) > 1e-60)


def exact(number):
    """Rational values of an array."""
    return np.vectorize(lambda hi, lo: Fraction(hi) + Fraction(lo), otypes=[object])(
        number.hi, number.lo
    )


def drawn(random, *shape):
    hi = random.normal(size=shape)
    return DoubleDouble(hi, np.spacing(hi) * random.uniform(-0.5, 0.5, shape))


def pair(hi, share):
    return DoubleDouble(np.array(hi), np.array(np.spacing(hi) * share))


def off(found, expected):
    """Largest error, as a share of the expected values."""
    return max(
        abs(Fraction(value) - want) / abs(want) if want else abs(Fraction(value))
        for value, want in zip(exact(found).ravel(), np.ravel(expected), strict=True)
    )


@given(x=numbers, y=numbers, share=st.floats(-0.5, 0.5))
def test_every_operation_is_good_to_a_hundred_bits(x, y, share):
    a, b = pair(x, share), pair(y, -share)
    p, q = exact(a).item(), exact(b).item()
    total = exact(a + b).item()
    assert abs(total - (p + q)) <= UNIT * abs(p + q)
    assert abs(exact(a - b).item() - (p - q)) <= UNIT * abs(p - q)
    assert off(a * b, [p * q]) <= UNIT
    if y:
        assert off(a / b, [p / q]) <= 8 * UNIT
    root = exact(square_root(a * a)).item()
    assert abs(root - abs(p)) <= 2 * UNIT * abs(p)


def test_arrays_and_numbers_stand_on_either_side():
    x = DoubleDouble.of(np.array([1.0, 3.0]))
    for found in (2 + x, x + 2, np.array([2.0, 2.0]) + x):
        assert exact(found).tolist() == [3, 5]
    assert exact(1 - x).tolist() == [0, -2]
    assert exact(np.array([2.0, 2.0]) * x).tolist() == [2, 6]
    third = exact(1 / x)[1]
    assert abs(third - Fraction(1, 3)) < Fraction(1, 10**32)


@pytest.mark.parametrize("count", [0, 1, 2, 7, 120])
def test_sums_keep_what_cancels(count):
    random = np.random.default_rng(count)
    x = drawn(random, count, 3)
    both = concatenate([x, -x, DoubleDouble.of(np.full((1, 3), 1e-25))])
    np.testing.assert_allclose(both.sum(axis=0).hi, 1e-25, rtol=1e-4)


@pytest.mark.parametrize("terms", [0, 1, 3, 120, 5000])
def test_a_product_of_matrices_is_good_to_the_last_bits(terms):
    random = np.random.default_rng(terms)
    a = drawn(random, 2, terms) * np.array([[1.0], [1e-20]])
    b = drawn(random, terms, 3)
    wanted = exact(a).dot(exact(b)) if terms else np.zeros((2, 3), object) + Fraction(0)
    largest = np.abs(exact(a)).max(axis=1, initial=Fraction(0))[:, None]
    for found, bits in ((exact(matmul(a, b)), 104), (reproducible_matmul(a.hi, b.hi), 51)):
        errors = np.vectorize(Fraction, otypes=[object])(found) - wanted
        assert (np.abs(errors) <= largest * (terms + 1) * Fraction(8, 2**bits)).all()


@pytest.mark.parametrize("product", [lambda a, b: matmul(a, b).hi, reproducible_matmul])
def test_a_product_does_not_depend_on_the_order_of_its_terms(product):
    random = np.random.default_rng(3)
    a, b = random.normal(size=(5, 700)), random.normal(size=(700, 4))
    order = random.permutation(700)
    np.testing.assert_array_equal(product(a, b), product(a[:, order], b[order]))
    stacked = np.stack([a, 2 * a])
    np.testing.assert_array_equal(product(stacked, b)[1], 2 * product(a, b))


def test_sine_and_cosine_agree_with_their_series():
    random = np.random.default_rng(4)
    angles = np.concatenate([random.uniform(-8, 8, 30), random.uniform(-1e-4, 1e-4, 9), [0.0, 8.0]])
    sines, versines = [], []
    for angle in map(Fraction, angles.tolist()):
        terms = [(-1) ** (k // 2) * angle**k / math.factorial(k) for k in range(80)]
        sines.append(sum(terms[1::2]))
        versines.append(-sum(terms[2::2]))
    sine, versine = sine_and_versine(DoubleDouble.of(angles))
    assert off(sine, sines) < 1e-29
    assert off(versine, versines) < 1e-29
    with pytest.raises(ValueError, match="beyond 8 radians"):
        sine_and_versine(DoubleDouble.of(np.array([8.1])))


def test_a_basis_is_orthonormal_and_spans_the_columns():
    random = np.random.default_rng(5)
    columns = (
        random.normal(size=(60, 5)) @ np.diag(np.logspace(0, -9, 5)) @ random.normal(size=(5, 5))
    )
    basis = OrthonormalBasis.of(columns)
    gram = matmul(basis.vectors.T, basis.vectors) - np.eye(5)
    assert np.abs(gram.hi).max() < 1e-30
    assert np.abs((matmul(columns, basis.back) - basis.vectors).hi).max() < 1e-20


def test_an_ill_conditioned_system_is_solved_to_the_last_digit():
    # Hilbert's matrix of order 9 has condition 5e11; its solutions here are whole numbers.
    whole = np.arange(1.0, 10.0)
    scale = float(math.lcm(*range(1, 18)))
    matrix = np.array([[scale / (i + j - 1) for i in range(1, 10)] for j in range(1, 10)])
    found = least_squares(matrix, matmul(matrix, whole[:, None]))
    np.testing.assert_array_equal(found[:, 0], whole)


def test_what_is_not_determined_is_small():
    random = np.random.default_rng(6)
    columns = random.normal(size=(40, 3))
    doubled = columns[:, [0, 1, 1, 2]]
    targets = random.normal(size=(40, 2))
    once, twice = least_squares(columns, targets), least_squares(doubled, targets)
    np.testing.assert_allclose(twice, once[[0, 1, 1, 2]] * [[1], [0.5], [0.5], [1]], rtol=1e-15)
    assert not least_squares(np.zeros((8, 3)), np.ones((8, 1))).any()


def test_fewer_rows_than_columns_are_met_by_the_smallest_solution():
    random = np.random.default_rng(7)
    columns, targets = random.normal(size=(3, 7)), random.normal(size=(3, 2))
    np.testing.assert_allclose(
        least_squares(columns, targets), np.linalg.pinv(columns) @ targets, rtol=0, atol=1e-13
    )
