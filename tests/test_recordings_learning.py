"""What recordings tell of a joint's compliance and sensors, against joints that are known."""

from dataclasses import replace

import numpy as np
import pytest

from ccgen.recordings.learning import _descended, independent_rows, learn, most_probable
from ccgen.recordings.likelihood import Evidence, Lengths, Likelihood
from ccgen.recordings.modes import free_model, smooth_model

M = 12
ROM = np.radians(7.0)
RADIUS = 0.03
SPANS = ((0, 3), (2, 6), (5, 9), (8, 11))
GAIN = np.array([1.01, 0.98, 1.015, 0.99] * 2)
ZERO = 1e-3 * np.array([0.3, -0.2, 0.5, 0.1] * 2)
STIFF = np.array([0.45, 0.65, *[1.0] * 9, 0.4])


def tendons(elongates=False):
    """Change of length by u, v, h and twist for the paper's two sets."""
    matrix = np.zeros((8, 2 * M + 2))
    for axis in (0, 1):
        for j, (first, last) in enumerate(SPANS):
            matrix[4 * axis + j, M * axis + first : M * axis + last + 1] = RADIUS
    if elongates:
        matrix[:, 2 * M] = [(b - a + 1) * 0.0175 for a, b in SPANS] * 2
    return matrix


def bent(count=240, seed=0, compliance=STIFF):
    """Shapes of a joint with stiff ends under smooth moments, one after the other."""
    random = np.random.default_rng(seed)
    left = 1 - (np.arange(M) + 0.5) / M
    families = np.array([np.ones(M), left, left**2]) * [[1.0], [0.4], [0.2]]
    moments = random.standard_normal((count, 2, 3)) @ families * 0.5 * ROM
    states = np.zeros((count, 2 * M + 2))
    states[:, : 2 * M] = (moments * compliance).reshape(count, 2 * M)
    return states


def lengths(states, noise=5e-5, seed=1, groups=1):
    random = np.random.default_rng(seed)
    matrix = tendons()
    read = GAIN * (states @ matrix.T) + ZERO + noise * random.standard_normal((len(states), 8))
    return Lengths(
        read, matrix, np.zeros(len(states), dtype=np.intp), np.ones(8), np.full(8, 0.02),
        np.zeros((groups, 8)), np.full((groups, 8), 1e-3), np.full(8, 1e-4),
    )  # fmt: skip


def markers(states, std=1e-3, seed=2):
    """References that see sums of a few segments: as few as five markers do."""
    random = np.random.default_rng(seed)
    rows = np.zeros((10, 2 * M + 2))
    for axis in (0, 1):
        for k, end in enumerate((2, 5, 7, 9, 12)):
            # A marker's place off the straight axis: bends below it by their distances.
            rows[5 * axis + k, M * axis : M * axis + end] = 0.0175 * (end - np.arange(end) - 0.5)
    seen = states @ rows.T + std * random.standard_normal((len(states), 10))
    information = np.broadcast_to(rows.T @ rows / std**2, (len(states), 2 * M + 2, 2 * M + 2))
    evidence = Evidence(information, seen @ rows / std**2)
    return lambda _: evidence


def model(**options):
    return smooth_model((M,), ROM, 0.0, **options)


def test_the_gradient_is_that_of_the_value():
    states = bent(20)
    seen = lengths(states)
    weight = np.full((20, 8), 1e-4**-2.0)
    likelihood = Likelihood(model(), seen, markers(states)(states), weight, 0.3)
    random = np.random.default_rng(3)
    theta = likelihood.start() + 0.01 * random.standard_normal(len(likelihood.start()))
    value, gradient = likelihood.value_and_gradient(theta)
    assert np.isfinite(value)
    for i in range(0, len(theta), 3):
        step = np.zeros_like(theta)
        step[i] = 1e-5
        high, low = (likelihood.value_and_gradient(theta + s * step)[0] for s in (1, -1))
        assert gradient[i] == pytest.approx((high - low) / 2e-5, rel=1e-4, abs=1e-2)


