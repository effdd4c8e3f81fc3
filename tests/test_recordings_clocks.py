"""Readings laid on another clock: what lies between rows, across cuts, and of their noise."""

import numpy as np
import pytest

from ccgen.recordings.clocks import averaged, estimated_delay, sampled, white_noise

T = np.arange(400) * 0.01
SWING = np.sin(2.0 * T)
CUT = SWING + np.where(T >= 2.0, 1.0, 0.0)


def at(values, shift, stands_for=None):
    return sampled(T, values[:, None], T + shift, stands_for)[:, 0]


def test_values_between_rows_are_on_the_line_between_them():
    np.testing.assert_allclose(at(SWING, 0.004)[:-1], np.sin(2.0 * (T[:-1] + 0.004)), atol=1e-4)
    assert np.isnan(at(SWING, 0.004)[-1])


def test_nothing_lies_between_rows_where_a_recording_was_cut():
    found = at(CUT, 0.004)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(found)), [199, 399])


def test_readings_that_lag_over_a_cut_are_those_of_another_time():
    found = at(CUT, 0.025, T)
    # 1.975 lies before the cut as its reading does; the last times have no reading.
    np.testing.assert_array_equal(
        np.flatnonzero(np.isnan(found)), [197, 198, 199, 398 - 1, 398, 399]
    )


def test_quick_motion_is_no_cut():
    quick = np.where(T < 2.0, 0.0, 3.0 * np.square(T - 2.0))
    noise = 1e-3 * np.random.default_rng(0).standard_normal(len(T))
    assert np.isfinite(at(quick + noise, 0.004)[:-1]).all()
    still = np.zeros(len(T))
    assert np.isfinite(at(still, 0.004)[:-1]).all()


def test_a_mean_of_two_rows_keeps_part_of_their_noise():
    noise = np.random.default_rng(1).standard_normal((4000, 1))
    t = np.arange(4000.0)
    for shift in (0.5, 0.2):
        kept = averaged(t, t + shift)
        found = sampled(t, noise, t + shift)[:-1]
        assert np.var(found) == pytest.approx(kept, rel=0.1)
    assert averaged(t, t) == 1.0
    assert white_noise(noise)[0] == pytest.approx(1.0, rel=0.1)


def test_a_delay_that_is_nearly_known_is_found_as_one_that_is_not():
    lagging = np.sin(2.0 * (T - 0.073))[:, None]
    anywhere = estimated_delay(T, SWING[:, None], T, lagging)
    near = estimated_delay(T, SWING[:, None], T, lagging, near=0.05)
    assert anywhere.seconds == pytest.approx(0.073, abs=2e-3)
    assert near == anywhere
