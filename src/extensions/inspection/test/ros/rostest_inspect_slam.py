"""The node inspect with its poses from SLAM: loop closures, and a SLAM that is lost."""

import sys
import tempfile
import unittest
from pathlib import Path as FilePath

import numpy as np
import rospy
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage

from flight_basics.correction import SlowCorrection
from flight_basics.pose.trust import LOST_S
from inspection.msg import SurveyActionFeedback, SurveyActionGoal, SurveyActionResult
from inspection.photographs.listing import photographs_in
from inspection.photographs.record import read_record
from inspection.survey import FlightParameters, SurveyCamera, SurveyParameters
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import write_plan
from inspection.survey.views.candidates import View
from node_tools.conversions import set_yaw
from node_tools.testing import Input, wait_until

sys.path.insert(0, str(FilePath(__file__).resolve().parents[3] / "exploration/test"))
from flight_basics_ros.testing import Newest, correction, odometry_of
from surveying_uav import START, Uav

NODE = "/inspect"
SETTLED_S = 0.2
"""As in `pose_source`: SLAM's correction counts so long after its stamp."""
NO_TURN = (0.0, 0.0, 0.0, 1.0)
VIEWS = (View((4.0, 5.0, 2.0), 0.0, 0.0), View((6.0, 4.0, 2.5), 1.5, 0.4), View((4.0, 3.0, 1.5), 3.0, -0.4))
CLOSURE_M = np.array((0.6, 0.8, 0.0))


class SlamUav(Uav):
    """Flies by what SLAM's correction slowly makes of its odometry, as the position controller does.

    Attributes:
        correction_m: of `odom` in the map. told: (stamp, place in odom, yaw) of each pose.
    """

    step_s, pause_s = 0.05, 0.01

    def __init__(self):
        super().__init__("/odometry")
        self.correction_m, self.told = np.zeros(3), []
        self._sent, self._slow, self._in_odom_m = [], SlowCorrection(), np.array(START)
        self._tf = Input("/tf", TFMessage)
        self._matched = Input("/odometry_matched", Odometry)

    def odometry(self, stamp):
        self._tf.send(correction(stamp, self.correction_m[0], self.correction_m[1], 0.0))
        self._sent.append((stamp.to_sec(), self.correction_m))
        known = [each for sent_s, each in self._sent if sent_s <= stamp.to_sec() - SETTLED_S + 1e-9]
        if known:
            shown_m, _ = self._slow.apply(
                stamp.to_sec(), (tuple(self._in_odom_m), 0.0), tuple(known[-1]), NO_TURN
            )
            self._in_odom_m = self._in_odom_m + np.subtract(self.place, shown_m)
        self.told.append((stamp.to_sec(), self._in_odom_m, self._yaw_rad))
        odometry = odometry_of(stamp, self._in_odom_m, self._yaw_rad)
        odometry.pose.covariance = list((0.02**2 * np.eye(6)).ravel())
        self._matched.send(odometry)
        return odometry

    def at_rest(self):
        """Return what was told where it was at rest: nobody knows odometry in the midst of its leaps."""
        return [self.told[k] for k in range(3, len(self.told) - 3) if self._rests(self.told[k - 3 : k + 4])]

    @staticmethod
    def _rests(told):
        return all(np.allclose((*place, yaw), (*told[0][1], told[0][2])) for _, place, yaw in told)

    def in_odom_m(self, stamp_s):
        """Return where it was at a stamp."""
        return min(self.told, key=lambda each: abs(each[0] - stamp_s))[1]


class InspectSlamTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = FilePath(tempfile.mkdtemp())
        cls.feedback = Newest(NODE + "/survey/feedback", SurveyActionFeedback)
        cls.results = Newest(NODE + "/survey/result", SurveyActionResult)
        cls.goals = Input(NODE + "/survey/goal", SurveyActionGoal, latch=True)
        cls.states = Input("/slam_state", String, latch=True)
        cls.paths = Input("/slam_path", Path, latch=True)
        cls.uav = SlamUav()
        cls.states.send(String("tracking"))
        for _ in range(20):
            cls.uav.tell()
            rospy.sleep(0.02)
        cls.uav.send_map()

    def begin(self, name):
        plan = self.folder / f"{name}.yaml"
        flight = Flight(tuple(map(PlannedView, VIEWS)), 60.0, 10.0)
        asked, flying = SurveyParameters(resolution=20.0), FlightParameters()
        camera = SurveyCamera(64, 48, 60.0)
        write_plan(plan, SurveyPlan("room.stl", START, camera, asked, flying, (flight,)))
        goal = SurveyActionGoal()
        goal.goal_id.id = name
        goal.goal.plan, goal.goal.folder = str(plan), str(self.folder / name)
        self.goals.send(goal)
        self.uav.fly(lambda: len(self.records(name)) == 1, "the first photograph")

    def records(self, name):
        paths = photographs_in(self.folder / name)
        return {record.view: record for record in (read_record(each.with_suffix(".json")) for each in paths)}

    def ended(self, name):
        return self.results.last is not None and self.results.last.status.goal_id.id == name

    def off_m(self, record, correction_m):
        """Return how far a record is off, if `odom` was there. The camera is 0.1 m from the UAV's middle."""
        true_m = self.uav.in_odom_m(record.stamp_s) + correction_m
        return np.linalg.norm(np.subtract(record.position_m, true_m))

    def test_1_photographs_of_a_loop_closure_are_where_they_were_taken(self):
        # Given a survey; when SLAM closes a loop, then nothing is photographed until the pose has followed
        self.begin("closure")
        closed_s = self.uav.stamp_s
        self.uav.correction_m = CLOSURE_M
        self.uav.fly(lambda: self.feedback.last.feedback.phase == "waiting for SLAM", "the wait")
        self.uav.fly(lambda: self.ended("closure"), "the end")
        self.assertEqual(self.results.last.result.end, "done")
        records = self.records("closure")
        self.assertEqual(sorted(records), [1, 2, 3])
        known_s = closed_s + SETTLED_S  # the second one may be taken before anybody can know of the closure
        later = [record for record in records.values() if record.stamp_s > known_s + 0.25]
        self.assertTrue(later)
        for record in later:
            self.assertGreater(record.stamp_s, known_s + (1.0 - 0.05) / 0.15 - 0.1)
            self.assertLess(self.off_m(record, CLOSURE_M), 0.2)
            self.assertLess(np.sqrt(max(record.covariance)), 0.1)
        self.assertLess(self.off_m(records[1], np.zeros(3)), 0.2)
        # When SLAM's path tells that the UAV was there all along, then the first one follows
        path = Path()
        for stamp_s, place_m, yaw_rad in self.uav.at_rest():
            pose = PoseStamped()
            pose.header.stamp = rospy.Time.from_sec(stamp_s)
            x, y, _ = place_m + CLOSURE_M
            pose.pose.position.x, pose.pose.position.y = x, y
            set_yaw(pose.pose.orientation, yaw_rad)
            path.poses.append(pose)
        self.paths.send(path)
        wait_until(lambda: self.records("closure")[1].told_position_m is not None, "the corrected record")
        moved = self.records("closure")[1]
        np.testing.assert_allclose(np.subtract(moved.position_m, moved.told_position_m), CLOSURE_M, atol=0.02)
        for number in (1, 2, 3):
            self.assertLess(self.off_m(self.records("closure")[number], CLOSURE_M), 0.2)

    def test_2_lost_it_hovers_and_then_comes_home(self):
        self.begin("lost")
        self.states.send(String("lost"))
        self.uav.step_s = 0.25
        lost_s = self.uav.stamp_s
        self.uav.fly(lambda: self.feedback.last.feedback.phase == "waiting for SLAM", "the wait")
        taken = len(self.records("lost"))
        self.uav.fly(lambda: self.ended("lost"), "the end")
        result = self.results.last.result
        self.assertGreaterEqual(self.uav.stamp_s, lost_s + LOST_S)
        self.assertEqual((result.end, result.is_home), ("aborted", True))
        self.assertEqual(result.reason, "SLAM is lost. That lasted too long.")
        self.assertEqual(len(self.records("lost")), taken)
