"""What the node cepa tells beside its commands; computed only while somebody listens."""

from __future__ import annotations

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from cepa import Improved
from cepa.algorithm import Algorithm
from cepa.decision import Vector2
from cepa_ros import decision_message
from cepa_ros.conversions import stats_of
from cepa_ros.parameters import Choice
from cepa_ros.steering import Answer


class Reports:
    """The topics ~stats and ~decision."""

    def __init__(self, choice: Choice) -> None:
        self.apply(choice)
        self._stats = rospy.Publisher("~stats", DiagnosticArray, queue_size=10)
        self._decisions = rospy.Publisher("~decision", MarkerArray, queue_size=10)

    def apply(self, choice: Choice) -> None:
        """Take other parameters."""
        self._name = choice.algorithm
        self._improved = Improved(choice.parameters)

    def publish(self, header: Header, answer: Answer, algorithm: Algorithm) -> None:
        """Tell of one answer to the scan with this header."""
        if self._stats.get_num_connections():
            self._stats.publish(
                stats_of(header.stamp, rospy.get_name(), self._name, answer.decision, answer.computation_ms)
            )
        if self._decisions.get_num_connections():
            self._decisions.publish(decision_message.write(header, self._velocities(answer)))

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
        return velocities
