"""MAVROS's plugins of external estimates in a graph: from ROS to the flight controller and back."""

from __future__ import annotations

import rospy
from geometry_msgs.msg import PoseWithCovarianceStamped
from mavros_msgs.msg import EstimatorStatus
from mavros_test_case import MavrosTestCase
from nav_msgs.msg import Odometry
from sensor_msgs.msg import Range

from node_tools.testing import Input, Warned


class TestMavrosVision(MavrosTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.listen(
            {
                "odometry/in": Odometry,
                "distance_sensor/hrlv_ez4_pub": Range,
                "estimator_status": EstimatorStatus,
            }
        )
        cls.warned = Warned("/mavros")

    def test_a_the_estimate_comes_with_its_covariance(self):
        self.assertTrue(self.eventually(lambda: self.last("odometry/in") is not None))
        odometry = self.last("odometry/in")
        self.assertEqual((odometry.header.frame_id, odometry.child_frame_id), ("map", "base_link"))
        for variance in (*odometry.pose.covariance[0:15:7], *odometry.twist.covariance[0:15:7]):
            self.assertGreater(variance, 0.0)
        self.assertTrue(self.eventually(lambda: self.last("estimator_status") is not None))
        self.assertTrue(self.last("estimator_status").pos_horiz_abs_status_flag)

    def test_a_range_goes_to_px4_and_comes_back_as_its_own(self):
        ranges = Input("/mavros/distance_sensor/laser_1_sub", Range)
        message = Range(radiation_type=Range.INFRARED, min_range=0.1, max_range=40.0, range=2.34)
        message.header.stamp = rospy.get_rostime()
        topic = "distance_sensor/hrlv_ez4_pub"
        sent = self.eventually(lambda: self.last(topic) is not None, act=lambda: ranges.send(message))
        self.assertTrue(sent)
        self.assertAlmostEqual(self.last(topic).range, 2.34, delta=0.011)  # in whole cm

    def test_b_what_cannot_be_sent_gives_a_sentence(self):
        odometry = Input("/mavros/odometry/out", Odometry)
        odometry.send(Odometry(child_frame_id="nose"))
        self.warned.wait_for("it is of 'nose' in ''")
        pose = PoseWithCovarianceStamped()
        pose.pose.pose.position.x = 1e300
        Input("/mavros/vision_pose/pose_cov", PoseWithCovarianceStamped).send(pose)
        pose.header.stamp.secs = 1
        Input("/mavros/vision_pose/pose_cov", PoseWithCovarianceStamped).send(pose)
        self.warned.wait_for("vision_pose/pose_cov is refused: it holds a number beyond 3.4e38")
