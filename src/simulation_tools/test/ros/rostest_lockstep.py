"""Lockstep through the whole graph: a flight repeats bit for bit, take-off included, at full speed."""

from __future__ import annotations

import threading
import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_srvs.srv import Empty

FLIGHT_S = 12.0


class TestLockstep(unittest.TestCase):
    def setUp(self):
        self.changed = threading.Condition()
        self.flights = [{}]  # stamp in ns -> pose, of each flight
        self.commands = rospy.Publisher(
            "/UAV/vel_setpoint/final/body", TwistStamped, queue_size=10, tcp_nodelay=True
        )
        rospy.Subscriber(
            "/UAV/ground_truth", Odometry, self.on_ground_truth, queue_size=1000, tcp_nodelay=True
        )
        rospy.Subscriber("/scan", LaserScan, self.on_scan, queue_size=1, tcp_nodelay=True)

    def on_scan(self, scan):
        """A controller made of this scan alone: it flies faster the farther it sees."""
        command = TwistStamped(header=scan.header)
        command.header.frame_id = "base_frame"
        seen = [r for r in scan.ranges if scan.range_min <= r <= scan.range_max]
        command.twist.linear.x = 0.4 + 0.01 * len(seen) / len(scan.ranges)
        command.twist.angular.z = 0.2
        self.commands.publish(command)

    def on_ground_truth(self, message):
        stamp_ns = message.header.stamp.to_nsec()
        p, q = message.pose.pose.position, message.pose.pose.orientation
        with self.changed:
            if self.flights[-1] and stamp_ns < max(self.flights[-1]):
                self.flights.append({})
            self.flights[-1][stamp_ns] = (p.x, p.y, p.z, q.x, q.y, q.z, q.w)
            self.changed.notify_all()

    def fly(self, number):
        def is_over():
            return len(self.flights) > number and max(self.flights[number], default=0) >= 1e9 * FLIGHT_S

        with self.changed:
            done = self.changed.wait_for(is_over, 70.0)
        self.assertTrue(done, f"flight {number} got stuck: {[len(flight) for flight in self.flights]}")

    def test_after_a_reset_the_flight_repeats_bit_for_bit(self):
        reset = rospy.ServiceProxy("/gazebo/reset_simulation", Empty)
        reset.wait_for_service(200.0)
        self.fly(0)
        performance = rospy.wait_for_message("/gazebo/performance", DiagnosticArray, timeout=200.0)
        values = {item.key: float(item.value) for item in performance.status[0].values}
        self.assertEqual(values["lockstep_misses"], 0.0)
        self.assertGreater(values["real_time_factor_mean"], 0.0)
        reset()
        self.fly(1)
        first, second = self.flights[:2]
        common = [stamp for stamp in sorted(first) if stamp in second and stamp <= 1e9 * FLIGHT_S]
        self.assertGreater(len(common), 100 * FLIGHT_S)
        parting = [(stamp, first[stamp], second[stamp]) for stamp in common if first[stamp] != second[stamp]]
        self.assertFalse(parting[:2], "the flights part at this time (ns), at these poses")
        self.assertGreater(max(pose[2] for pose in first.values()), 1.8, "it did take off")
        self.assertGreater(max(pose[0] for pose in first.values()), 0.5, "it did fly")
