"""Write recordings of an invented finger whose sensors are not quite as finger.toml says.

    python record.py

bench.csv holds counts and, by a camera with its own clock, the angles of all segments; straight.csv
holds counts of the straight finger alone. Sensors have gains, zeros and noise of their own, lag by
30 ms behind the camera, and v1 is wired so that its count falls as it lengthens.
"""

from pathlib import Path

import numpy as np

SEGMENTS, RADIUS, STEP = 6, 0.012, 8.0e-6
SPANS = [(0, 3), (2, 5)]
NAMES = ["u0", "u1", "v0", "v1"]
GAIN = np.array([1.021, 0.978, 1.006, -0.991])
ZERO = np.array([2031.0, 2064.0, 2050.0, 2049.0])
NOISE, DELAY = 3.0e-5, 0.030
HERE = Path(__file__).parent

random = np.random.default_rng(7)


def shape(t):
    """Angles of the segments about both axes at some times, shape (N, 2 SEGMENTS), radians."""
    place = np.arange(SEGMENTS) / SEGMENTS
    t = t[:, None]
    u = 5.0 * np.sin(1.1 * t) * (1.0 - 0.5 * place) + 2.0 * np.sin(2.3 * t) * place
    v = 4.0 * np.sin(0.8 * t) * (0.4 + place) - 2.0 * np.sin(2.9 * t)
    return np.radians(np.concatenate([u, v], axis=1))


def counts(angles):
    """What the sensors count at these shapes, shape (N, 4)."""
    by_axis = angles.reshape(len(angles), 2, SEGMENTS)
    bends = [by_axis[:, axis, a : b + 1].sum(axis=1) for axis in (0, 1) for a, b in SPANS]
    noise = NOISE * random.standard_normal((len(angles), 4))
    return np.rint(ZERO + (GAIN * RADIUS * np.stack(bends, axis=1) + noise) / STEP)


def write(name, titles, *columns):
    """Write a table beside this file."""
    table = np.concatenate([np.atleast_2d(one.T).T for one in columns], axis=1)
    np.savetxt(HERE / name, table, "%.6g", ",", header=",".join(titles), comments="")


titles = [f"count_{name}" for name in NAMES]
angles = [f"{axis}{i}" for axis in "uv" for i in range(SEGMENTS)]
t = np.arange(0.0, 40.0, 0.02)
write("bench.csv", ["t", *angles, *titles], t, np.degrees(shape(t)), counts(shape(t - DELAY)))
t = np.arange(0.0, 5.0, 0.02)
write("straight.csv", ["t", *titles], t, counts(np.zeros((len(t), 2 * SEGMENTS))))
