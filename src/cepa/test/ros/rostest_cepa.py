"""The contract of the node cepa, seen from outside."""

import itertools
import math
import subprocess
import sys
import unittest
from pathlib import Path

import numpy as np
import rospy
from cepa_probe import BEAMS, Mounts, column, odometry_of, of_stamp, scan_of, velocity_of
from cepa_ros.parameters import Choice, config_of
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_cases import DynamicCases
from dynamic_reconfigure.client import Client
from geometry_msgs.msg import TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from visualization_msgs.msg import MarkerArray

from cepa import CepaParameters, Improved, LaserScan2D, Original
from node_tools.testing import Input, Output, Stamps, Warned, long, wait_until

NODE = "/cepa"
DEFAULTS = config_of(Choice("improved", CepaParameters()))


class CepaTest(DynamicCases, unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.commands = Output("vel_setpoint_out", TwistStamped)
        cls.stats = Output("cepa/stats", DiagnosticArray)
        cls.decisions = Output("cepa/decision", MarkerArray)
        cls.scans = Input("scan_in", LaserScan)
        cls.references = Input("vel_setpoint_in", TwistStamped)
        cls.odometry = Input("odometry", Odometry)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.mounts = Mounts()
        cls.starts = itertools.count(100, 100)

    def setUp(self):
        self.stamps = Stamps(next(self.starts))
        self.client.update_configuration(DEFAULTS)
        self.share_a_stamp()

    def share_a_stamp(self):
        """Show cepa that reference and odometry come with the stamps of scans, until it waits for them."""
        wait_until(lambda: self.answer((0.25, 0.0, 0.0))[0] > 0.0, "an answer to a scan's own reference")
        rospy.rostime.wallsleep(0.05)

    def answer(
        self, v_ref=(1.0, 0.0, 0.0), ranges=None, own=(0.0, 0.0, 0.0), v_ref_frame="base_frame", **scan
    ):
        """The command for one scan whose reference and odometry have its own stamp."""
        stamp = self.stamps.next()
        self.odometry.send(odometry_of(stamp, own))
        self.scans.send(scan_of(stamp, ranges, **scan))
        self.references.send(velocity_of(stamp, v_ref, v_ref_frame))
        command = of_stamp(self.commands, stamp)
        self.assertEqual(command.header.frame_id, "base_frame")
        v = command.twist.linear
        return v.x, v.y, v.z

    def assert_velocity(self, velocity, expected):
        np.testing.assert_allclose(velocity, expected, atol=1e-6)

    # what it answers

    def test_in_the_open_the_reference_passes_with_its_height(self):
        self.assert_velocity(self.answer((1.2, -0.4, 0.3)), (1.2, -0.4, 0.3))

    def test_it_answers_as_the_library_does(self):
        ranges = column(5.0, 2.0)
        rounded = LaserScan2D(
            np.float32(ranges), np.float32(-math.pi), np.float32(2 * math.pi / BEAMS), 0.06, 10.0
        )
        for name, algorithm in (("improved", Improved), ("original", Original)):
            self.client.update_configuration({"algorithm": name})
            expected = algorithm(CepaParameters()).steer(rounded, (2.0, 0.0), (1.5, 0.2))
            self.assert_velocity(
                self.answer((2.0, 0.0, 0.0), ranges, (1.5, 0.2, 0.0))[:2], expected.velocity_xy
            )

    def test_a_ring_at_range_max_is_nothing_and_no_wall(self):
        self.mounts.add("base_frame", "of_gazebo")
        ranges = column(180.0, 0.9)
        told = np.where(np.isinf(ranges), 1.0, ranges)
        expected = self.answer((1.0, 0.3, 0.0), ranges, range_max=1.0)
        self.assertGreater(expected[0], 0.9)
        self.assert_velocity(self.answer((1.0, 0.3, 0.0), told, range_max=1.0, frame="of_gazebo"), expected)
        self.warned.wait_for("range_max")

    def test_an_emergency_flees_whatever_the_reference(self):
        x, _, z = self.answer((1.0, 0.0, 0.2), column(0.0, 0.4))
        self.assertLess(x, -0.1)
        self.assertAlmostEqual(z, 0.2)

    def test_stats(self):
        self.stats.messages.clear()
        self.answer((1.0, 0.0, 0.0), column(0.0, 0.4))
        status = self.stats.next().status[0]
        values = {pair.key: pair.value for pair in status.values}
        self.assertEqual((status.level, status.message), (1, "emergency sum"))
        self.assertEqual(
            set(values),
            {
                *("computation_time_ms", "cpu_time_ms", "directions_tested"),
                *("cost", "emergency", "reason", "algorithm"),
            },
        )
        self.assertGreater(float(values["cpu_time_ms"]), 0.0)
        # The thread cannot have worked for longer than it took, but for the clocks' steps.
        self.assertGreater(float(values["computation_time_ms"]), float(values["cpu_time_ms"]) - 0.02)

    def test_decision_shows_both_emergency_proposals(self):
        for algorithm in ("improved", "original"):
            self.client.update_configuration({"algorithm": algorithm})
            self.decisions.messages.clear()
            self.answer(ranges=np.minimum(column(90.0, 0.4), column(-60.0, 0.45)))
            markers = {marker.ns: marker for marker in self.decisions.next().markers}
            expected = {"v_ref", "v_out", "v_uav", "emergency original", "emergency improved"}
            self.assertEqual(set(markers), expected)
            self.assertEqual(markers["v_out"].header.frame_id, "base_frame")

    # pairing and age

    def test_a_scan_is_paired_with_the_reference_of_its_stamp_not_the_newest(self):
        self.answer()
        stamp = self.stamps.next()
        self.scans.send(scan_of(stamp))
        self.odometry.send(odometry_of(stamp))
        self.commands.assert_quiet()  # it waits
        self.references.send(velocity_of(stamp, (0.7, 0.0, 0.0)))
        self.assertAlmostEqual(of_stamp(self.commands, stamp).twist.linear.x, 0.7)

    def test_a_reference_that_is_missing_is_waited_for_until_the_next_scan(self):
        self.answer((1.0, 0.0, 0.0))
        first, second = self.stamps.next(), self.stamps.next()
        self.scans.send(scan_of(first))
        self.commands.assert_quiet()
        self.scans.send(scan_of(second))
        self.assertAlmostEqual(of_stamp(self.commands, first).twist.linear.x, 1.0)
        self.assertAlmostEqual(of_stamp(self.commands, second).twist.linear.x, 1.0)

    def test_a_stale_reference_counts_as_zero(self):
        self.answer((1.0, 0.0, 0.5))
        self.scans.send(scan_of(self.stamps.next()))
        self.commands.assert_quiet()  # it waits for the reference; from the next scan on no more
        for step_s, expected in ((0.4, (1.0, 0.5)), (0.2, (0.0, 0.0))):
            stamp = self.stamps.next(step_s)
            self.scans.send(scan_of(stamp))
            linear = of_stamp(self.commands, stamp).twist.linear
            self.assertEqual((linear.x, linear.z), expected)

    # frames

    def test_references_of_other_frames_are_turned_by_yaw_only(self):
        self.mounts.add("odom", "base_frame", yaw=math.pi / 2, pitch=0.3)
        self.assert_velocity(self.answer((0.0, 1.0, 0.1), v_ref_frame=""), (0.0, 1.0, 0.1))
        stamp_is_known = self.answer_soon((0.0, 1.0, 0.1), "odom")
        self.assert_velocity(stamp_is_known, (1.0, 0.0, 0.1))

    def answer_soon(self, v_ref, frame):
        """TF comes over its own connection: ask until it is there."""
        return self.first_move(f"{frame} to become known", v_ref, v_ref_frame=frame)

    def first_move(self, what, *how, **more):
        """Ask until the answer is another than to hover; returns it."""
        answers = []

        def moves():
            answers.append(self.answer(*how, **more))
            return answers[-1] != (0.0, 0.0, 0.0)

        wait_until(moves, what)
        return answers[-1]

    def test_a_reference_of_an_unknown_frame_counts_as_zero(self):
        self.assert_velocity(self.answer(v_ref_frame="nowhere"), (0.0, 0.0, 0.0))
        self.warned.wait_for('TF knows no transform from "nowhere" to "base_frame"')

    def test_it_hovers_until_the_lidars_mounting_is_known(self):
        self.assert_velocity(self.answer(frame="late_lidar"), (0.0, 0.0, 0.0))
        self.warned.wait_for("Hovering until the lidar's mounting is known")
        self.mounts.add("base_frame", "late_lidar")
        self.assert_velocity(self.first_move("the mounting", frame="late_lidar"), (1.0, 0.0, 0.0))

    def test_a_turned_and_a_flipped_lidar(self):
        self.mounts.add("base_frame", "turned_lidar", yaw=math.pi / 2)
        self.mounts.add("base_frame", "flipped_lidar", roll=math.pi)
        ahead_left = 10.0  # degrees in the body
        expected = self.answer((1.5, 0.0, 0.0), column(ahead_left, 1.5))
        self.assertLess(expected[1], -0.1)
        for frame, bearing in (("turned_lidar", ahead_left - 90.0), ("flipped_lidar", -ahead_left)):
            velocity = self.first_move(frame, (1.5, 0.0, 0.0), column(bearing, 1.5), frame=frame)
            np.testing.assert_allclose(velocity, expected, atol=0.02)  # a quarter of a degree: whole beams

    def test_a_lidar_that_does_not_lie_flat_is_refused(self):
        self.mounts.add("base_frame", "upright_lidar", pitch=math.pi / 2)

        def refused():
            self.assert_velocity(self.answer(frame="upright_lidar"), (0.0, 0.0, 0.0))
            return self.warned.count("leans by 90 degrees")

        wait_until(refused, "a word about it")

    # bad input

    def test_bad_scans_give_one_sentence_and_nothing_else(self):
        good = np.full(BEAMS, np.inf)
        cases = {
            "holds no beams": {"ranges": [], "angle_max": -math.pi},
            "no valid reading": {"ranges": np.full(BEAMS, np.nan)},
            "angle_increment must be": {"angle_increment": 0.0},
            "angles ask for 1440": {"ranges": good[:-7], "angle_max": math.pi - math.radians(0.25)},
            "0 <= range_min < range_max": {"range_max": -1.0},
            "2 intensities for 1440": {"intensities": [1.0, 2.0]},
            "angle_min must be finite": {"angle_min": math.nan},
        }
        for complaint, changes in cases.items():
            for _ in range(2):
                self.scans.send(scan_of(self.stamps.next(), **{"ranges": good, **changes}))
            self.warned.wait_for(complaint)
        self.commands.assert_quiet()
        for complaint in cases:
            self.assertEqual(self.warned.count(complaint), 1, complaint)
        self.assert_velocity(self.answer(), (1.0, 0.0, 0.0))

    def test_velocities_that_are_not_finite_count_as_zero(self):
        self.assert_velocity(self.answer((math.nan, 0.0, 0.0)), (0.0, 0.0, 0.0))
        self.warned.wait_for("reference velocity is not finite")
        self.assert_velocity(self.answer(own=(math.inf, 0.0, 0.0)), (1.0, 0.0, 0.0))
        self.warned.wait_for("odometry's velocity is not finite")

    def test_velocities_beyond_all_reason_count_as_zero(self):
        self.assert_velocity(self.answer((1e308, 0.0, 0.0)), (0.0, 0.0, 0.0))
        self.assert_velocity(self.answer((1.0, 0.0, -2e6)), (0.0, 0.0, 0.0))
        self.warned.wait_for("reference velocity is beyond 1e+06 m/s")
        self.assert_velocity(self.answer(own=(1e300, 0.0, 0.0)), (1.0, 0.0, 0.0))
        self.warned.wait_for("odometry's velocity is beyond 1e+06 m/s")

    def test_beams_of_intensity_minus_one_are_unseen(self):
        intensities = np.full(BEAMS, -1.0)
        intensities[BEAMS // 2 :] = 0.0  # only the left is seen
        _, y, _ = self.answer((1.0, -1.0, 0.0), intensities=intensities)
        self.assertGreaterEqual(y, -1e-6)
        self.client.update_configuration({"unseen_is_free": True})
        self.assert_velocity(self.answer((1.0, -1.0, 0.0), intensities=intensities), (1.0, -1.0, 0.0))

    def test_a_clock_that_jumps_back_is_said_and_survived(self):
        self.answer()
        self.stamps = Stamps(5.0)
        self.share_a_stamp()
        self.assert_velocity(self.answer((0.5, 0.0, 0.0)), (0.5, 0.0, 0.0))
        self.warned.wait_for("clock jumped back")

    def test_messages_of_another_clock_are_dropped(self):
        self.assert_velocity(self.answer(), (1.0, 0.0, 0.0))
        before = self.warned.count("clock jumped back")
        ahead = rospy.Time.now() + rospy.Duration(60.0)
        self.scans.send(scan_of(ahead))
        self.references.send(velocity_of(ahead, (0.0, 1.0, 0.0)))
        self.odometry.send(odometry_of(ahead, (0.0, 1.0, 0.0)))
        for what in ("scan", "reference velocity", "odometry"):
            self.warned.wait_for(f"The {what} is stamped")
        self.assert_velocity(self.answer(), (1.0, 0.0, 0.0))
        self.assertEqual(self.warned.count("clock jumped back"), before)

    # parameters

    def test_combinations_that_make_no_sense_keep_the_old_values(self):
        cases = [
            ({"r_lb": 1.5}, "r_lb must be less than r_ub", "r_lb", 0.5),
            (
                {"speed_fractions": "fast"},
                "speed_fractions must be numbers",
                "speed_fractions",
                DEFAULTS["speed_fractions"],
            ),
            ({"algorithm": "magic"}, "algorithm is 'magic'", "algorithm", "improved"),
        ]
        for change, sentence, name, kept in cases:
            self.assertEqual(self.client.update_configuration(change)[name], kept)
            self.warned.wait_for(sentence)
        self.assert_velocity(self.answer(), (1.0, 0.0, 0.0))

    @long
    def test_an_unknown_algorithm_at_the_start_is_a_sentence_and_exit_code_1(self):
        cepa = Path(sys.argv[0]).parents[1] / "cepa/cepa"  # rosrun takes long to find it
        command = [str(cepa), "__name:=cepa_wrong", "_algorithm:=magic"]
        ended = subprocess.run(command, capture_output=True, text=True, timeout=200.0, check=False)
        self.assertEqual(ended.returncode, 1)
        said = ended.stdout + ended.stderr
        self.assertIn("algorithm is 'magic'; it must be one of improved, original, dynamic.", said)
        self.assertNotIn("Traceback", said)
