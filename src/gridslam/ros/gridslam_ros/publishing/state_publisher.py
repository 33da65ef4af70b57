"""Publishes whether the vehicle is tracked: in one word, as a marker for RViz, and with numbers."""

from __future__ import annotations

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseWithCovarianceStamped
from std_msgs.msg import ColorRGBA, Header, String
from visualization_msgs.msg import Marker

from gridslam.session import SlamSession
from gridslam.tracking.monitor import DRIFTING, LOST, TRACKING, UNCERTAIN
from node_tools.conversions import set_yaw

PERIOD_S = 1.0
"""Time by the scans' stamps between two diagnostics of one state."""
LEVELS = {
    TRACKING: DiagnosticStatus.OK,
    DRIFTING: DiagnosticStatus.OK,
    UNCERTAIN: DiagnosticStatus.WARN,
    LOST: DiagnosticStatus.ERROR,
}
COLOURS = {
    TRACKING: (0.08, 0.6, 0.24, 1.0),
    DRIFTING: (0.55, 0.6, 0.0, 1.0),
    UNCERTAIN: (0.96, 0.47, 0.0, 1.0),
    LOST: (0.8, 0.0, 0.0, 1.0),
}
PLANAR = np.ix_((0, 1, 5), (0, 1, 5))
"""Rows and columns of x, y and yaw in a covariance of ROS."""
TEXT_HEIGHT_M, TEXT_ABOVE_M = 0.6, 1.2


class StatePublisher:
    """Publishes ~state and ~state_marker when the state changes, and /diagnostics then and every second.

    It also publishes ~pose with each scan.

    Args:
        base_frame: the marker is above it.
        map_frame: of the pose.
    """

    def __init__(self, base_frame: str, map_frame: str) -> None:
        self._base_frame, self._map_frame = base_frame, map_frame
        self._poses = rospy.Publisher("~pose", PoseWithCovarianceStamped, queue_size=10)
        self._markers = rospy.Publisher("~state_marker", Marker, queue_size=10, latch=True)
        self._states = rospy.Publisher("~state", String, queue_size=10, latch=True)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self._state = ""
        self._published_s = 0.0

    def publish(self, session: SlamSession, stamp: rospy.Time) -> None:
        """Publish what a session says after the scan of this stamp."""
        if session.slam is not None and stamp.to_nsec():
            self._poses.publish(pose_of(session, Header(stamp=stamp, frame_id=self._map_frame)))
        self.tell(session, stamp)

    def tell(self, session: SlamSession, stamp: rospy.Time) -> None:
        """Publish the state at this time, whether or not there was a scan."""
        state = session.told_state
        is_new = state != self._state
        if is_new:
            self._state = state
            self._states.publish(state)
            self._markers.publish(marker_of(state, self._base_frame))
        if is_new or not 0.0 <= stamp.to_sec() - self._published_s < PERIOD_S:
            self._published_s = stamp.to_sec()
            status = status_of(session)
            self._diagnostics.publish(DiagnosticArray(Header(stamp=stamp), [status]))


def pose_of(session: SlamSession, header: Header) -> PoseWithCovarianceStamped:
    """Return where the base is in the map, and how uncertain that is; see `SlamSession.covariance`."""
    assert session.slam is not None  # since the first scan
    message, (x_m, y_m, yaw_rad) = PoseWithCovarianceStamped(header=header), session.slam.base_in_map
    message.pose.pose.position.x, message.pose.pose.position.y = x_m, y_m
    set_yaw(message.pose.pose.orientation, yaw_rad)
    covariance = np.zeros((6, 6))
    covariance[PLANAR] = session.covariance
    message.pose.covariance = covariance.ravel().tolist()
    return message


def marker_of(state: str, base_frame: str) -> Marker:
    """Return the state as a text that moves with the vehicle."""
    marker = Marker(ns="state", type=Marker.TEXT_VIEW_FACING, text=state, frame_locked=True)
    marker.header.frame_id = base_frame
    marker.pose.position.z, marker.pose.orientation.w = TEXT_ABOVE_M, 1.0
    marker.scale.z, marker.color = TEXT_HEIGHT_M, ColorRGBA(*COLOURS[state])
    return marker


def status_of(session: SlamSession) -> DiagnosticStatus:
    """Return the diagnostics of a session, in words and numbers."""
    tracking, state = session.tracking, session.told_state
    status = DiagnosticStatus(name=f"{rospy.get_name().lstrip('/')}: localisation")
    if tracking is None or tracking.last is None:
        status.level, status.message = LEVELS[state], f"{state}: no scan has been compared with a map yet"
        return status
    last = tracking.last
    status.level, status.message = LEVELS[state], f"{state}: {tracking.reason}"
    numbers = {
        "age of the newest scan that saw something (s)": session.sight.age_s,
        "beams that agree with the map (share)": tracking.share_of(last),
        "the same over the last scans (share)": tracking.smoothed_share,
        "beams that the map can be compared with (share)": last.agreement.compared_share,
        "spread of the particles (m)": last.spread_m,
        "effective particles (share)": last.neff_share,
        "correction of odometry (standard deviations)": last.correction,
        "scans in a row that contradict the map": tracking.contradictions,
        "drift since a place was recognised (m)": tracking.self_check.spread_m,
        "parts of the map that odometry alone joins (1: it is one)": len(session.loose_parts_s) + 1,
        "scans since tracking": tracking.scans_since_tracking,
        "travel since tracking (m)": tracking.travelled_since_tracking_m,
    }
    status.values = [KeyValue(name, f"{number:.3g}") for name, number in numbers.items()]
    status.values.append(KeyValue("search on the whole map", session.search or "none"))
    return status
