import pytest

from ccgen.digits import at_least, at_most


@pytest.mark.parametrize("value", [0.0511913, 1.0e-9, 99.95, 0.1, 7.64e-07, 0.123, 1234567.0])
def test_a_bound_in_print_is_a_bound_and_close(value):
    assert value <= float(at_least(value)) * (1 + 1e-9) <= 1.02 * value
    assert value >= float(at_most(value)) * (1 - 1e-9) >= 0.98 * value


def test_three_digits_stay_as_they_are():
    assert at_least(2.5e-6) == at_most(2.5e-6) == "2.5e-06"
    assert at_least(0.0) == at_most(0.0) == "0"
