"""False alarms: how often a sound joint's residuals exceed their thresholds, and the thresholds.

Shapes are not Gaussian: few of them, far out, give most of the alarms. But at each shape x the
residuals z = T (y(x) + e) are, so that the rate of alarms is the mean over the shapes of
P(some |z_j| > h_j). Each |z_j| alone has a closed form; all together, correlated as they are, they
are one rare event of a union, whose probability is

    P(union of A_k) = sum_k P(A_k) E[1 / N | A_k],    N = number of the A_k that hold,

with A_k the events "z_j of shape i beyond the upper (lower) threshold". The expectation is sampled
from normal distributions cut at the threshold, which keeps the error at a per cent of the rate
however small it is (Owen, Maximov and Chertkov 2019, "Importance sampling the union of rare
events"; Adler, Blanchet and Liu 2012).
"""

import numpy as np

from ccgen.estimation.consistency.sound import Floats, SoundReadings, chosen, even_points

_SAMPLES = 2**13
_BISECTIONS = 50
_ROUNDS = 8
_CLOSE = 0.005
"""Share of the rate at which thresholds are as right as sampling tells."""
_BEYOND = 10.0
"""Standard deviations of noise beyond which no rate is asked for."""


def thresholds(matrix: Floats, sound: SoundReadings, rate: float) -> Floats:
    """Thresholds at which the mean over the shapes of the probability of an alarm is the rate.

    Every sensor alone alarms equally often.

    Args:
        matrix: T of the residuals, shape (n, n), no row zero.
        sound: readings of a sound joint.
        rate: of snapshots, above 0 and below 1.

    Returns:
        Shape (n,), in the residuals' unit.
    """
    each = rate / sound.sensors
    for _ in range(_ROUNDS):
        found = _marginal_thresholds(matrix, sound, each)
        excess = alarm_rate(matrix, found, sound) / rate
        if abs(excess - 1.0) < _CLOSE:
            break
        each = min(each / excess, rate)
    return found


def alarm_rate(matrix: Floats, limits: Floats, sound: SoundReadings) -> float:
    """Mean over the shapes of the probability that some |z_j| exceeds its threshold.

    Args:
        matrix: T of the residuals, shape (n, n).
        limits: the thresholds, shape (n,).
        sound: readings of a sound joint.
    """
    from scipy.special import ndtr, ndtri

    mean, deviation = _moments(matrix, sound)
    # The distances of both thresholds from the mean: events by shape, sensor and side.
    distance = np.stack([limits - mean, limits + mean], axis=-1) / deviation[..., None]
    probability = sound.weight[:, None, None] * ndtr(-distance)
    total = float(probability.sum())
    if total <= 0.0:
        return 0.0
    points = even_points(_SAMPLES, sound.sensors + 2)
    event = chosen(probability.ravel(), points[:, 0])
    shape, sensor, side = np.unravel_index(event, probability.shape)
    beyond = -ndtri(points[:, 1] * ndtr(-distance[shape, sensor, side]))
    wanted = np.where(side == 0, 1.0, -1.0) * beyond * deviation[shape, sensor]
    variance = sound.variance[shape]
    free = ndtri(points[:, 2:]) * np.sqrt(variance)
    noise = _conditioned(free, variance, matrix[sensor], wanted)
    residuals = mean[shape] + noise @ matrix.T
    holds = np.abs(residuals) > limits
    holds[np.arange(_SAMPLES), sensor] = True  # whatever rounding says
    return total * float(np.mean(1.0 / holds.sum(axis=1)))


def sharing(matrix: Floats, sound: SoundReadings, rate: float) -> float:
    """How many shapes share the alarms: 1 / the sum of squares of their shares.

    Thresholds from few of them tell the rate no better than those few tell all that there are.

    Args:
        matrix: T of the residuals, shape (n, n), no row zero.
        sound: readings of a sound joint.
        rate: of snapshots, at which thresholds stand.
    """
    from scipy.special import ndtr

    mean, deviation = _moments(matrix, sound)
    limits = _marginal_thresholds(matrix, sound, rate / sound.sensors)
    beyond = ndtr((mean - limits) / deviation) + ndtr((-mean - limits) / deviation)
    alarms = sound.weight * beyond.sum(axis=1)
    return float(np.square(alarms.sum()) / np.square(alarms).sum())


def _conditioned(noise: Floats, variance: Floats, rows: Floats, wanted: Floats) -> Floats:
    """Noise e under the condition rows . e = wanted, from unconditioned noise (Matheron's rule)."""
    lacking = wanted - np.einsum("kj,kj->k", rows, noise)
    spread = np.einsum("kj,kj->k", np.square(rows), variance)
    conditioned: Floats = noise + variance * rows * (lacking / spread)[:, None]
    return conditioned


def _moments(matrix: Floats, sound: SoundReadings) -> tuple[Floats, Floats]:
    """Mean and standard deviation of each residual at each shape, shape (N, n)."""
    return sound.lengths @ matrix.T, np.sqrt(sound.variance @ np.square(matrix).T)


def _marginal_thresholds(matrix: Floats, sound: SoundReadings, rate: float) -> Floats:
    """Thresholds that each residual alone exceeds at the rate, shape (n,)."""
    from scipy.special import ndtr

    mean, deviation = _moments(matrix, sound)
    low = np.zeros(sound.sensors)
    high = np.abs(mean).max(axis=0) + _BEYOND * deviation.max(axis=0)
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        beyond = ndtr((mean - middle) / deviation) + ndtr((-mean - middle) / deviation)
        often = sound.weight @ beyond > rate
        low, high = np.where(often, middle, low), np.where(often, high, middle)
    return np.asarray(high)
