"""Publishes whether the vehicle is tracked: ~state in one word, /diagnostics with the numbers."""

from __future__ import annotations

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header, String

from gridslam.localisation.judgement import LOST, TRACKING, UNCERTAIN, Judgement
from gridslam.session import SlamSession

PERIOD_S = 1.0
"""Time by the scans' stamps between two diagnostics of one state."""
LEVELS = {TRACKING: DiagnosticStatus.OK, UNCERTAIN: DiagnosticStatus.WARN, LOST: DiagnosticStatus.ERROR}


class StatePublisher:
    """Publishes the state when it changes, and diagnostics then and every second."""

    def __init__(self) -> None:
        self._states = rospy.Publisher("~state", String, queue_size=10, latch=True)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)
        self._state = ""
        self._published_s = 0.0

    def publish(self, session: SlamSession, stamp: rospy.Time) -> None:
        """Publish what a session says after the scan of this stamp."""
        state = UNCERTAIN if session.judgement is None else session.judgement.state
        is_new = state != self._state
        if is_new:
            self._state = state
            self._states.publish(state)
        if is_new or not 0.0 <= stamp.to_sec() - self._published_s < PERIOD_S:
            self._published_s = stamp.to_sec()
            status = status_of(session.judgement, session.search)
            self._diagnostics.publish(DiagnosticArray(Header(stamp=stamp), [status]))


def status_of(judgement: Judgement | None, search: str) -> DiagnosticStatus:
    """Return the diagnostics of a judgement (None: before the first scan) and of the search, in words."""
    status = DiagnosticStatus(name=f"{rospy.get_name().lstrip('/')}: localisation")
    if judgement is None or judgement.last is None:
        state = UNCERTAIN if judgement is None else judgement.state
        status.level, status.message = LEVELS[state], f"{state}: no scan has been compared with a map yet"
        return status
    last = judgement.last
    status.level, status.message = LEVELS[judgement.state], f"{judgement.state}: {judgement.reason}"
    numbers = {
        "beams that agree with the map (share)": judgement.share_of(last),
        "the same over the last scans (share)": judgement.smoothed_share,
        "beams that the map can be compared with (share)": last.agreement.compared_share,
        "spread of the particles (m)": last.spread_m,
        "effective particles (share)": last.neff_share,
        "correction of odometry (standard deviations)": last.correction,
        "scans in a row that contradict the map": judgement.contradictions,
        "scans since tracking": judgement.scans_since_tracking,
        "travel since tracking (m)": judgement.travelled_since_tracking_m,
    }
    status.values = [KeyValue(name, f"{number:.3g}") for name, number in numbers.items()]
    status.values.append(KeyValue("search on the whole map", search or "none"))
    return status
