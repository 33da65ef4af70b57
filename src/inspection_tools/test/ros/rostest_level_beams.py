"""The contract of the node level_beams, seen from outside."""

import math
import unittest

import numpy as np
import rospy
from flight_basics_ros.testing import bad_scans, scan_of
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input, Output, Stamps, Warned

NODE = "/level/level_beams"
AHEAD = 540


def lidar_at(stamp, pitch):
    edge = TransformStamped(child_frame_id="hokuyo")
    edge.header.stamp, edge.header.frame_id = stamp, "base_frame"
    edge.transform.translation = Vector3(0.0, 0.0, 0.1)
    edge.transform.rotation = Quaternion(0.0, math.sin(pitch / 2.0), 0.0, math.cos(pitch / 2.0))
    return TFMessage([edge])


class LevelBeamsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scans = Input("level/scan_in", LaserScan)
        cls.tf = Input("level/tf", TFMessage)
        cls.level = Output("level/scan_out", LaserScan)
        cls.whole = Output("level/scan_whole", LaserScan)
        cls.static = Output("level/tf_static", TFMessage)
        cls.warned = Warned(NODE)
        cls.stamps = Stamps()

    def answer(self, ranges, pitch):
        stamp = self.stamps.next()
        self.scans.send(scan_of(stamp, ranges, frame="hokuyo"))
        self.tf.send(lidar_at(stamp, pitch))
        found = self.level.last(lambda message: message.header.stamp == stamp, "the answer to a scan")
        self.level.messages.clear()
        self.assertEqual(found.header.frame_id, "lidar_level")
        return np.array(found.ranges)

    def test_a_level_lidars_scans_pass_and_a_nodding_ones_lose_what_is_not_level(self):
        ranges = np.linspace(1.0, 9.0, 1081, dtype=np.float32)
        np.testing.assert_array_equal(self.answer(ranges, 0.0), ranges)
        self.whole.last(lambda message: True, "a whole scan")
        self.whole.messages.clear()
        steep = self.answer(ranges, 0.6)
        self.whole.assert_quiet()
        self.assertTrue(np.isnan(steep[AHEAD]))
        self.assertAlmostEqual(steep[AHEAD + 360], ranges[AHEAD + 360], delta=0.05)  # along the axis
        np.testing.assert_array_equal(self.answer(ranges, 0.0), ranges)

    def test_the_level_frame_is_told_once_with_the_lidars_place(self):
        self.answer(np.ones(1081, np.float32), 0.0)
        edge = self.static.last(lambda message: True, "the static frame").transforms[0]
        self.assertEqual((edge.header.frame_id, edge.child_frame_id), ("base_frame", "lidar_level"))
        self.assertAlmostEqual(edge.transform.translation.z, 0.1)
        self.assertAlmostEqual(edge.transform.rotation.y, 0.0)

    def test_scans_that_make_no_sense_are_dropped_with_a_sentence(self):
        for scan, words in bad_scans(self.stamps):
            self.scans.send(scan)
            self.tf.send(lidar_at(scan.header.stamp, 0.3))
            self.warned.wait_for(words)
        self.level.assert_quiet()
        self.answer(np.ones(1081, np.float32), 0.0)

    def test_a_scan_without_tf_is_dropped_and_told(self):
        for _ in range(8):  # the node may take the newest of some only
            self.scans.send(scan_of(self.stamps.next(), np.ones(1081), frame="elsewhere"))
            rospy.rostime.wallsleep(0.05)
        self.warned.wait_for('TF told no "elsewhere"')
        for _ in range(3):  # these push out the ones that wait
            stamp = self.stamps.next()
            self.scans.send(scan_of(stamp, np.ones(1081), frame="hokuyo"))
            rospy.rostime.wallsleep(0.05)
            self.tf.send(lidar_at(stamp, 0.0))
        self.answer(np.ones(1081, np.float32), 0.0)
