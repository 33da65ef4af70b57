"""The node mavros as a script written for MAVROS sees it, over a real MAVLink link to the simulated PX4."""

from __future__ import annotations

import math
import socket
import subprocess
import sys
import time
from pathlib import Path

import rospy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from mavros_msgs import srv
from mavros_msgs.msg import AttitudeTarget, ExtendedState, HomePosition, ParamValue, PositionTarget, State
from mavros_test_case import PATIENCE_S, MavrosTestCase
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Imu, NavSatFix
from std_msgs.msg import Float64
from std_srvs.srv import Empty

from node_tools.testing import long

TOPICS = {
    "state": State,
    "extended_state": ExtendedState,
    "local_position/pose": PoseStamped,
    "local_position/velocity_local": TwistStamped,
    "local_position/velocity_body": TwistStamped,
    "local_position/odom": Odometry,
    "imu/data": Imu,
    "battery": BatteryState,
    "home_position/home": HomePosition,
    "global_position/global": NavSatFix,
    "global_position/rel_alt": Float64,
    "global_position/compass_hdg": Float64,
}


class TestMavros(MavrosTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.listen(TOPICS)
        cls.services = {}
        for name, service_class in (
            ("cmd/arming", srv.CommandBool),
            ("cmd/command", srv.CommandLong),
            ("cmd/takeoff", srv.CommandTOL),
            ("cmd/land", srv.CommandTOL),
            ("set_mode", srv.SetMode),
            ("param/get", srv.ParamGet),
            ("param/set", srv.ParamSet),
            ("param/pull", srv.ParamPull),
        ):
            cls.services[name] = cls.service(name, service_class)
        cls.pose_setpoint = rospy.Publisher("/mavros/setpoint_position/local", PoseStamped, queue_size=1)
        cls.raw_setpoint = rospy.Publisher("/mavros/setpoint_raw/local", PositionTarget, queue_size=1)
        cls.velocity_setpoint = rospy.Publisher(
            "/mavros/setpoint_velocity/cmd_vel", TwistStamped, queue_size=1
        )
        cls.attitude_setpoint = rospy.Publisher("/mavros/setpoint_raw/attitude", AttitudeTarget, queue_size=1)
        cls.unstamped = rospy.Publisher("/mavros/setpoint_velocity/cmd_vel_unstamped", Twist, queue_size=1)
        cls.eventually(lambda: cls.last("home_position/home") is not None)

    def mode(self):
        return self.last("state").mode

    def ask_for(self, mode):
        self.assertTrue(self.services["set_mode"](0, mode).mode_sent)

    def stream_pose(self, x=0.0, y=0.0, z=2.0, yaw=0.0):
        message = PoseStamped()
        message.header.stamp = rospy.get_rostime()
        p, q = message.pose.position, message.pose.orientation
        p.x, p.y, p.z = x, y, z
        q.z, q.w = math.sin(yaw / 2), math.cos(yaw / 2)
        self.pose_setpoint.publish(message)

    # The names sort the flight to the end: the other tests want it on the ground.

    def test_a_topics_come_with_their_frames_and_simulated_stamps(self):
        for name in TOPICS:
            self.assertTrue(self.eventually(lambda name=name: self.last(name) is not None), name)
        state = self.last("state")
        self.assertEqual((state.connected, state.armed, state.mode), (True, False, "AUTO.LOITER"))
        self.assertEqual((state.guided, state.system_status), (True, 3))
        pose = self.last("local_position/pose")
        self.assertEqual(pose.header.frame_id, "map")
        late_s = lambda: rospy.get_time() - self.last("local_position/pose").header.stamp.to_sec()  # noqa: E731
        self.assertTrue(self.eventually(lambda: abs(late_s()) < 2.0), late_s())
        self.assertAlmostEqual(pose.pose.position.z, 0.0, delta=0.05)  # the frame begins where it stands
        self.assertAlmostEqual(pose.pose.orientation.w, 1.0, delta=0.01)  # facing east
        imu = self.last("imu/data")
        self.assertEqual(imu.header.frame_id, "base_link")
        self.assertAlmostEqual(imu.linear_acceleration.z, 9.8, delta=0.5)
        self.assertEqual(self.last("extended_state").landed_state, ExtendedState.LANDED_STATE_ON_GROUND)
        self.assertTrue(self.eventually(lambda: self.last("battery").cell_voltage), "no BATTERY_STATUS")
        battery = self.last("battery")
        self.assertAlmostEqual(battery.percentage, 0.8, delta=0.02)  # the launch file's
        drawn_a = lambda: self.last("battery").current  # noqa: E731
        self.assertTrue(self.eventually(lambda: abs(drawn_a() + 10.0 / 11.82) < 0.03), drawn_a())  # 10 W
        self.assertEqual((len(battery.cell_voltage), battery.present, battery.location), (3, True, "id0"))
        self.assertAlmostEqual(battery.voltage, 11.82, delta=0.02)  # three cells of 3.95 V, less 0.02 ohm
        self.assertEqual(battery.power_supply_status, BatteryState.POWER_SUPPLY_STATUS_DISCHARGING)
        self.assertAlmostEqual(self.last("home_position/home").geo.latitude, 47.3977, delta=0.001)
        self.assertEqual(self.last("local_position/odom").child_frame_id, "base_link")

    def test_b_state_and_home_are_latched(self):
        for name in ("state", "home_position/home"):
            latched = []
            subscriber = rospy.Subscriber(f"/mavros/{name}", TOPICS[name], latched.append)
            self.assertTrue(self.eventually(lambda seen=latched: seen), name)
            self.assertEqual(latched[0]._connection_header["latching"], "1", name)
            subscriber.unregister()

    def test_c_diagnostics_are_mavros_own(self):
        arrays = []
        subscriber = rospy.Subscriber("/diagnostics", DiagnosticArray, arrays.append)
        self.assertTrue(self.eventually(lambda: len(arrays) >= 2))
        subscriber.unregister()
        levels = {status.name: status.level for status in arrays[-1].status}
        names = ("FCU connection", "Heartbeat", "System", "Battery")
        self.assertEqual(levels, {f"mavros: {name}": DiagnosticStatus.OK for name in names})
        values = {value.key: value.value for value in arrays[-1].status[1].values}
        self.assertEqual(values["Mode"], "AUTO.LOITER")
        self.assertIn("24640", arrays[-1].status[0].hardware_id)

    def test_d_parameters(self):
        get, put = self.services["param/get"], self.services["param/set"]
        self.assertAlmostEqual(get("MPC_XY_P").value.real, 0.95, places=5)
        self.assertEqual(get("COM_RC_IN_MODE").value.integer, 1)
        self.assertFalse(put("MPC_XY_P", ParamValue(real=1e300)).success)
        self.assertFalse(put("COM_RC_IN_MODE", ParamValue(integer=2**40)).success)
        answer = put("MPC_XY_P", ParamValue(real=1.1))
        self.assertTrue(answer.success)
        self.assertAlmostEqual(answer.value.real, 1.1, places=5)
        self.assertFalse(put("MPC_XY_P", ParamValue(real=99.0)).success)
        self.assertTrue(put("MPC_XY_P", ParamValue(real=0.95)).success)
        self.assertTrue(put("MPC_Z_VEL_MAX_DN", ParamValue(integer=1)).success)  # a float, given as integer
        self.assertFalse(put("COM_OBL_ACT", ParamValue(real=0.5)).success)
        pulled = self.services["param/pull"](True)
        self.assertTrue(pulled.success)
        self.assertGreater(pulled.param_received, 90)

    def test_e_modes_are_refused_as_px4_does(self):
        self.assertFalse(self.services["set_mode"](0, "FLY").mode_sent)
        self.ask_for("OFFBOARD")  # sent, but there is no stream
        time.sleep(0.3)
        self.assertEqual(self.mode(), "AUTO.LOITER")
        answer = self.services["cmd/command"](False, 31000, 0, 0, 0, 0, 0, 0, 0, 0)
        self.assertEqual((answer.success, answer.result), (False, 3))

    def test_g_garbage_on_the_port_does_no_harm(self):
        sender = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        for data in (b"", b"\xfd", b"\xfd\xff\x00", b"\xfe\x09garbage", b"x" * 2000):
            sender.sendto(data, ("127.0.0.1", 24640))
        sender.close()
        stamp = self.last("local_position/pose").header.stamp
        newer = self.eventually(lambda: self.last("local_position/pose").header.stamp > stamp)
        self.assertTrue(newer)

    def test_h_while_time_stands_still_services_answer_within_their_time_out(self):
        rospy.ServiceProxy("/gazebo/pause_physics", Empty)()
        try:
            began = time.monotonic()
            self.services["param/get"]("MPC_XY_P")
            self.services["set_mode"](0, "AUTO.LOITER")
            self.services["cmd/command"](False, 31000, 0, 0, 0, 0, 0, 0, 0, 0)
            # A second for a parameter, for a command the one that mavros.test sets
            self.assertLess(time.monotonic() - began, 20.0)  # and not for as long as time stands still
        finally:
            rospy.ServiceProxy("/gazebo/unpause_physics", Empty)()

    def test_y_a_script_for_mavros_flies(self):
        """The well-known offboard example: stream, OFFBOARD, arm, hover, fly, land."""
        self.eventually(lambda: False, 0.3, self.stream_pose)
        self.ask_for("OFFBOARD")
        self.assertTrue(self.services["cmd/arming"](True).success)
        height = lambda: self.last("local_position/pose").pose.position.z  # noqa: E731
        self.assertTrue(self.eventually(lambda: abs(height() - 2.0) < 0.1, 60.0, self.stream_pose))
        state = self.last("state")
        self.assertEqual((state.armed, state.mode), (True, "OFFBOARD"))
        self.assertEqual(self.last("extended_state").landed_state, ExtendedState.LANDED_STATE_IN_AIR)

        # Velocity in the body's frame, FLU: forward is east here.
        def fly_forward():
            message = PositionTarget(coordinate_frame=8, type_mask=0b0101_1100_0111)
            message.header.stamp = rospy.get_rostime()
            message.velocity.x = 1.0
            self.raw_setpoint.publish(message)

        body = lambda: self.last("local_position/velocity_body").twist.linear  # noqa: E731
        local = lambda: self.last("local_position/velocity_local").twist.linear  # noqa: E731
        self.assertTrue(self.eventually(lambda: body().x > 0.9 and local().x > 0.9, 60.0, fly_forward))

        # Velocity in the local frame, ENU, by cmd_vel and without a stamp: to the left is north.
        def fly_north():
            message = Twist()
            message.linear.y = 1.0
            self.unstamped.publish(message)

        self.assertTrue(self.eventually(lambda: local().y > 0.9 and abs(local().x) < 0.2, 60.0, fly_north))

        # An attitude, FLU in ENU: nose down by 10 degrees, which flies forward, to the east.
        def lean_forward():
            message = AttitudeTarget(type_mask=AttitudeTarget.IGNORE_ROLL_RATE | 2 | 4, thrust=0.55)
            message.header.stamp = rospy.get_rostime()
            message.orientation.y, message.orientation.w = (
                math.sin(math.radians(5)),
                math.cos(math.radians(5)),
            )
            self.attitude_setpoint.publish(message)

        pitch = lambda: 2.0 * math.asin(self.last("imu/data").orientation.y)  # noqa: E731
        leaning = self.eventually(
            lambda: abs(pitch() - math.radians(10)) < 0.03 and local().x > 0.3, 60.0, lean_forward
        )
        self.assertTrue(leaning)
        denied = self.services["cmd/arming"](False)
        self.assertEqual((denied.success, denied.result), (False, 2))

        # The stream ends: PX4 lands, and comes back with it.
        self.be_patient(1.0)
        self.assertTrue(self.eventually(lambda: self.mode() == "AUTO.LAND"))
        self.be_patient(PATIENCE_S)
        self.assertEqual(self.last("state").system_status, 5)
        self.assertTrue(self.eventually(lambda: self.mode() == "OFFBOARD", 60.0, self.stream_pose))
        self.land_soon()
        self.assertTrue(self.services["cmd/land"](0, 0, 0, 0, 0).success)
        self.assertTrue(self.eventually(lambda: not self.last("state").armed, 60.0))

    @long
    def test_z_the_example_of_an_offboard_script_takes_off_and_lands(self):
        """As a user starts it; afterwards the UAV stands where it stood."""
        z = lambda: self.last("local_position/pose").pose.position.z  # noqa: E731
        ground, heights = z(), []
        # In a node's folder are all the others. rosrun takes long to find one, and time goes fast here.
        command = [
            str(Path(sys.argv[0]).parents[1] / "simulation_tools/offboard_example"),
            "_height:=1.0",
            "_hold:=0.5",
        ]
        example = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        self.addCleanup(example.kill)
        self.eventually(lambda: heights.append(z()) or example.poll() is not None, 90.0)
        said = example.communicate(timeout=200.0)[0]
        self.assertEqual(example.returncode, 0, said)
        self.assertAlmostEqual(max(heights) - ground, 1.0, delta=0.15)
        self.assertAlmostEqual(z(), ground, delta=0.05)
        self.assertFalse(self.last("state").armed)
