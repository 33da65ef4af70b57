"""Live tuning: each parameter is changed through dynamic_reconfigure, and the next answer shows it."""

import unittest
from collections import deque

import numpy as np
import rospy
from cepa_probe import odometry_of, of_stamp, scan_of, velocity_of
from cepa_ros.parameters import Choice, config_of
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tuning_cases import CASES, PERIOD_S, UNSEEN_INTENSITY

from cepa import CepaParameters
from node_tools.testing import Input, Output, Stamps, Warned

NODE = "/cepa"
DEFAULTS = config_of(Choice("improved", CepaParameters()))


class TuningTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.commands = Output("vel_setpoint_out", TwistStamped)
        cls.scans = Input("scan_in", LaserScan)
        cls.references = Input("vel_setpoint_in", TwistStamped)
        cls.odometry = Input("odometry", Odometry)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.axes = deque(("base_frame", "odom"))
        cls.stamps = Stamps(1000.0)  # after those of rostest_cepa.py, whose clock jumps

    def configure(self, **changes):
        config = {**DEFAULTS, **changes}
        if "speed_fractions" in changes:
            config["speed_fractions"] = " ".join(map(str, changes["speed_fractions"]))
        if "algorithm" in changes:
            self.client.update_configuration(DEFAULTS)  # another algorithm, so that nothing is remembered
        self.client.update_configuration(config)

    def answer(self, case):
        if case.before is not None:
            self.ask(case, case.before, np.zeros_like(case.unseen))
        return self.ask(case, case.ranges, case.unseen)

    def ask(self, case, ranges, unseen):
        stamp = self.stamps.next(PERIOD_S)
        intensities = np.where(unseen, UNSEEN_INTENSITY, 0.0)
        odometry = odometry_of(stamp, (*case.own, 0.0), case.height_m, case.pitch_rad)
        # With yaw 0 both axes are the same. A change of them lets the comparison with the places, which stand
        # still here, begin anew.
        self.axes.rotate(1)
        odometry.child_frame_id = self.axes[0]
        self.odometry.send(odometry)
        self.scans.send(scan_of(stamp, ranges, intensities=intensities))
        self.references.send(velocity_of(stamp, (*case.v_ref, 0.0)))
        linear = of_stamp(self.commands, stamp).twist.linear
        return linear.x, linear.y

    def test_each_parameter_changes_the_next_answer_as_it_does_the_librarys(self):
        self.answer(CASES[0])
        rospy.rostime.wallsleep(0.05)  # cepa has seen that all three share a stamp, and waits for them
        for case in CASES:
            with self.subTest(case.name):
                change = {case.name: case.value}
                self.configure(**case.given)
                before = self.answer(case)
                self.configure(**case.given, **change)
                after = self.answer(case)
                np.testing.assert_allclose(before, case.answer(), atol=1e-6)
                np.testing.assert_allclose(after, case.answer(**change), atol=1e-6)
                self.assertGreater(np.hypot(*np.subtract(after, before)), 0.01)

    def test_without_an_attitude_near_in_time_or_of_sense_floor_is_an_obstacle(self):
        case = next(case for case in CASES if case.name == "levelling")
        self.configure(levelling=True)
        self.answer(case)
        self.assertEqual(self.answer(case), case.v_ref)
        held = case.answer()  # of the library, without levelling
        # Given an orientation that is none
        stamp = self.stamps.next()
        odometry = odometry_of(stamp, (0.0, 0.0, 0.0), case.height_m)
        odometry.pose.pose.orientation.w = 0.0
        self.odometry.send(odometry)
        self.references.send(velocity_of(stamp, (*case.v_ref, 0.0)))
        self.scans.send(scan_of(stamp, case.ranges))
        linear = of_stamp(self.commands, stamp).twist.linear
        np.testing.assert_allclose((linear.x, linear.y), held, atol=1e-6)
        self.warned.wait_for("orientation must be a unit quaternion")
        # Given an odometry that is 0.1 s older than the scan
        self.odometry.send(odometry_of(self.stamps.next(), (0.0, 0.0, 0.0), case.height_m, case.pitch_rad))
        stamp = self.stamps.next(0.1)
        self.references.send(velocity_of(stamp, (*case.v_ref, 0.0)))
        self.scans.send(scan_of(stamp, case.ranges))
        self.commands.assert_quiet()  # it waits for the odometry of this stamp, until the next scan comes
        self.scans.send(scan_of(self.stamps.next(0.1), case.ranges))
        linear = of_stamp(self.commands, stamp).twist.linear
        np.testing.assert_allclose((linear.x, linear.y), held, atol=1e-6)
        self.warned.wait_for("No odometry is near to the scan in time")
