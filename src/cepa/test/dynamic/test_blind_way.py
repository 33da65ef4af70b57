"""How far the UAV may go where nobody has looked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.dynamic.candidates import leads_back
from cepa.dynamic.constants.free_space import EARLIER_SCANS, NEWEST_SCANS
from cepa.dynamic.free_space.blind_way import BlindWay
from cepa.dynamic.free_space.earlier_scans import EarlierScans
from cepa.motion import Motion

NOT_LONG = [0.0, 0.0]
BLIND = np.full(360, -1.0)


def motion(x, yaw_rad=0.0):
    return Motion(
        0.0, (x, 3.0, 2.0), (0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad)), (0.0, 0.0, 0.0)
    )


def test_a_uav_that_does_not_turn_may_go_half_a_metre():
    way = BlindWay()
    for x in (0.0, -0.2, -0.45):
        assert way.follow(motion(x), False, BLIND).tolist() == NOT_LONG
        assert not way.is_too_long
    assert way.follow(motion(-0.55), False, BLIND) == pytest.approx([-1.0, 0.0])
    assert way.is_too_long
    assert way.follow(motion(-0.45), False, BLIND).tolist() == NOT_LONG  # it came back


@pytest.mark.table("turned_rad", [-0.8, 0.3, 0.8])
def test_a_uav_that_turns_may_go_a_metre_more_for_each_rad(turned_rad):
    way, allowed_m = BlindWay(), 0.5 + abs(turned_rad)
    way.follow(motion(0.0, 3.0), False, BLIND)  # the turn leads over the seam at 180 degrees
    for share in (0.5, 0.96):
        place = motion(-share * allowed_m, 3.0 + share * turned_rad)
        assert way.follow(place, False, BLIND).tolist() == NOT_LONG
    there = motion(-1.04 * allowed_m, 3.0 + turned_rad)
    assert way.follow(there, False, BLIND) == pytest.approx([-1.0, 0.0])


def test_the_way_begins_again_where_the_uav_sees_or_after_open_flight():
    way = BlindWay()
    way.follow(motion(0.0), False, BLIND)
    assert way.follow(motion(-0.55), True, BLIND).tolist() == NOT_LONG
    assert way.follow(motion(-1.0), False, BLIND).tolist() == NOT_LONG
    assert way.follow(motion(-1.1), False, BLIND).tolist() != NOT_LONG
    assert way.follow(motion(5.0), False, BLIND).tolist() == NOT_LONG


def test_a_way_that_leads_where_a_beam_looks_is_never_too_long():
    way, ahead = BlindWay(), np.where(np.abs(np.arange(360) - 180) <= 60, -1.0, 5.0)  # 240 degrees of view
    for x, is_long in ((0.0, False), (0.6, False), (1.2, False), (0.4, False), (-0.4, False), (-0.6, True)):
        assert (way.follow(motion(x), False, ahead).tolist() != NOT_LONG) == is_long


def test_what_leads_back_is_within_60_degrees_of_the_way_back_or_stands():
    angles = np.radians([0.0, 59.0, -59.0, 61.0, 90.0, 180.0])
    commands = 0.7 * np.column_stack((np.cos(angles), np.sin(angles), np.zeros(6)))
    commands = np.concatenate((commands, np.zeros((1, 3))))
    assert leads_back(commands, np.array([-1.0, 0.0])).tolist() == [
        True,
        True,
        True,
        False,
        False,
        False,
        True,
    ]
    assert leads_back(commands, np.zeros(2)).all()


@pytest.mark.table(
    ("ago", "must_flee", "is_known"), [(19, False, True), (25, False, False), (25, True, True)]
)
def test_while_something_comes_older_scans_tell_what_is_free_behind(ago, must_flee, is_known):
    """The UAV stands at (2, 3). So many scans ago one from there saw free to 5 m all around; none since."""
    scans, free_m = EarlierScans(), BLIND.copy()
    for age in range(EARLIER_SCANS + 7, -1, -1):
        scans.take_in(2.0, 3.0, np.full(360, 5.0) if age == ago else BLIND)
    asked = EARLIER_SCANS if must_flee else NEWEST_SCANS
    assert scans.have_seen_around(free_m, 2.0, 3.0, 0.35, asked) == is_known
    scans.fill(free_m, 2.0, 3.0, 0.6, asked)
    assert free_m == pytest.approx(np.full(360, 3.0 if is_known else 0.6))
