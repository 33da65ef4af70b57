"""setpoint_trajectory: when each point goes out, and as what. Expected values are MAVROS 1.21's."""

from __future__ import annotations

import math

import pytest
import rospy
from fake_uas import attitude, make_uas, request, xyz
from geometry_msgs.msg import Quaternion, Transform, Twist, Vector3
from trajectory_msgs.msg import MultiDOFJointTrajectory, MultiDOFJointTrajectoryPoint

from simulation_tools.mavros.trajectory import TrajectoryClock, TrajectoryPoint
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_trajectory import SetpointTrajectoryPlugin

pytestmark = pytest.mark.ros

EAST = Quaternion(0.0, 0.0, 0.0, 1.0)


def point(wait_s, place=None, velocity=None, yaw_rate=0.0, acceleration=None, turn=EAST):
    return MultiDOFJointTrajectoryPoint(
        transforms=[Transform(Vector3(*place), turn)] if place else [],
        velocities=[Twist(Vector3(*velocity), Vector3(0.0, 0.0, yaw_rate))] if velocity else [],
        accelerations=[Twist(linear=Vector3(*acceleration))] if acceleration else [],
        time_from_start=rospy.Duration.from_sec(wait_s),
    )


@pytest.fixture
def plugged(uas):
    SetpointTrajectoryPlugin(uas)
    return uas


def give(uas, *points):
    uas.callbacks["setpoint_trajectory/local"](MultiDOFJointTrajectory(points=list(points)))


def tick(uas, ms):
    """Let the flight controller's clock stand there; return what was sent."""
    before = len(uas.client.sent)
    uas.client.hear(attitude(ms=ms))
    return uas.client.sent[before:]


def test_a_point_waits_for_the_time_of_the_one_before():
    """The first waits for its own time, so points of 1, 2 and 3 s go out after 1, 2 and 4 s."""
    clock = TrajectoryClock()
    points = [TrajectoryPoint(1000), TrajectoryPoint(2000), TrajectoryPoint(3000)]
    clock.start(points)
    sent = {ms: found for ms in range(70_000, 75_001, 500) if (found := clock.due(ms))}
    assert sent == {71_000: points[:1], 72_000: points[1:2], 74_000: points[2:]}
    assert not clock.is_running


def test_points_without_time_go_out_at_once_and_a_new_trajectory_takes_the_place_of_the_old():
    clock = TrajectoryClock()
    clock.start([TrajectoryPoint(0), TrajectoryPoint(0), TrajectoryPoint(9000), TrajectoryPoint(0)])
    assert len(clock.due(5)) == 3
    clock.start([TrajectoryPoint(100)])
    assert clock.due(6) == []
    assert len(clock.due(106)) == 1
    assert clock.due(99_999) == []


def test_a_point_becomes_a_setpoint_in_ned(plugged):
    north = Quaternion(0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    give(plugged, point(0.0, (1.0, 2.0, 3.0), (4.0, 5.0, 6.0), 0.7, (8.0, 9.0, 10.0), north))
    (sent,) = tick(plugged, 1000)
    assert (sent.x, sent.y, sent.z) == (2.0, 1.0, -3.0)
    assert (sent.vx, sent.vy, sent.vz) == (5.0, 4.0, -6.0)
    assert (sent.afx, sent.afy, sent.afz) == (9.0, 8.0, -10.0)
    assert sent.yaw == pytest.approx(0.0)
    assert sent.yaw_rate == 0.7  # MAVROS does not turn it
    assert (sent.type_mask, sent.coordinate_frame, sent.time_boot_ms) == (0, 1, 77_000)
    assert xyz(plugged.topics["setpoint_trajectory/desired"].last.poses[0].pose.position) == (1.0, 2.0, 3.0)


@pytest.mark.parametrize(
    ("given", "mask"),
    [
        ({"place": (1.0, 2.0, 3.0)}, 0b1001_1111_1000),
        ({"velocity": (1.0, 2.0, 3.0)}, 0b0101_1100_0111),
        ({"acceleration": (1.0, 2.0, 3.0)}, 0b1100_0011_1111),
    ],
)
def test_what_a_point_lacks_is_ignored(plugged, given, mask):
    give(plugged, point(0.0, **given))
    assert [sent.type_mask for sent in tick(plugged, 1000)] == [mask]


def test_in_a_body_frame_values_are_forward_left_up(plugged, monkeypatch):
    monkeypatch.setattr(rospy, "set_param", lambda name, value: None)
    assert plugged.services["setpoint_trajectory/mav_frame"](request(mav_frame=8)).success
    give(plugged, point(0.0, (1.0, 2.0, 3.0)))
    (sent,) = tick(plugged, 1000)
    assert (sent.x, sent.y, sent.z, sent.coordinate_frame) == (1.0, -2.0, -3.0, 8)


def test_reset_ends_a_trajectory_once(plugged):
    give(plugged, point(0.0, (1.0, 2.0, 3.0)), point(1.0, (1.0, 2.0, 3.0)))
    reset = plugged.services["setpoint_trajectory/reset"]
    assert reset(None).success
    assert tick(plugged, 1000) == []
    refused = reset(None)
    assert (refused.success, refused.message) == (False, "Trajectory reset denied: Empty trajectory")


def test_a_bad_trajectory_is_refused_and_the_flown_one_goes_on(plugged, monkeypatch):
    said = []
    monkeypatch.setattr(rospy, "logwarn", said.append)
    give(plugged, point(0.0, (1.0, 2.0, 3.0)))
    give(plugged)
    give(plugged, point(0.0, (1.0, 2.0, 3.0)), point(0.0, (math.nan, 2.0, 3.0)))
    give(plugged, point(-1.0, (1.0, 2.0, 3.0)))
    assert ["no points" in said[0], "of point 1" in said[1], "negative" in said[2]] == [True] * 3
    assert len(tick(plugged, 1000)) == 1


def test_a_clock_that_jumps_back_ends_a_trajectory(plugged, monkeypatch):
    monkeypatch.setattr(rospy, "logwarn", lambda text: None)
    tick(plugged, 50_000)
    give(plugged, point(1.0, (1.0, 2.0, 3.0)))
    tick(plugged, 50_010)
    assert tick(plugged, 10) == []
    assert tick(plugged, 60_000) == []


def test_the_frame_of_the_path_is_a_parameter(monkeypatch):
    uas = make_uas(monkeypatch, {"~setpoint_trajectory/frame_id": "odom"})
    SetpointTrajectoryPlugin(uas)
    give(uas, point(0.0, (1.0, 2.0, 3.0)), point(0.0, velocity=(1.0, 0.0, 0.0)))
    path = uas.topics["setpoint_trajectory/desired"].last
    assert (path.header.frame_id, len(path.poses)) == ("odom", 1)
