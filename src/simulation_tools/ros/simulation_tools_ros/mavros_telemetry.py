"""What MAVROS publishes about the flight controller: MAVLink messages in, topics out."""

from __future__ import annotations

from collections import deque

import rospy
from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PoseStamped, TwistStamped
from mavros_msgs.msg import ExtendedState, HomePosition, State, StatusText
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState, Imu, NavSatFix
from std_msgs.msg import Float64

from simulation_tools.mavros.client import FcuClient
from simulation_tools_ros import mavros_diagnostics as diagnose
from simulation_tools_ros import mavros_messages as convert

DIAGNOSTICS_PERIOD_S = 1.0
_HEARTBEATS_KEPT = 10


class MavrosTelemetry:
    """The publishers, used by the one thread that polls the client. Stamps are the flight controller's."""

    def __init__(self, client: FcuClient) -> None:
        """Read the frame names from the node's parameters, advertise, and listen to the client."""
        self._client = client
        self._frame_id = rospy.get_param("~local_position/frame_id", "map")
        self._child_frame_id = rospy.get_param("~local_position/child_frame_id", "base_link")
        self._global_frame_id = rospy.get_param("~global_position/child_frame_id", "base_link")
        self._imu_frame_id = rospy.get_param("~imu/frame_id", "base_link")
        self._heartbeats_s: deque[float] = deque(maxlen=_HEARTBEATS_KEPT)
        self._heartbeat_count = 0
        self._diagnostics_due_s = 0.0
        self._forget()
        self._advertise()
        for name, handler in (
            ("HEARTBEAT", self._on_heartbeat),
            ("EXTENDED_SYS_STATE", self._on_extended_state),
            ("ATTITUDE_QUATERNION", self._on_attitude),
            ("HIGHRES_IMU", self._on_highres_imu),
            ("LOCAL_POSITION_NED", self._on_local_position),
            ("GLOBAL_POSITION_INT", self._on_global_position),
            ("SYS_STATUS", self._on_sys_status),
            ("BATTERY_STATUS", self._on_battery),
            ("HOME_POSITION", self._on_home),
            ("STATUSTEXT", self._on_status_text),
        ):
            client.on(name, handler)

    def _advertise(self) -> None:
        def advertise(name, message_class, latch=False):
            return rospy.Publisher("~" + name, message_class, queue_size=10, latch=latch, tcp_nodelay=True)

        self._state = advertise("state", State, latch=True)
        self._extended_state = advertise("extended_state", ExtendedState)
        self._pose = advertise("local_position/pose", PoseStamped)
        self._velocity_local = advertise("local_position/velocity_local", TwistStamped)
        self._velocity_body = advertise("local_position/velocity_body", TwistStamped)
        self._odometry = advertise("local_position/odom", Odometry)
        self._fix = advertise("global_position/global", NavSatFix)
        self._relative_altitude = advertise("global_position/rel_alt", Float64)
        self._compass = advertise("global_position/compass_hdg", Float64)
        self._imu = advertise("imu/data", Imu)
        self._battery = advertise("battery", BatteryState)
        self._home = advertise("home_position/home", HomePosition, latch=True)
        self._status_text = advertise("statustext/recv", StatusText)
        self._diagnostics = rospy.Publisher("/diagnostics", DiagnosticArray, queue_size=10)

    def _forget(self) -> None:
        """Know nothing about the flight controller."""
        self._time_boot_ms = 0
        self._heartbeat = None
        self._attitude = None
        self._highres = None
        self._sys_status = None
        self._battery_status = None
        self._published_state: tuple | None = None

    def _note_time(self, time_boot_ms: int) -> None:
        """Keep the flight controller's clock; when it jumps back, forget what was before."""
        if time_boot_ms < self._time_boot_ms - 1000:
            rospy.logwarn("The flight controller's clock jumped back: mavros forgets what it heard before.")
            heartbeat = self._heartbeat
            self._heartbeats_s.clear()
            self._forget()
            self._heartbeat = heartbeat
        self._time_boot_ms = max(time_boot_ms, self._time_boot_ms)

    @property
    def _stamp(self):
        """The flight controller's time; ROS's, which is the same in simulation, before it is known."""
        return convert.stamp_from_ms(self._time_boot_ms) if self._time_boot_ms else rospy.get_rostime()

    def publish_state(self, only_changes: bool = False) -> None:
        """Publish the state: with each heartbeat, and when the heartbeats stop."""
        message = convert.state_message(self._heartbeat, self._stamp, self._client.connected)
        content = (message.connected, message.armed, message.mode, message.system_status)
        if only_changes and content == self._published_state:
            return
        was_connected = bool(self._published_state and self._published_state[0])
        if message.connected and not was_connected:
            rospy.loginfo("Connected to the flight controller.")
        elif was_connected and not message.connected:
            rospy.logerr("The flight controller's heartbeats have stopped.")
        self._published_state = content
        self._state.publish(message)

    def publish_diagnostics(self, now_s: float) -> None:
        """Publish /diagnostics, at most once per second. now_s: wall time."""
        if now_s < self._diagnostics_due_s:
            return
        self._diagnostics_due_s = now_s + DIAGNOSTICS_PERIOD_S
        statuses = (
            diagnose.connection(self._client),
            diagnose.heartbeats(self._heartbeat, self._heartbeat_count, self._heartbeats_s, rospy.get_time()),
            diagnose.system(self._sys_status),
            diagnose.battery(self._sys_status),
        )
        self._diagnostics.publish(diagnose.array(statuses, self._client, rospy.get_rostime()))

    def _on_heartbeat(self, message) -> None:
        self._heartbeat = message
        self._heartbeat_count += 1
        self._heartbeats_s.append(rospy.get_time())
        self.publish_state()

    def _on_extended_state(self, message) -> None:
        self._extended_state.publish(convert.extended_state_message(message, self._stamp))

    def _on_attitude(self, message) -> None:
        self._note_time(message.time_boot_ms)
        self._attitude = message
        if self._imu.get_num_connections():
            self._imu.publish(convert.imu_message(message, self._highres, self._imu_frame_id))

    def _on_highres_imu(self, message) -> None:
        self._note_time(message.time_usec // 1000)
        self._highres = message

    def _on_local_position(self, message) -> None:
        self._note_time(message.time_boot_ms)
        if self._attitude is None:
            return
        attitude, rates = convert.attitude_of(self._attitude), convert.rates_of(self._attitude)
        pose, velocity_local, velocity_body, odometry = convert.local_position_messages(
            message, attitude, rates, self._frame_id, self._child_frame_id
        )
        self._pose.publish(pose)
        self._velocity_local.publish(velocity_local)
        self._velocity_body.publish(velocity_body)
        self._odometry.publish(odometry)

    def _on_global_position(self, message) -> None:
        """Nobody listens to these most of the time, and they come at 50 Hz."""
        if self._fix.get_num_connections():
            self._fix.publish(convert.fix_message(message, self._global_frame_id))
        if self._relative_altitude.get_num_connections():
            self._relative_altitude.publish(Float64(1e-3 * message.relative_alt))
        if self._compass.get_num_connections():
            self._compass.publish(Float64(1e-2 * message.hdg))

    def _on_sys_status(self, message) -> None:
        self._sys_status = message
        self._battery.publish(convert.battery_message(message, self._battery_status, self._stamp))

    def _on_battery(self, message) -> None:
        self._battery_status = message

    def _on_home(self, message) -> None:
        self._home.publish(convert.home_message(message))

    def _on_status_text(self, message) -> None:
        text = convert.status_text_message(message, self._stamp)
        log = rospy.logerr if text.severity <= StatusText.ERROR else rospy.loginfo
        log(f"FCU: {text.text}")
        self._status_text.publish(text)
