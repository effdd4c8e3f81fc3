"""What recordings tell of a joint: its compliance, its shapes' second moment, and its sensors.

Few markers do not determine many segments, but many rows determine what all of them share. The
compliance of each segment, the sizes of smooth modes, gains and zeros are those of the greatest
posterior probability, shapes integrated out (empirical Bayes). Between the rounds references are
linearised anew and readings trusted less that lie far off, by the weights of Student's
distribution; the noise of each sensor follows from what is left.

Errors of a joint that moves slowly are alike from row to row, so the likelihood counts for as many
rows as are independent; standard deviations would otherwise be told far too small.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.likelihood import Evidence, Lengths, Likelihood, Parameters, Posterior
from ccgen.recordings.modes import Model

Floats = NDArray[np.float64]
Sight = Callable[[Floats], Evidence]
"""Linearises references about states of shape (N, p)."""

_SETTLED = 1e-7
"""Share of what a round gains below which a step ends it."""
_STEPS, _STEPS_ANEW = 150, 30
"""Of the quasi-Newton descent in a round, at most; and where most is known."""
_FLAT, _FLAT_ANEW = 1e-2, 0.1
"""Slope in standard deviations of what rows tell that counts as none; and where most is known."""
_FARTHEST = 6.0
"""Standard deviations of their priors within which parameters are sought."""
_NOWHERE = 1e30
_FREEDOM = 4.0
"""Degrees of freedom of Student's distribution: outliers of more than two deviations count less."""
_CLIPPED, _CLIPPED_MEAN = 2.5, 0.9775
"""Standard deviations beyond which a reading's square says no more of the noise, and the mean of
such squares where noise is normal (Huber, "Robust statistics", 1981, section 5.2). That of play,
which is bounded, is told as well."""
_NOISE_TURNS = 4
"""Times that trust and noise follow each other after each round."""
_SETTLING, _SETTLING_ANEW = (4, 2, 2), (2, 1)
"""Times that shapes and trust follow each other before each round, and where most is known."""
_STRONG = 3.0
"""Logarithm of how many times more probable a model must make the rows than the first one does
(strong evidence; Kass and Raftery, "Bayes factors", JASA 90, 1995)."""
_PRIOR_ROWS = 2.0
"""Independent rows for which uncorrelated modes count in the second moment."""
LEAST_NOISE = 1e-7
"""Metres."""


@dataclass(frozen=True, eq=False)
class Learned:
    """What recordings told.

    Attributes:
        model: how shapes come about.
        found: compliances, sizes, gains and zeros.
        covariance: of them, in their order.
        spread: their standard deviations.
        curvature: of what was minimised, by theta of `Likelihood`.
        noise: of each sensor, shape (n,), metres.
        posterior: shapes of the rows.
        trust: how far each reading was trusted, 0 to 1 and a little more; shape (N, n).
        independent: rows as which all of them count.
    """

    model: Model
    found: Parameters
    covariance: Floats
    spread: Parameters
    curvature: Floats
    noise: Floats
    posterior: Posterior
    trust: Floats
    independent: float

    @property
    def second_moment(self) -> Floats:
        """Second moment of the states, shape (p, p).

        The mean of x x' over the rows; in bending alike for both axes, which the same joint takes
        to either side. What so few independent rows may have missed is left to modes of the sizes
        that were found, not correlated.
        """
        own = self.posterior
        mean = (own.state.T @ own.state + own.covariance.sum(axis=0)) / len(own.state)
        T = self.model.transform(self.found.log_compliance, self.found.log_size)
        share = _PRIOR_ROWS / (_PRIOR_ROWS + self.independent)
        return np.asarray((1 - share) * mean + share * (T @ T.T))


