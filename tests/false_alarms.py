"""Snapshots of sound and of faulty joints, at shapes that their checks have never seen."""

from dataclasses import dataclass

import numpy as np
from joint_files import joint_text

import ccgen
from ccgen.fixedpoint.consistency import NOBODY
from ccgen.sensing.readings import length_changes
from ccgen.shapes.loads.drawn import shapes_at
from ccgen.shapes.loads.draws import draw_loads

RATE = 1e-4
LOADS = """\
[loads]
samples = 300
stiffness = 0.4
stiffness_tolerance = 0.1
actuation = [-36.0, 36.0]
mass = 0.2
payload = [0.0, 0.25]
tip_force = [0.0, 4.0]
tip_moment = [0.0, 0.2]
contact = [0.0, 6.0]
contact_from = 0.05
"""
NOISE = "noise = 3.14e-5"
"""0.1 % of what a sensor along the whole joint reads at full range."""

ESTIMATOR = f'[estimator]\nmethod = "noise-aware"\nfalse_alarms = {RATE}\n'

STRINGS = (
    """\
name = "trunk"
[geometry]
segments = 12
length = 0.24
range_of_motion = 3.0
[sensors.transducer]
bits = 12
signed = false
zero = 1600
metres_per_count = 2.4e-5
noise = 1.0e-4
gain_tolerance = 0.01
"""
    + LOADS
    + "elongation = [0.0, 0.05]\n"
    + ESTIMATOR
    + 'axes = ["u", "v", "h"]\n'
)


def along(count, gain_tolerance=0.005, **changes):
    """As many sensors along each axis, overlapping."""
    transducer = f"{NOISE}\ngain_tolerance = {gain_tolerance}"
    return joint_text(count=count, transducer=transducer, tables=LOADS + ESTIMATOR, **changes)


def nine_strings():
    """Three strings at 120 degrees along the whole joint, three along each half."""
    return STRINGS + "".join(
        f'[[sensor]]\nname = "s{level}{k}"\nspan = {span}\nangle = {120.0 * k}\nradius = 0.03\n'
        for level, span in enumerate(([0, 11], [0, 6], [5, 11]))
        for k in range(3)
    )


JOINTS = {
    "six sensors an axis": along(6),
    "eight sensors an axis": along(8),
    "nine strings at 120 degrees, with elongation": nine_strings(),
    "six sensors an axis, precision 32": along(6, precision=32, bits=24, step=1e-7),
    "four sensors an axis, known gains": along(4, gain_tolerance=0.0),
}


@dataclass(frozen=True)
class Shares:
    """Of snapshots with a fault in one sensor, for the worse sign of the fault."""

    sensor: str
    seen: float
    named: float
    mistaken: float
    isolable: bool


def fitted(text):
    return ccgen.fit(ccgen.parse(text))


def unseen_lengths(joint, count, seed):
    """What ideal sensors read at shapes of other draws of the joint's loads, shape (count, n)."""
    geometry, random = joint.geometry, np.random.default_rng(seed)
    known = draw_loads(joint.loads, geometry.length, len(geometry.sections), 1).points
    found, total = [], 0
    while total < count:
        points = random.random((len(known), min(count, 4096)))
        shapes, valid = shapes_at(
            joint.loads, geometry.sections, geometry.length, geometry.range_of_motion, points
        )
        found.append(length_changes(joint, shapes.state)[valid])
        total += int(valid.sum())
    return np.concatenate(found)[:count]


def differences(joint, lengths, random):
    """Counts minus zeros of transducers with noise, and gains off within their tolerance."""
    noise, tolerance, step = (
        np.array([getattr(sensor, key) or 0.0 for sensor in joint.sensors])
        for key in ("noise", "gain_tolerance", "metres_per_count")
    )
    gains = 1.0 + tolerance * random.normal(size=lengths.shape)
    read = lengths * gains + noise * random.normal(size=lengths.shape)
    return np.rint(read / step).astype(np.int64)


def alarm_share(fit, lengths, snapshots, seed):
    """Share of snapshots of a sound joint in which some check alarms."""
    random, alarms = np.random.default_rng(seed), 0
    for part in np.array_split(np.arange(snapshots), -(-snapshots // 100_000)):
        counts = differences(fit.joint, lengths[part % len(lengths)], random)
        found = [group.verdicts(counts[:, group.own])[0] for group in fit.checks.groups]
        alarms += int(np.any(found, axis=0).sum())
    return alarms / snapshots


def fault_shares(fit, lengths, snapshots, seed):
    """For each sensor that is checked, what becomes of faults of the told size."""
    random = np.random.default_rng(seed)
    for group in fit.checks.groups:
        for j in range(group.sensors):
            told = fit.checks.sensors[group.first + j]
            if told.detectable_m is None:
                continue
            rows = []
            for sign in (-1.0, 1.0):
                faulty = lengths[np.arange(snapshots) % len(lengths)]
                faulty[:, group.first + j] += sign * told.detectable_m
                counts = differences(fit.joint, faulty, random)[:, group.own]
                alarm, named = group.verdicts(counts)
                other = (named != j) & (named != NOBODY)
                rows.append((alarm.mean(), np.mean(named == j), np.mean(other)))
            seen, right, wrong = np.array(rows).T
            yield Shares(told.sensor, seen.min(), right.min(), wrong.max(), told.isolable)
