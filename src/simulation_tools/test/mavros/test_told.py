"""What a client tells the flight controller: scans in sectors, motion capture in NED, texts."""

from __future__ import annotations

import math

import pytest
from fake_uas import make_uas

from simulation_tools.mavros.told import (
    SECTORS,
    UNKNOWN_CM,
    Scan,
    mocap_estimate,
    obstacle_distance,
    status_text,
)


def scan(ranges, increment=math.pi / 36.0):
    return Scan(ranges, -math.pi, increment, 0.1, 30.0)


def test_a_scan_that_fits_is_passed_on_in_centimetres():
    message = obstacle_distance(7, scan([1.234, math.inf, math.nan, -1.0, 700.0]), 12)
    assert message.distances[:5] == [123, *[UNKNOWN_CM] * 4]
    assert message.distances[5:] == [UNKNOWN_CM] * (SECTORS - 5)
    assert (message.time_usec, message.increment, message.frame) == (7, 5, 12)
    assert (message.min_distance, message.max_distance) == (10, 3000)
    assert (message.increment_f, message.angle_offset) == pytest.approx((5.0, -180.0))


def test_where_beams_share_a_sector_the_nearest_counts():
    """720 beams of half a degree: ten a sector."""
    ranges = [9.0] * 720
    ranges[25] = 2.0
    ranges[26] = math.nan
    message = obstacle_distance(0, scan(ranges, math.radians(0.5)), 0)
    assert message.distances == [900, 900, 200, *[900] * 69]
    assert (message.increment, message.increment_f) == (5, pytest.approx(5.0))


def test_of_a_number_of_beams_that_does_not_divide_none_is_lost():
    for beams in (73, 100, 271, 1081):
        for near in (0, beams // 2, beams - 1):
            ranges = [9.0] * beams
            ranges[near] = 1.0
            assert 100 in obstacle_distance(0, scan(ranges, 0.01), 0).distances


def test_a_scan_whose_angles_are_no_numbers_is_refused():
    with pytest.raises(ValueError, match="no numbers"):
        obstacle_distance(0, scan([1.0], math.nan), 0)


def test_motion_capture_is_turned_to_ned():
    """1 m east, 2 m north, 3 m up, facing east: yaw 90 degrees in NED."""
    message = mocap_estimate(5, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 2.0))
    assert (message.x, message.y, message.z) == (2.0, 1.0, -3.0)
    half = math.sqrt(0.5)
    assert message.q == pytest.approx([half, 0.0, 0.0, half])
    with pytest.raises(ValueError, match="length 0"):
        mocap_estimate(5, (1.0, 2.0, 3.0), (0.0, 0.0, 0.0, 0.0))


def test_a_text_is_cut_and_a_wrong_severity_is_refused():
    message = status_text(4, "x" * 60)
    assert (message.severity, message.text) == (4, "x" * 50)
    with pytest.raises(ValueError, match="severity is 9"):
        status_text(9, "hello")


def test_the_plugins_pass_them_on(monkeypatch):
    from geometry_msgs.msg import PoseStamped
    from mavros_msgs.msg import StatusText
    from sensor_msgs.msg import LaserScan

    from simulation_tools_ros.mavros.plugins.extras import to_fcu

    uas = make_uas(monkeypatch)
    for plugin in (to_fcu.ObstacleDistancePlugin, to_fcu.MocapPlugin, to_fcu.StatusTextPlugin):
        plugin(uas)
    pose = PoseStamped()
    pose.pose.orientation.w = 1.0
    uas.callbacks["mocap/pose"](pose)
    uas.callbacks["obstacle/send"](LaserScan(ranges=[1.0], angle_increment=0.1))
    uas.callbacks["statustext/send"](StatusText(severity=5, text="hello"))
    assert [message.get_type() for message in uas.client.sent] == [
        "ATT_POS_MOCAP",
        "OBSTACLE_DISTANCE",
        "STATUSTEXT",
    ]


def test_the_fence_is_read_pushed_and_published(monkeypatch):
    from mavros_msgs.msg import Waypoint

    from simulation_tools_ros.mavros.plugins.extras import geofence

    class Fence:
        def __init__(self, *_given, **_named):
            self.items = []

        def read(self):
            return self.items

        def write(self, items):
            self.items = items

        def clear(self):
            self.items = []

    monkeypatch.setattr(geofence, "MissionClient", Fence)
    uas = make_uas(monkeypatch)
    geofence.GeofencePlugin(uas)
    push = geofence.srv.WaypointPushRequest(waypoints=[Waypoint(frame=3, command=5003, param1=20.0)])
    assert uas.services["geofence/push"](push).wp_transfered == 1
    assert uas.topics["geofence/waypoints"].last.waypoints[0].param1 == 20.0
    assert uas.services["geofence/clear"](None).success
    assert uas.services["geofence/pull"](None).wp_received == 0
    assert uas.topics["geofence/waypoints"].last.waypoints == []
