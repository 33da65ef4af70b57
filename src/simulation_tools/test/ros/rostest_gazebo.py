#!/usr/bin/env python3
"""The node gazebo as other nodes see it: topics, times, services, reset, nonsense."""

from __future__ import annotations

import math
import threading
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from gazebo_msgs.msg import ContactsState, ModelState, ModelStates
from gazebo_msgs.srv import DeleteModel, GetModelState, GetWorldProperties, SetModelState, SpawnModel
from geometry_msgs.msg import Pose
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, FluidPressure, Image, Imu, JointState, LaserScan, Range
from std_srvs.srv import Empty, SetBool
from visualization_msgs.msg import Marker, MarkerArray

BOX = """<sdf version="1.6"><model name="crate"><static>true</static><link name="link">
<collision name="c"><geometry><box><size>0.2 2 2</size></box></geometry></collision>
<visual name="v"><geometry><box><size>0.2 2 2</size></box></geometry></visual></link></model></sdf>"""
PARCEL = """<sdf version="1.6"><model name="parcel"><link name="link"><inertial><mass>1</mass><inertia>
<ixx>0.007</ixx><iyy>0.007</iyy><izz>0.007</izz></inertia></inertial><collision name="c"><geometry>
<box><size>0.2 0.2 0.2</size></box></geometry></collision></link></model></sdf>"""
TOPICS = {
    "/clock": Clock,
    "/scan": LaserScan,
    "/UAV/odometry": Odometry,
    "/UAV/ground_truth": Odometry,
    "/UAV/collision": ContactsState,
    "/imu": Imu,
    "/gazebo/model_states": ModelStates,
}