@pytest.mark.parametrize("true", [0, 1])
def test_a_stated_profile_is_held_against_a_joint_that_is_alike_all_along(true):
    stiff = np.array([1.0, 1.0, 1.0, 1.0, 2.5, 2.5, 2.5, 1.0, 1.0, 1.0, 1.0, 1.0])
    models = [model(), model(profile=1 / stiff, tolerance=0.1)]
    soft = np.array([STIFF, 1 / stiff])[true]
    states = bent(compliance=soft)
    given = markers(states, 2e-4), models, lengths(states), 120, np.zeros_like(states)
    learned = most_probable(*given)
    assert learned.model is models[true]
    other = learn(given[0], models[1 - true], *given[2:])
    wrong, right = (np.std(one.posterior.state - states) for one in (other, learned))
    assert right < wrong
    told = np.exp(learned.model.expected + learned.found.log_compliance)
    np.testing.assert_allclose(
        told[2:10] / told[2:10].mean(), soft[2:10] / soft[2:10].mean(), rtol=0.25
    )


def test_doubt_is_how_shapes_follow_the_parameters():
    states = bent(6)
    seen = lengths(states)
    weight = np.full((6, 8), 1e-4**-2.0)
    likelihood = Likelihood(model(), seen, markers(states)(states), weight, 1.0)
    theta = 0.3 * np.random.default_rng(4).standard_normal(len(likelihood.start()))
    at = likelihood.parameters(theta)
    for i in range(0, len(theta), 5):
        step = np.zeros_like(theta)
        step[i] = 1e-5
        high, low = (likelihood.posterior(theta + s * step).state for s in (1, -1))
        slope = (high - low) / 2e-5
        moved = likelihood.spread(step / 1e-5)
        own = np.concatenate([np.ravel(part) for part in vars(moved).values()])
        found = likelihood.doubt(at, np.outer(own, own))
        expected = slope[:, :, None] * slope[:, None, :]
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-5 * np.abs(found).max())


def test_few_markers_and_counts_tell_where_the_joint_is_stiff():
    states = bent()
    learned = learn(markers(states, 2e-4), model(), lengths(states), 240, np.zeros_like(states))
    soft = np.exp(learned.found.log_compliance)
    soft /= soft[2:10].mean()
    np.testing.assert_allclose(soft[[0, 11]], STIFF[[0, 11]], rtol=0.35)
    error = learned.posterior.state - states
    assert np.degrees(np.sqrt(np.mean(error[:, : 2 * M] ** 2))) < 0.4
    assert np.degrees(np.sqrt(np.mean(states[:, : 2 * M] ** 2))) > 2


def evaluations(monkeypatch):
    """A list that grows with every evaluation of a likelihood."""
    taken = []
    value = Likelihood.value_and_gradient

    def counted(self, theta):
        taken.append(theta)
        return value(self, theta)

    monkeypatch.setattr(Likelihood, "value_and_gradient", counted)
    return taken


def test_most_of_the_rows_tell_from_all_of_them_on_what_they_tell_from_nothing(monkeypatch):
    states = bent()
    rest = states[48:]
    sight, seen = markers(rest, 2e-4), lengths(rest)
    whole = learn(markers(states, 2e-4), model(), lengths(states), 240, np.zeros_like(states))
    taken = evaluations(monkeypatch)
    anew = learn(sight, model(), seen, 192, np.zeros_like(rest))
    cold = len(taken)
    begun = learn(sight, model(), seen, 192, np.zeros_like(rest), before=whole)
    assert len(taken) - cold < cold / 4
    for name in ("gain", "zero", "log_compliance"):
        one, other = getattr(begun.found, name), getattr(anew.found, name)
        assert np.abs((one - other) / getattr(anew.spread, name)).max() < 0.5
    np.testing.assert_allclose(begun.noise, anew.noise, rtol=0.1)
    apart = begun.posterior.state - anew.posterior.state
    assert np.degrees(np.sqrt(np.mean(np.square(apart)))) < 0.05


