"""What the node cepa tells beside its commands; computed only while somebody listens."""

from __future__ import annotations

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from cepa import Dynamic, Improved
from cepa.algorithm import Algorithm
from cepa.decision import Vector2
from cepa.steering.answering import Answer
from cepa_ros import decision_message
from cepa_ros.conversions import remembered_of, stats_of
from cepa_ros.parameters import Choice

MEMORY_PERIOD_NS = 100_000_000


class Reports:
    """The topics ~stats, ~decision and ~remembered."""

    def __init__(self, choice: Choice) -> None:
        self.apply(choice)
        self._shown_ns = 0
        self._stats = rospy.Publisher("~stats", DiagnosticArray, queue_size=10)
        self._decisions = rospy.Publisher("~decision", MarkerArray, queue_size=10)
        self._remembered = rospy.Publisher("~remembered", PointCloud2, queue_size=2)

    def apply(self, choice: Choice) -> None:
        """Take other parameters."""
        self._name = choice.algorithm
        self._improved = Improved(choice.parameters)

    def publish(self, header: Header, answer: Answer, algorithm: Algorithm) -> None:
        """Tell of one answer to the scan with this header."""
        dynamic = algorithm if isinstance(algorithm, Dynamic) else None
        is_drawn = dynamic and not answer.is_mirrored
        if self._stats.get_num_connections():
            figures = self._name, answer.decision, answer.computation_ms, answer.cpu_ms
            report = dynamic.report() if dynamic else None
            self._stats.publish(stats_of(header.stamp, rospy.get_name(), *figures, report))
        shows_memory = dynamic and self._remembered.get_num_connections() and self._is_time(header.stamp)
        is_watched = self._decisions.get_num_connections()
        view = dynamic.view() if dynamic and is_drawn and (is_watched or shows_memory) else None
        if is_watched:
            message = decision_message.write(header, self._velocities(answer))
            message.markers += decision_message.write_view(header, view) if view else []
            self._decisions.publish(message)
        if view and shows_memory:
            self._remembered.publish(remembered_of(header, view))

    def _is_time(self, stamp: rospy.Time) -> bool:
        """Whether the next picture of the memory is due. After a clock that jumped back it is."""
        due = not 0 <= stamp.to_nsec() - self._shown_ns < MEMORY_PERIOD_NS
        if due:
            self._shown_ns = stamp.to_nsec()
        return due

    def _velocities(self, answer: Answer) -> dict[str, Vector2]:
        """Return the decision. In an emergency it holds the answers of both algorithms."""
        decision, (v_ref, v_uav) = answer.decision, answer.velocities_xy
        velocities = {
            decision_message.REFERENCE: v_ref,
            decision_message.OUTPUT: decision.velocity_xy,
            decision_message.OWN: v_uav,
        }
        if decision.emergency_original_xy is not None:  # it is an emergency
            improved = decision.emergency_improved_xy
            velocities[decision_message.ORIGINAL] = decision.emergency_original_xy
            velocities[decision_message.IMPROVED] = (
                improved or self._improved.steer(answer.scan, v_ref, v_uav).velocity_xy
            )
        side = -1.0 if answer.is_mirrored else 1.0
        return {name: (x, side * y) for name, (x, y) in velocities.items()}
