"""What path_planner promises: plans by service and by topic, again when the map changes, and one sentence."""

import math
import unittest

import numpy as np
import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from drawn_voxels import block, tiles_of
from exploration_ros.planner_messages import tiles_class
from flight_basics_ros.lock_order import take_report
from flight_basics_ros.testing import odometry_of
from geometry_msgs.msg import PointStamped, PoseStamped
from nav_msgs.msg import Odometry
from nav_msgs.msg import Path as PathMessage
from nav_msgs.srv import GetPlan, GetPlanRequest
from std_msgs.msg import Bool

from inspection_tools.msg import MissionActionGoal, MissionActionResult
from node_tools.testing import Input, Output, Warned, wait_until

NODE = "/planned/path_planner"
RESOLUTION_M, SIDE = 0.2, 16
START, GOAL = (1.5, 2.5, 2.0), (8.1, 2.5, 2.0)
WALL = slice(24, 26)  # x from 4.8 to 5.2 m


def room(doors=()):
    """Kinds of a room of 9.6 x 9.6 x 4.8 m, with a wall that has doors (slices of y)."""
    kinds = block(24, 48, 48)
    kinds[:, :, WALL] = 2
    for door in doors:
        kinds[5:16, door, WALL] = 1
    return kinds


NEAR, FAR = slice(7, 15), slice(30, 44)


def stamped(kind, place, frame="map"):
    message = kind()
    message.header.frame_id = frame
    target = message.point if kind is PointStamped else message.pose.position
    target.x, target.y, target.z = place
    return message


def points_of(path):
    return np.array([(p.pose.position.x, p.pose.position.y, p.pose.position.z) for p in path.poses])


class PathPlannerTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.plans = Output("/planned/plan", PathMessage)
        cls.missions = Output("/planned/mission/goal", MissionActionGoal)
        cls.cancels = Output("/planned/mission/cancel", GoalID)
        cls.warned = Warned(NODE)
        cls.maps = Input("/planned/updates", tiles_class())
        cls.poses = Input("/planned/ground_truth", Odometry)
        cls.goals = Input("/planned/goal", PoseStamped)
        cls.closed = Input(NODE + "/close", PointStamped)
        cls.ready = Input("/planned/ready", Bool)
        cls.results = Input("/planned/mission/result", MissionActionResult)
        cls.service = rospy.ServiceProxy(NODE + "/make_plan", GetPlan)
        cls.service.wait_for_service(200.0)

    def send_map(self, kinds, frame="map", **changes):
        tiles, voxels = tiles_of(kinds, SIDE)
        message = tiles_class()()
        message.header.frame_id = frame
        message.resolution, message.side = RESOLUTION_M, SIDE
        message.tiles, message.voxels = tiles.ravel().tolist(), voxels.tobytes()
        for name, value in changes.items():
            setattr(message, name, value)
        self.maps.send(message)

    def ask(self, goal=GOAL, start=START, frame="map", start_frame="map"):
        request = GetPlanRequest(
            stamped(PoseStamped, start, start_frame), stamped(PoseStamped, goal, frame), 0.0
        )
        return points_of(self.service(request).plan)

    def refusal(self, **how):
        with self.assertRaises(rospy.ServiceException) as told:
            self.ask(**how)
        return str(told.exception)

    def wait_for_path(self, **how):
        def answers():
            try:
                return len(self.ask(**how))
            except rospy.ServiceException:
                return False

        wait_until(answers, "a plan")
        return self.ask(**how)

    def send_pose(self, place):
        self.poses.send(odometry_of(rospy.Time.now(), place, frame="map"))

    def test_1_without_a_map_it_says_so(self):
        self.assertIn("There is no map yet", self.refusal())

    def test_2_a_plan_leads_through_the_door(self):
        self.send_map(room([NEAR]))
        points = self.wait_for_path()
        np.testing.assert_allclose(points[[0, -1]], (START, GOAL))
        length = np.linalg.norm(np.diff(points, axis=0), axis=1).sum()
        self.assertLess(length, 1.1 * math.dist(START, GOAL))

    def test_3_bad_requests_have_one_sentence_each(self):
        self.send_map(room([NEAR]))
        self.wait_for_path()
        for words, how in (
            ('goal is in frame "odom", but the map is in "map"', {"frame": "odom"}),
            ('start is in frame "odom"', {"start_frame": "odom"}),
            ("goal has a position that is not finite", {"goal": (math.nan, 0.0, 2.0)}),
            ("start (5.0, 8.0, 2.0) is in an obstacle", {"start": (5.0, 8.0, 2.0)}),
            ("goal (5.0, 8.0, 2.0) is in an obstacle", {"goal": (5.0, 8.0, 2.0)}),
            ("goal (50.0, 2.0, 2.0) is in unknown space", {"goal": (50.0, 2.0, 2.0)}),
            ("goal (1.5, 5.5, 2.0) is in the keep-out box pump", {"goal": (1.5, 5.5, 2.0)}),
            ("above the ceiling of 4 m", {"goal": (8.1, 2.5, 4.3)}),
        ):
            self.assertIn(words, self.refusal(**how))

    def test_4_bad_messages_are_left_out_with_a_sentence(self):
        self.send_map(room([NEAR]))
        self.wait_for_path()
        self.send_map(room(), frame="odom")
        self.warned.wait_for('The map is in frame "odom", but poses are in "map"')
        self.send_map(room(), voxels=b"123")
        self.warned.wait_for("came as 3.")
        self.send_map(room(), unit=0.1)
        self.warned.wait_for("The tiles hold distances")
        self.send_map(room(), resolution=math.nan)
        self.warned.wait_for("makes no sense")
        self.goals.send(stamped(PoseStamped, GOAL, "odom"))
        self.warned.wait_for('The goal is in frame "odom"')
        self.goals.send(stamped(PoseStamped, (math.nan, 0.0, 0.0)))
        self.warned.wait_for("The goal has a position that is not finite")
        self.closed.send(stamped(PointStamped, (math.inf, 0.0, 0.0)))
        self.warned.wait_for("The place has a position that is not finite")
        self.assertTrue(len(self.ask()))

    def test_5_a_goal_is_planned_flown_and_planned_again(self):
        # Given: two doors, and a UAV before the wall
        self.send_map(room([NEAR, FAR]))
        self.send_pose(START)
        wait_until(lambda: len(self.wait_for_path(start_frame="")), "a plan from the UAV's place")
        # When it gets a goal, then there is a path through the near door, and a mission along it
        self.goals.send(stamped(PoseStamped, GOAL))
        near = self.plans.last(lambda plan: len(plan.poses) > 1, "a plan")
        self.assertLess(points_of(near)[:, 1].max(), 4.0)
        mission = self.missions.last(lambda goal: True, "a mission")
        self.assertEqual(
            [p.position for p in mission.goal.waypoints], [p.pose.position for p in near.poses[1:]]
        )
        # When the near door closes, then the path leads through the far one
        self.send_map(room([FAR]))
        far = self.plans.last(
            lambda plan: len(plan.poses) > 1 and points_of(plan)[:, 1].max() > 6.0, "far door"
        )
        np.testing.assert_allclose(points_of(far)[-1], GOAL)
        # When both are closed, then there is none, a sentence says why, and the mission is cancelled
        self.send_map(room())
        self.plans.last(lambda plan: not plan.poses, "no plan")
        self.warned.wait_for("No known free way leads to (8.1, 2.5, 2.0)")
        self.cancels.last(lambda _: True, "a cancelled mission")
        # When the near one opens, and CEPA does not let the UAV pass it, then it is closed for a while
        cancelled = self.missions.messages[-1].goal_id.id
        self.send_map(room([NEAR, FAR]))
        self.plans.last(lambda plan: plan.poses and points_of(plan)[:, 1].max() < 4.0, "near door")
        self.missions.last(lambda goal: goal.goal_id.id != cancelled, "a mission through it")
        self.send_pose((4.3, 2.3, 2.0))
        wait_until(lambda: np.allclose(self.ask(start_frame="")[0], (4.3, 2.3, 2.0)), "the pose")
        result = MissionActionResult()
        result.status.status = GoalStatus.ABORTED
        result.status.goal_id.id = self.missions.messages[-1].goal_id.id
        self.results.send(result)
        self.plans.last(lambda plan: plan.poses and points_of(plan)[:, 1].max() > 6.0, "far door again")
        # When the UAV has jumped past the wall, then the path begins there; at the goal it ends
        self.send_pose((7.0, 7.0, 2.0))
        there = self.plans.last(
            lambda plan: plan.poses and np.allclose(points_of(plan)[0], (7.0, 7.0, 2.0)), "from there"
        )
        flown = [p.pose.position for p in there.poses[1:]]
        self.missions.last(lambda goal: [p.position for p in goal.goal.waypoints] == flown, "its mission")

    def test_6_a_goal_waits_until_the_uav_hovers(self):
        # Given: a UAV on the ground
        self.send_map(room([NEAR, FAR]))
        self.ready.deliver(Bool(False))
        # When it gets a goal, then a sentence says why nothing flies
        self.poses.deliver(odometry_of(rospy.Time.now(), START, frame="map"))
        self.goals.send(stamped(PoseStamped, GOAL))
        self.warned.wait_for("The goal waits until the UAV hovers.")
        rospy.sleep(0.5)  # a mission that was sent before that may still be on its way
        sent = len(self.missions.messages)
        # When the near door closes, then there is another plan, but no mission
        self.send_map(room([FAR]))
        planned = self.plans.messages
        wait_until(lambda: planned[-1].poses and points_of(planned[-1])[:, 1].max() > 6.0, "the far door")
        rospy.sleep(0.5)
        self.assertEqual(len(self.missions.messages), sent)
        # When it hovers, then the mission begins
        self.ready.send(Bool(True))
        wait_until(lambda: len(self.missions.messages) > sent, "a mission")

    def test_z_its_threads_take_locks_in_one_order(self):
        self.assertEqual(take_report("path_planner"), "")
