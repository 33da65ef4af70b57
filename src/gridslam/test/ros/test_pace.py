"""When changes of the map are told: at most once a period, none forgotten."""

import numpy as np
import pytest
from gridslam_ros.volume.pace import Pace
from gridslam_ros.volume.parameters import parameters_of
from hypothesis import given
from hypothesis import strategies as st

from gridslam import ParameterError


def told_at(pace, changes):
    """The stamps at which a change was told; changes: rows (stamp, whether the map has changed)."""
    told = []
    for stamp_s, has_changed in changes:
        if has_changed:
            pace.note()
        if pace.is_due(stamp_s):
            pace.tell(stamp_s)
            told.append(stamp_s)
    return told


def test_a_period_of_the_clouds_own_is_not_doubled_by_rounding():
    stamps = 100.0 + 0.2 * np.arange(1, 50)
    assert told_at(Pace(0.2), [(stamp_s, True) for stamp_s in stamps]) == stamps.tolist()


def test_a_change_that_came_too_early_waits_for_a_later_cloud():
    clouds = [(10.0, True), (10.4, True), (10.8, False), (11.0, False), (11.4, False)]
    assert told_at(Pace(1.0), clouds) == [10.0, 11.0]


def test_without_a_cloud_all_is_told_at_once():
    pace = Pace(1.0, has_changed=True)
    assert told_at(pace, [(0.0, False), (0.0, True), (0.0, False)]) == [0.0, 0.0]


def test_after_the_clock_jumped_back_the_next_change_is_told():
    pace = Pace(1.0)
    assert told_at(pace, [(10.0, True), (9.8, True)]) == [10.0, 9.8]
    pace.restart()
    assert told_at(pace, [(9.9, True)]) == [9.9]


@given(
    st.lists(st.tuples(st.floats(0.01, 2.0), st.booleans()), min_size=1, max_size=60), st.floats(0.05, 3.0)
)
def test_each_change_is_told_within_a_period_and_the_next_cloud(steps, period_s):
    pace, now_s, pending_since_s, last_s = Pace(period_s), 5.0, None, None
    for step_s, has_changed in steps:
        now_s += step_s
        if has_changed:
            pace.note()
            pending_since_s = now_s if pending_since_s is None else pending_since_s
        is_due = pace.is_due(now_s)
        assert not is_due or pending_since_s is not None
        assert is_due or pending_since_s is None or now_s - last_s < period_s
        if is_due:
            assert last_s is None or now_s - last_s > period_s - 1e-5
            pace.tell(now_s)
            pending_since_s, last_s = None, now_s


@pytest.mark.parametrize("name", ["publish_period", "updates_period"])
@pytest.mark.parametrize("period_s", [0.0, -1.0, float("nan")])
def test_a_period_that_is_none_is_refused_by_its_name(name, period_s):
    with pytest.raises(ParameterError, match=name):
        parameters_of({name: period_s})
