"""The doctor's judgement of bags made up by hand: one that is well, and one fault at a time."""

from __future__ import annotations

from dataclasses import replace

import pytest
from recordings import FINAL, HEALTHY, RAW, SAFE, bag_without, times

from doctor import bag
from doctor.diagnosis import ERROR, NOTE, WARNING
from doctor.snapshot import Recording, Topic


def test_a_bag_that_is_well_has_no_finding():
    assert bag.check(bag_without()) == []


ODD = tuple(t for t in times(40) if not 12.0 < t < 13.0)
BROKEN_BAGS = {
    "empty": (Recording(), ERROR, "bag", "no messages"),
    "no scans": (bag_without("/scan", "/scan/filtered", "/scan/padded"), NOTE, "gridslam", "no scans"),
    "no velocity": (bag_without(RAW, SAFE, FINAL), NOTE, "cepa", "reference velocity"),
    "no odometry": (bag_without("/UAV/odometry"), NOTE, "cepa", "no odometry"),
    "no tf": (bag_without(transforms=HEALTHY.transforms[2:]), NOTE, "gridslam", "TF does not lead"),
    "clock inside": (HEALTHY, NOTE, "/clock", "is in the bag"),
    "hole": (
        replace(
            HEALTHY, topics={"/scan": Topic("/scan", "sensor_msgs/LaserScan", ("/gazebo",), (), ODD, ODD)}
        ),
        WARNING,
        "/scan",
        "every 25 ms, but not for 1.0",
    ),
    "stamps back": (
        replace(
            HEALTHY,
            topics={RAW: replace(HEALTHY.topics[RAW], received_s=(14.0, 14.1), stamps_s=(14.0, 13.9))},
        ),
        WARNING,
        RAW,
        "go back",
    ),
}


@pytest.mark.table("case", BROKEN_BAGS)
def test_what_is_broken_in_a_bag_is_found(case):
    recording, severity, where, what = BROKEN_BAGS[case]
    found = bag.check(recording)
    assert any(one.severity == severity and one.where == where and what in one.what for one in found), found


def test_contacts_with_the_ground_are_no_fault():
    touches = Topic("/UAV/collision", "gazebo_msgs/ContactsState", ("/gazebo",), (), ODD, ODD)
    flown = bag_without()
    assert bag.check(replace(flown, topics={**flown.topics, touches.name: touches})) == []
