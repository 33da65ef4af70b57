"""launch/hokuyo_only.launch: the lidar on its stand sees the columns, and CEPA steers clear of them."""

import unittest

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import TwistStamped
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from node_tools.testing import wait_until


class HokuyoOnlyTest(unittest.TestCase):
    def test_the_lidar_is_answered(self):
        scans, answers, stats, pictures = [], [], [], []
        for topic, kind, heard in (
            ("/scan", LaserScan, scans),
            ("/UAV/vel_setpoint/safe/body", TwistStamped, answers),
            ("/cepa/stats", DiagnosticArray, stats),
            ("/cepa_visualiser/markers", MarkerArray, pictures),
        ):
            rospy.Subscriber(topic, kind, heard.append)
        wait_until(lambda: scans and pictures, "scans and pictures", 200.0)
        ahead = scans[-1].ranges[len(scans[-1].ranges) // 2]
        self.assertAlmostEqual(ahead, 2.47, delta=0.1)  # the column at (2.6, 0.15), radius 0.2
        wait_until(
            lambda: any(answer.twist.linear.x > 0.1 for answer in answers), "an answer that goes on", 20.0
        )
        wait_until(lambda: stats, "stats")
        self.assertEqual(answers[-1].header.frame_id, "base_frame")
        self.assertLess(answers[-1].twist.linear.x, 1.5)  # v_ref leads into the column
