"""Each single sensor lost: the integer fallback errs on the shapes by what `fit` tells."""

from pathlib import Path

import numpy as np
import pytest
from false_alarms import JOINTS as NOISY
from false_alarms import differences
from test_sensors_anywhere import nine, pairs, planar, raw

import ccgen
from ccgen.estimation.errors import tips
from ccgen.sensing.readings import length_changes

EXAMPLES = Path(__file__).parent.parent / "examples"


def noisy(text, noise):
    return text.replace("[sensors.transducer]", f"[sensors.transducer]\nnoise = {noise}")


JOINTS = {
    **{name: (EXAMPLES / f"{name}.toml").read_text() for name in ("shoulder", "wrist", "spine")},
    "nine, precision 16": nine(16),
    "nine, precision 32": nine(32),
    "nine strings with loads": NOISY["nine strings at 120 degrees, with elongation"],
    "nine, precision 32, noise": noisy(nine(32), 1e-5),
    "pairs": pairs(),
    "pairs, noise": noisy(pairs(), 4e-5),
    "planar, noise": noisy(planar(), 4e-5),
    "raw, noise": noisy(raw(), 4e-5),
}
ROWS = 4_000


@pytest.mark.parametrize("name", JOINTS)
def test_the_error_without_a_sensor_is_what_fit_told(name):
    fit = ccgen.fit(ccgen.parse(JOINTS[name]))
    joint, model = fit.joint, fit.guarded.model
    rows = np.resize(np.arange(len(fit.stated.shapes)), ROWS)
    state = fit.stated.shapes.state[rows]
    read = differences(joint, length_changes(joint, state), np.random.default_rng(1))
    for j, told in enumerate(fit.without):
        absent = np.zeros(read.shape, bool)
        absent[:, j] = True
        values = model.split(fit.guarded.estimate(read + model.readings.zero, absent))
        estimate = np.zeros_like(state)
        for axis, steps in values.items():
            estimate[:, joint.rows(axis)] = model.axis(axis).radians(steps)
        for axis, expected in told.rms_deg.items():
            if expected is None:
                assert (values[axis] == -(2 ** (joint.precision - 1))).all()
                continue
            part = joint.rows(axis)
            error = np.degrees(np.sqrt(np.mean(np.square(estimate[:, part] - state[:, part]))))
            assert error == pytest.approx(expected, rel=0.1), (told.sensor, axis)
        if told.elongation_rms_percent is not None:
            part = joint.rows("h")
            error = 100.0 * np.sqrt(np.mean(np.square(estimate[:, part] - state[:, part])))
            assert error == pytest.approx(told.elongation_rms_percent, rel=0.1), told.sensor
        # Counts of straight axes are exact where nothing is noisy, which these figures are not.
        if not all(sensor.noise for sensor in joint.sensors):
            continue
        for axis, expected in told.deviations.items():
            part, step = joint.rows(axis), 2.0 ** -model.axis(axis).fraction_bits
            each = np.sqrt(np.mean(np.square(estimate[:, part] - state[:, part]), axis=0))
            assert each == pytest.approx(expected, rel=0.1, abs=step), (told.sensor, axis)
        if told.tip_rms_m is not None:
            off = np.linalg.norm(tips(joint, estimate) - tips(joint, state), axis=1)
            tip = np.sqrt(np.mean(np.square(off)))
            assert tip == pytest.approx(told.tip_rms_m, rel=0.1), told.sensor