def test_few_steps_lead_to_the_least_value(monkeypatch):
    states = bent(200)
    weight = np.full((200, 8), 1e-4**-2.0)
    likelihood = Likelihood(model(), lengths(states), markers(states, 2e-4)(states), weight, 0.3)
    found = likelihood.start()
    for _ in range(3):
        found = _descended(likelihood, found, likelihood.thinned.curvature(found), 150, 1e-2)
    slope = likelihood.value_and_gradient(found)[1]
    curvature = likelihood.curvature(found)
    left = np.sqrt(slope @ np.linalg.solve(curvature, slope))
    assert left < 0.1  # standard deviations of what the rows tell
    taken = evaluations(monkeypatch)
    spread = np.linalg.inv(np.linalg.cholesky(curvature)).T
    away = found + spread @ np.random.default_rng(6).standard_normal(len(found))
    again = _descended(likelihood, away, likelihood.thinned.curvature(away), 150, 1e-2)
    assert len(taken) - 2 * len(found) < 30
    assert np.linalg.norm(np.linalg.solve(spread, again - found)) < 0.1


def test_gains_are_not_sought_where_nobody_would_believe_them():
    states = bent()
    seen = lengths(states)
    wrong = np.concatenate([[1.3], np.ones(7)])
    seen = replace(seen, length=seen.length * wrong)
    learned = learn(markers(states, 2e-4), model(), seen, 240, np.zeros_like(states))
    assert learned.found.gain[0] == pytest.approx(1.0 + 6 * 0.02)
    assert np.abs(learned.found.gain - 1.0).max() < 6.001 * 0.02


@pytest.mark.parametrize("seed", range(4))
def test_gains_and_zeros_lie_within_what_is_told_of_them(seed):
    states = bent(seed=seed)
    seen = lengths(states, seed=seed + 10)
    learned = learn(markers(states, 2e-4, seed), model(), seen, 240, np.zeros_like(states))
    off = np.concatenate(
        [
            (learned.found.gain - GAIN) / learned.spread.gain,
            (learned.found.zero[0] - ZERO) / learned.spread.zero[0],
        ]
    )
    assert np.mean(np.abs(off) < 2) >= 0.75
    assert np.abs(off).max() < 4
    assert learned.spread.gain.max() < 0.02
    assert learned.spread.zero.max() < 5e-5


def test_fewer_independent_rows_tell_less():
    states = bent()
    few, many = (
        learn(markers(states, 2e-4), model(), lengths(states), count, np.zeros_like(states))
        for count in (12, 240)
    )
    assert (few.spread.gain > many.spread.gain).all()
    assert (few.spread.zero > many.spread.zero).all()


def test_readings_that_stick_are_trusted_less_and_do_not_move_gains():
    states = bent()
    seen = lengths(states)
    seen.length[40:60, 2] = seen.length[40, 2] + 0.02
    seen.length[100:110, 5] = np.nan
    learned = learn(markers(states, 2e-4), model(), seen, 240, np.zeros_like(states))
    clean = learn(markers(states, 2e-4), model(), lengths(states), 240, np.zeros_like(states))
    assert learned.trust[40:60, 2].max() < 0.1
    assert not learned.trust[100:110, 5].any()
    np.testing.assert_allclose(learned.found.gain, clean.found.gain, atol=5e-3)


def test_the_noise_of_each_sensor_is_found():
    states = bent()
    seen = lengths(states)
    loud = np.random.default_rng(7).standard_normal(len(states))
    seen.length[:, 3] += 4e-4 * loud
    noise = learn(markers(states, 2e-4), model(), seen, 240, np.zeros_like(states)).noise
    assert noise[3] == pytest.approx(4e-4, rel=0.4)
    assert np.delete(noise, 3).max() < 2e-4


def test_zeros_are_those_of_each_recording():
    states = bent()
    first, second = lengths(states), lengths(states, seed=5)
    group = np.repeat([0, 1], 120).astype(np.intp)
    shifted = np.where(group[:, None] == 1, second.length + 7e-4, first.length)
    seen = Lengths(
        shifted, first.matrix, group, first.gain, first.gain_std,
        np.zeros((2, 8)), np.full((2, 8), 1e-3), first.noise,
    )  # fmt: skip
    learned = learn(markers(states, 2e-4), model(), seen, 240, np.zeros_like(states))
    np.testing.assert_allclose(learned.found.zero[1] - learned.found.zero[0], 7e-4, atol=5e-5)


