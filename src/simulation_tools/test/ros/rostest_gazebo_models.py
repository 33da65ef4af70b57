"""Models of the node gazebo come, go and move by its services, are seen, and nonsense is refused."""

from __future__ import annotations

import math

import rospy
from gazebo_msgs.msg import ModelState
from gazebo_test_case import PATIENCE_S, GazeboTestCase
from geometry_msgs.msg import Pose
from visualization_msgs.msg import Marker, MarkerArray

from node_tools.testing import Input

BOX = """<sdf version="1.6"><model name="crate"><static>true</static><link name="link">
<collision name="c"><geometry><box><size>0.2 2 2</size></box></geometry></collision>
<visual name="v"><geometry><box><size>0.2 2 2</size></box></geometry></visual></link></model></sdf>"""


class TestGazeboModels(GazeboTestCase):
    def test_visuals_are_latched_and_follow_the_models(self):
        def marker_names():
            array = rospy.wait_for_message("/gazebo/visuals", MarkerArray, timeout=PATIENCE_S)
            return {(m.ns, m.header.frame_id) for m in array.markers if m.action == Marker.ADD}

        names = marker_names()
        self.assertIn(("wall", "world"), names)
        self.assertIn(("iris", "base_frame"), names)
        self.services["spawn_sdf_model"]("painted", BOX, "", far_pose(), "")
        self.assertIn(("painted", "world"), marker_names())
        self.services["delete_model"]("painted")
        self.assertNotIn(("painted", "world"), marker_names())

    def test_a_model_in_urdf_is_spawned(self):
        shape = '<collision><geometry><sphere radius="0.2"/></geometry></collision>'
        text = f'<robot name="r"><link name="l">{shape}</link></robot>'
        answer = self.services["spawn_urdf_model"]("ball", text, "", far_pose(), "")
        self.assertTrue(answer.success, answer.status_message)
        self.assertTrue(self.services["delete_model"]("ball").success)

    def test_what_is_spawned_while_paused_is_seen_afterwards(self):
        self.assertAlmostEqual(self.scan_ahead(), 3.0, delta=0.06)
        self.services["pause_physics"]()
        pose = Pose()
        pose.position.x, pose.position.z, pose.orientation.w = 1.6, 1.0, 1.0
        answer = self.services["spawn_sdf_model"]("crate", BOX, "", pose, "world")
        self.assertTrue(answer.success, answer.status_message)
        self.services["unpause_physics"]()
        self.assertAlmostEqual(self.scan_ahead(), 1.5, delta=0.06)
        self.assertTrue(self.services["delete_model"]("crate").success)
        self.assertAlmostEqual(self.scan_ahead(), 3.0, delta=0.06)

    def test_states_are_relative_to_the_entity_asked_for(self):
        state = ModelState(model_name="wall", reference_frame="")
        state.pose.position.x, state.pose.position.y, state.pose.position.z = 5.0, 1.0, 1.0
        state.pose.orientation.z = state.pose.orientation.w = math.sqrt(0.5)  # turned by 90 degrees
        try:
            self.assertTrue(self.services["set_model_state"](state).success)
            floor = self.services["get_model_state"]("ground_plane", "wall")
            # From the wall, turned left, the origin is 1 m behind on x and 5 m ahead on y.
            self.assertTrue(floor.success, floor.status_message)
            place = floor.pose.position
            self.assertAlmostEqual(place.x, -1.0, places=9)
            self.assertAlmostEqual(place.y, 5.0, places=9)
            link = self.services["get_model_state"]("ground_plane", "wall::link")
            self.assertAlmostEqual(link.pose.position.y, 5.0, places=9)
            relative = ModelState(model_name="wall", reference_frame="wall")
            relative.pose.position.x, relative.pose.orientation.w = 1.0, 1.0
            self.assertTrue(self.services["set_model_state"](relative).success)
            moved = self.services["get_model_state"]("wall", "world").pose.position
            self.assertAlmostEqual(moved.y, 2.0, places=9)
            self.assertAlmostEqual(moved.x, 5.0, places=9)
        finally:
            self.services["reset_world"]()
        home = self.services["get_model_state"]("wall", "").pose.position
        self.assertEqual((home.x, home.y, home.z), (4.0, 0.0, 1.0))

    def test_an_orientation_of_zeros_is_none_as_in_gazebo(self):
        state = ModelState(model_name="wall")
        state.pose.position.x = 5.5
        try:
            self.assertTrue(self.services["set_model_state"](state).success)
            pose = self.services["get_model_state"]("wall", "").pose
            self.assertEqual((pose.position.x, pose.orientation.w), (5.5, 1.0))
        finally:
            self.services["reset_world"]()

    def test_the_topic_set_model_state_moves_models_too(self):
        states = Input("/gazebo/set_model_state", ModelState)
        state = ModelState(model_name="wall")
        state.pose.position.x, state.pose.position.z, state.pose.orientation.w = 6.0, 1.0, 1.0
        states.send(state)
        self.wait_for(
            lambda: any(
                m.pose[m.name.index("wall")].position.x == 6.0 for m in self.received["/gazebo/model_states"]
            ),
            what="the wall at x = 6",
        )
        self.services["reset_world"]()

    def test_nonsense_is_refused_with_a_sentence_and_time_goes_on(self):
        nan_pose = Pose()
        nan_pose.position.x, nan_pose.orientation.w = math.nan, 1.0
        good = far_pose()
        spin = ModelState(model_name="wall", pose=good)
        spin.twist.angular.z = math.inf
        call = self.services
        refused = [
            call["spawn_sdf_model"]("a", "<sdf", "", good, ""),
            call["spawn_sdf_model"]("a", BOX, "", nan_pose, ""),
            call["spawn_sdf_model"]("a", BOX, "", good, "no_such_model"),
            call["delete_model"]("iris"),
            call["get_model_state"]("wall", "wall::no_such_link"),
            call["set_model_state"](ModelState(model_name="no_such_model", pose=good)),
            call["set_model_state"](ModelState(model_name="wall", pose=nan_pose)),
            call["set_model_state"](spin),
        ]
        for number, answer in enumerate(refused):
            self.assertFalse(answer.success, f"request {number}")
            self.assertTrue(10 < len(answer.status_message) < 400, f"{number}: {answer.status_message}")
            self.assertNotIn("\n", answer.status_message)
        self.assertNotIn("a", call["get_world_properties"]().model_names)
        self.forget()
        self.wait_for(lambda: len(self.received["/scan"]) > 3, what="scans after nonsense")


def far_pose():
    pose = Pose()
    pose.position.x, pose.position.y, pose.orientation.w = -20.0, 20.0, 1.0
    return pose
