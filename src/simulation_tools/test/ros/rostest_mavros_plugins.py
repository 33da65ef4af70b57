"""MAVROS's further plugins as a script finds them: types, values beside the simulator's truth, refusals."""

from __future__ import annotations

import math

import rosgraph
import rospy
import rosservice
from geographic_msgs.msg import GeoPoseStamped
from geometry_msgs.msg import PoseStamped, Vector3Stamped
from mavros_interface import PUBLISHED, SERVED, SUBSCRIBED
from mavros_msgs import srv
from mavros_msgs.msg import (
    VFR_HUD,
    Altitude,
    AttitudeTarget,
    GlobalPositionTarget,
    HomePosition,
    PositionTarget,
    RCOut,
    State,
    Thrust,
    Waypoint,
    WaypointList,
)
from mavros_test_case import MavrosTestCase
from nav_msgs.msg import Odometry
from sensor_msgs.msg import FluidPressure, Imu, MagneticField, NavSatFix
from std_srvs.srv import Trigger

from node_tools.testing import long

HEARD = {
    "state": State,
    "local_position/pose": PoseStamped,
    "global_position/local": Odometry,
    "global_position/raw/fix": NavSatFix,
    "imu/data": Imu,
    "imu/data_raw": Imu,
    "imu/mag": MagneticField,
    "imu/static_pressure": FluidPressure,
    "altitude": Altitude,
    "vfr_hud": VFR_HUD,
    "home_position/home": HomePosition,
    "setpoint_raw/target_local": PositionTarget,
    "setpoint_raw/target_global": GlobalPositionTarget,
    "setpoint_raw/target_attitude": AttitudeTarget,
    "rc/out": RCOut,
    "mission/waypoints": WaypointList,
}
LATITUDE, LONGITUDE, ALTITUDE_M = 47.397742, 8.545594, 488.0  # the world's origin
GEOID_M = 47.3  # the sea's height over the ellipsoid there
IN_METRES = math.radians(1.0) * 6371000.0  # a degree of latitude on PX4's sphere


