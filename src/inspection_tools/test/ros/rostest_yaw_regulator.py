"""The contract of the node yaw_regulator, seen from outside."""

import math
import time
import unittest

import rospy
from dynamic_reconfigure.client import Client
from flight_basics_ros.testing import velocity_of
from geometry_msgs.msg import TransformStamped, TwistStamped
from tf2_msgs.msg import TFMessage

from node_tools.testing import Input, Output, Stamps, Warned, wait_until

NODE = "/yaw/yaw_regulator"
DEFAULTS = {"gain": 1.5, "max_yaw_rate": 1.0, "speed_on": 0.25, "speed_off": 0.15}
ANSWER_S = 0.5


class YawRegulatorTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.commands = Input("yaw/vel_setpoint_in", TwistStamped)
        cls.references = Input("yaw/vel_reference", TwistStamped)
        cls.final = Output("yaw/vel_setpoint_out", TwistStamped)
        cls.warned = Warned(NODE)
        cls.client = Client(NODE, timeout=200.0)
        cls.stamps = Stamps()

    def setUp(self):
        self.client.update_configuration(DEFAULTS)
        self.stamps.next(step_s=1.0)  # old references are forgotten
        wait_until(self.hovers, "the answer to a hover command")
        self.final.messages.clear()

    def hovers(self):
        """Switch the hysteresis off; the first command of several may wait for a reference, in vain."""
        stamp = self.stamps.next()
        self.commands.send(velocity_of(stamp, (0.0, 0.0, 0.0)))
        end_s = time.monotonic() + ANSWER_S
        while time.monotonic() < end_s:
            if self.final.messages and self.final.messages[-1].header.stamp == stamp:
                return True
            time.sleep(0.003)
        return False

    def answer(self, linear, frame="base_frame"):
        self.commands.send(velocity_of(self.stamps.next(), linear, frame))
        return self.final.next()

    def test_adds_the_yaw_rate_and_carries_everything_else_through(self):
        stamp = self.stamps.next()
        command = velocity_of(stamp, (1.0, 0.5, -0.3))
        command.twist.angular.x = 9.0  # means nothing for a levelled velocity
        self.commands.send(command)
        result = self.final.next()
        self.assertEqual(result.header.stamp, stamp)
        self.assertEqual(result.header.frame_id, "base_frame")
        linear, angular = result.twist.linear, result.twist.angular
        self.assertEqual((linear.x, linear.y, linear.z), (1.0, 0.5, -0.3))
        self.assertEqual((angular.x, angular.y), (0.0, 0.0))
        self.assertAlmostEqual(angular.z, 1.5 * math.atan2(0.5, 1.0))

    def test_no_frame_means_the_body_frame_and_stays_so(self):
        self.assertEqual(self.answer((0.0, 1.0, 0.0), frame="").header.frame_id, "")

    def test_does_not_turn_when_hovering(self):
        self.assertEqual(self.answer((0.0, 0.1, 1.0)).twist.angular.z, 0.0)

    def test_turns_towards_the_reference_when_held_back(self):
        stamp = self.stamps.next()
        self.references.deliver(velocity_of(stamp, (0.0, -1.0, 0.0)))
        self.commands.send(velocity_of(stamp, (0.0, 0.0, 0.0)))
        self.assertEqual(self.final.next().twist.angular.z, -1.0)

    def test_an_old_reference_counts_as_none(self):
        self.references.deliver(velocity_of(self.stamps.next(), (0.0, -1.0, 0.0)))
        self.assertEqual(self.answer((0.0, 0.0, 0.0)).twist.angular.z, -1.0)  # 25 ms old
        self.stamps.next(step_s=0.5)
        self.assertEqual(self.answer((0.0, 0.0, 0.0)).twist.angular.z, 0.0)

    def test_a_reference_without_a_stamp_is_as_new_as_it_came(self):
        self.references.deliver(velocity_of(rospy.Time(0), (0.0, -1.0, 0.0)))
        stamps = Stamps(start_s=rospy.get_time())
        self.commands.send(velocity_of(stamps.next(), (0.0, 0.0, 0.0)))
        self.assertEqual(self.final.next().twist.angular.z, -1.0)

    def test_waits_for_the_reference_that_belongs_to_the_command(self):
        first = self.stamps.next()
        self.references.deliver(velocity_of(first, (0.0, -1.0, 0.0)))
        self.commands.send(velocity_of(first, (0.0, 0.0, 0.0)))
        self.assertEqual(self.final.next().twist.angular.z, -1.0)
        second = self.stamps.next()
        self.commands.send(velocity_of(second, (0.0, 0.0, 0.0)))  # overtakes its reference
        self.final.assert_quiet()
        self.references.send(velocity_of(second, (0.0, 1.0, 0.0)))
        result = self.final.next()
        self.assertEqual((result.header.stamp, result.twist.angular.z), (second, 1.0))
        # the next goes without: nobody waits for a source that died for longer than a command
        self.commands.send(velocity_of(self.stamps.next(), (0.0, 0.0, 0.0)))
        self.final.assert_quiet()
        self.assertEqual(self.answer((0.0, 0.0, 0.0)).twist.angular.z, 1.0)

    def test_bad_commands_give_one_sentence_and_nothing_else(self):
        cases = [
            ((math.nan, 0.0, 0.0), "base_frame", "not finite. The command"),
            ((0.0, 0.0, math.inf), "base_frame", "not finite. The command"),
            ((0.0, 1e300, 0.0), "base_frame", "beyond 1e+06 m/s; check its source. The command"),
            ((1.0, 0.0, 0.0), "odom", 'frame "odom"'),
        ]
        for linear, frame, complaint in cases:
            self.commands.send(velocity_of(self.stamps.next(), linear, frame))
            self.warned.wait_for(complaint)
        self.final.assert_quiet()
        self.assertEqual(self.warned.count("not finite. The command"), 1)
        self.assertEqual(self.answer((1.0, 0.0, 0.0)).twist.linear.x, 1.0)

    def test_bad_references_are_ignored(self):
        for linear, frame, complaint in (
            ((math.nan, 0.0, 0.0), "base_frame", "not finite. The reference"),
            ((0.0, 1e300, 0.0), "base_frame", "beyond 1e+06 m/s; check its source. The reference"),
            ((0.0, 1.0, 0.0), "map", 'no transform from "map" to "base_frame". The reference is ignored'),
        ):
            self.references.send(velocity_of(self.stamps.next(), linear, frame))
            self.warned.wait_for(complaint)
        self.assertEqual(self.answer((0.0, 0.0, 0.0)).twist.angular.z, 0.0)

    def test_a_reference_of_another_frame_is_turned_by_yaw(self):
        # the body faces the world's y, so that the world's x is to its right; it leans forward meanwhile
        transform = TransformStamped()
        transform.header.frame_id, transform.child_frame_id = "base_frame", "world"
        half_yaw, half_lean = -math.pi / 4.0, 0.1
        q = transform.transform.rotation
        q.x, q.z = math.sin(half_lean) * math.cos(half_yaw), math.cos(half_lean) * math.sin(half_yaw)
        q.y = math.sin(half_lean) * math.sin(half_yaw)
        q.w = math.cos(half_lean) * math.cos(half_yaw)
        tf = rospy.Publisher("yaw/tf_static", TFMessage, queue_size=1, latch=True)
        tf.publish(TFMessage([transform]))
        self.client.update_configuration({"max_yaw_rate": 5.0})

        def yaw_rate():
            stamp = self.stamps.next()
            self.references.deliver(velocity_of(stamp, (0.6, 0.6, 0.0), "world"))
            self.commands.send(velocity_of(stamp, (0.0, 0.0, 0.0)))
            rospy.sleep(0.05)
            return self.final.messages.pop().twist.angular.z if self.final.messages else 0.0

        wait_until(
            lambda: yaw_rate() != 0.0, "a turn towards the reference"
        )  # TF comes over its own connection
        self.assertAlmostEqual(yaw_rate(), -1.5 * math.pi / 4.0, places=6)
        self.final.messages.clear()

    def test_a_clock_that_jumps_back_clears_the_hysteresis(self):
        self.assertNotEqual(self.answer((0.0, 1.0, 0.0)).twist.angular.z, 0.0)
        self.assertNotEqual(self.answer((0.0, 0.2, 0.0)).twist.angular.z, 0.0)
        self.stamps = Stamps(start_s=5.0)
        self.assertEqual(self.answer((0.0, 0.2, 0.0)).twist.angular.z, 0.0)
        self.warned.wait_for("clock jumped back")

    def test_live_parameters(self):
        self.client.update_configuration({"gain": 0.5, "max_yaw_rate": 3.0})
        self.assertAlmostEqual(self.answer((0.0, 1.0, 0.0)).twist.angular.z, 0.25 * math.pi)

    def test_thresholds_the_wrong_way_round_are_refused(self):
        kept = self.client.update_configuration({"speed_off": 0.5})
        self.assertEqual(kept["speed_off"], 0.15)
        self.warned.wait_for("speed_off is 0.5 m/s; it must be below speed_on")
