"""The node tf_publisher as other nodes see it: one tree, true inverse, bad input, a clock that jumps back."""

from __future__ import annotations

import math
import unittest

import rospy
from gazebo_msgs.msg import ModelStates
from geometry_msgs.msg import Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input, Output, Warned, wait_until
from simulation_tools.geometry import Pose
from simulation_tools_ros.conversions import pose_message

PATIENCE_S = 60.0
"""Wall time; only a test that fails waits this long."""
IN_ODOM = Pose.from_xyz_rpy(1.0, 2.0, 3.0, yaw=0.3)
IN_WORLD = Pose.from_xyz_rpy(1.5, 1.0, 3.0, yaw=0.5)


def pose_of(transform):
    t, q = transform.transform.translation, transform.transform.rotation
    return Pose((t.x, t.y, t.z), (q.x, q.y, q.z, q.w))


class TestTfPublisher(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.odometry, cls.ground_truth = Input("odometry", Odometry), Input("ground_truth", Odometry)
        cls.joint_states = Input("joint_states", JointState)
        cls.tf = Output("/tf", TFMessage)
        cls.received = cls.tf.messages
        cls.seconds = 10.0

    def setUp(self):
        self.received.clear()

    def publish(self, source, seconds, pose):
        message = Odometry()
        message.header.stamp = rospy.Time.from_sec(seconds)
        message.pose.pose = pose_message(pose)
        source.send(message)

    def publish_pair(self):
        type(self).seconds += 0.01
        self.publish(self.odometry, self.seconds, IN_ODOM)
        self.publish(self.ground_truth, self.seconds, IN_WORLD)
        return self.seconds

    def is_of_both(self, message, seconds):
        edges = message.transforms
        return len(edges) == 2 and edges[0].header.stamp == rospy.Time.from_sec(seconds)

    def fly_until_both(self):
        """The first messages may go out alone, while one of the two topics is not connected yet."""
        found = []

        def comes():
            seconds = self.publish_pair()
            self.tf.holds(lambda message: self.is_of_both(message, seconds), 0.05)
            found.extend(message for message in self.received if self.is_of_both(message, seconds))
            return found

        wait_until(comes, "both edges in one message")
        return found[0]

    def test_both_edges_in_one_message_and_the_world_is_the_inverse(self):
        message = self.fly_until_both()
        edges = {(t.header.frame_id, t.child_frame_id): t for t in message.transforms}
        self.assertEqual(set(edges), {("odom", "base_frame"), ("base_frame", "world")})
        self.assertEqual(len({t.header.stamp.to_nsec() for t in message.transforms}), 1)
        back = IN_WORLD @ pose_of(edges["base_frame", "world"])
        for value in back.position_m:
            self.assertAlmostEqual(value, 0.0, places=12)
        self.assertAlmostEqual(pose_of(edges["odom", "base_frame"]).yaw_rad, 0.3, places=12)

    def test_static_frames_come_from_the_sdf_and_form_one_tree(self):
        static = rospy.wait_for_message("/tf_static", TFMessage, timeout=PATIENCE_S)
        parents = {t.child_frame_id: t.header.frame_id for t in static.transforms}
        self.assertEqual(len(parents), len(static.transforms), "a frame has two parents")
        frame, seen = "hokuyo", set()
        while frame != "base_frame":
            self.assertIn(frame, parents, "hokuyo is not connected to base_frame")
            self.assertNotIn(frame, seen)
            seen.add(frame)
            frame = parents[frame]
        self.assertFalse({"world", "odom", "map"} & set(parents))

    def test_the_lidar_turns_on_its_gimbal_once_its_joints_are_told(self):
        names = ["iris::lidar_roll_joint", "iris::lidar_pitch_joint"]
        bad = JointState(name=names, position=[math.nan, 0.0])
        short = JointState(name=names, position=[0.1])
        good = JointState(name=names, position=[0.3, -0.2])
        good.header.stamp = rospy.Time.from_sec(7.0)
        for message in (bad, short, good):
            self.joint_states.send(message)
        wait_until(lambda: self.received, "the lidar's frames")
        (message,) = self.received
        edges = {t.child_frame_id: t for t in message.transforms}
        self.assertEqual(set(edges), {"lidar_gimbal", "lidar_mount"})
        self.assertEqual({t.header.stamp for t in message.transforms}, {good.header.stamp})
        turned = pose_of(edges["lidar_gimbal"]) @ pose_of(edges["lidar_mount"])
        # Rx(roll) Ry(pitch): its z axis is (sin p, -sin r cos p, cos r cos p).
        up = turned.rotation[:, 2]
        for value, expected in zip(up, (math.sin(-0.2), -math.sin(0.3) * math.cos(-0.2))):
            self.assertAlmostEqual(value, expected, places=12)

        def standing():
            static = rospy.wait_for_message("/tf_static", TFMessage, timeout=PATIENCE_S)
            return {t.child_frame_id for t in static.transforms}

        wait_until(lambda: "lidar_mount" not in standing(), "a tree without the frame that moves")
        self.assertIn("hokuyo", standing())

    def test_any_model_of_the_simulator_goes_to_tf_with_its_joints(self):
        """Of another node: it hangs the model `door` into the world and turns its leaf."""
        states = Input("model_states", ModelStates)
        pose = Pose.from_xyz_rpy(3.0, 1.0, 0.0, yaw=math.pi / 2)
        joint = JointState(name=["door::hinge", "iris::other"], position=[math.pi / 2, 1.0])
        joint.header.stamp = rospy.Time.from_sec(5.0)
        warned = Warned("/door_tf")
        none = pose_message(Pose())
        none.orientation.w = 0.0
        states.send(ModelStates(["door"], [none], [Twist()]))
        warned.wait_for("tf_publisher ignores a pose of door")
        poses = [pose_message(Pose()), pose_message(pose)]
        states.send(ModelStates(["floor", "door"], poses, [Twist(), Twist()]))
        self.joint_states.send(joint)
        moved = {"door", "door/leaf"}
        wait_until(lambda: moved <= {t.child_frame_id for t in self.transforms()}, "the door's frames")
        edges = {t.child_frame_id: t for t in self.transforms()}
        self.assertEqual(edges["door"].header.frame_id, "world")
        self.assertEqual(edges["door/leaf"].header.frame_id, "door/post")
        leaf = pose_of(edges["door"]) @ pose_of(edges["door/leaf"])
        # The door stands turned to the left by 90 degrees and is open by as much: its leaf lies along -x.
        for value, expected in zip(leaf.position_m, (2.5, 1.0, 0.0)):
            self.assertAlmostEqual(value, expected, places=9)
        self.assertAlmostEqual(abs(leaf.yaw_rad), math.pi, places=9)

    def transforms(self):
        return [transform for message in self.received for transform in message.transforms]

    def test_a_pose_that_is_none_is_ignored(self):
        self.fly_until_both()
        bad = Odometry()
        bad.header.stamp = rospy.Time.from_sec(self.seconds + 0.005)
        bad.pose.pose.position.x = math.nan
        self.ground_truth.send(bad)
        bad.pose.pose.position.x = 0.0  # and a quaternion of zeros
        self.odometry.send(bad)
        self.fly_until_both()
        for message in self.received:
            for transform in message.transforms:
                pose = pose_of(transform)
                self.assertTrue(all(map(math.isfinite, pose.position_m + pose.orientation_xyzw)))

    def test_without_odometry_the_world_edge_goes_on(self):
        self.fly_until_both()
        self.received.clear()
        for _ in range(110):  # a busy machine may lose some on the way
            type(self).seconds += 0.01
            count = len(self.received)
            self.publish(self.ground_truth, self.seconds, IN_WORLD)
            self.tf.holds(lambda _: len(self.received) > count, 0.05)  # noqa: B023
        self.assertGreaterEqual(len(self.received), 99)
        self.assertEqual({t.child_frame_id for m in self.received for t in m.transforms}, {"world"})

    def test_a_clock_that_jumps_back_is_followed(self):
        self.fly_until_both()
        type(self).seconds = 1.0
        self.fly_until_both()
        self.assertLess(self.seconds, 10.0)
