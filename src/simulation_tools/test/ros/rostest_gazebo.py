"""The node gazebo as other nodes see it: topics, sensors, times, physics."""

from __future__ import annotations

import math
import time

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from gazebo_msgs.msg import ModelState
from gazebo_test_case import PATIENCE_S, GazeboTestCase
from geometry_msgs.msg import Pose
from sensor_msgs.msg import CameraInfo, FluidPressure, Image, JointState, Range
from std_srvs.srv import SetBool, Trigger

from node_tools.testing import wait_until
from simulation_tools.srv import NodLidar

PARCEL = """<sdf version="1.6"><model name="parcel"><link name="link"><inertial><mass>1</mass><inertia>
<ixx>0.007</ixx><iyy>0.007</iyy><izz>0.007</izz></inertia></inertial><collision name="c"><geometry>
<box><size>0.2 0.2 0.2</size></box></geometry></collision></link></model></sdf>"""


class TestGazebo(GazeboTestCase):
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
        touched = lambda: [m for m in self.received["/UAV/collision"] if m.states]  # noqa: E731
        self.wait_for(touched, what="a contact")
        states = touched()[-1].states
        names = {name for s in states for name in (s.collision1_name, s.collision2_name)}
        self.assertTrue(any(name.startswith("ground_plane::") for name in names), names)
        self.assertTrue(any(name.startswith("iris::") for name in names), names)

    def test_model_states_name_every_model(self):
        self.wait_for(lambda: self.received["/gazebo/model_states"])
        message = self.received["/gazebo/model_states"][-1]
        self.assertTrue({"ground_plane", "wall", "iris"} <= set(message.name))
        wall = message.pose[message.name.index("wall")]
        self.assertEqual((wall.position.x, wall.position.y, wall.position.z), (4.0, 0.0, 1.0))

    def test_performance_carries_its_figures(self):
        message = rospy.wait_for_message("/gazebo/performance", DiagnosticArray, timeout=PATIENCE_S)
        values = {item.key: float(item.value) for item in message.status[0].values}
        self.assertGreater(values["real_time_factor"], 0.0)
        self.assertEqual(values["lockstep_misses"], 0.0)
        self.assertIn("setpoint_latency_ms_median", values)
        self.assertIn("setpoint_latency_ms_p99", values)
        self.assertEqual(values["setpoint_latency_count"], 0.0)

    def test_further_sensors_publish_while_somebody_listens(self):
        answer = rospy.wait_for_message("range_finder", Range, timeout=PATIENCE_S)
        self.assertEqual(answer.header.frame_id, "range_finder_link")
        self.assertAlmostEqual(answer.range, 0.12 - 0.055, delta=0.06)  # on its feet; five sigma
        air = rospy.wait_for_message("barometer", FluidPressure, timeout=PATIENCE_S)
        self.assertAlmostEqual(air.fluid_pressure, 101325.0 - 0.14 * 12.01, delta=8.0)
        self.assertAlmostEqual(air.variance, 1.5**2)
        info = rospy.wait_for_message("camera/camera_info", CameraInfo, timeout=PATIENCE_S)
        picture = rospy.wait_for_message("camera/image_raw", Image, timeout=PATIENCE_S)
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
        joints = rospy.wait_for_message("/gazebo/joint_states", JointState, timeout=PATIENCE_S)
        self.assertEqual(joints.name, ["iris::lidar_roll_joint", "iris::lidar_pitch_joint"])
        self.assertLess(max(map(abs, joints.position)), 0.01)  # it stands level already
        self.assertTrue(level(False).success)

    def test_the_lidar_nods_by_a_service_that_refuses_nonsense(self):
        nod = rospy.ServiceProxy("/gazebo/nod_lidar", NodLidar)
        for values, words in (
            ((math.nan, 4.0, 0), "amplitude_rad of a nod"),
            ((-0.5, 4.0, 0), "amplitude_rad of a nod"),
            ((0.5, -4.0, 0), "period_s of a nod"),
            ((0.5, math.nan, 0), "period_s of a nod"),
            ((1.5, 4.0, 0), "too wide"),
            ((0.7, 0.1, 0), "longer period"),
        ):
            answer = nod(*values)
            self.assertFalse(answer.success)
            self.assertIn(words, answer.status_message)
        answer = nod(0.5, 1.0, 0)
        self.assertTrue(answer.success, answer.status_message)
        pitch_rad = lambda: (  # noqa: E731
            rospy.wait_for_message("/gazebo/joint_states", JointState, timeout=PATIENCE_S).position[1]
        )
        wait_until(lambda: pitch_rad() > 0.4, "a lidar that looks down", PATIENCE_S)
        wait_until(lambda: pitch_rad() < -0.4, "a lidar that looks up", PATIENCE_S)
        self.assertTrue(nod(0.0, 1.0, 0).success)
        wait_until(lambda: pitch_rad() == 0.0, "a level lidar", PATIENCE_S)

    def test_a_full_battery_is_put_in_by_a_service(self):
        answer = rospy.ServiceProxy("/gazebo/swap_battery", Trigger)()
        self.assertEqual((answer.success, answer.message), (True, "A full battery is in."))

    def test_paused_time_stands_still(self):
        self.services["pause_physics"]()
        self.wait_for_standstill()
        before = self.sim_time_s()
        self.services["unpause_physics"]()
        self.wait_for(lambda: self.received["/clock"] and self.received["/scan"], what="time to go on")
        self.assertLess(self.received["/clock"][0].clock.to_sec() - before, 0.05)

    def test_physics_is_tuned_by_dynamic_reconfigure(self):
        client = Client("gazebo", timeout=PATIENCE_S)
        try:
            client.update_configuration({"real_time_factor": 0.25})
            began_s, simulated_s = time.monotonic(), self.sim_time_s()
            self.let_pass(0.4)
            factor = (self.sim_time_s() - simulated_s) / (time.monotonic() - began_s)
            self.assertAlmostEqual(factor, 0.25, delta=0.05)
            applied = client.update_configuration({"real_time_factor": 1.0, "time_step": 0.0021})
            self.assertAlmostEqual(applied["time_step"], 0.002)  # whole milliseconds
            self.assertAlmostEqual(applied["max_update_rate"], 500.0)
            applied = client.update_configuration({"max_update_rate": 250.0})
            self.assertAlmostEqual(applied["real_time_factor"], 0.5)
            client.update_configuration({"real_time_factor": 1.0})
            applied = client.update_configuration({"real_time_factor": -3.0})
            self.assertEqual(applied["real_time_factor"], 1.0)  # refused: 0 would be as fast as possible
            client.update_configuration({"pause": True})
            self.wait_for_standstill()
            self.services["unpause_physics"]()
            runs = lambda: not client.get_configuration(timeout=PATIENCE_S)["pause"]  # noqa: E731
            wait_until(runs, "the configuration without pause", PATIENCE_S)
        finally:
            client.update_configuration({"real_time_factor": 1.0, "time_step": 0.004, "pause": False})
            client.close()

    def test_gravity_and_contacts_are_tuned_while_the_world_runs(self):
        client = Client("gazebo", timeout=PATIENCE_S)
        usual = client.get_configuration(timeout=PATIENCE_S)
        self.assertAlmostEqual(usual["gravity_z"], -9.80665)  # the world file's
        pose = Pose()
        pose.position.x, pose.position.y, pose.position.z, pose.orientation.w = -5.0, -5.0, 40.0, 1.0
        try:
            client.update_configuration({"gravity_x": 1.0, "gravity_z": 0.0})
            self.services["spawn_sdf_model"]("parcel", PARCEL, "", pose, "world")
            before = self.services["get_model_state"]("parcel", "")
            self.let_pass(0.3)
            after = self.services["get_model_state"]("parcel", "")
            passed_s = (after.header.stamp - before.header.stamp).to_sec()
            gained = after.twist.linear.x - before.twist.linear.x
            self.assertAlmostEqual(gained / passed_s, 1.0, delta=0.05)
            self.assertAlmostEqual(after.pose.position.z, 40.0, delta=1e-6)
            client.update_configuration({"gravity_x": 0.0, "gravity_z": -9.8, "contact_surface_layer": 0.02})
            pose.position.z = 0.5
            self.services["set_model_state"](ModelState(model_name="parcel", pose=pose))
            self.let_pass(1.0)
            at_rest = self.services["get_model_state"]("parcel", "").pose.position.z
            self.assertAlmostEqual(at_rest, 0.1 - 0.02, delta=2e-3)
        finally:
            self.services["delete_model"]("parcel")
            client.update_configuration(
                {name: usual[name] for name in ("gravity_x", "gravity_z", "contact_surface_layer")}
            )
            self.services["reset_world"]()  # the UAV has sunk as well
