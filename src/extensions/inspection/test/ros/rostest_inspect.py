"""What the node inspect promises: photographs of a plan, pause, closer looks, a way home, and plain refusals.

Time is that of the messages' stamps, so the UAV flies faster than any clock.
"""

import os
import signal
import sys
import tempfile
import unittest
from dataclasses import replace
from pathlib import Path
from xmlrpc.client import ServerProxy

import numpy as np
import rospy
import trimesh
from actionlib_msgs.msg import GoalStatus
from geometry_msgs.msg import Point, PointStamped
from sensor_msgs.msg import Image
from std_msgs.msg import String
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from exploration.srv import RoomAbove
from inspection.msg import SurveyActionFeedback, SurveyActionGoal, SurveyActionResult
from inspection.photographs.listing import photographs_in
from inspection.photographs.record import read_record
from inspection.srv import LookCloser
from inspection.survey import FlightParameters, SurveyCamera, SurveyParameters
from inspection.survey.plan import Draft, Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.views.candidates import View
from node_tools.testing import Input, address_of, long, wait_until

sys.path.insert(0, str(Path(__file__).resolve().parents[3] / "exploration/test"))
from flight_basics_ros.lock_order import take_report
from flight_basics_ros.testing import Newest
from surveying_uav import START, Uav

NODE = "/inspect"
CAMERA = SurveyCamera(64, 48, 60.0)
FINE_CAMERA = SurveyCamera(4000, 3000, 60.0)
VIEWS = (View((4.0, 5.0, 2.0), 0.0, 0.0), View((6.0, 4.0, 2.5), 1.5, 0.4), View((4.0, 3.0, 1.5), 3.0, -0.4))


class InspectTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = Path(tempfile.mkdtemp())
        cls.feedback = Newest(NODE + "/survey/feedback", SurveyActionFeedback)
        cls.results = Newest(NODE + "/survey/result", SurveyActionResult)
        cls.markers = Newest(NODE + "/markers", MarkerArray)
        cls.last = Newest(NODE + "/last_photograph", Image)
        cls.search = Newest(NODE + "/search", String)
        cls.goals = Input(NODE + "/survey/goal", SurveyActionGoal, latch=True)
        cls.clicks = Input("/clicked_point", PointStamped)
        kinds = {"pause": Trigger, "resume": Trigger, "abort": Trigger, "look_closer": LookCloser}
        kinds["room_above"] = RoomAbove
        cls.services = {name: rospy.ServiceProxy(f"{NODE}/{name}", kind) for name, kind in kinds.items()}
        for service in cls.services.values():
            service.wait_for_service(200.0)
        cls.uav = Uav()

    def plan(self, name="plan.yaml", views=VIEWS, camera=CAMERA, source="room.stl"):
        path = self.folder / name
        flight = Flight(tuple(PlannedView(view) for view in views), 60.0, 10.0)
        asked, flying = SurveyParameters(resolution=20.0), FlightParameters()
        write_plan(path, SurveyPlan(source, START, camera, asked, flying, (flight,)))
        return path

    def send_goal(self, name, plan, folder=None, second_look=False, time_max=0.0):
        goal = SurveyActionGoal()
        goal.goal.second_look, goal.goal.time_max = second_look, time_max
        goal.goal_id.id = name
        goal.goal.plan, goal.goal.folder = str(plan), str(self.folder / (folder or name))
        self.goals.send(goal)

    def records(self, name):
        return [read_record(path.with_suffix(".json")) for path in photographs_in(self.folder / name)]

    def listed(self, name):
        """Number of photographs that are stored whole: the list is written last."""
        path = self.folder / name / "rgb.txt"
        lines = path.read_text().splitlines() if path.exists() else []
        return sum(not line.startswith("#") for line in lines)

    def ended(self, name):
        return self.results.last is not None and self.results.last.status.goal_id.id == name

    def refused(self, name, plan):
        self.send_goal(name, plan)
        wait_until(lambda: self.ended(name), "the refusal")
        self.assertEqual(self.results.last.status.status, GoalStatus.ABORTED)
        return self.results.last.status.text

    def test_01_what_cannot_be_flown_is_refused_with_a_sentence(self):
        self.assertIn("place of the UAV is not known yet", self.refused("early", self.plan()))
        self.uav.tell()
        rospy.sleep(0.3)
        self.assertIn("nowhere.yaml", self.refused("no plan", self.folder / "nowhere.yaml"))
        bad = self.folder / "bad.yaml"
        bad.write_text(self.plan().read_text().replace("yaw:", "jaw:"))
        self.assertIn("bad.yaml", self.refused("bad plan", bad))
        self.assertFalse(self.services["pause"]().success)
        self.assertFalse(self.services["look_closer"](Point(4.0, 9.4, 2.0)).success)
        self.assertEqual(self.services["room_above"](1.5).room, 1.5)  # no map yet

    def test_02_it_photographs_pauses_looks_closer_and_comes_home(self):
        uav, told = self.uav, self.feedback
        uav.send_map()
        self.send_goal("survey", self.plan())
        uav.fly(lambda: told.last is not None and told.last.feedback.taken == 1, "the first photograph")
        # When it is paused, then it takes no photograph until it is resumed
        self.assertTrue(self.services["pause"]().success)
        uav.fly(lambda: told.last.feedback.phase == "paused", "the pause")
        taken = told.last.feedback.taken
        for _ in range(30):
            uav.tell()
            rospy.sleep(0.02)
        self.assertEqual(told.last.feedback.taken, taken)
        self.assertTrue(self.services["resume"]().success)
        # When a point is asked for, then it comes next; a point that cannot be seen is refused
        self.assertFalse(self.services["look_closer"](Point(400.0, 9.4, 2.0)).success)
        self.assertTrue(self.services["look_closer"](Point(4.0, 9.4, 2.0)).success)
        uav.fly(lambda: any(each.view == -1 for each in self.records("survey")), "the closer look")
        # When the clock is set ahead by more than a battery lasts, and back, then it goes on
        for step_s in (3600.0, -60.0):
            uav.stamp_s += step_s
            uav.tell()
        click = PointStamped(point=Point(9.4, 5.0, 2.0))
        click.header.frame_id = "map"
        self.clicks.send(click)
        uav.fly(lambda: self.ended("survey"), "the end")
        result = self.results.last.result
        self.assertEqual((result.end, result.is_home, result.taken, result.open), ("done", True, 3, 0))
        records = self.records("survey")
        self.assertEqual(sorted(each.view for each in records), [-2, -1, 1, 2, 3])
        for record in records:
            if record.view > 0:
                off_m = np.subtract(record.position_m, VIEWS[record.view - 1].place_m)
                self.assertLess(float(np.linalg.norm(off_m)), 0.2)
        self.assertEqual(self.last.last.encoding, "rgb8")
        self.assertTrue(self.markers.last.markers)
        self.assertAlmostEqual(uav.tilts.last.data, 0.0)

    def test_03_an_abort_brings_it_home_and_the_same_goal_goes_on(self):
        uav = self.uav
        self.send_goal("again", self.plan())
        uav.fly(lambda: self.feedback.last.status.goal_id.id == "again", "the flight")
        uav.fly(lambda: self.feedback.last.feedback.taken >= 1, "a photograph")
        self.assertTrue(self.services["abort"]().success)
        uav.fly(lambda: self.ended("again"), "the way home")
        self.assertEqual(self.results.last.result.end, "aborted")
        self.assertTrue(self.results.last.result.is_home)
        taken = self.results.last.result.taken
        self.send_goal("the rest", self.plan(), "again")
        uav.fly(lambda: self.ended("the rest"), "the rest")
        self.assertEqual(self.results.last.result.end, "done")
        self.assertLess(taken, 3)
        self.assertEqual(len(self.records("again")), 3)

    def plan_of_a_crack(self):
        """The photograph of a wall with a crack, and the plan for it."""
        self.uav.picture = np.full((3000, 4000, 3), 150, np.uint8)
        self.uav.picture[1300:1700, 2100:2103] = 70
        room = trimesh.creation.box((9.2, 9.2, 4.4))
        room.apply_translation((4.8, 4.8, 2.4))
        room.export(self.folder / "drawn.stl")
        views, mesh = (View((6.0, 5.0, 2.0), 0.0, 0.0),), str(self.folder / "drawn.stl")
        return self.plan("fine.yaml", views, FINE_CAMERA, mesh)

    @long
    def test_04_a_search_that_is_awaited_on_the_ground_is_aborted(self):
        plan = self.plan_of_a_crack()
        self.send_goal("aborted", plan, second_look=True)
        self.uav.fly(lambda: self.ended("aborted"), "the wait on the ground")
        self.assertEqual(self.results.last.result.end, "searching")
        self.uav.fly(lambda: self.search.last.data == "searching", "the state of the search")
        self.assertTrue(self.services["abort"]().success)
        self.uav.fly(lambda: self.search.last.data == "aborted", "the end of the search")
        self.assertFalse(self.services["abort"]().success)

    def test_05_it_lands_while_the_photograph_is_searched_and_the_crack_is_photographed_from_nearer(self):
        uav, plan, camera, wall_m = self.uav, self.plan_of_a_crack(), FINE_CAMERA, 9.4
        self.send_goal("second look", plan, second_look=True)
        phases = set()

        def has_ended():
            phases.add(self.feedback.last.feedback.phase)
            return self.ended("second look")

        uav.fly(has_ended, "the wait on the ground")
        result = self.results.last.result
        self.assertEqual((result.end, result.is_home, result.taken), ("searching", True, 1))
        self.assertEqual(self.search.last.data, "searching")
        uav.fly(lambda: self.search.last.data == "idle", "the answer of the search")
        self.send_goal("nearer", plan, "second look", second_look=True)
        uav.fly(lambda: self.ended("nearer"), "the end")
        result = self.results.last.result
        self.assertEqual((result.end, result.taken, result.closer), ("done", 1, 1))
        self.assertIn("searching the photographs", phases)
        near = next(each for each in self.records("second look") if each.view == -1)
        self.assertAlmostEqual(wall_m - near.position_m[0], camera.distance_m(0.3), delta=0.15)
        crack_m = -(2101.0 - camera.centre_px[0]) * (wall_m - 6.0) / camera.focal_px  # left of x is y
        self.assertAlmostEqual(near.position_m[1] - 5.0, crack_m, delta=0.15)

    @long
    def test_06_a_draft_is_completed_while_its_photograph_is_taken(self):
        uav, plan = self.uav, self.plan_of_a_crack()
        asked = SurveyParameters(resolution=20.0, patch=1.0, spacing=2.0)
        write_plan(plan, replace(read_plan(plan), asked=asked, draft=Draft(1, 0.0)))
        self.send_goal("draft", plan)
        uav.fly(lambda: self.ended("draft"), "the photograph of the draft")
        for name in ("the others", "no others"):
            if self.results.last.result.end == "searching":  # a slow machine
                uav.fly(lambda: self.search.last.data == "idle", "the whole plan, or that no more is needed")
                self.send_goal(name, plan, "draft")
                uav.fly(lambda name=name: self.ended(name), "the end")
        whole = read_plan(plan)
        self.assertIsNone(whole.draft)
        self.assertEqual(self.results.last.result.end, "done")
        self.assertEqual({each.view for each in self.records("draft")}, set(range(1, len(whole.views) + 1)))
        self.assertGreater(len(whole.views), 3)

    def test_07_a_camera_that_stops_brings_it_home_and_what_is_taken_stays(self):
        uav, told = self.uav, self.feedback
        uav.picture = np.zeros((48, 64, 3), np.uint8)
        uav.send_map()
        self.send_goal("camera", self.plan())
        uav.fly(lambda: len(self.records("camera")) == 1, "the first photograph")
        uav.camera = "stopped"
        uav.fly(lambda: self.ended("camera"), "the way home")
        uav.camera = "good"
        result = self.results.last.result
        self.assertEqual((result.end, result.is_home, result.taken), ("camera", True, 1))
        self.assertIn("It has stopped. It was asked 3 times.", result.reason)
        self.assertEqual(len(self.records("camera")), 1)
        # When the camera works again, then the same goal takes the others
        self.send_goal("camera again", self.plan(), "camera")
        uav.fly(lambda: self.ended("camera again"), "the rest")
        self.assertEqual(self.results.last.result.end, "done")
        self.assertEqual(sorted(each.view for each in self.records("camera")), [1, 2, 3])
        self.assertEqual(told.last.status.goal_id.id, "camera again")

    def test_08_a_picture_that_is_cut_or_has_no_orientation_is_taken_again(self):
        uav = self.uav
        uav.cut, uav.unturned = 2, 2
        self.send_goal("cut", self.plan())
        uav.fly(lambda: self.ended("cut"), "the end")
        result = self.results.last.result
        self.assertEqual((result.end, result.taken, result.shots >= 5), ("done", 3, True))
        self.assertEqual(uav.unturned, 0)
        self.assertEqual(sorted(each.view for each in self.records("cut")), [1, 2, 3])

    def test_09_a_folder_that_cannot_be_written_brings_it_home(self):
        uav, folder, away = self.uav, self.folder / "storage", self.folder / "storage is away"
        self.send_goal("storage", self.plan())
        uav.fly(lambda: self.listed("storage") == 1, "the first photograph")
        folder.rename(away)
        uav.fly(lambda: self.ended("storage"), "the way home")
        away.rename(folder)
        result = self.results.last.result
        self.assertEqual((result.end, result.is_home, result.taken), ("storage", True, 1))
        self.assertIn("cannot be stored", result.reason)
        self.send_goal("storage again", self.plan(), "storage")
        uav.fly(lambda: self.ended("storage again"), "the rest")
        self.assertEqual(sorted(each.view for each in self.records("storage")), [1, 2, 3])

    def test_10_killed_in_flight_it_loses_no_photograph(self):
        uav = self.uav
        self.send_goal("killed", self.plan())
        uav.fly(lambda: len(self.records("killed")) >= 1, "the first photograph")
        kept = {path: path.read_bytes() for path in photographs_in(self.folder / "killed")}
        begun, old = rospy.get_param(NODE + "/begun"), address_of(NODE)
        os.kill(ServerProxy(old).getPid("/inspect_probe")[2], signal.SIGKILL)
        wait_until(lambda: address_of(NODE) not in (None, old), "the node's new start", 200.0)
        # The goal is latched, so it goes on with what its folder lacks
        self.services["pause"].wait_for_service(200.0)
        begun_again = ServerProxy(address_of(NODE))
        # The result comes once, and the killed node's connection may still count here
        results = NODE + "/survey/result"

        def tells_its_result():
            connections = begun_again.getBusInfo("/inspect_probe")[2]
            return any(each[2] == "o" and each[4] == results for each in connections)

        wait_until(tells_its_result, "the result's topic", 200.0)

        def ended():
            uav.send_map()  # whole, as slam_octomap does for a new listener
            uav.tell()
            return self.ended("killed")

        wait_until(ended, "the end", 200.0)
        result = self.results.last.result
        self.assertEqual(result.left_out_reasons, [])
        self.assertEqual((result.end, result.is_home, result.taken), ("done", True, 3))
        self.assertEqual(rospy.get_param(NODE + "/begun"), {**begun, "has_ended": True})
        self.assertEqual(sorted(each.view for each in self.records("killed")), [1, 2, 3])
        for path, content in kept.items():
            self.assertEqual(path.read_bytes(), content)

    @long
    def test_12_what_a_launch_before_has_left_gives_no_home(self):
        uav = self.uav
        self.send_goal("left", self.plan())
        uav.fly(lambda: len(self.records("left")) >= 1, "the first photograph")
        # Given what another launch has kept of this goal; when the node starts again far from that home
        begun, old = rospy.get_param(NODE + "/begun"), address_of(NODE)
        rospy.set_param(NODE + "/begun", {**begun, "home": [7.0, 7.0, 2.0], "launch": "another one"})
        os.kill(ServerProxy(old).getPid("/inspect_probe")[2], signal.SIGKILL)
        wait_until(lambda: address_of(NODE) not in (None, old), "the node's new start", 200.0)
        # Then it does not wait, as after a death in flight, until it can go on with the latched goal
        wait_until(lambda: self.ended("left"), "the refusal", 200.0)
        self.assertIn("place of the UAV is not known yet", self.results.last.status.text)
        # And another goal comes home to where it begins
        uav.tell()
        rospy.sleep(0.3)
        uav.send_map()
        begin_m = uav.place
        self.assertGreater(float(np.linalg.norm(np.subtract(begin_m, (7.0, 7.0, 2.0)))), 1.0)
        self.send_goal("begun anew", self.plan(), "left")
        uav.fly(lambda: self.ended("begun anew"), "the end")
        self.assertTrue(self.results.last.result.is_home)
        self.assertLess(float(np.linalg.norm(np.subtract(uav.place, begin_m))), 0.5)

    def test_13_an_edited_plan_is_flown_at_its_new_places_only(self):
        uav, moved = self.uav, replace(VIEWS[0], place_m=(6.0, 7.0, 2.0))
        self.send_goal("edited", self.plan("edited.yaml"))
        uav.fly(lambda: self.ended("edited"), "the first flight")
        self.send_goal("edited again", self.plan("edited.yaml", (VIEWS[2], moved)), "edited")
        uav.fly(lambda: self.ended("edited again"), "the second flight")
        result = self.results.last.result
        self.assertEqual((result.end, result.taken, result.open), ("done", 2, 0))
        *_, new = self.records("edited")
        self.assertEqual(len(self.records("edited")), 4)
        self.assertLess(float(np.linalg.norm(np.subtract(new.position_m, moved.place_m))), 0.2)

    def test_14_in_flight_a_plan_that_has_lost_a_key_is_refused(self):
        plan, uav = self.plan("whole.yaml"), self.uav
        lost = self.folder / "lost.yaml"
        lost.write_text(
            plan.read_text().replace("left_out: []", "left_out: [{part: a, area_m2: 1, at: [0, 0, 0]}]")
        )
        self.send_goal("whole", plan)
        uav.fly(lambda: self.feedback.last.status.goal_id.id == "whole", "the flight")
        self.send_goal("lost", lost)
        uav.fly(lambda: self.ended("lost"), "the refusal")
        self.assertIn("entry 1 of left_out lacks the key 'why'", self.results.last.status.text)
        self.send_goal("whole again", plan, "whole")
        uav.fly(lambda: self.ended("whole again"), "the end")
        self.assertEqual(self.results.last.result.end, "done")

    def test_15_the_time_of_a_later_goal_counts(self):
        plan, uav = self.plan("timed.yaml"), self.uav
        self.send_goal("a long time", plan, time_max=1000.0)
        uav.fly(lambda: self.feedback.last.status.goal_id.id == "a long time", "the flight")
        self.send_goal("a short time", plan, "a long time", time_max=1.0)
        uav.fly(lambda: self.ended("a short time"), "the end")
        self.assertEqual(self.results.last.result.end, "time")
        self.assertIn("The time of 1 s is over", self.results.last.result.reason)

    def test_16_where_it_must_land_it_does_not_wait_for_pictures(self):
        """The last of all: the camera's thread goes on waiting for the picture."""
        uav = self.uav
        uav.camera = "blind"
        self.send_goal("blind", self.plan())
        uav.fly(lambda: self.feedback.last.status.goal_id.id == "blind", "the flight")
        uav.fly(lambda: self.feedback.last.feedback.taken == 1, "the first photograph")
        uav.charge = 0.02
        wait_until(lambda: uav.tell() or rospy.sleep(0.02) or self.ended("blind"), "the end", 15.0)
        uav.camera, uav.charge = "good", 0.9
        # "done" if the last shutter opened before the battery was looked at
        self.assertIn(self.results.last.result.end, ("battery", "done"))
        self.assertIn("land here", self.results.last.result.reason)

    def test_z_its_threads_take_locks_in_one_order(self):
        self.assertEqual(take_report(NODE), "")