def test_dense_references_leave_no_prior_in_gains():
    states = bent()
    std = np.radians(0.05)
    p = states.shape[1]
    evidence = Evidence(np.broadcast_to(np.eye(p) / std**2, (len(states), p, p)), states / std**2)
    seen = lengths(states)
    wide = Lengths(
        seen.length, seen.matrix, seen.group, seen.gain, np.full(8, 0.3), seen.zero,
        np.full((1, 8), 0.1), seen.noise,
    )  # fmt: skip
    learned = learn(lambda _: evidence, free_model(states[:, :-1]), wide, 240, states)
    np.testing.assert_allclose(learned.found.gain, GAIN, atol=0.004)
    np.testing.assert_allclose(learned.found.zero[0], ZERO, atol=2e-5)


def test_the_second_moment_is_that_of_the_shapes():
    states = bent(600)
    learned = learn(markers(states, 2e-4), model(), lengths(states), 600, np.zeros_like(states))
    C = states.T @ states / len(states)
    found = learned.second_moment
    top = np.linalg.eigh(C)[1][:, -2:]
    assert np.trace(top.T @ found @ top) == pytest.approx(np.trace(top.T @ C @ top), rel=0.05)
    np.testing.assert_allclose(found, found.T, atol=1e-15)
    assert np.linalg.eigvalsh(found).min() > -1e-12


def test_what_few_rows_miss_is_left_to_uncorrelated_modes():
    states = bent(60)
    states[:, M : 2 * M] = states[:, :M]  # both axes always bend alike
    few, many = (
        learn(markers(states, 2e-4), model(), lengths(states), count, np.zeros_like(states))
        for count in (3, 60)
    )
    difference = np.concatenate([np.ones(M), -np.ones(M), [0.0, 0.0]])
    kept = [difference @ one.second_moment @ difference for one in (few, many)]
    assert kept[0] > 3 * kept[1] > 0


def test_rows_that_follow_each_other_slowly_are_few():
    random = np.random.default_rng(0)
    white = random.standard_normal((4000, 2))
    assert independent_rows(white) == pytest.approx(4000, rel=0.2)
    slow = np.zeros_like(white)
    for i in range(1, len(white)):
        slow[i] = 0.98 * slow[i - 1] + white[i]  # 99 rows for each independent one
    assert 15 < independent_rows(slow) < 110
    slow[::7] = np.nan
    assert 15 < independent_rows(slow) < 400
    assert independent_rows(np.zeros((50, 2))) == 1.0


@pytest.mark.parametrize("sections", [(12,), (6, 6), (1, 1), (3,)])
def test_models_hold_every_state_that_may_move(sections):
    found = smooth_model(sections, ROM, 0.1)
    m, count = sum(sections), len(sections)
    assert found.basis.shape[0] == len(found.compliance) == 2 * m + count + 1
    T = found.transform(np.zeros(m), np.zeros(found.sizes))
    assert np.linalg.norm(T, axis=1).all()
    assert np.sqrt(np.square(T[:m]).sum() / m) == pytest.approx(0.4 * ROM)
    still = smooth_model(sections, ROM, 0.0)
    assert not still.basis[2 * m : -1].any()
    softer = found.transform(np.log(np.r_[2.0, np.ones(m - 1)]), np.zeros(found.sizes))
    np.testing.assert_allclose(softer[[0, m]], 2 * T[[0, m]])


def test_a_signal_without_values_says_nothing_of_independent_rows():
    random = np.random.default_rng(0)
    signals = np.cumsum(random.standard_normal((500, 2)), axis=0)
    empty = np.full((500, 1), np.nan)
    assert independent_rows(np.hstack([signals, empty])) == independent_rows(signals)
    assert independent_rows(empty) == 1.0
