"""The node cepa in its graph commands, bit for bit, what the loop without ROS has flown.

Each flight has a fault that a campaign may meet. Its messages are recorded as they reach CEPA.
"""

from __future__ import annotations

import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("rosbag", reason="needs ROS, which is not installed: ./bringup.sh setup")
pytest.importorskip("cepa_ros.conversions", reason="needs the built workspace: ./bringup.sh setup")

import rosbag
import rosgraph
import rospy
from cepa_ros.conversions import scan_of
from geometry_msgs.msg import TransformStamped, TwistStamped
from nav_msgs.msg import Odometry
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import Imu, LaserScan, PointCloud2, PointField
from tf2_msgs.msg import TFMessage

from cepa import SteeringLoop
from flights.flight import steering_chain
from flights.flight.closed_loop import ClosedLoop
from flights.flight.conditions import Conditions
from flights.flight.parameters import ClosedLoopParameters
from simulation_tools.simulation import SimulationParameters

pytestmark = [pytest.mark.ros, pytest.mark.long]
ROOT = Path(__file__).resolve().parents[2]
COMMANDS = "/UAV/vel_setpoint/safe/body"
BEGIN_NS, FAULT_NS, END_S = 9_500_000_000, 11_000_000_000, 12.0
"""The flight begins at the hover; the second half has the fault."""


class Recorded(SteeringLoop):
    """A loop that writes down every message that it takes, and what it commands then."""

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        self.messages = []

    def _told(self, topic, message, stamp_ns, take):
        if stamp_ns < BEGIN_NS:
            return []
        message.header.stamp = rospy.Time(0, stamp_ns)
        commands = take(message)
        self.messages.append((topic, message))
        for command in commands:
            velocity = TwistStamped()
            velocity.header.stamp = rospy.Time(0, command.stamp_ns)
            linear = velocity.twist.linear
            linear.x, linear.y, linear.z = command.velocity_m_s
            self.messages.append((COMMANDS, velocity))
        return commands

    def on_reference(self, stamp_ns, velocity_m_s):
        message = TwistStamped()
        message.header.frame_id = "base_frame"
        linear = message.twist.linear
        linear.x, linear.y, linear.z = velocity_m_s
        take = super().on_reference
        return self._told(
            "/UAV/vel_setpoint/raw/body", message, stamp_ns, lambda m: take(stamp_ns, velocity_m_s)
        )

    def on_odometry(self, stamp_ns, state):
        message = Odometry()
        message.header.frame_id, message.child_frame_id = "odom", "base_frame"
        p, q, v = message.pose.pose.position, message.pose.pose.orientation, message.twist.twist.linear
        p.x, p.y, p.z = state.position_m
        q.x, q.y, q.z, q.w = state.orientation_xyzw
        v.x, v.y, v.z = state.velocity_m_s
        take = super().on_odometry
        return self._told("/UAV/odometry", message, stamp_ns, lambda m: take(stamp_ns, state))

    def on_imu(self, stamp_ns, reading):
        message = Imu()
        w, f = message.angular_velocity, message.linear_acceleration
        (w.x, w.y, w.z), (f.x, f.y, f.z) = reading.rates_rad_s, reading.force_m_s2
        take = super().on_imu
        return self._told("/mavros/imu/data", message, stamp_ns, lambda m: take(stamp_ns, reading))

    def on_scan(self, stamp_ns, scan, frame):
        message = LaserScan()
        message.header.frame_id = frame
        message.ranges = scan.ranges.tolist()
        message.intensities = np.where(scan.seen, 0.0, -1.0).tolist()
        message.angle_min, message.angle_increment = scan.angle_min, scan.angle_increment
        message.angle_max = scan.angle_min + (scan.ranges.size - 1) * scan.angle_increment
        message.range_min, message.range_max = scan.range_min, scan.range_max
        take = super().on_scan
        return self._told(
            "/scan/padded", message, stamp_ns, lambda m: take(stamp_ns, scan_of(as_received(m)), frame)
        )

    def on_cloud(self, stamp_ns, points):
        rows = np.asarray(points.points_m, np.float32)
        message = PointCloud2(height=1, width=len(rows), point_step=12, row_step=12 * len(rows))
        message.fields = [PointField(name, 4 * k, PointField.FLOAT32, 1) for k, name in enumerate("xyz")]
        message.header.frame_id, message.data = steering_chain.FRAME, rows.tobytes()
        take = super().on_cloud
        return self._told("/cloud", message, stamp_ns, lambda m: take(stamp_ns, points))


class OdometryJumps(Recorded):
    """The odometry begins anew somewhere else."""

    def on_odometry(self, stamp_ns, state):
        if stamp_ns >= FAULT_NS:
            x, y, z = state.position_m
            state = state._replace(position_m=(x + 2.0, y - 1.0, z))
        return super().on_odometry(stamp_ns, state)


