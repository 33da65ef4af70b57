"""ROS messages of the simulator's data. Imports message classes only: no node, no rospy.

Every time is in microseconds of simulated time, or a stamp made of it by `stamp`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Iterable, Sequence

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from gazebo_msgs.msg import ContactsState, ContactState, ModelStates
from genpy import Time
from geometry_msgs.msg import Point, Quaternion, Transform, TransformStamped, Twist, Vector3, Wrench
from geometry_msgs.msg import Pose as PoseMessage
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu, JointState, LaserScan
from std_msgs.msg import Header

from simulation_tools.bounds import MAX_MAGNITUDE, are_sane
from simulation_tools.geometry import Pose

if TYPE_CHECKING:  # they load physics and numba, which tf_publisher does not need
    from simulation_tools.running.performance import PerformanceFigures
    from simulation_tools.sensors.imu import ImuSample
    from simulation_tools.sensors.lidar import Lidar
    from simulation_tools.sensors.odometry import OdometrySample
    from simulation_tools.transforms.edge_pairing import Edge
    from simulation_tools.world.world import BodyState, Contact


def stamp(time_us: int) -> Time:
    """Return a ROS time."""
    seconds, microseconds = divmod(time_us, 1_000_000)
    return Time(seconds, 1000 * microseconds)


def clock_message(time_us: int) -> Clock:
    """Return a rosgraph_msgs/Clock."""
    return Clock(stamp(time_us))


def pose_message(pose: Pose) -> PoseMessage:
    """Return a geometry_msgs/Pose."""
    return PoseMessage(Point(*pose.position_m), Quaternion(*pose.orientation_xyzw))


def pose_from_message(message: PoseMessage) -> Pose:
    """Return the pose in a message. Raises ValueError, whose text is a clause, if it is not a pose."""
    p, q = message.position, message.orientation
    return Pose.checked((p.x, p.y, p.z), (q.x, q.y, q.z, q.w))


def gazebo_pose_from_message(message: PoseMessage) -> Pose:
    """Return a pose as Gazebo's services read it: an orientation of zeros means no rotation."""
    q = message.orientation
    if q.x == q.y == q.z == q.w == 0.0:
        q = Quaternion(0.0, 0.0, 0.0, 1.0)
    return pose_from_message(PoseMessage(message.position, q))


def twist_message(linear: Sequence[float], angular: Sequence[float]) -> Twist:
    """Return a geometry_msgs/Twist."""
    return Twist(Vector3(*linear), Vector3(*angular))


def twist_from_message(message: Twist) -> tuple:
    """Return (linear, angular) as tuples. Raises ValueError if they cannot be speeds."""
    linear = (message.linear.x, message.linear.y, message.linear.z)
    angular = (message.angular.x, message.angular.y, message.angular.z)
    if not are_sane(linear + angular):
        raise ValueError(f"the twist {linear}, {angular} is not finite or beyond {MAX_MAGNITUDE:g}")
    return linear, angular


def transform_message(edge: Edge) -> TransformStamped:
    """Return a geometry_msgs/TransformStamped."""
    seconds, nanoseconds = divmod(edge.stamp_ns, 1_000_000_000)
    return TransformStamped(
        Header(stamp=Time(seconds, nanoseconds), frame_id=edge.parent),
        edge.child,
        Transform(Vector3(*edge.pose.position_m), Quaternion(*edge.pose.orientation_xyzw)),
    )


def scan_message(time_us: int, ranges: np.ndarray, lidar: Lidar, frame_id: str) -> LaserScan:
    """Return a sensor_msgs/LaserScan. All beams of a scan are measured at the same instant."""
    return LaserScan(
        header=Header(stamp=stamp(time_us), frame_id=frame_id),
        angle_min=lidar.angle_min,
        angle_max=lidar.angle_min + (lidar.beams - 1) * lidar.angle_increment,
        angle_increment=lidar.angle_increment,
        time_increment=0.0,
        scan_time=1e-6 * lidar.period_us,
        range_min=lidar.range_min,
        range_max=lidar.range_max,
        # genpy packs a list of floats in 13 us (1081 beams), a numpy array in 31 us.
        ranges=ranges.tolist(),
    )


