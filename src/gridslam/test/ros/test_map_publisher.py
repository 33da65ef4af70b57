"""When a new map goes out: once in an interval, and later if scans wait."""

import math

import numpy as np
import planar_world
import pytest

from gridslam import SlamParameters, StateError
from gridslam.session import SlamSession

map_publisher = pytest.importorskip(
    "gridslam_ros.publishing.map_publisher", reason="the workspace is not built, or not sourced"
)
INTERVAL_S = 2.0
LIDAR = planar_world.Lidar(6.2, 60, 20.0, 0.01, 10.0)


class Topic(list):
    """Stands for a rospy.Publisher: keeps what goes out."""

    def __init__(self, *_args, **_options):
        super().__init__()

    publish = list.append


@pytest.fixture(scope="module")
def session():
    """A session that has integrated one scan, of stamp 0 s."""
    log = planar_world.drive(planar_world.hold(), np.zeros((1, 3)), LIDAR, seed=4)
    session = SlamSession(SlamParameters(particles=2, delta=0.2))
    session.process(log.scans[0], tuple(log.odometry[0]))
    return session


@pytest.fixture
def publisher(monkeypatch):
    monkeypatch.setattr(map_publisher.rospy, "Publisher", Topic)
    return map_publisher.MapPublisher("map", INTERVAL_S)


def test_without_a_scan_there_is_no_map(publisher, session):
    publisher.restart(math.nan)
    assert publisher.is_empty
    assert not publisher.is_due(5.0, scans_wait=False)
    with pytest.raises(StateError, match="no scan has been integrated"):
        publisher.publish(session, 5.0)


def test_the_first_map_is_due_at_once_and_the_next_after_the_interval(publisher, session):
    publisher.integrated(10.0)
    assert publisher.is_due(10.0, scans_wait=True)
    message = publisher.publish(session, 10.0)
    assert (message.header.frame_id, message.header.stamp.to_sec()) == ("map", 10.0)
    assert not publisher.is_due(20.0, scans_wait=False)  # nothing new
    publisher.integrated(11.0)
    assert [publisher.is_due(now_s, scans_wait=False) for now_s in (11.9, 12.0)] == [False, True]
    assert [publisher.is_due(now_s, scans_wait=True) for now_s in (13.9, 14.0)] == [False, True]


def test_after_a_clock_that_went_back_it_is_due(publisher, session):
    publisher.integrated(10.0)
    publisher.publish(session, 10.0)
    publisher.integrated(3.0)
    assert publisher.is_due(3.0, scans_wait=False)


def test_a_session_from_a_saved_state_is_shown_at_once(publisher):
    publisher.restart(7.5)
    assert not publisher.is_empty
    assert publisher.is_due(7.5, scans_wait=False)