class TestMavrosPlugins(MavrosTestCase):
    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.listen(HEARD)
        cls.truth = None
        rospy.Subscriber("/UAV/ground_truth", Odometry, cls.on_truth)
        cls.ask_for_mode = cls.service("set_mode", srv.SetMode)
        cls.arm = cls.service("cmd/arming", srv.CommandBool)
        for name in ("home_position/home", "local_position/pose", "global_position/local"):
            assert cls.eventually(lambda name=name: cls.last(name) is not None), name
        assert cls.eventually(lambda: cls.truth is not None)
        cls.ask_for_mode(0, "AUTO.LOITER")  # after a landing it is AUTO.LAND
        pose = cls.last("local_position/pose").pose.position
        # PX4's local frame begins where the UAV stood at first: the middle of its body, above the ground.
        cls.origin_up = cls.truth.position.z - pose.z
        cls.publishers = {
            name: rospy.Publisher(f"/mavros/{name}", message_class, queue_size=1)
            for name, message_class in (
                ("setpoint_position/global", GeoPoseStamped),
                ("setpoint_position/global_to_local", GeoPoseStamped),
                ("setpoint_raw/global", GlobalPositionTarget),
                ("setpoint_accel/accel", Vector3Stamped),
                ("setpoint_attitude/attitude", PoseStamped),
                ("setpoint_attitude/thrust", Thrust),
            )
        }

    @classmethod
    def on_truth(cls, message):
        cls.truth = message.pose.pose

    def publish(self, name, message):
        if hasattr(message, "header"):
            message.header.stamp = rospy.get_rostime()
        self.publishers[name].publish(message)

    def where(self):
        """Where the UAV is in truth: (east, north, up)."""
        p = self.truth.position
        return p.x, p.y, p.z

    def flies_to(self, place, act, delta=0.15):
        return self.eventually(lambda: math.dist(self.where(), place) < delta, 60.0, act)

    # The names sort the flight to the end: the other tests want it on the ground.

    def test_a_every_name_has_mavros_type(self):
        master = rosgraph.Master("/rostest")
        types = dict(master.getTopicTypes())
        publishers, subscribers, _ = master.getSystemState()
        for names, those_who in ((PUBLISHED, dict(publishers)), (SUBSCRIBED, dict(subscribers))):
            for name, kind in names.items():
                self.assertIn("/mavros", those_who.get(f"/mavros/{name}", ()), name)
                self.assertEqual(types[f"/mavros/{name}"], kind, name)
        for name, kind in SERVED.items():
            self.assertEqual(rosservice.get_service_type(f"/mavros/{name}"), kind, name)

    def test_b_sensors_at_rest_say_what_the_truth_is(self):
        for name in ("imu/data_raw", "imu/mag", "imu/static_pressure", "altitude", "vfr_hud"):
            self.assertTrue(self.eventually(lambda name=name: self.last(name) is not None), name)
        up = self.where()[2]
        altitude = self.last("altitude")
        self.assertEqual(altitude.header.frame_id, "map")
        self.assertAlmostEqual(altitude.amsl, ALTITUDE_M + up, delta=0.05)
        self.assertAlmostEqual(altitude.local, up - self.origin_up, delta=0.05)
        self.assertAlmostEqual(altitude.bottom_clearance, 0.1, places=5)  # as PX4 on the ground
        hud = self.last("vfr_hud")
        self.assertAlmostEqual(hud.altitude, ALTITUDE_M + up, delta=0.05)
        self.assertEqual((hud.throttle, hud.airspeed), (0.0, 0.0))
        raw = self.last("imu/data_raw")
        self.assertEqual((raw.header.frame_id, raw.orientation_covariance[0]), ("base_link", -1.0))
        self.assertAlmostEqual(raw.linear_acceleration.z, 9.81, delta=0.5)
        # Zurich's field in gauss, NED: 0.2144, 0.0105, 0.4269; turned by the heading, clockwise from north
        heading = math.radians(hud.heading)
        forward = 0.2144 * math.cos(heading) + 0.0105 * math.sin(heading)
        left = 0.2144 * math.sin(heading) - 0.0105 * math.cos(heading)
        field = self.last("imu/mag").magnetic_field
        for value, wanted in zip((field.x, field.y, field.z), (forward, left, -0.4269)):
            self.assertAlmostEqual(value, 1e-4 * wanted, delta=1e-6)
        # The international standard atmosphere at that height
        pressure = 101325.0 * (1.0 - 2.25577e-5 * (ALTITUDE_M + up)) ** 5.25588
        self.assertAlmostEqual(self.last("imu/static_pressure").fluid_pressure, pressure, delta=5.0)

    def test_b_positions_on_earth_are_those_of_the_truth(self):
        self.assertTrue(self.eventually(lambda: self.last("global_position/raw/fix") is not None))
        east, north, up = self.where()
        fix = self.last("global_position/raw/fix")
        self.assertAlmostEqual((fix.latitude - LATITUDE) * IN_METRES, north, delta=0.1)
        self.assertAlmostEqual(fix.altitude, ALTITUDE_M + GEOID_M + up, delta=0.1)
        self.assertEqual((fix.status.status, fix.position_covariance_type), (0, 2))
        self.assertAlmostEqual(fix.position_covariance[0], 0.299**2, places=6)
        home = self.last("home_position/home").position
        local = self.last("global_position/local")
        self.assertEqual((local.header.frame_id, local.child_frame_id), ("map", "base_link"))
        self.assertAlmostEqual(local.pose.pose.position.x, east - home.x, delta=0.15)
        self.assertAlmostEqual(local.pose.pose.position.y, north - home.y, delta=0.15)

    def test_d_a_mission_is_pushed_chosen_pulled_and_cleared(self):
        self.assertTrue(self.eventually(lambda: self.last("mission/waypoints") is not None))
        self.assertEqual(self.last("mission/waypoints").waypoints, [])
        push = self.service("mission/push", srv.WaypointPush)
        at = {"x_lat": LATITUDE, "y_long": LONGITUDE, "autocontinue": True}
        items = [Waypoint(frame=3, command=command, z_alt=3.0, **at) for command in (22, 16)]
        answer = push(1, items)
        self.assertEqual((answer.success, answer.wp_transfered), (False, 0))  # PX4 takes whole missions
        answer = push(0, [Waypoint(frame=1, command=16, z_alt=3.0)])
        self.assertEqual((answer.success, answer.wp_transfered), (False, 0))  # and no local frame
        answer = push(0, items)
        self.assertEqual((answer.success, answer.wp_transfered), (True, 2))
        self.assertTrue(self.service("mission/set_current", srv.WaypointSetCurrent)(1).success)
        self.assertTrue(self.eventually(lambda: self.last("mission/waypoints").current_seq == 1))
        pulled = self.service("mission/pull", srv.WaypointPull)()
        self.assertEqual((pulled.success, pulled.wp_received), (True, 2))
        commands = [waypoint.command for waypoint in self.last("mission/waypoints").waypoints]
        self.assertEqual(commands, [22, 16])
        self.assertTrue(self.service("mission/clear", srv.WaypointClear)().success)

    def test_d_parameters_are_copied_and_pushed(self):
        self.assertTrue(self.service("param/pull", srv.ParamPull)(True).success)
        self.assertAlmostEqual(rospy.get_param("/mavros/param/MPC_XY_P"), 0.95, places=5)
        rospy.set_param("/mavros/param/MPC_XY_P", 0.9)
        rospy.set_param("/mavros/param/COM_RC_IN_MODE", "nonsense")
        rospy.set_param("/mavros/param/NO_SUCH", 1)
        pushed = self.service("param/push", srv.ParamPush)()
        self.assertTrue(pushed.success)
        get = self.service("param/get", srv.ParamGet)
        self.assertAlmostEqual(get("MPC_XY_P").value.real, 0.9, places=5)
        self.assertEqual(get("COM_RC_IN_MODE").value.integer, 1)
        count = len(rospy.get_param("/mavros/param"))
        self.assertEqual(pushed.param_transfered, count - 2)
        rospy.set_param("/mavros/param/MPC_XY_P", 0.95)
        self.service("param/push", srv.ParamPush)()

    def test_d_home_is_set_here_and_elsewhere(self):
        set_home = self.service("cmd/set_home", srv.CommandHome)
        self.assertTrue(set_home(False, 0.0, LATITUDE + 1e-4, LONGITUDE, 490.0).success)
        home = lambda: self.last("home_position/home")  # noqa: E731
        moved = self.eventually(lambda: abs(home().geo.latitude - LATITUDE - 1e-4) < 1e-5)
        self.assertTrue(moved, home().geo)
        self.assertAlmostEqual(home().position.y, 1e-4 * IN_METRES, delta=0.5)  # float32 on its way
        self.assertAlmostEqual(home().position.z, 2.0 - self.origin_up, delta=0.02)
        self.assertTrue(self.service("home_position/req_update", Trigger)().success)
        refused = set_home(False, 0.0, 99.0, LONGITUDE, 490.0)
        self.assertEqual((refused.success, refused.result), (False, 2))
        sent = self.service("cmd/command_int", srv.CommandInt)(False, 0, 179, 0, 0, 1.0, 0, 0, 0, 0, 0, 0.0)
        self.assertTrue(sent.success)  # here, that is
        place = lambda: home().position  # noqa: E731
        here = self.where()
        self.assertTrue(self.eventually(lambda: math.dist((place().x, place().y), here[:2]) < 0.1))

    def test_e_frames_that_do_not_exist_are_refused(self):
        for plugin in ("setpoint_position", "setpoint_velocity"):
            set_frame = self.service(f"{plugin}/mav_frame", srv.SetMavFrame)
            self.assertFalse(set_frame(77).success)
            self.assertTrue(set_frame(8).success)
            self.assertEqual(rospy.get_param(f"/mavros/{plugin}/mav_frame"), "BODY_NED")
            self.assertTrue(set_frame(1).success)

    @long
    def test_y_further_setpoints_fly(self):
        """Global setpoints, then an acceleration and an attitude; PX4's targets beside them."""

        def global_place(north, up, east=0.0):
            place = GeoPoseStamped()
            place.pose.position.latitude = LATITUDE + north / IN_METRES
            place.pose.position.longitude = LONGITUDE + east / IN_METRES / math.cos(math.radians(LATITUDE))
            place.pose.position.altitude = ALTITUDE_M + up
            place.pose.orientation.w = 1.0  # facing east
            return place

        take_off = lambda: self.publish("setpoint_position/global", global_place(2.0, 3.0))  # noqa: E731
        self.eventually(lambda: False, 0.5, take_off)
        self.ask_for_mode(0, "OFFBOARD")
        self.eventually(lambda: False, 0.2, take_off)
        self.assertTrue(self.arm(True).success)
        self.assertTrue(self.flies_to((0.0, 2.0, 3.0), take_off), self.where())
        target = self.last("setpoint_raw/target_local")
        self.assertAlmostEqual(target.position.y, 2.0, delta=0.02)
        self.assertAlmostEqual(target.position.z, 3.0 - self.origin_up, delta=0.02)
        self.assertAlmostEqual(target.yaw, 0.0, delta=0.01)
        self.assertEqual((target.coordinate_frame, target.type_mask), (1, 0))

        # From where it is: the way on earth becomes one in the local frame.
        goal = global_place(0.0, 2.5 + GEOID_M, 1.0)  # above the ellipsoid
        go = lambda: self.publish("setpoint_position/global_to_local", goal)  # noqa: E731
        self.assertTrue(self.flies_to((1.0, 0.0, 2.5), go), self.where())

        # Over home, which lies where it was armed; high, because an attitude alone does not keep the height
        home = self.last("home_position/home").position
        raw = GlobalPositionTarget(coordinate_frame=6, type_mask=0b1001_1111_1000)  # place and yaw
        raw.latitude, raw.longitude, raw.altitude = LATITUDE, LONGITUDE, 12.0
        hover = lambda: self.publish("setpoint_raw/global", raw)  # noqa: E731
        self.assertTrue(self.flies_to((0.0, 0.0, 12.0 + home.z + self.origin_up), hover), self.where())

        thrust = self.last("setpoint_raw/target_attitude").thrust  # that hovers

        # An acceleration, ENU: to the north
        began = self.where()[1]
        push = Vector3Stamped()
        push.vector.y = 1.0
        north = lambda: self.publish("setpoint_accel/accel", push)  # noqa: E731
        self.assertTrue(self.eventually(lambda: self.where()[1] > began + 0.5, 60.0, north))
        mask = lambda: self.last("setpoint_raw/target_local").type_mask & 0b11_1111  # noqa: E731
        self.assertTrue(self.eventually(lambda: mask() == 0b11_1111, 60.0, north), mask())

        # An attitude, FLU in ENU: nose down by ten degrees
        def lean():
            pose = PoseStamped()
            pose.pose.orientation.y = math.sin(math.radians(5.0))
            pose.pose.orientation.w = math.cos(math.radians(5.0))
            self.publish("setpoint_attitude/attitude", pose)
            self.publish("setpoint_attitude/thrust", Thrust(thrust=thrust))

        pitch = lambda: 2.0 * math.asin(self.last("imu/data").orientation.y)  # noqa: E731
        leaning = self.eventually(lambda: abs(pitch() - math.radians(10.0)) < 0.03, 60.0, lean)
        self.assertTrue(leaning, pitch())
        target = lambda: self.last("setpoint_raw/target_attitude")  # noqa: E731
        told = lambda: abs(target().orientation.y - math.sin(math.radians(5.0))) < 0.005  # noqa: E731
        self.assertTrue(self.eventually(told, 60.0, lean), target())
        self.assertAlmostEqual(target().thrust, thrust, places=3)
        self.assertGreater(self.last("vfr_hud").throttle, 0.3)
        self.assertGreater(min(self.last("rc/out").channels[:4]), 1000)

        # In an automatic mode PX4 says where it flies to on earth.
        self.ask_for_mode(0, "AUTO.LOITER")
        told = self.eventually(lambda: self.last("setpoint_raw/target_global") is not None)
        self.assertTrue(told, (self.last("state"), self.where()))
        target = self.last("setpoint_raw/target_global")
        self.assertEqual(target.coordinate_frame, 5)
        self.assertAlmostEqual(target.latitude, LATITUDE, delta=1e-3)
        self.land_soon()
        self.ask_for_mode(0, "AUTO.LAND")
        landed = self.eventually(lambda: not self.last("state").armed, 60.0)
        self.assertTrue(landed, (self.last("state"), self.where()))
