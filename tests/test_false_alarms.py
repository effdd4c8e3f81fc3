"""False alarms and faults as told, at shapes that the check does not know.

`tests/benchmarks/false_alarms.py` holds more joints to it, in a million snapshots each. Here what
few shapes and snapshots leave to chance is allowed for: at a rate of 1e-4 some fifty alarms.
"""

import pytest
from false_alarms import JOINTS, RATE, alarm_share, fault_shares, fitted, unseen_lengths

QUICK = ("six sensors an axis", "nine strings at 120 degrees, with elongation")
SHAPES, SNAPSHOTS = 6_000, 500_000


@pytest.fixture(scope="module", params=QUICK)
def joint(request):
    fit = fitted(JOINTS[request.param])
    return fit, unseen_lengths(fit.joint, SHAPES, seed=1)


def test_false_alarms_come_at_the_stated_rate_at_other_shapes(joint):
    fit, lengths = joint
    assert 0.4 * RATE < alarm_share(fit, lengths, SNAPSHOTS, seed=2) < 2.5 * RATE


def test_faults_are_seen_and_named_as_told_at_other_shapes(joint):
    fit, lengths = joint
    told = list(fault_shares(fit, lengths, 20_000, seed=3))
    assert len(told) == len(fit.joint.sensors)
    for one in told:
        assert one.seen >= 0.98, one
        assert one.named >= 0.95 or not one.isolable, one