def odometry_message(time_us: int, sample: OdometrySample, frame_id: str, child_frame_id: str) -> Odometry:
    """Return a nav_msgs/Odometry: pose in frame_id, twist in child_frame_id."""
    message = Odometry()
    message.header.stamp = stamp(time_us)
    message.header.frame_id = frame_id
    message.child_frame_id = child_frame_id
    message.pose.pose = pose_message(sample.pose)
    message.twist.twist = twist_message(sample.linear_velocity_m_s, sample.angular_velocity_rad_s)
    return message


def joint_state_message(time_us: int, angles_rad: dict[str, float]) -> JointState:
    """Return a sensor_msgs/JointState with the angles of joints by name."""
    return JointState(
        header=Header(stamp=stamp(time_us)), name=list(angles_rad), position=list(angles_rad.values())
    )


def angles_from_message(message: JointState) -> dict[str, float]:
    """Return the angle of each joint by its name. Raises ValueError, whose text is a clause."""
    if len(message.name) != len(message.position):
        raise ValueError(f"it names {len(message.name)} joints and {len(message.position)} angles")
    if not are_sane(message.position):
        raise ValueError(f"an angle is not finite or beyond {MAX_MAGNITUDE:g} rad")
    return dict(zip(message.name, message.position))


def imu_message(time_us: int, sample: ImuSample, frame_id: str) -> Imu:
    """Return a sensor_msgs/Imu."""
    message = Imu()
    message.header.stamp = stamp(time_us)
    message.header.frame_id = frame_id
    message.orientation = Quaternion(*sample.orientation_xyzw)
    message.angular_velocity = Vector3(*sample.angular_velocity_rad_s)
    message.linear_acceleration = Vector3(*sample.linear_acceleration_m_s2)
    return message


def contacts_message(time_us: int, contacts: Iterable[Contact], frame_id: str) -> ContactsState:
    """Return a gazebo_msgs/ContactsState with one state per pair of collision shapes."""
    message = ContactsState(header=Header(stamp=stamp(time_us), frame_id=frame_id))
    states: dict = {}
    for contact in contacts:
        pair = (contact.collision_1, contact.collision_2)
        state = states.get(pair)
        if state is None:
            state = states[pair] = ContactState(
                info=f"{pair[0]} touches {pair[1]}", collision1_name=pair[0], collision2_name=pair[1]
            )
            message.states.append(state)
        force = Vector3(*(contact.force_n * component for component in contact.normal))
        state.wrenches.append(Wrench(force=force))
        state.contact_positions.append(Vector3(*contact.position_m))
        state.contact_normals.append(Vector3(*contact.normal))
        state.depths.append(contact.depth_m)
        total = state.total_wrench.force
        total.x, total.y, total.z = total.x + force.x, total.y + force.y, total.z + force.z
    return message


def model_states_message(states: dict[str, BodyState]) -> ModelStates:
    """Return a gazebo_msgs/ModelStates, in the world frame."""
    return ModelStates(
        name=list(states),
        pose=[pose_message(state.pose) for state in states.values()],
        twist=[
            twist_message(state.linear_velocity_m_s, state.angular_velocity_rad_s)
            for state in states.values()
        ],
    )


def performance_message(now: Time, figures: PerformanceFigures, paused: bool) -> DiagnosticArray:
    """Return a diagnostic_msgs/DiagnosticArray with every figure as a key."""
    if figures.lockstep_misses:
        level = DiagnosticStatus.WARN
        text = f"{figures.lockstep_misses} lockstep time-outs: this run is not reproducible."
    else:
        level, text = DiagnosticStatus.OK, "Paused." if paused else "Running."
    values = [KeyValue(key, f"{value:.6g}") for key, value in vars(figures).items()]
    status = DiagnosticStatus(
        level=level, name="gazebo: performance", message=text, hardware_id="simulator", values=values
    )
    return DiagnosticArray(header=Header(stamp=now), status=[status])
