"""The contract of the node lidar_padding, seen from outside."""

import math
import unittest

import numpy as np
from dynamic_reconfigure.client import Client
from flight_basics_ros.testing import bad_scans, scan_of
from sensor_msgs.msg import LaserScan

from node_tools.testing import Input, Output, Stamps, Warned

NODE = "/padding/lidar_padding"


class LidarPaddingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scans = Input("padding/scan_in", LaserScan)
        cls.padded = Output("padding/scan_out", LaserScan)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.stamps = Stamps()

    def setUp(self):
        self.client.update_configuration({"value": "nan"})

    def answer(self, scan):
        self.scans.send(scan)
        return self.padded.next()

    def test_pads_to_a_full_turn_and_marks_the_unseen(self):
        ranges = np.linspace(1.0, 9.0, 1081)
        scan = scan_of(self.stamps.next(), ranges, frame="uav1/hokuyo")
        result = self.answer(scan)
        self.assertEqual(result.header.stamp, scan.header.stamp)
        self.assertEqual(result.header.frame_id, "uav1/hokuyo")
        self.assertEqual(len(result.ranges), 1440)
        self.assertEqual(result.angle_increment, np.float32(scan.angle_increment))
        self.assertAlmostEqual(result.angle_min, -math.pi, places=6)
        self.assertAlmostEqual(result.angle_max, math.pi - math.radians(0.25), places=6)
        intensities, values = np.array(result.intensities), np.array(result.ranges)
        np.testing.assert_array_equal(values[180:1261], ranges.astype(np.float32))
        np.testing.assert_array_equal(intensities[180:1261], 0.0)
        unseen = np.r_[0:180, 1261:1440]
        self.assertTrue(np.isnan(values[unseen]).all())
        np.testing.assert_array_equal(intensities[unseen], -1.0)
        self.assertEqual((result.range_min, result.range_max), (np.float32(0.06), np.float32(10.0)))

    def test_keeps_the_intensities_of_the_source(self):
        result = self.answer(scan_of(self.stamps.next(), [2.0, 3.0], turn=8, intensities=[50.0, 60.0]))
        np.testing.assert_array_equal(result.intensities, [-1, 50, 60, -1, -1, -1, -1, -1])

    def test_bad_scans_give_one_sentence_and_nothing_else(self):
        cases = bad_scans(self.stamps)
        for scan, complaint in cases:
            with self.subTest(complaint):
                self.scans.send(scan)
                self.warned.wait_for(complaint)
                self.scans.send(scan)
        self.padded.assert_quiet()
        for _, complaint in cases:
            self.assertEqual(self.warned.count(complaint), 1, complaint)
        good = scan_of(self.stamps.next(), [2.0] * 9)
        self.assertEqual(self.answer(good).header.stamp, good.header.stamp)

    def test_a_clock_that_jumps_back_is_said_and_survived(self):
        self.answer(scan_of(self.stamps.next(), [2.0] * 9))
        self.stamps = Stamps(start_s=5.0)
        scan = scan_of(self.stamps.next(), [2.0] * 9)
        self.assertEqual(self.answer(scan).header.stamp, scan.header.stamp)
        self.warned.wait_for("clock jumped back")

    def test_live_value(self):
        for value, expected in (("range_max", 10.0), ("inf", math.inf), ("4.5", 4.5)):
            self.client.update_configuration({"value": value})
            result = self.answer(scan_of(self.stamps.next(), [2.0] * 9))
            self.assertEqual(result.ranges[0], expected)
            self.assertEqual(result.intensities[0], -1.0)

    def test_a_senseless_value_is_refused_and_the_old_one_stays(self):
        kept = self.client.update_configuration({"value": "far away"})
        self.assertEqual(kept["value"], "nan")
        self.warned.wait_for("value is 'far away'")
        self.assertTrue(math.isnan(self.answer(scan_of(self.stamps.next(), [2.0] * 9)).ranges[0]))