def learn(
    sight: Sight,
    model: Model,
    seen: Lengths,
    independent: float,
    start: Floats,
    before: Learned | None = None,
) -> Learned:
    """Find what the rows of recordings have in common.

    Args:
        sight: linearises the references of the N rows.
        model: how shapes come about.
        seen: the readings; of no sensor where there are none.
        independent: number of independent rows among them.
        start: states to begin with, shape (N, p).
        before: what nearly the same rows told, to begin with; its curvature is kept.
    """
    share = min(1.0, independent / len(start))
    noise, state = seen.noise, start
    nothing = Likelihood(model, seen, sight(start), np.zeros_like(seen.length), share)
    theta = nothing.start()
    if before is not None:
        noise, theta = before.noise, nothing.theta(before.found)
    for turns in _SETTLING if before is None else _SETTLING_ANEW:
        for _ in range(turns):
            at = nothing.parameters(theta)
            weight = _weight(seen, at, state, noise)
            likelihood = replace(nothing, evidence=sight(state), weight=weight)
            state = likelihood.states_at(at)
        if before is None:
            curvature = likelihood.thinned.curvature(theta)
            theta = _descended(likelihood, theta, curvature, _STEPS, _FLAT)
        else:
            theta = _descended(likelihood, theta, before.curvature, _STEPS_ANEW, _FLAT_ANEW)
        posterior = likelihood.posterior(theta)
        state = posterior.state
        for _ in range(_NOISE_TURNS):
            noise = _noise(seen, likelihood.parameters(theta), posterior, noise)
    found = likelihood.parameters(theta)
    curvature = likelihood.thinned.curvature(theta) if before is None else before.curvature
    covariance = likelihood.covariance(curvature)
    return Learned(
        model=model,
        found=found,
        covariance=covariance,
        spread=likelihood.named(np.sqrt(np.diag(covariance))),
        curvature=curvature,
        noise=noise,
        posterior=posterior,
        trust=_trust(seen, found, posterior.state, noise),
        independent=independent,
    )


def most_probable(
    sight: Sight, models: Sequence[Model], seen: Lengths, independent: float, start: Floats
) -> Learned:
    """What rows have in common, by whichever model makes them the most probable.

    Models are held against each other where the first one has references linearised and noise
    found; another is taken where the rows speak for it strongly. Arguments as of `learn`.
    """
    learned = learn(sight, models[0], seen, independent, start)
    if len(models) == 1:
        return learned
    state = learned.posterior.state
    evidence = sight(state)
    weight = _weight(seen, learned.found, state, learned.noise)
    share = min(1.0, independent / len(start))
    improbable = []
    for model in models:
        likelihood = Likelihood(model, seen, evidence, weight, share)
        soft = learned.found.log_compliance + models[0].expected - model.expected
        theta = likelihood.theta(replace(learned.found, log_compliance=soft))
        curvature = likelihood.thinned.curvature(theta)
        theta = _descended(likelihood, theta, curvature, _STEPS, _FLAT)
        improbable.append(likelihood.improbability(theta))
    best = int(np.argmin(improbable))
    if improbable[0] - improbable[best] < _STRONG:
        return learned
    return learn(sight, models[best], seen, independent, state)


def shapes(
    sight: Sight,
    model: Model,
    seen: Lengths,
    at: Parameters,
    start: Floats,
    turns: int,
    doubt: Floats | None = None,
) -> Posterior:
    """Most probable shapes of rows under what was learned of their joint.

    Args:
        sight: linearises the references of the N rows.
        model: how shapes come about.
        seen: the readings; their noise is the one that was learned.
        at: what was learned; its zeros are those of the groups of `seen`.
        start: states to begin with, shape (N, p).
        turns: times that shapes and trust follow each other.
        doubt: covariance of what was learned, in its order, for what it adds to that of the shapes.
    """
    state = states(sight, model, seen, at, start, turns - 1)
    weight = _weight(seen, at, state, seen.noise)
    likelihood = Likelihood(model, seen, sight(state), weight, 1.0)
    posterior = likelihood.posterior_at(at)
    if doubt is None:
        return posterior
    return replace(posterior, doubt=likelihood.doubt(at, doubt))


def states(
    sight: Sight, model: Model, seen: Lengths, at: Parameters, start: Floats, turns: int
) -> Floats:
    """The means of such shapes alone, shape (N, p); arguments as of `shapes`."""
    state = start
    for _ in range(turns):
        weight = _weight(seen, at, state, seen.noise)
        state = Likelihood(model, seen, sight(state), weight, 1.0).states_at(at)
    return state


