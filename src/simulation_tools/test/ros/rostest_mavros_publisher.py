"""sitl.launch and tools.launch in flight: ready, TF, commands, bad commands, deaths, landings."""

from __future__ import annotations

import contextlib
import math
import os
import re
import shlex
import signal
import subprocess
import time
import xmlrpc.client
from pathlib import Path

import rosgraph
import rosgraph_msgs.msg
import rosnode
import rospkg
import rospy
import tf2_ros
from diagnostic_msgs.msg import DiagnosticArray
from dynamic_reconfigure.client import Client
from gazebo_msgs.msg import ContactsState
from geometry_msgs.msg import Pose, TwistStamped
from mavros_msgs.msg import State
from mavros_msgs.srv import SetMode
from mavros_test_case import MavrosTestCase
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from std_msgs.msg import Bool
from std_srvs.srv import Trigger

from node_tools.testing import long

YAW = 0.5  # at the start
HIGH_M = 2.5  # above the hover height: PX4's landing takes 7 s from there, longer than any node is away
PATIENCE_S = 4.0  # PX4's own is 1 s
STOOD_M = 0.12  # height of an Iris's origin over the ground


class TestMavrosPublisher(MavrosTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.truth = cls.state = None
        cls.ready = []
        cls.highest = 0.0
        cls.touched = []
        cls.tf = tf2_ros.Buffer()
        cls.listener = tf2_ros.TransformListener(cls.tf)
        rospy.Subscriber("/UAV/ground_truth", Odometry, cls.on_truth, queue_size=1, tcp_nodelay=True)
        rospy.Subscriber("/UAV/ready", Bool, lambda m: cls.ready.append(m.data))
        rospy.Subscriber("/mavros/state", State, cls.on_state)
        rospy.Subscriber("/gazebo/performance", DiagnosticArray, cls.on_performance)
        rospy.Subscriber("/UAV/collision", ContactsState, lambda m: cls.touched.extend(m.states))
        cls.velocity = rospy.Publisher("/UAV/vel_setpoint/final/body", TwistStamped, queue_size=1)
        cls.position = rospy.Publisher("/UAV/pos_setpoint/final", Pose, queue_size=1)
        cls.use_position = rospy.Publisher("/UAV/use_pos_setpoint", Bool, queue_size=1)
        cls.be_patient(PATIENCE_S)

    @classmethod
    def on_truth(cls, message):
        cls.truth = message
        cls.highest = max(cls.highest, message.pose.pose.position.z)

    @classmethod
    def on_performance(cls, message):
        cls.performance = {item.key: float(item.value) for item in message.status[0].values}

    @classmethod
    def on_state(cls, message):
        cls.state = message

    def setUp(self):
        """Every test begins in flight; that it gets there is part of what is tested."""
        self.assertTrue(self.eventually(lambda: self.ready and self.ready[-1], 60.0))

    @staticmethod
    def for_simulated(duration_s, act=lambda: None):
        """Let simulated time pass, and do something every now and then meanwhile."""
        end = rospy.get_rostime() + rospy.Duration(duration_s)
        deadline = time.monotonic() + 20.0 + 5.0 * duration_s
        while rospy.get_rostime() < end:
            assert time.monotonic() < deadline, "simulated time stands still"
            act()
            time.sleep(0.02)

    @contextlib.contextmanager
    def in_real_time(self):
        """PX4 waits in simulated time for nodes that start in wall time."""
        client = Client("/gazebo", timeout=200.0)
        usual = client.get_configuration()["real_time_factor"]
        client.update_configuration({"real_time_factor": 1.0})
        try:
            yield
        finally:
            client.update_configuration({"real_time_factor": usual})

    @property
    def place(self):
        p = self.truth.pose.pose.position
        return p.x, p.y, p.z

    @property
    def speed(self):
        v = self.truth.twist.twist.linear
        return math.sqrt(v.x**2 + v.y**2 + v.z**2)

    def fly(self, forward=1.0, left=0.0, frame="base_frame", stamp=None):
        message = TwistStamped()
        message.header.stamp = stamp or rospy.get_rostime()
        message.header.frame_id = frame
        message.twist.linear.x, message.twist.linear.y = forward, left
        self.velocity.publish(message)

    def assert_hovers(self):
        """It has come to rest: slow for a second on end, and still in the same place after another."""
        moved = [rospy.get_time()]

        def settled():
            if self.speed > 0.1:
                moved[0] = rospy.get_time()
            return rospy.get_time() - moved[0] > 1.0

        self.assertTrue(self.eventually(settled, 60.0))
        before = self.place
        self.for_simulated(1.0)
        self.assertLess(math.dist(before, self.place), 0.15)

    def test_a_it_hovers_two_metres_over_the_ground_facing_as_it_stood(self):
        self.assertEqual((self.state.mode, self.state.armed), ("OFFBOARD", True))
        self.for_simulated(4.0, lambda: self.fly(forward=0.0))  # a stack without a goal
        x, y, z = self.place
        self.assertLess(math.hypot(x, y), 0.05)
        self.assertAlmostEqual(z, 2.0, delta=0.05)
        q = self.truth.pose.pose.orientation
        self.assertAlmostEqual(2.0 * math.atan2(q.z, q.w), YAW, delta=0.03)

    def test_aa_tf_of_the_lidar_agrees_with_the_ground_truth(self):
        hokuyo, base = (
            self.tf.lookup_transform("world", frame, rospy.Time(0), rospy.Duration(60.0)).transform
            for frame in ("hokuyo", "base_frame")
        )
        self.tf.lookup_transform("odom", "hokuyo", rospy.Time(0), rospy.Duration(60.0))
        self.assertAlmostEqual(base.translation.z, 2.0, delta=0.06)
        height = hokuyo.translation.z - base.translation.z
        self.assertAlmostEqual(height, 0.062 + 0.0525, delta=0.002)  # the mount and the UST's own height

    def test_ab_answers_to_scans_are_flown_and_their_latency_is_measured(self):
        self.touched.clear()
        answer = lambda scan: self.fly(forward=0.5, stamp=scan.header.stamp)  # noqa: E731
        subscriber = rospy.Subscriber("/scan", LaserScan, answer, queue_size=1, tcp_nodelay=True)
        self.for_simulated(3.0)
        began, start = rospy.get_time(), self.place
        self.for_simulated(2.0)
        way = math.dist(start, self.place)
        self.assertAlmostEqual(way / (rospy.get_time() - began), 0.5, delta=0.1)
        subscriber.unregister()
        self.assertTrue(self.eventually(lambda: self.performance["setpoint_latency_count"] > 50))
        self.assertGreater(self.performance["setpoint_latency_ms_median"], 0.0)
        self.assertFalse(self.touched)

    def test_b_velocities_are_flown_in_the_levelled_body_frame(self):
        start = self.place
        v = lambda: self.truth.twist.twist.linear  # noqa: E731  body frame
        self.assertTrue(self.eventually(lambda: v().x > 0.9 and abs(v().y) < 0.15, 60.0, self.fly))
        heading = math.atan2(self.place[1] - start[1], self.place[0] - start[0])
        self.assertAlmostEqual(heading, YAW, delta=0.1)

    @long
    def test_ba_the_command_of_the_readme_flies(self):
        readme = Path(rospkg.RosPack().get_path("simulation_tools"), "README.md").read_text()
        command = re.search(r"^rostopic pub .*$", readme, re.MULTILINE).group()
        x, y, _ = self.place
        environment = {**os.environ, "PATH": f"/usr/bin:{os.environ['PATH']}"}
        pilot = subprocess.Popen(shlex.split(command), env=environment, stdout=subprocess.DEVNULL)
        try:
            ahead = lambda: (self.place[0] - x) * math.cos(YAW) + (self.place[1] - y) * math.sin(YAW)  # noqa: E731
            self.assertTrue(self.eventually(lambda: ahead() > 2.0))
        finally:
            pilot.terminate()
            pilot.wait()

    def test_c_without_commands_it_hovers_on_the_spot(self):
        self.for_simulated(1.5, self.fly)
        there = self.place
        self.assert_hovers()
        self.assertLess(math.dist(there, self.place), 2.0)

    def test_d_bad_commands_are_refused_and_it_hovers(self):
        def nonsense():
            self.fly(forward=math.nan)
            self.fly(left=math.inf)
            self.fly(frame="nowhere")
            self.fly(stamp=rospy.Time(1))

        before = self.place
        self.for_simulated(2.0, nonsense)
        self.assertLess(math.dist(before, self.place), 0.15)

    def test_e_positions_are_flown_by_topic_or_dynamic_reconfigure(self):
        x, y, z = self.place
        target = Pose()
        # In PX4's local frame, which begins where the UAV stood.
        target.position.x, target.position.y, target.position.z = x - 2.0, y + 1.0, z + HIGH_M - STOOD_M
        target.orientation.w = 1.0

        def both():
            self.position.publish(target)
            self.fly()

        self.use_position.publish(True)
        there = (x - 2.0, y + 1.0, z + HIGH_M)
        self.assertTrue(self.eventually(lambda: math.dist(self.place, there) < 0.15, 60.0, both))
        client = Client("/mavros_publisher", timeout=200.0)
        self.assertTrue(client.get_configuration()["use_pos_setpoint"])
        client.update_configuration({"use_pos_setpoint": False})
        v = lambda: self.truth.twist.twist.linear  # noqa: E731
        self.assertTrue(self.eventually(lambda: v().x > 0.8, 60.0, both))

    @long
    def test_f_killed_in_mid_air_it_takes_over_where_the_uav_is(self):
        self.for_simulated(1.5, self.fly)
        type(self).highest = 0.0
        where = self.place
        seen = len(self.ready)
        with self.in_real_time():
            rosnode.kill_nodes(["/mavros_publisher"])
            self.assertTrue(self.eventually(lambda: True in self.ready[seen:], 60.0))
            self.assertTrue(self.eventually(lambda: self.state.mode == "OFFBOARD"))
        taken_over = self.place
        self.assert_hovers()
        self.assertTrue(self.state.armed)
        self.assertLess(math.dist(taken_over[:2], self.place[:2]), 1.5)
        self.assertLess(self.highest, where[2] + 0.3)  # no second take-off

    @long
    def test_g_mavros_killed_leads_to_landing_and_back_to_the_hover_height(self):
        height = self.place[2]
        seen = len(self.ready)
        self.be_patient(1.0)
        self.addCleanup(self.be_patient, PATIENCE_S)
        rises = lambda: self.state.mode == "OFFBOARD" and self.truth.twist.twist.linear.z > -0.1  # noqa: E731
        with self.in_real_time():
            rosnode.kill_nodes(["/mavros"])
            self.assertTrue(self.eventually(lambda: self.place[2] < height - 0.1))
            self.assertTrue(self.eventually(rises, 60.0))
        self.assertTrue(self.eventually(lambda: False in self.ready[seen:] and self.ready[-1], 60.0))
        self.assert_hovers()
        self.assertGreater(self.place[2], 1.9)

    @long
    def test_ga_a_mavros_that_hangs_is_called_by_its_name(self):
        said = []
        rosout = rospy.Subscriber("/rosout", rosgraph_msgs.msg.Log, lambda m: said.append(m.msg))
        seen = len(self.ready)
        pid = self.pid_of("/mavros")
        os.kill(pid, signal.SIGSTOP)
        try:
            self.for_simulated(6.0, self.fly)
        finally:
            os.kill(pid, signal.SIGCONT)
        self.assertTrue(self.eventually(lambda: False in self.ready[seen:]))
        self.assertTrue(self.eventually(lambda: any("MAVROS has sent no pose for" in text for text in said)))
        self.assertFalse([text for text in said if "stamped in the future" in text])
        self.assertTrue(self.eventually(lambda: self.ready[-1], 60.0, self.fly))
        self.assertGreater(self.place[2], 1.9)
        rosout.unregister()

    @staticmethod
    def pid_of(node):
        uri = rosgraph.Master("/test").lookupNode(node)
        return xmlrpc.client.ServerProxy(uri).getPid("/test")[2]

    @long
    def test_gb_wind_tilts_the_hovering_uav_and_can_be_tuned(self):
        client = Client("/gazebo", timeout=200.0)
        client.update_configuration({"wind_x": 6.0})
        self.addCleanup(client.update_configuration, {"wind_x": 0.0})
        self.for_simulated(8.0, lambda: self.fly(forward=0.0))
        q = self.truth.pose.pose.orientation
        tilt = math.acos(1.0 - 2.0 * (q.x**2 + q.y**2))
        # Four rotors' drag, 1.75e-4 N per m/s and rad/s, at the speed that carries 1.63 kg, over the weight.
        weight_n = 1.63 * 9.8
        drag_n = 4 * 1.75e-4 * 6.0 * math.sqrt(weight_n / 4 / 5.84e-6)
        self.assertAlmostEqual(tilt, math.atan2(drag_n, weight_n), delta=math.radians(2.5))
        self.assertLess(self.speed, 0.3)

    @long
    def test_h_somebody_elses_landing_is_left_alone_until_restart(self):
        self.land_soon()
        rospy.ServiceProxy("/mavros/set_mode", SetMode)(0, "AUTO.LAND")
        seen = len(self.ready)
        self.assertTrue(self.eventually(lambda: not self.state.armed, 60.0, self.fly))
        self.assertTrue(self.eventually(lambda: False in self.ready[seen:]))
        self.assertAlmostEqual(self.place[2], STOOD_M, delta=0.05)
        armed = []
        self.for_simulated(2.0, lambda: (self.fly(), armed.append(self.state.armed)))
        self.assertNotIn(True, armed)
        self.assertTrue(rospy.ServiceProxy("/mavros_publisher/restart", Trigger)().success)
        self.assertTrue(self.eventually(lambda: self.state.armed and self.place[2] > 0.5, 60.0))
        self.assertTrue(self.eventually(lambda: self.ready[-1], 60.0))
