"""The contract of the node vision_pose_publisher: good poses with their stamps, else silence and a state."""

import math
import unittest

import rospy
from flight_basics_ros.testing import odometry_of
from geometry_msgs.msg import PoseWithCovarianceStamped
from nav_msgs.msg import Odometry
from std_msgs.msg import String

from node_tools.testing import Input, Output, Warned, wait_until

NODE = "/vision/vision_pose_publisher"


class VisionPosePublisherTest(unittest.TestCase):
    def setUp(self):
        self.odometry = Input("vision/odometry", Odometry)
        self.poses = Output("vision/vision_pose", PoseWithCovarianceStamped)
        self.states = Output(NODE + "/state", String)
        self.warned = Warned(NODE)

    def send(self, x=0.0, variance=1e-4, **frames):
        message = odometry_of(rospy.Time.now(), (x, 0.0, 2.0), **frames)
        message.pose.covariance = [variance if i % 7 == 0 else 0.0 for i in range(36)]
        message.twist.twist.linear.x = 0.5
        self.odometry.send(message)
        return message

    def wait_for_state(self, state):
        self.states.last(lambda message: message.data == state, state)

    def refused(self, state, sentence, **message):
        self.send(0.0)
        self.wait_for_state("good")
        rospy.sleep(0.02)
        self.poses.messages.clear()
        sent = self.send(**message)
        self.wait_for_state(state)
        self.warned.wait_for(sentence)
        self.assertNotIn(sent.header.stamp, [pose.header.stamp for pose in self.poses.messages])

    def test_a_pose_keeps_stamp_frame_and_covariance(self):
        sent = self.send(1.0)
        received = self.poses.last(lambda pose: pose.header.stamp == sent.header.stamp, "the pose")
        self.assertEqual(received.header.frame_id, "odom")
        self.assertEqual(received.pose, sent.pose)
        out = Output("vision/out/odometry_out", Odometry)
        source = Input("vision/out/odometry", Odometry)
        source.send(self.send(1.0))
        received = out.next()
        self.assertEqual((received.header.frame_id, received.child_frame_id), ("odom", "base_frame"))
        self.assertEqual(received.twist.twist.linear.x, 0.5)

    def test_bad_odometry_is_refused_with_one_sentence(self):
        rospy.sleep(0.6)  # a jump of another test has settled
        self.refused("invalid", "not finite", x=math.nan)
        self.refused("invalid", '"base_link" in "odom"', child="base_link")
        self.refused("invalid", '"base_frame" in "map"', frame="map")
        self.refused("uncertain", "position is uncertain", variance=1.0)

    def test_silence_is_stale_and_a_jump_settles(self):
        rospy.sleep(0.6)
        self.send(0.0)
        self.wait_for_state("good")
        self.wait_for_state("stale")
        self.warned.wait_for("No odometry has come for")
        self.send(0.0)
        self.send(40.0)
        self.wait_for_state("jumped")
        wait_until(lambda: self.send(40.0) and self.states.messages[-1].data == "good", "the state good")
        pose = self.poses.messages[-1].pose.pose
        self.assertAlmostEqual(pose.position.x, 0.0, delta=0.5 * 0.3)  # it goes on, by max_age at most
