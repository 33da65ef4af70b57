"""The contract of the node mission: its action, its setpoints, and who waits for whom in lockstep."""

import math
import threading
import unittest

import rospy
from actionlib_msgs.msg import GoalID, GoalStatus
from flight_basics_ros.lock_order import take_report
from flight_basics_ros.testing import odometry_of, scan_of, velocity_of
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped, TwistStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Header

from inspection_tools.msg import MissionActionFeedback, MissionActionGoal, MissionActionResult, MissionGoal
from node_tools.testing import Input, Output, Stamps, Warned, wait_until


class Client:
    """An action client made of topics, which shows every message."""

    def __init__(self, server):
        self.goals = Input(server + "/goal", MissionActionGoal)
        self.cancels = Input(server + "/cancel", GoalID)
        self.feedback = Output(server + "/feedback", MissionActionFeedback)
        self.results = Output(server + "/result", MissionActionResult)
        self._count = 0

    def send(self, *places, **options):
        self._count += 1
        waypoints = [Pose(position=Point(*place)) for place in places]
        goal = MissionActionGoal(goal=MissionGoal(waypoints=waypoints, **options))
        goal.goal_id.id = f"mission {self._count}"
        self.goals.send(goal)


def place(pose):
    return (pose.position.x, pose.position.y, pose.position.z)


class MissionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.poses = Input("odometry", Odometry)
        cls.setpoints = Output("pos_setpoint", Pose)
        cls.plans = Output("mission/waypoints", PoseArray)
        cls.client = Client("mission/fly")
        cls.warned = Warned("/mission")
        cls.stamps = Stamps()

    def setUp(self):
        for output in (self.setpoints, self.plans, self.client.feedback, self.client.results):
            output.messages.clear()

    def be_at(self, x, y, z=2.0, step_s=0.01, **frames):
        self.poses.send(odometry_of(self.stamps.next(step_s), (x, y, z), **frames))

    def result(self):
        result = self.client.results.next()
        return result.status.status, result.result.reached

    def test_flies_the_file_s_mission_to_its_end(self):
        # When a goal has no waypoints, those of the file are flown
        self.client.send()
        plan = self.plans.next()
        self.assertEqual([place(pose) for pose in plan.poses], [(10.0, 0.0, 2.0), (10.0, 5.0, 2.0)])
        self.assertEqual(plan.header.frame_id, "odom")
        self.be_at(0.0, 0.0)
        self.assertEqual(place(self.setpoints.next()), (10.0, 0.0, 2.0))
        feedback = self.client.feedback.next().feedback
        self.assertEqual((feedback.reached, feedback.of, feedback.distance), (0, 2, 10.0))

        # Then the next follows when the first is reached, with its heading
        self.be_at(9.6, 0.0)
        second = self.setpoints.next()
        self.assertEqual(place(second), (10.0, 5.0, 2.0))
        self.assertAlmostEqual(2.0 * math.atan2(second.orientation.z, second.orientation.w), 1.0)

        # And a pose of another frame, or none, is left out with a warning
        self.be_at(10.0, 5.0, frame="world")
        self.warned.wait_for('"base_frame" in "world"')
        self.be_at(math.nan, 5.0)
        self.warned.wait_for("not finite")

        # And it is over when the last has been held for its second
        self.be_at(10.0, 5.0)
        self.be_at(10.0, 5.1, step_s=0.95)
        self.assertEqual(self.client.results.messages, [])
        self.be_at(10.0, 5.1, step_s=0.1)
        self.assertEqual(self.result(), (GoalStatus.SUCCEEDED, 2))
        self.be_at(0.0, 0.0)
        self.setpoints.assert_quiet()

    def test_a_cancelled_mission_leaves_the_uav_where_it_is(self):
        self.client.send((50.0, 0.0, 2.0))
        self.plans.next()
        self.be_at(0.0, 0.0)
        self.setpoints.next()
        self.client.cancels.send(GoalID())
        wait_until(lambda: self.be_at(3.0, 1.0) or self.setpoints.messages, "a setpoint that stops the UAV")
        self.assertEqual(place(self.setpoints.next()), (3.0, 1.0, 2.0))
        self.assertEqual(self.result(), (GoalStatus.PREEMPTED, 0))

    def test_a_mission_that_stalls_is_aborted(self):
        self.client.send((50.0, 0.0, 2.0))
        self.plans.next()
        self.be_at(0.0, 0.0)
        self.setpoints.next()
        for _ in range(122):  # the first one is nearer; a longer step would be a clock that was set
            self.be_at(1.0, 0.0, step_s=0.5)
            rospy.sleep(0.005)
        self.assertEqual(place(self.setpoints.next()), (1.0, 0.0, 2.0))
        result = self.client.results.next()
        self.assertEqual(result.status.status, GoalStatus.ABORTED)
        self.assertIn("The UAV has come no nearer to waypoint 1 of 1 for 60 s", result.status.text)

    def test_a_new_mission_takes_the_place_of_the_old_one(self):
        self.client.send((50.0, 0.0, 2.0))
        self.plans.next()
        self.be_at(0.0, 0.0)
        self.setpoints.next()
        self.client.send((0.0, 7.0, 2.0), tolerance=1.0)
        self.assertEqual(self.result(), (GoalStatus.PREEMPTED, 0))
        self.plans.next()
        self.be_at(0.0, 0.0)
        self.assertEqual(place(self.setpoints.next()), (0.0, 7.0, 2.0))
        self.be_at(0.0, 6.1)
        self.assertEqual(self.result(), (GoalStatus.SUCCEEDED, 1))

    def test_goals_that_come_between_poses_are_all_taken(self):
        over = threading.Event()

        def fly():
            while not over.wait(0.0005):
                self.be_at(0.0, 0.0, step_s=0.25)  # each is answered with feedback

        pilot = threading.Thread(target=fly)
        pilot.start()
        try:
            for count in range(100):
                self.client.send((50.0, float(count), 2.0))
                self.assertEqual(place(self.plans.next().poses[0]), (50.0, float(count), 2.0))
        finally:
            over.set()
            pilot.join()
        self.client.cancels.send(GoalID())

    def test_a_mission_that_makes_no_sense_is_refused(self):
        for places, words in (
            ([(math.nan, 0.0, 2.0)], "not finite"),
            ([(0.0, 1e9, 2.0)], "beyond"),
        ):
            self.client.send(*places)
            result = self.client.results.next()
            self.assertEqual(result.status.status, GoalStatus.ABORTED)
            self.assertIn(words, result.status.text)
        self.client.send((0.0, 0.0, 2.0), hold=-1.0)
        self.assertIn("hold is -1", self.client.results.next().status.text)
        self.be_at(0.0, 0.0)
        self.setpoints.assert_quiet()

    def test_in_lockstep_a_scan_is_acknowledged_after_its_instants_poses(self):
        poses, scans = Input("lockstep/odometry", Odometry), Input("lockstep/scan", LaserScan)
        answers = Input("lockstep/vel_setpoint", TwistStamped)
        goals = Input("lockstep/goal", PoseStamped)
        processed = Output("lockstep/mission/processed", Header)
        setpoints = Output("lockstep/pos_setpoint", Pose)
        client = Client("lockstep/mission/fly")
        stamps = Stamps()

        # Without a mission every scan is acknowledged at once
        stamp = stamps.next()
        scans.send(scan_of(stamp, [1.0] * 9))
        self.assertEqual(processed.next().stamp, stamp)

        # With one, not before the position controller has answered the pose
        client.send((5.0, 0.0, 2.0))
        rospy.sleep(0.6)
        stamp = stamps.next()
        poses.send(odometry_of(stamp))
        scans.send(scan_of(stamp, [1.0] * 9))
        processed.assert_quiet()
        self.assertEqual(setpoints.messages, [])
        # then the setpoint goes out, and its arrival is waited for
        answers.send(velocity_of(stamp, (0.0, 0.0, 0.0)))
        self.assertEqual(place(setpoints.next()), (5.0, 0.0, 2.0))
        processed.assert_quiet()
        goals.send(PoseStamped())
        self.assertEqual(processed.next().stamp, stamp)

        # Where nothing changes, the answer is enough; in whichever order the three come
        stamp = stamps.next()
        answers.send(velocity_of(stamp, (0.0, 0.0, 0.0)))
        scans.send(scan_of(stamp, [1.0] * 9))
        poses.send(odometry_of(stamp, (1.0, 0.0, 2.0)))
        self.assertEqual(processed.next().stamp, stamp)
        setpoints.assert_quiet()

        # And between scans nothing is decided
        poses.send(odometry_of(stamps.next(0.01), (5.0, 0.0, 2.0)))
        client.results.assert_quiet()

    def test_z_its_threads_take_locks_in_one_order(self):
        self.assertEqual(take_report("mission"), "")
