"""How probable a recording is for given compliances, sizes, gains and zeros, shapes integrated out.

With shapes x = T w, w ~ N(0, 1), references that say of x what a normal distribution of information
F and potential b says, and readings y = g H x + z + e, each row adds to the negative logarithm of
the likelihood

    1/2 log |A| - 1/2 c' A^-1 c + 1/2 r' W r,
    A = 1 + T' (F + H' g W g H) T,    c = T' (b + H' g W r),    r = y - z,

and A^-1 and w = A^-1 c are the covariance and the mean of its coordinates. (Rasmussen and Williams,
"Gaussian processes for machine learning", 2006, sections 2.1 and 5.4.)
"""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ccgen.recordings.modes import Model

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

SIZE_STD = 2.0
"""Standard deviation of the logarithm of a size."""
_CURVED = 100
"""Rows that tell how sharply the likelihood falls off."""
_STEP = 1e-3
"""Of theta, for differences of the gradient."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """What references say of N states, linearised about them.

    Attributes:
        information: J' W J, shape (N, p, p).
        potential: information times the state, plus the gradient there, shape (N, p).
    """

    information: Floats
    potential: Floats


@dataclass(frozen=True, eq=False)
class Lengths:
    """Readings of n sensors in N rows, and what is known of the sensors beforehand.

    Attributes:
        length: at nominal gain, shape (N, n), metres; NaN without a reading.
        matrix: change of length for a unit of state, shape (n, p), metres.
        group: which recording a row belongs to, from 0; each has zeros of its own; shape (N,).
        gain: about which gains are expected, shape (n,).
        gain_std: of that, shape (n,).
        zero: about which zeros are expected, shape (groups, n), metres.
        zero_std: of that, same shape.
        noise: to begin with, shape (n,), metres.
    """

    length: Floats
    matrix: Floats
    group: Indices
    gain: Floats
    gain_std: Floats
    zero: Floats
    zero_std: Floats
    noise: Floats


@dataclass(frozen=True, eq=False)
class Parameters:
    """What all rows have in common."""

    log_compliance: Floats
    log_size: Floats
    gain: Floats
    zero: Floats
    """Shape (groups, n), metres."""


@dataclass(frozen=True, eq=False)
class Posterior:
    """Shapes of N rows under given parameters.

    Attributes:
        state: means, shape (N, p).
        covariance: shape (N, p, p).
        doubt: what adds to it since the parameters are not certain, to first order, shape
            (N, p, p); None where it was not asked for.
    """

    state: Floats
    covariance: Floats
    doubt: Floats | None = None

    def with_doubt(self, share: float) -> Floats:
        """Covariance and a share of the doubt, shape (N, p, p)."""
        return self.covariance if self.doubt is None else self.covariance + share * self.doubt


@dataclass(frozen=True, eq=False)
class Likelihood:
    """The negative logarithm of likelihood and prior of parameters, as one vector theta.

    Theta counts from where the priors expect the parameters, in coordinates that they expect to be
    independent, of variance 1.

    Attributes:
        model: how shapes come about.
        seen: the readings.
        evidence: what references say.
        weight: by which a reading's square counts, 1 over its variance; 0 without one; (N, n).
        share: of the rows that count, where many tell the same.
    """

    model: Model
    seen: Lengths
    evidence: Evidence
    weight: Floats
    share: float

    def start(self) -> Floats:
        """Theta where priors expect it."""
        return np.zeros(len(self._prior_root))

    def parameters(self, theta: Floats) -> Parameters:
        """The parameters that theta stands for."""
        moved = self.spread(theta)
        return Parameters(
            moved.log_compliance,
            moved.log_size,
            self.seen.gain + moved.gain,
            self.seen.zero + moved.zero,
        )

    def theta(self, at: Parameters) -> Floats:
        """What `parameters` makes these of; what is certain beforehand stays where it is."""
        zero = (at.zero - self.seen.zero).reshape(-1)
        moved = np.concatenate([at.log_compliance, at.log_size, at.gain - self.seen.gain, zero])
        found: Floats = np.linalg.lstsq(self._prior_root, moved, rcond=None)[0]
        return found

    def spread(self, theta: Floats) -> Parameters:
        """By how much theta differs from 0, in parameters."""
        return self.named(self._prior_root @ theta)

    def named(self, values: Floats) -> Parameters:
        """A number for each parameter, in their order."""
        ends = np.cumsum([self.model.compliances, self.model.sizes, len(self.seen.gain)])
        soft, large, gain, zero = np.split(values, ends)
        return Parameters(soft, large, gain, zero.reshape(self.seen.zero.shape))

    def value_and_gradient(self, theta: Floats) -> tuple[float, Floats]:
        """Its value and its gradient by theta."""
        at = self.parameters(theta)
        model, H = self.model, self.seen.matrix
        T = model.transform(at.log_compliance, at.log_size)
        information, potential, residual = self._known(at)
        FT = information @ T
        c = potential @ T
        A = np.eye(T.shape[1]) + T.T @ FT
        triangle = np.asarray(np.linalg.cholesky(A), dtype=np.float64)
        covariance = _inverse(triangle)
        w = (covariance @ c[..., None])[..., 0]
        rows = (
            np.log(np.diagonal(triangle, axis1=1, axis2=2)).sum()
            - np.sum(c * w) / 2
            + np.sum(self.weight * np.square(residual)) / 2
        )
        second = w[:, :, None] * w[:, None, :] + covariance
        by_transform = (np.tensordot(FT, second, axes=([0, 2], [0, 2])) - potential.T @ w) * T
        by_state, by_coordinate = by_transform.sum(axis=1), by_transform.sum(axis=0)
        HT = H @ T
        expected = w @ HT.T
        squares = np.einsum("jk,nkl,jl->nj", HT, second, HT, optimize=True)
        by_gain = (self.weight * (at.gain * squares - residual * expected)).sum(axis=0)
        by_reading = self.weight * (at.gain * expected - residual)
        gradient = np.concatenate(
            [
                _gathered(model.compliance, by_state, model.compliances),
                _gathered(model.size, by_coordinate, model.sizes),
                by_gain,
                *(by_reading[self.seen.group == i].sum(axis=0) for i in self._groups),
            ]
        )
        value = self.share * float(rows) + float(theta @ theta) / 2
        return value, self.share * (gradient @ self._prior_root) + theta

    def posterior(self, theta: Floats) -> Posterior:
        """Shapes of all rows."""
        return self.posterior_at(self.parameters(theta))

    def posterior_at(self, at: Parameters) -> Posterior:
        """Shapes of all rows under parameters of one's own."""
        T, A, c = self._system(at)
        inverse = np.linalg.inv(A)
        w = (inverse @ c[..., None])[..., 0]
        return Posterior(w @ T.T, T @ inverse @ T.T)

    def states_at(self, at: Parameters) -> Floats:
        """Their means alone, which take less."""
        T, A, c = self._system(at)
        return np.asarray(np.linalg.solve(A, c[..., None])[..., 0] @ T.T)

    def _system(self, at: Parameters) -> tuple[Floats, Floats, Floats]:
        """T, A and c."""
        T = self.model.transform(at.log_compliance, at.log_size)
        information, potential, _ = self._known(at)
        return T, np.eye(T.shape[1]) + T.T @ information @ T, potential @ T

    def doubt(self, at: Parameters, of: Floats) -> Floats:
        """What not knowing parameters adds to the covariance of shapes, to first order, (N, p, p).

        With x = (1 / (T T') + F)^-1 b, x changes by (1 - P F) dT w + P dT' / T' (b - F x).

        Args:
            at: the parameters, of one group of rows.
            of: their covariance, in the order of `Parameters`.
        """
        model, H = self.model, self.seen.matrix
        T = model.transform(at.log_compliance, at.log_size)
        information, potential, residual = self._known(at)
        coordinates = T @ np.linalg.inv(np.eye(T.shape[1]) + T.T @ information @ T)
        P = coordinates @ T.T
        x = (P @ potential[..., None])[..., 0]
        left = potential - (information @ x[..., None])[..., 0]
        w = left @ T
        by_state = (np.eye(len(T)) - P @ information) * x[:, None] + P * left[:, None]
        by_coordinate = 2 * coordinates * w[:, None]
        by_length = P @ H.T
        off = self.weight * (residual - 2 * at.gain * (x @ H.T))
        by = np.concatenate(
            [
                by_state @ _members(model.compliance, model.compliances),
                by_coordinate @ _members(model.size, model.sizes),
                by_length * off[:, None],
                -by_length * (self.weight * at.gain)[:, None],
            ],
            axis=2,
        )
        return np.asarray(by @ of @ np.swapaxes(by, 1, 2))

    def covariance(self, curvature: Floats) -> Floats:
        """Of the parameters, in the order of `Parameters`, by the curvature where they are."""
        root = self._prior_root
        return np.asarray(root @ np.linalg.inv(curvature) @ root.T)

    @property
    def thinned(self) -> "Likelihood":
        """Some of the rows, each counting for several, which tell the curvature as well."""
        every = max(1, len(self.weight) // _CURVED)
        seen, known, some = self.seen, self.evidence, slice(None, None, every)
        return replace(
            self,
            seen=replace(seen, length=seen.length[some], group=seen.group[some]),
            evidence=Evidence(known.information[some], known.potential[some]),
            weight=self.weight[some],
            share=self.share * len(self.weight) / len(self.weight[some]),
        )

    def curvature(self, theta: Floats) -> Floats:
        """Second derivative by theta, by differences of the gradient, nowhere below the prior's."""
        rows = [
            self.value_and_gradient(theta + _STEP * one)[1]
            - self.value_and_gradient(theta - _STEP * one)[1]
            for one in np.eye(len(theta))
        ]
        whole = np.array(rows) / (2 * _STEP)
        values, vectors = np.linalg.eigh((whole + whole.T) / 2)
        return np.asarray((vectors * np.maximum(values, 1.0)) @ vectors.T)

    def improbability(self, theta: Floats) -> float:
        """Negative logarithm of how probable the recording is under the model, but for a constant.

        Parameters are integrated out about theta, where they are most probable (Laplace). A model
        that leaves them much room pays for it. (MacKay, "Bayesian interpolation", 1992.)
        """
        value, _ = self.value_and_gradient(theta)
        return value + float(np.linalg.slogdet(self.thinned.curvature(theta))[1]) / 2

    def _known(self, at: Parameters) -> tuple[Floats, Floats, Floats]:
        """Information and potential of references and readings, and the readings less zeros."""
        sensed = at.gain[:, None] * self.seen.matrix
        there = ~np.isnan(self.seen.length)
        residual = np.where(there, self.seen.length - at.zero[self.seen.group], 0.0)
        information = self.evidence.information + (sensed.T * self.weight[:, None, :]) @ sensed
        return information, self.evidence.potential + (self.weight * residual) @ sensed, residual

    @cached_property
    def _groups(self) -> range:
        return range(len(self.seen.zero))

    @cached_property
    def _prior_root(self) -> Floats:
        """R of the prior's covariance R R' of the parameters, in their order."""
        from scipy.linalg import block_diag

        std = np.concatenate(
            [
                np.full(self.model.sizes, SIZE_STD),
                self.seen.gain_std,
                self.seen.zero_std.reshape(-1),
            ]
        )
        return np.asarray(block_diag(self.model.compliance_root, np.diag(std)))


def _inverse(triangle: Floats) -> Floats:
    """Inverses of L L' of N lower triangles L, shape (N, k, k): half of the work of a general one.

    Row after row of the inverse triangle, for all N at once.
    """
    inverse = np.zeros_like(triangle)
    scale = 1 / np.diagonal(triangle, axis1=1, axis2=2)
    for i in range(triangle.shape[1]):
        above = triangle[:, i, None, :i] @ inverse[:, :i, :i]
        inverse[:, i, :i] = -above[:, 0] * scale[:, i, None]
        inverse[:, i, i] = scale[:, i]
    return np.asarray(np.swapaxes(inverse, 1, 2) @ inverse)


def _members(number: Indices, count: int) -> Floats:
    """Which values each parameter multiplies, shape (values, count)."""
    return np.asarray(number[:, None] == np.arange(count), dtype=np.float64)


def _gathered(number: Indices, values: Floats, count: int) -> Floats:
    """Sums of the values that each parameter multiplies, shape (count,)."""
    return np.bincount(number + 1, values, count + 1)[1:].astype(np.float64)
