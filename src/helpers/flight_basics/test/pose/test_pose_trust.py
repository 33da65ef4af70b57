"""When SLAM's pose is sure enough to photograph and to fly by."""

from __future__ import annotations

import math

import numpy as np
import pytest

from flight_basics.correction import SlowCorrection
from flight_basics.pose.trust import LOST_S, SETTLED_M, UNSURE_S, PoseTrust, Trust

STEP_S = 0.05
NO_TURN = (0.0, 0.0, 0.0, 1.0)


def trusts(trust, seconds, state="tracking", **off):
    """Return what the pose is good for, pose by pose."""
    trust.on_state(state)
    return [trust.at(STEP_S * k, **off) for k in range(round(seconds / STEP_S))]


@pytest.mark.table("photographs", [True, False])
@pytest.mark.table("state", ["", "tracking"])
def test_a_pose_that_is_tracked_is_sure(photographs, state):
    assert set(trusts(PoseTrust(photographs), 5.0, state, off_m=0.02)) == {Trust.SURE}


@pytest.mark.table("photographs", [True, False])
def test_a_uav_that_is_lost_hovers_and_then_comes_home(photographs):
    trust = PoseTrust(photographs)
    told = trusts(trust, LOST_S + 1.0, "lost")
    assert Trust.SURE not in told
    assert told[round(2.0 / STEP_S)] is Trust.HOVER
    assert told[round((LOST_S - 0.5) / STEP_S)] is Trust.HOVER
    assert told[-1] is Trust.COME_HOME
    assert trust.reason == "SLAM is lost."


def test_for_how_long_it_was_lost_before_the_flight_does_not_count():
    trust = PoseTrust(photographs=True)
    trusts(trust, LOST_S + 1.0, "lost")
    trust.begin()
    assert trust.at(LOST_S + 1.0) is Trust.UNSURE


def test_a_uav_that_finds_itself_again_goes_on():
    trust = PoseTrust(photographs=False)
    trusts(trust, 5.0, "lost")
    trust.on_state("tracking")
    assert trust.at(5.0) is Trust.SURE


@pytest.mark.table("off", [{"state": "uncertain"}, {"off_m": 0.3}, {"off_rad": 0.1}])
def test_only_photographs_mind_a_place_that_is_a_little_off(off):
    told = trusts(PoseTrust(photographs=True), UNSURE_S + 1.0, **off)
    assert told[0] is Trust.UNSURE
    assert told[round(2.0 / STEP_S)] is Trust.HOVER
    assert told[round((UNSURE_S - 1.0) / STEP_S)] is Trust.HOVER
    assert told[-1] is Trust.COME_HOME
    assert set(trusts(PoseTrust(photographs=False), 5.0, **off)) == {Trust.SURE}


def test_the_deviation_is_honest_while_the_pose_is_not_sure():
    trust = PoseTrust(photographs=True)
    trust.at(0.0, off_m=0.7)
    assert trust.deviation_m == 0.7
    for state in ("uncertain", "lost"):
        trust.on_state(state)
        assert trust.deviation_m >= 1.0


def test_after_a_loop_closure_of_a_metre_the_pose_is_unsure_until_it_has_come_there():
    """1.0 m at 0.15 m/s take 6.7 s. Less what counts as settled, the pose is sure again."""
    slow, trust = SlowCorrection(), PoseTrust(photographs=True)
    slow.apply(0.0, ((3.0, 1.0, 2.0), 0.2), (0.0, 0.0, 0.0), NO_TURN)
    unsure_s = []
    for k in range(1, 400):
        here_m, _ = slow.apply(STEP_S * k, ((3.0, 1.0, 2.0), 0.2), (0.6, 0.8, 0.0), NO_TURN)
        assert slow.whole[0] == pytest.approx((3.6, 1.8, 2.0))
        assert slow.off_m == pytest.approx(math.dist(here_m, (3.6, 1.8, 2.0)))
        if trust.at(STEP_S * k, slow.off_m, slow.off_rad) is not Trust.SURE:
            unsure_s.append(STEP_S * k)
    assert unsure_s[0] == STEP_S
    assert unsure_s[-1] == pytest.approx((1.0 - SETTLED_M) / 0.15, abs=2 * STEP_S)
    assert np.diff(unsure_s) == pytest.approx(STEP_S)
