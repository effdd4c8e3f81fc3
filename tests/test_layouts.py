import pytest

from ccgen.joint.layouts import end_to_end, heuristic, single, spans_for


def test_single_spans_the_joint():
    assert single(12) == ((0, 11),)


def test_end_to_end_gives_the_remainder_to_the_distal_sensors():
    assert end_to_end(12, 5) == ((0, 1), (2, 3), (4, 5), (6, 8), (9, 11))


def test_heuristic_grows_each_span_by_one_and_clips():
    assert heuristic(12, 5) == ((0, 2), (1, 4), (3, 6), (5, 9), (8, 11))
    assert heuristic(12, 3) == ((0, 4), (3, 8), (7, 11))


@pytest.mark.parametrize("segments", range(1, 20))
def test_end_to_end_covers_every_segment_once(segments):
    for sensors in range(1, segments + 1):
        covered = [i for a, b in end_to_end(segments, sensors) for i in range(a, b + 1)]
        assert covered == list(range(segments))


def test_a_count_that_does_not_fit_is_refused():
    with pytest.raises(ValueError, match="13 sensors do not fit end to end on 12 segments"):
        spans_for("heuristic", 12, 13)
