"""What the node explore promises: an action with feedback, pause, resume, abort, and a way home in time."""

import math
import os
import signal
import unittest
from xmlrpc.client import ServerProxy

import rospy
from actionlib_msgs.msg import GoalStatus
from drawn_voxels import block, tiles_of
from exploration_ros.planner_messages import tiles_class
from flight_basics_ros.lock_order import take_report
from flight_basics_ros.testing import Newest, odometry_of
from geometry_msgs.msg import Pose
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from exploration.msg import ExploreActionFeedback, ExploreActionGoal, ExploreActionResult
from exploration.srv import RoomAbove
from node_tools.testing import Input, Warned, address_of, long, wait_until

NODE = "/explore"
RESOLUTION_M, SIDE = 0.2, 16
START = (2.0, 5.0, 2.0)


def kill_and_wait():
    """Kill the node, and wait until roslaunch has started it again."""
    old = address_of(NODE)
    os.kill(ServerProxy(old).getPid("/explore_probe")[2], signal.SIGKILL)
    wait_until(lambda: address_of(NODE) not in (None, old), "the node's new start", 200.0)


class ExploreTest(unittest.TestCase):
    jumped_s = 0.0
    """By which the clock has jumped."""

    @classmethod
    def setUpClass(cls):
        cls.setpoints = Newest("/pos_setpoint", Pose)
        cls.feedback = Newest(NODE + "/explore/feedback", ExploreActionFeedback)
        cls.results = Newest(NODE + "/explore/result", ExploreActionResult)
        cls.markers = Newest(NODE + "/markers", MarkerArray)
        cls.maps = Input("/updates", tiles_class())
        cls.poses = Input("/ground_truth", Odometry)
        cls.batteries = Input("/battery", BatteryState)
        cls.goals = Input(NODE + "/explore/goal", ExploreActionGoal, latch=True)
        cls.warned = Warned(NODE)
        cls.services = {
            name: rospy.ServiceProxy(f"{NODE}/{name}", Trigger) for name in ("pause", "resume", "abort")
        }
        cls.services["room_above"] = rospy.ServiceProxy(f"{NODE}/room_above", RoomAbove)
        for service in cls.services.values():
            service.wait_for_service(200.0)

    def be(self, place, charge=0.9):
        """Be at a place, with a charge, now. charge: None: the battery tells nothing."""
        pose, battery = self.instant(place, charge)
        self.poses.send(pose)
        if charge is not None:
            self.batteries.send(battery)

    def instant(self, place, charge):
        """Pose and battery of now."""
        now = rospy.Time.now() + rospy.Duration(self.jumped_s)
        battery = BatteryState(percentage=charge or 0.0, voltage=12.0, current=-10.0)
        battery.header.stamp = now
        return odometry_of(now, place, frame="map"), battery

    def be_at_start(self):
        """Be there, with what the node knows before a goal comes on another connection."""
        pose, battery = self.instant(START, 0.9)
        self.poses.deliver(pose)
        self.batteries.deliver(battery)

    def send_goal(self, name):
        goal = ExploreActionGoal()
        goal.goal_id.id = name
        self.goals.send(goal)

    def send_map(self, frame="map"):
        """Send a room with a deck above 4.4 m, open at its far end."""
        kinds = block(24, 48, 48)
        kinds[22:] = 2
        kinds[:, :, 40:] = 0
        tiles, voxels = tiles_of(kinds, SIDE)
        message = tiles_class()()
        message.header.frame_id = frame
        message.header.stamp = rospy.Time.now() + rospy.Duration(self.jumped_s)
        message.resolution, message.side = RESOLUTION_M, SIDE
        message.tiles, message.voxels = tiles.ravel().tolist(), voxels.tobytes()
        self.maps.send(message)

    def fly(self, until, charge=0.9, seconds=150.0, has_map=True):
        """Let a UAV be where the node sends it, until something is true. has_map: whether the map comes."""

        def flown():
            target = self.setpoints.last
            here = START if target is None else (target.position.x, target.position.y, target.position.z)
            self.be(here, charge)
            if has_map:
                self.send_map()
            return until()

        wait_until(flown, "the UAV's flight", seconds, longest_s=0.03)

    def test_1_nothing_begins_without_pose_and_battery(self):
        self.send_goal("too early")
        wait_until(lambda: self.results.last is not None, "the refusal")
        self.assertEqual(self.results.last.status.status, GoalStatus.ABORTED)
        self.assertIn("not known yet", self.results.last.status.text)
        self.assertIn("not known yet", self.services["room_above"](1.0).message)
        self.assertFalse(self.services["pause"]().success)

    def test_2_it_explores_pauses_and_comes_home_before_the_battery_is_low(self):
        # Given a UAV that hovers; when it gets a goal, then it flies and tells its way home
        self.be_at_start()
        self.send_goal("explore")
        # And while the map is empty, it hovers and says so
        self.fly(
            lambda: self.feedback.last and self.feedback.last.feedback.phase == "waiting for the map",
            has_map=False,
        )
        self.warned.wait_for("The map is empty. The UAV hovers")
        self.assertLess(math.dist(self.target_m(), START), 1.0)
        self.fly(lambda: self.feedback.last is not None and self.feedback.last.feedback.phase == "exploring")
        self.fly(lambda: math.isfinite(self.feedback.last.feedback.home_energy))
        self.assertGreater(self.feedback.last.feedback.known, 50.0)
        self.assertTrue(self.markers.last.markers)
        # When it is paused, then it hovers
        self.assertTrue(self.services["pause"]().success)
        self.fly(lambda: self.feedback.last.feedback.phase == "paused")
        self.assertTrue(self.services["resume"]().success)
        # When the charge is down at the reserve, then it comes home and says why
        self.fly(lambda: self.results.last.status.goal_id.id == "explore", charge=0.1)
        result = self.results.last.result
        self.assertEqual(result.end, "battery")
        self.assertTrue(result.is_home)
        self.assertIn("reserve", result.reason)

        # And it tells how far a UAV may rise: radius and margin, 0.55 m, stay below the deck's lowest voxels
        answer = self.services["room_above"](10.0)
        self.assertTrue(answer.success)
        self.assertAlmostEqual(answer.room, 4.5 - 0.55 - self.target_m()[2], delta=0.06)
        self.assertEqual(self.services["room_above"](0.5).room, 0.5)
        self.assertIn("cannot rise by nan", self.services["room_above"](math.nan).message)

    def test_3_with_a_new_battery_it_goes_on_and_it_can_be_aborted(self):
        self.fly(lambda: True)
        self.be_at_start()
        self.send_goal("go on")
        self.fly(lambda: self.feedback.last.status.goal_id.id == "go on")
        self.assertTrue(self.services["abort"]().success)
        self.fly(lambda: self.results.last.status.goal_id.id == "go on")
        self.assertEqual(self.results.last.result.end, "aborted")
        self.assertTrue(self.results.last.result.is_home)

    def test_4_after_the_clock_was_set_the_battery_still_counts(self):
        # Given a UAV that explores; when the clock is set ahead, and back again, then it goes on
        self.be_at_start()
        self.send_goal("jump")
        self.fly(lambda: self.feedback.last.status.goal_id.id == "jump")
        for jumped_s in (3600.0, -100.0):
            type(self).jumped_s = jumped_s
            self.feedback.last = None
            self.fly(lambda: self.feedback.last is not None)
            self.assertEqual(self.feedback.last.feedback.phase, "exploring")
            self.assertEqual(self.feedback.last.status.goal_id.id, "jump")
        # When the charge is down at the reserve, then it comes home
        self.fly(lambda: self.results.last.status.goal_id.id == "jump", charge=0.1)
        self.assertEqual(self.results.last.result.end, "battery")
        self.assertIn("reserve", self.results.last.result.reason)
        self.assertTrue(self.results.last.result.is_home)

    def test_5_killed_in_flight_it_goes_on_and_comes_home_to_the_same_place(self):
        # Given a UAV that explores away from where it began; when the node is killed and starts again
        self.be_at_start()
        self.send_goal("killed")
        self.fly(lambda: self.feedback.last.status.goal_id.id == "killed")
        self.fly(lambda: self.target_m() is not None and math.dist(self.target_m(), START) > 2.0)
        began = rospy.get_param(NODE + "/begun")
        kill_and_wait()
        self.feedback.last = None
        # Then it flies the same goal, which is latched, with the same home
        self.fly(lambda: self.feedback.last is not None, seconds=60.0)
        self.assertEqual(self.feedback.last.status.goal_id.id, "killed")
        self.assertEqual(rospy.get_param(NODE + "/begun"), began)
        self.fly(lambda: self.results.last.status.goal_id.id == "killed", charge=0.1)
        self.assertEqual(self.results.last.result.end, "battery")
        self.assertLess(math.dist(self.target_m(), began["home"]), 0.01)

    @long
    def test_5a_killed_after_the_end_it_does_not_fly_the_goal_again(self):
        self.results.last = self.feedback.last = None
        kill_and_wait()
        self.services["pause"].wait_for_service(200.0)
        for _ in range(20):
            self.be(START)
            rospy.sleep(0.1)
        self.assertIsNone(self.results.last)
        self.assertIsNone(self.feedback.last)

    def begin(self, name):
        """Hover, and fly a goal."""
        self.be_at_start()
        self.send_goal(name)
        self.fly(lambda: self.feedback.last is not None and self.feedback.last.status.goal_id.id == name)

    def end_of(self, name, **how):
        """Fly to the end of a goal; return its result."""
        self.fly(lambda: self.results.last is not None and self.results.last.status.goal_id.id == name, **how)
        return self.results.last.result

    def let_pass(self, seconds, charge=0.9, has_map=False):
        """Let time pass sooner than it does. The UAV stays where it is. charge, has_map: as in `fly`."""
        target = self.setpoints.last.position
        for _ in range(2 * seconds):
            type(self).jumped_s += 0.5
            self.be((target.x, target.y, target.z), charge)
            if has_map:
                self.send_map()
            rospy.sleep(0.05)

    def test_6_when_the_map_stops_it_comes_home(self):
        self.begin("no map")
        self.let_pass(11)
        result = self.end_of("no map", has_map=False)
        self.assertEqual(result.end, "aborted")
        self.assertIn("The map has told nothing new", result.reason)
        self.assertTrue(result.is_home)
        self.warned.wait_for("The map has told nothing for")

    def test_7_when_the_battery_stops_it_comes_home(self):
        self.begin("no battery")
        self.let_pass(7, charge=None, has_map=True)
        result = self.end_of("no battery", charge=None)
        self.assertEqual(result.end, "battery")
        self.assertIn("told nothing to believe", result.reason)
        self.assertTrue(result.is_home)

    def test_8_a_charge_that_cannot_be_is_told_and_does_not_count(self):
        self.begin("wrong battery")
        for charge, words in ((math.nan, "not a number from 0 to 1"), (0.5, ""), (1.0, "jumped up from 50%")):
            self.fly(lambda words=words: self.warned.count(words), charge=charge)
            self.fly(lambda: self.feedback.last.feedback.phase == "exploring", charge=charge)
            rospy.sleep(1.0)
        self.assertTrue(self.services["abort"]().success)
        self.assertTrue(self.end_of("wrong battery").is_home)

    def test_9_a_map_in_another_frame_is_left_out(self):
        self.send_map(frame="odom")
        self.warned.wait_for('The map is in frame "odom"')

    def test_z_its_threads_take_locks_in_one_order(self):
        self.assertEqual(take_report(NODE), "")

    def test_9a_a_single_pose_far_off_is_left_out(self):
        self.begin("wild pose")
        self.be((2000.0, 5.0, 2.0))
        self.warned.wait_for("m off the one before; it is left out")
        self.feedback.last = None
        self.fly(lambda: self.feedback.last is not None and self.feedback.last.feedback.phase == "exploring")
        self.assertTrue(self.services["abort"]().success)
        self.assertTrue(self.end_of("wild pose").is_home)

    def target_m(self):
        """Return where the node sends the UAV."""
        target = self.setpoints.last
        return None if target is None else (target.position.x, target.position.y, target.position.z)