class ClockGoesBack(Recorded):
    """From the fault on all stamps are smaller by 1.2 s, as after a reset of the simulator."""

    def _back(self, stamp_ns):
        return stamp_ns - 1_200_000_000 if stamp_ns >= FAULT_NS else stamp_ns

    def _again(self, stamp_ns, commands):
        shift_ns = stamp_ns - self._back(stamp_ns)
        return [command._replace(stamp_ns=command.stamp_ns + shift_ns) for command in commands]

    def on_reference(self, stamp_ns, velocity_m_s):
        return self._again(stamp_ns, super().on_reference(self._back(stamp_ns), velocity_m_s))

    def on_odometry(self, stamp_ns, state):
        return self._again(stamp_ns, super().on_odometry(self._back(stamp_ns), state))

    def on_scan(self, stamp_ns, scan, frame):
        return self._again(stamp_ns, super().on_scan(self._back(stamp_ns), scan, frame))


class CloudsAreLate(Recorded):
    """Each cloud comes after the next scan."""

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        self._under_way = []

    def on_cloud(self, stamp_ns, points):
        self._under_way.append((stamp_ns, points))
        return []

    def on_scan(self, stamp_ns, scan, frame):
        commands = super().on_scan(stamp_ns, scan, frame)
        if len(self._under_way) > 1:
            commands += super().on_cloud(*self._under_way.pop(0))
        return commands


def as_received(message):
    """Return the message as a subscriber gets it: in 32 bits where it has no more."""
    buffer = io.BytesIO()
    message.serialize(buffer)
    return numpy_msg(LaserScan)().deserialize(buffer.getvalue())


def flown(monkeypatch, kind, lidar, conditions, imu):
    """Fly with a recorded loop; return it, and the lidar's pose on the body."""
    monkeypatch.setattr(steering_chain, "SteeringLoop", kind)
    simulation = SimulationParameters(
        str(ROOT / "src/extensions/flights/worlds/forest.world"), lidar=lidar, seed=3
    )
    parameters = ClosedLoopParameters(simulation, algorithm="dynamic", conditions=conditions, imu=imu)
    with ClosedLoop(parameters) as loop:
        loop.run(until=lambda loop: loop.time_s >= END_S)
        return loop._steering._loop, loop.lidar.pose_in_body


def write_bag(path, messages, pose):
    """Write a recorded flight, with how the lidar sits on the body."""
    mount = TransformStamped()
    mount.header.frame_id, mount.child_frame_id = "base_frame", steering_chain.FRAME
    t, q = mount.transform.translation, mount.transform.rotation
    t.x, t.y, t.z = pose.position_m
    q.x, q.y, q.z, q.w = pose.orientation_xyzw
    with rosbag.Bag(path, "w") as bag:
        for place, (topic, message) in enumerate([("/tf_static", TFMessage([mount])), *messages]):
            bag.write(topic, message, rospy.Time(1, 1000 * place))


@pytest.mark.parametrize(
    ("kind", "lidar", "conditions", "imu"),
    [
        pytest.param(Recorded, "ust", Conditions(scan_loss=0.6), True, id="lost scans, with an IMU"),
        pytest.param(OdometryJumps, "ust", Conditions(), False, id="odometry jumps", marks=pytest.mark.long),
        pytest.param(ClockGoesBack, "ust", Conditions(), False, id="clock goes back"),
        pytest.param(CloudsAreLate, "puck", Conditions(), False, id="late clouds", marks=pytest.mark.long),
    ],
)
def test_the_node_commands_what_the_loop_has_flown(
    monkeypatch, tmp_path, ros_master, kind, lidar, conditions, imu
):
    recorded, pose = flown(monkeypatch, kind, lidar, conditions, imu)
    bag = str(tmp_path / "flight.bag")
    write_bag(bag, recorded.messages, pose)
    expected = [
        [m.header.stamp.to_nsec(), m.twist.linear.x, m.twist.linear.y, m.twist.linear.z]
        for topic, m in recorded.messages
        if topic == COMMANDS
    ]
    assert sum(any(command[1:]) for command in expected) > 20  # it flies

    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    master.setParam("/use_sim_time", True)
    words = (
        "algorithm:=dynamic",
        "visualiser:=false",
        f"lidar:={lidar}",
        f"imu:={'/mavros/imu/data' if imu else ' '}",
    )
    ros_master.start("roslaunch", "cepa", "cepa.launch", *words)
    probe = str(ROOT / "tests/flights/replay_probe.py")
    run = ros_master.run(sys.executable, probe, bag, timeout_s=200.0)
    commands = json.loads(run.stdout.splitlines()[-1])
    assert commands == expected
