"""The contract of the node cepa_visualiser, seen from outside, fed by cepa itself."""

import math
import unittest

import numpy as np
import rospy
from cepa_probe import column, odometry_of, of_stamp, scan_of, velocity_of
from cepa_ros.parameters import Choice, config_of
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan, PointCloud2
from visualization_msgs.msg import Marker, MarkerArray

from cepa import CepaParameters
from node_tools.testing import Input, Output, Stamps, Warned, wait_until

R_LB, R_UB = 0.5, 1.2
DEFAULTS = config_of(Choice("improved", CepaParameters()))


class CepaVisualiserTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.pictures = Output("cepa_visualiser/markers", MarkerArray)
        cls.scans = Input("scan_in", LaserScan)
        cls.references = Input("vel_setpoint_in", TwistStamped)
        cls.odometry = Input("odometry", Odometry)
        cls.warned = Warned("/cepa_visualiser")
        cls.client = Client("/cepa", timeout=200.0)
        cls.client.update_configuration(DEFAULTS)
        cls.stamps = Stamps(5000.0)  # after those of rostest_tuning.py
        wait_until(lambda: cls.scans._publisher.get_num_connections() == 2, "cepa and its visualiser")
        cls.settle()

    @classmethod
    def settle(cls):
        """The decision comes over a connection that cepa only opens when somebody listens."""

        def is_shown():
            cls.scans.send(scan_of(cls.stamps.next()))
            rospy.rostime.wallsleep(0.05)
            return cls.pictures.messages

        wait_until(is_shown, "a picture")

    def setUp(self):
        rospy.rostime.wallsleep(0.1)
        self.pictures.messages.clear()

    def picture(self, ranges=None, v_ref=(2.0, 0.0, 0.0)):
        """The visible markers of one scan, by namespace."""
        stamp = self.stamps.next()
        self.references.deliver(velocity_of(stamp, v_ref))  # it has no order with scans here
        self.odometry.deliver(odometry_of(stamp))
        self.scans.send(scan_of(stamp, ranges))
        message = of_stamp(self.pictures, stamp)
        names = [(marker.header.frame_id, marker.ns, marker.id) for marker in message.markers]
        self.assertEqual(len(names), len(set(names)))
        for marker in message.markers:
            self.assertEqual((marker.header.frame_id, marker.header.stamp), ("base_frame", stamp))
            self.assertTrue(marker.frame_locked)
            self.assertTrue(all(math.isfinite(v) for p in marker.points for v in (p.x, p.y, p.z)))
        return {marker.ns: marker for marker in message.markers if marker.action == Marker.ADD}

    def radii(self, marker):
        return np.array([math.hypot(point.x, point.y) for point in marker.points])

    def tip(self, marker):
        return marker.points[1].x, marker.points[1].y

    def test_steering(self):
        shown = self.picture(column(0.0, 2.8))
        np.testing.assert_allclose(self.radii(shown["r_lb"]), R_LB)
        np.testing.assert_allclose(self.radii(shown["r_ub"]), R_UB)
        speed = math.hypot(*self.tip(shown["v_out"]))
        self.assertAlmostEqual(self.radii(shown["cushion_lb"]).max(), 1.5 * speed + R_LB)
        self.assertAlmostEqual(self.radii(shown["cushion_ub"]).max(), 1.5 * speed + R_UB)
        self.assertEqual(self.tip(shown["v_ref"]), (2.0, 0.0))
        self.assertNotIn("emergency original", shown)
        self.assertNotIn("intrusions", shown)
        bearings = [math.degrees(math.atan2(point.y, point.x)) for point in shown["rejected"].points]
        reach = 5.0 + math.degrees(math.asin(R_LB / 2.8))
        self.assertAlmostEqual(max(bearings), reach, delta=0.5)
        self.assertAlmostEqual(min(bearings), -reach, delta=0.5)

    def test_emergency(self):
        shown = self.picture(np.minimum(column(90.0, 0.4, 30.0), column(-90.0, 0.45, 30.0)))
        original, improved = shown["emergency original"], shown["emergency improved"]
        self.assertGreater(original.color.r, original.color.g)
        self.assertGreater(improved.color.g, improved.color.r)
        self.assertLess(self.tip(original)[1], 0.0)
        self.assertGreater(abs(self.tip(improved)[0]), abs(self.tip(improved)[1]))
        self.assertNotIn("cushion_lb", shown)
        ends = self.radii(shown["intrusions"])
        np.testing.assert_allclose(ends[0::2], R_LB)
        self.assertAlmostEqual(ends[1::2].min(), 0.4, places=5)

    def test_standing_still_shows_no_arrows(self):
        shown = self.picture(v_ref=(0.0, 0.0, 0.0))
        self.assertEqual(set(shown), {"r_lb", "r_ub"})

    def test_live_tuning_is_seen(self):
        self.client.update_configuration({"r_ub": 1.5})
        wait_until(lambda: abs(self.radii(self.picture()["r_ub"])[0] - 1.5) < 1e-9, "the new circle")
        self.client.update_configuration({"r_ub": R_UB})
        wait_until(lambda: abs(self.radii(self.picture()["r_ub"])[0] - R_UB) < 1e-9, "the old circle")

    def test_dynamic_shows_what_it_foresees_and_remembers(self):
        remembered = Output("cepa/remembered", PointCloud2)
        self.client.update_configuration({"algorithm": "dynamic"})
        self.addCleanup(self.client.update_configuration, {"algorithm": "improved"})
        near = column(0.0, 2.0)
        wait_until(lambda: "predicted path" in self.picture(near), "the new algorithm")
        shown = self.picture(near)
        for path in ("predicted path", "braking path"):
            first, last = shown[path].points[0], shown[path].points[-1]
            self.assertLess(math.hypot(first.x, first.y), 0.1)
            self.assertLess(math.hypot(last.x, last.y), 1.6 * 2.0 + R_LB)
        for name, radius in (("cushion_lb", R_LB), ("cushion_ub", R_UB)):
            edge = np.array([(point.x, point.y) for point in shown[name].points])
            path = np.array([(point.x, point.y) for point in shown["predicted path"].points])
            distances = np.hypot(*(edge[:, None] - path).transpose(2, 0, 1)).min(axis=1)
            np.testing.assert_allclose(distances, radius, rtol=0.05)
        self.assertNotIn("rejected", shown)
        cloud = remembered.last(lambda message: message.width > 0, "points of the column")
        points = np.frombuffer(cloud.data, np.float32).reshape(-1, 4)
        np.testing.assert_allclose(np.hypot(points[:, 0], points[:, 1]), 2.0, atol=0.01)

    def test_bad_scans_draw_nothing_and_the_clock_may_jump_back(self):
        self.scans.send(scan_of(self.stamps.next(), [], angle_max=-math.pi))
        self.pictures.assert_quiet()
        type(self).stamps = Stamps(5.0)
        self.assertIn("r_lb", self.picture())
