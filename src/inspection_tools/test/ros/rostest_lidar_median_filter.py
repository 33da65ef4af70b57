"""The contract of the node lidar_median_filter, seen from outside."""

import math
import unittest

import numpy as np
import rospy
from dynamic_reconfigure.client import Client
from flight_basics_ros.testing import bad_scans, scan_of
from sensor_msgs.msg import LaserScan

from node_tools.testing import Input, Output, Stamps, Warned

NODE = "/median/lidar_median_filter"


class LidarMedianFilterTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scans = Input("median/scan_in", LaserScan)
        cls.filtered = Output("median/scan_out", LaserScan)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.stamps = Stamps()

    def setUp(self):
        self.client.update_configuration({"window": 3, "scans": 1})

    def answer(self, scan):
        self.scans.send(scan)
        return self.filtered.next()

    def test_filters_and_carries_everything_else_through(self):
        ranges = [5.0, 5.0, 1.0, 5.0, math.nan, 5.0, math.inf, math.inf, math.inf]
        scan = scan_of(
            self.stamps.next(), ranges, intensities=[float(i) for i in range(9)], frame="uav1/hokuyo"
        )
        scan.time_increment = 1e-5
        result = self.answer(scan)
        expected = [5.0, 5.0, 5.0, 1.0, 5.0, 5.0, math.inf, math.inf, math.inf]
        np.testing.assert_array_equal(result.ranges, expected)
        self.assertEqual(result.header.stamp, scan.header.stamp)
        self.assertEqual(result.header.frame_id, "uav1/hokuyo")
        self.assertEqual(list(result.intensities), scan.intensities)
        for name in ("angle_min", "angle_max", "angle_increment", "time_increment", "scan_time"):
            self.assertEqual(getattr(result, name), np.float32(getattr(scan, name)), name)
        self.assertEqual((result.range_min, result.range_max), (np.float32(0.06), np.float32(10.0)))

    def test_bad_scans_give_one_sentence_and_nothing_else(self):
        for scan, complaint in bad_scans(self.stamps):
            with self.subTest(complaint):
                self.scans.send(scan)
                self.warned.wait_for(complaint)
                self.scans.send(scan)
        self.filtered.assert_quiet()
        for _, complaint in bad_scans(self.stamps):
            self.assertEqual(self.warned.count(complaint), 1, complaint)
        good = scan_of(self.stamps.next(), [2.0] * 9)
        self.assertEqual(self.answer(good).header.stamp, good.header.stamp)

    def test_a_blind_lidar_stays_blind(self):
        result = self.answer(scan_of(self.stamps.next(), [math.nan] * 9))
        self.assertTrue(np.isnan(result.ranges).all())

    def test_a_full_turn_may_leave_out_its_last_beam(self):
        scan = scan_of(self.stamps.next(), [2.0] * 360, turn=360)
        scan.angle_max = scan.angle_min + 2.0 * math.pi
        self.assertEqual(len(self.answer(scan).ranges), 360)

    def test_another_number_of_beams_is_another_scan(self):
        self.client.update_configuration({"scans": 3})
        for beams in (9, 9, 5, 7):
            self.assertEqual(len(self.answer(scan_of(self.stamps.next(), [2.0] * beams)).ranges), beams)

    def test_a_clock_that_jumps_back_clears_the_history(self):
        self.client.update_configuration({"scans": 3})
        for _ in range(3):
            self.answer(scan_of(self.stamps.next(), [6.0] * 9))
        self.assertEqual(self.answer(scan_of(self.stamps.next(), [2.0] * 9)).ranges[4], 6.0)
        self.stamps = Stamps(start_s=5.0)
        self.assertEqual(self.answer(scan_of(self.stamps.next(), [2.0] * 9)).ranges[4], 2.0)
        self.warned.wait_for("clock jumped back")

    def test_a_stamp_of_another_clock_is_dropped_and_the_history_stays(self):
        self.client.update_configuration({"scans": 3})
        for _ in range(3):
            self.answer(scan_of(self.stamps.next(), [6.0] * 9))
        before = self.warned.count("clock jumped back")
        for _ in range(3):
            self.scans.send(scan_of(rospy.Time.now() + rospy.Duration(60.0), [2.0] * 9))
        self.warned.wait_for("ahead of ROS time")
        self.assertEqual(self.answer(scan_of(self.stamps.next(), [2.0] * 9)).ranges[4], 6.0)
        self.assertEqual(self.warned.count("ahead of ROS time"), 1)
        self.assertEqual(self.warned.count("clock jumped back"), before)

    def test_live_parameters(self):
        lone = [5.0] * 4 + [1.0] + [5.0] * 4
        self.assertEqual(self.answer(scan_of(self.stamps.next(), lone)).ranges[4], 5.0)
        self.client.update_configuration({"window": 1})
        self.assertEqual(self.answer(scan_of(self.stamps.next(), lone)).ranges[4], 1.0)

    def test_an_even_window_is_refused_and_the_old_one_stays(self):
        kept = self.client.update_configuration({"window": 4, "scans": 2})
        self.assertEqual((kept["window"], kept["scans"]), (3, 1))
        self.assertEqual(rospy.get_param(NODE + "/window"), 3)
        self.warned.wait_for("window is 4; it must be odd")