class TestGazebo(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.changed = threading.Condition()
        cls.received = {name: [] for name in TOPICS}
        for name, message_class in TOPICS.items():
            rospy.Subscriber(name, message_class, cls._on_message, name, queue_size=1000, tcp_nodelay=True)
        cls.services = {}
        for name, service_class in (
            ("pause_physics", Empty),
            ("unpause_physics", Empty),
            ("reset_simulation", Empty),
            ("reset_world", Empty),
            ("spawn_sdf_model", SpawnModel),
            ("delete_model", DeleteModel),
            ("get_model_state", GetModelState),
            ("set_model_state", SetModelState),
            ("get_world_properties", GetWorldProperties),
        ):
            rospy.wait_for_service(f"/gazebo/{name}", timeout=20.0)
            cls.services[name] = rospy.ServiceProxy(f"/gazebo/{name}", service_class)

    @classmethod
    def _on_message(cls, message, name):
        with cls.changed:
            cls.received[name].append(message)
            cls.changed.notify_all()

    def setUp(self):
        self.services["unpause_physics"]()
        self.forget()

    def forget(self):
        with self.changed:
            for messages in self.received.values():
                messages.clear()

    def wait_for(self, condition, timeout_s=5.0, what="condition"):
        with self.changed:
            self.assertTrue(self.changed.wait_for(condition, timeout_s), f"{what} did not come true")

    def collect(self, seconds):
        self.wait_for(lambda: self.received["/clock"], what="/clock")
        time.sleep(seconds)
        with self.changed:
            return {name: list(messages) for name, messages in self.received.items()}

    def scan_ahead(self):
        """Median range of the beams within 2 degrees of straight ahead, of a scan that comes from now on."""
        time.sleep(0.1)
        self.forget()
        self.wait_for(lambda: self.received["/scan"], what="a scan")
        scan = self.received["/scan"][-1]
        beams = [
            r
            for k, r in enumerate(scan.ranges)
            if abs(scan.angle_min + k * scan.angle_increment) < math.radians(2.0)
        ]
        return sorted(beams)[len(beams) // 2]

    # -- topics
    # ------------------------------------------------------------------------------------------------

    def test_scan_is_that_of_the_ust_and_sees_the_wall(self):
        self.wait_for(lambda: len(self.received["/scan"]) > 10)
        scans = self.received["/scan"][:]
        scan = scans[0]
        self.assertEqual(scan.header.frame_id, "hokuyo")
        self.assertEqual(len(scan.ranges), 1081)
        self.assertAlmostEqual(scan.angle_increment, math.radians(0.25), places=6)
        self.assertAlmostEqual(scan.angle_min, -math.radians(135.0), places=6)
        self.assertAlmostEqual(scan.angle_max, scan.angle_min + 1080 * scan.angle_increment, places=5)
        self.assertAlmostEqual(scan.range_max, 10.0, places=5)
        self.assertAlmostEqual(scan.scan_time, 0.025, places=6)
        stamps = [message.header.stamp.to_sec() for message in scans]
        self.assertAlmostEqual((stamps[-1] - stamps[0]) / (len(stamps) - 1), 0.025, delta=0.001)
        self.assertAlmostEqual(self.scan_ahead(), 3.0, delta=0.06)  # the lidar's accuracy is 4 cm

    def test_a_touched_floor_is_a_collision(self):
        message = self.collect(0.5)["/UAV/collision"][-1]
        self.assertGreater(len(message.states), 0)
        names = {name for s in message.states for name in (s.collision1_name, s.collision2_name)}
        self.assertTrue(any(name.startswith("ground_plane::") for name in names), names)
        self.assertTrue(any(name.startswith("iris::") for name in names), names)

    def test_model_states_name_every_model(self):
        self.wait_for(lambda: self.received["/gazebo/model_states"])
        message = self.received["/gazebo/model_states"][-1]
        self.assertTrue({"ground_plane", "wall", "iris"} <= set(message.name))
        wall = message.pose[message.name.index("wall")]
        self.assertEqual((wall.position.x, wall.position.y, wall.position.z), (4.0, 0.0, 1.0))

    def test_visuals_are_latched_and_follow_the_models(self):
        def marker_names():
            array = rospy.wait_for_message("/gazebo/visuals", MarkerArray, timeout=5.0)
            return {(m.ns, m.header.frame_id) for m in array.markers if m.action == Marker.ADD}

        names = marker_names()
        self.assertIn(("wall", "world"), names)
        self.assertIn(("iris", "base_frame"), names)
        self.services["spawn_sdf_model"]("painted", BOX, "", far_pose(), "")
        self.assertIn(("painted", "world"), marker_names())
        self.services["delete_model"]("painted")
        self.assertNotIn(("painted", "world"), marker_names())

    def test_performance_carries_its_figures(self):
        message = rospy.wait_for_message("/gazebo/performance", DiagnosticArray, timeout=5.0)
        values = {item.key: float(item.value) for item in message.status[0].values}
        self.assertGreater(values["real_time_factor"], 0.0)
        self.assertEqual(values["lockstep_misses"], 0.0)
        self.assertIn("setpoint_latency_ms_median", values)
        self.assertIn("setpoint_latency_ms_p99", values)
        self.assertEqual(values["setpoint_latency_count"], 0.0)

    # -- time
    # --------------------------------------------------------------------------------------------------

    def test_paused_time_stands_still(self):
        self.services["pause_physics"]()
        time.sleep(0.2)
        self.forget()
        time.sleep(0.5)
        self.assertFalse(self.received["/clock"])
        self.assertFalse(self.received["/scan"])
        before = self.services["get_world_properties"]().sim_time
        self.services["unpause_physics"]()
        self.wait_for(lambda: self.received["/scan"], what="a scan after unpausing")
        self.assertLess(self.received["/clock"][0].clock.to_sec() - before, 0.05)

    def test_physics_is_tuned_by_dynamic_reconfigure(self):
        client = Client("gazebo", timeout=5.0)
        try:
            client.update_configuration({"real_time_factor": 0.25})
            self.forget()
            clock = self.collect(1.0)["/clock"]
            self.assertAlmostEqual((clock[-1].clock - clock[0].clock).to_sec(), 0.25, delta=0.05)
            applied = client.update_configuration({"real_time_factor": 1.0, "time_step": 0.0021})
            self.assertAlmostEqual(applied["time_step"], 0.002)  # whole milliseconds
            self.assertAlmostEqual(applied["max_update_rate"], 500.0)
            applied = client.update_configuration({"max_update_rate": 250.0})
            self.assertAlmostEqual(applied["real_time_factor"], 0.5)
            client.update_configuration({"real_time_factor": 1.0})
            applied = client.update_configuration({"real_time_factor": -3.0})
            self.assertEqual(applied["real_time_factor"], 1.0)  # refused: 0 would be as fast as possible
            client.update_configuration({"pause": True})
            time.sleep(0.1)
            self.forget()
            time.sleep(0.3)
            self.assertFalse(self.received["/clock"])
            self.services["unpause_physics"]()
            deadline = time.time() + 5.0
            while client.get_configuration(timeout=2.0)["pause"]:
                self.assertLess(time.time(), deadline, "the configuration still says pause")
                time.sleep(0.02)
        finally:
            client.update_configuration({"real_time_factor": 1.0, "time_step": 0.004, "pause": False})
            client.close()

    def test_gravity_and_contacts_are_tuned_while_the_world_runs(self):
        client = Client("gazebo", timeout=5.0)
        usual = client.get_configuration(timeout=5.0)
        self.assertAlmostEqual(usual["gravity_z"], -9.80665)  # the world file's
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z, pose.orientation.w = -5.0, -5.0, 40.0, 1.0
        try:
            client.update_configuration({"gravity_x": 1.0, "gravity_z": 0.0})
            self.services["spawn_sdf_model"]("parcel", PARCEL, "", pose, "world")
            before = self.services["get_model_state"]("parcel", "")
            time.sleep(0.5)
            after = self.services["get_model_state"]("parcel", "")
            passed_s = (after.header.stamp - before.header.stamp).to_sec()
            self.assertGreater(passed_s, 0.2)
            gained = after.twist.linear.x - before.twist.linear.x
            self.assertAlmostEqual(gained / passed_s, 1.0, delta=0.05)
            self.assertAlmostEqual(after.pose.position.z, 40.0, delta=1e-6)
            client.update_configuration({"gravity_x": 0.0, "gravity_z": -9.8, "contact_surface_layer": 0.02})
            pose.position.z = 0.5
            self.services["set_model_state"](ModelState(model_name="parcel", pose=pose))
            time.sleep(1.0)
            at_rest = self.services["get_model_state"]("parcel", "").pose.position.z
            self.assertAlmostEqual(at_rest, 0.1 - 0.02, delta=2e-3)
        finally:
            self.services["delete_model"]("parcel")
            client.update_configuration(
                {name: usual[name] for name in ("gravity_x", "gravity_z", "contact_surface_layer")}
            )
            self.services["reset_world"]()  # the UAV has sunk as well

    # -- models
    # ------------------------------------------------------------------------------------------------

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

    # -- further sensors
    # ------------------------------------------------------------------------------------------------

    def test_further_sensors_publish_while_somebody_listens(self):
        answer = rospy.wait_for_message("range_finder", Range, timeout=5.0)
        self.assertEqual(answer.header.frame_id, "range_finder_link")
        self.assertAlmostEqual(answer.range, 0.12 - 0.055, delta=0.06)  # on its feet; five sigma
        air = rospy.wait_for_message("barometer", FluidPressure, timeout=5.0)
        self.assertAlmostEqual(air.fluid_pressure, 101325.0 - 0.14 * 12.01, delta=8.0)
        self.assertAlmostEqual(air.variance, 1.5**2)
        info = rospy.wait_for_message("camera/camera_info", CameraInfo, timeout=5.0)
        picture = rospy.wait_for_message("camera/image_raw", Image, timeout=10.0)
        self.assertEqual((picture.encoding, picture.width, picture.height), ("rgb8", 320, 240))
        self.assertEqual(len(picture.data), 320 * 240 * 3)
        self.assertEqual(picture.header.frame_id, "camera_link/camera_optical")
        self.assertEqual(info.header.frame_id, picture.header.frame_id)
        self.assertAlmostEqual(info.K[0], 160.0 / math.tan(math.radians(40.0)), places=3)
        self.assertEqual((info.K[2], info.K[5]), (159.5, 119.5))

    def test_the_lidar_is_levelled_by_a_service(self):
        level = rospy.ServiceProxy("/gazebo/level_lidar", SetBool)
        answer = level(True)
        self.assertTrue(answer.success, answer.message)
        joints = rospy.wait_for_message("/gazebo/joint_states", JointState, timeout=5.0)
        self.assertEqual(joints.name, ["iris::lidar_roll_joint", "iris::lidar_pitch_joint"])
        self.assertLess(max(map(abs, joints.position)), 0.01)  # it stands level already
        self.assertTrue(level(False).success)

    def test_the_topic_set_model_state_moves_models_too(self):
        publisher = rospy.Publisher("/gazebo/set_model_state", ModelState, queue_size=1)
        while not publisher.get_num_connections():
            time.sleep(0.02)
        state = ModelState(model_name="wall")
        state.pose.position.x, state.pose.position.z, state.pose.orientation.w = 6.0, 1.0, 1.0
        publisher.publish(state)
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


if __name__ == "__main__":
    rospy.init_node("rostest_gazebo")
    rostest.rosrun("simulation_tools", "gazebo_test", TestGazebo)
