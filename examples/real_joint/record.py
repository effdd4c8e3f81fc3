"""Write recordings of an invented finger that is not quite as finger.toml says.

    python record.py

run1.csv and run2.csv hold counts and, by a camera, the places of four markers along the finger, in
its base frame. Its ends are stiffer than its middle, its sensors have gains and zeros of their own,
and it is bent, loaded and touched by hand. truth.csv holds the angles of run2.csv, which on a real
joint nobody knows.
"""

from pathlib import Path

import numpy as np

from ccgen.kinematics import chain

SEGMENTS, LENGTH, RADIUS, STEP = 12, 0.24, 0.03, 2.0e-5
SPANS = [(0, 3), (2, 6), (5, 9), (8, 11)]
NAMES = [f"{axis}{j}" for axis in "uv" for j in range(len(SPANS))]
MARKERS = {"m0": 3, "m1": 6, "m2": 9, "m3": 12}  # behind so many segments
COMPLIANCE = np.array([0.45, 0.6, 1, 1.1, 1.1, 1.1, 1.1, 1.1, 1.1, 1, 0.55, 0.4])
HERE = Path(__file__).parent

random = np.random.default_rng(11)
GAIN = random.normal(1.0, 0.01, len(NAMES))
ZERO = np.rint(random.uniform(2000, 2100, len(NAMES)))


def moment(t):
    """Bending moment of one axis at the segments, by actuation, weight and touch, shape (N, 12)."""
    place = (np.arange(SEGMENTS) + 0.5) / SEGMENTS

    def slow(size, count=5):
        rate, phase = random.uniform(0.2, 1.2, count), random.uniform(0, 2 * np.pi, count)
        return size * np.sin(np.outer(t, rate) + phase).mean(axis=1)[:, None] * np.sqrt(count)

    touched = 0.3 + 0.5 * random.uniform()
    touch = slow(1.8).clip(0.0) * (touched - place).clip(0.0)
    return slow(1.6) + slow(1.0) * (1 - place) + slow(0.7) * (1 - place) ** 2 + touch


def rest(t):
    """0 while the joint is straight at first, then 1."""
    return ((t - 2.0) / 1.5).clip(0.0, 1.0)[:, None]


def run(name, seconds):
    """Record one run; returns its angles, shape (N, 24), radians."""
    t = np.arange(0.0, seconds, 0.02)
    u, v = (np.radians(2.5) * COMPLIANCE * moment(t) * rest(t) for _ in range(2))
    u, v = (np.clip(one, -np.radians(7.9), np.radians(7.9)) for one in (u, v))
    poses = chain(u, v, LENGTH / SEGMENTS)
    columns, titles = [t], ["t"]
    for marker, behind in MARKERS.items():
        columns += list((poses[:, behind - 1, :3, 3] + random.normal(0, 2e-4, (len(t), 3))).T)
        titles += [f"{marker}_{one}" for one in "xyz"]
    bends = [one[:, a : b + 1].sum(axis=1) for one in (u, v) for a, b in SPANS]
    lengths = GAIN * RADIUS * np.stack(bends, axis=1) + random.normal(0, 5e-5, (len(t), len(NAMES)))
    columns += list(np.rint(ZERO + lengths / STEP).T)
    titles += [f"count_{one}" for one in NAMES]
    write(name, titles, columns)
    return t, np.concatenate([u, v], axis=1)


def write(name, titles, columns):
    """Write a table beside this file."""
    header = ",".join(titles)
    np.savetxt(HERE / name, np.stack(columns, axis=1), "%.6g", ",", header=header, comments="")


run("run1.csv", 60.0)
t, angles = run("run2.csv", 30.0)
titles = ["t", *(f"{axis}{i}" for axis in "uv" for i in range(SEGMENTS))]
write("truth.csv", titles, [t, *np.degrees(angles).T])