def _descended(
    likelihood: Likelihood, theta: Floats, curvature: Floats, steps: int, flat: float
) -> Floats:
    """Theta of the least value, from some theta on.

    Args:
        curvature: about its second derivative there: where that counts as 1, steps are few.
        steps: at most.
        flat: slope in those coordinates that counts as none.
    """
    from scipy.optimize import minimize

    # The value has a large constant, which the descent's tolerance must not be a share of.
    start, _ = likelihood.value_and_gradient(theta)

    def gained(at: Floats) -> tuple[float, Floats]:
        try:
            value, gradient = likelihood.value_and_gradient(at)
        except np.linalg.LinAlgError:  # so far away that rounding leaves nothing of the prior
            return _NOWHERE, at
        return value - start, gradient

    scale = np.linalg.inv(np.linalg.cholesky(curvature)).T

    def scaled(at: Floats) -> tuple[float, Floats]:
        value, gradient = gained(theta + scale @ at)
        return value, gradient @ scale

    options = {"maxiter": steps, "ftol": _SETTLED, "gtol": flat}
    begin = np.zeros_like(theta)
    moved = minimize(scaled, begin, jac=True, method="L-BFGS-B", options=options).x
    found: Floats = theta + scale @ moved
    if np.abs(found).max() <= _FARTHEST:
        return found
    bounds = [(-_FARTHEST, _FARTHEST)] * len(theta)
    begin = np.clip(found, -_FARTHEST, _FARTHEST)
    within = minimize(gained, begin, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    return np.asarray(within.x)


def independent_rows(signals: Floats) -> float:
    """Number of independent rows among N that follow each other.

    N over the integral of the autocorrelation of all signals together, up to where it first falls
    below zero (Geyer, "Practical Markov chain Monte Carlo", Statistical Science 7, 1992).

    Args:
        signals: shape (N, n); NaN where there is none, also in a whole column.
    """
    seen = signals[:, ~np.isnan(signals).all(axis=0)]
    if not seen.shape[1]:
        return 1.0
    known = np.where(np.isnan(seen), np.nanmean(seen, axis=0), seen)
    known = known - known.mean(axis=0)
    count = len(known)
    spectrum = np.square(np.abs(np.fft.rfft(known, 2 * count, axis=0))).sum(axis=1)
    correlation = np.fft.irfft(spectrum)[:count]
    if not correlation[0] > 0:
        return 1.0
    correlation = correlation / correlation[0]
    below = np.flatnonzero(correlation < 0)
    until = below[0] if below.size else count
    return float(count / (1.0 + 2.0 * correlation[1:until].sum()))


def _residuals(seen: Lengths, at: Parameters, state: Floats) -> Floats:
    """Readings less what the shapes let expect."""
    expected = at.gain * (state @ seen.matrix.T) + at.zero[seen.group]
    return np.where(~np.isnan(seen.length), seen.length - expected, 0.0)


def _trust(seen: Lengths, at: Parameters, state: Floats, noise: Floats) -> Floats:
    ratio = np.square(_residuals(seen, at, state) / noise)
    return np.asarray(~np.isnan(seen.length) * (_FREEDOM + 1.0) / (_FREEDOM + ratio))


def _weight(seen: Lengths, at: Parameters, state: Floats, noise: Floats) -> Floats:
    """By which each reading's square counts: 1 over its variance, less far off."""
    return np.asarray(_trust(seen, at, state, noise) / np.square(noise))


def _noise(seen: Lengths, at: Parameters, posterior: Posterior, noise: Floats) -> Floats:
    """Standard deviation of each sensor's readings, outliers trusted less, shape (n,)."""
    residual = _residuals(seen, at, posterior.state)
    variance = np.square(at.gain) * np.einsum(
        "ja,nab,jb->nj", seen.matrix, posterior.covariance, seen.matrix, optimize=True
    )
    there = np.maximum((~np.isnan(seen.length)).sum(axis=0), 1)
    square = (np.square(residual) + variance) * ~np.isnan(seen.length)
    mean = np.minimum(square, np.square(_CLIPPED * noise)).sum(axis=0) / (there * _CLIPPED_MEAN)
    return np.asarray(np.maximum(np.sqrt(mean), LEAST_NOISE))
