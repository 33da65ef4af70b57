"""Publishes the simulator's outputs: their order, rates and conditions.

The caller passes the publishers (anything with `publish` and `get_num_connections`). So this module needs
message classes, but no running ROS.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from simulation_tools.geometry import Pose
from simulation_tools.running.performance import PerformanceFigures
from simulation_tools.simulation import Simulation, StepOutput
from simulation_tools.transforms.edge_pairing import FrameNames
from simulation_tools_ros import conversions
from simulation_tools_ros.gazebo.markers import all_markers, model_markers
from simulation_tools_ros.gazebo.payload_output import PayloadOutput

CONTACT_PERIOD_US = 50_000
"""A lasting contact is published at 20 Hz. Its begin and its end are published at once."""

VISIBLE_MOVE_M = 1e-3

HELD_US = 28_000
"""A stream that holds back its messages sends them with the next scan, or after this time."""


class Publisher(Protocol):
    """The methods of a rospy.Publisher that this module uses."""

    def publish(self, message: Any) -> None:
        """Send to every subscriber."""

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""


class Stream(Publisher, Protocol):
    """A publisher that may hold back its messages."""

    def flush(self) -> None:
        """Send what was held back."""


@dataclass(frozen=True)
class Topics:
    """The publishers of the node, by their topics."""

    clock: Stream
    scan: Publisher
    odometry: Stream
    ground_truth: Stream
    imu: Stream
    collision: Publisher
    joint_states: Stream
    model_states: Publisher
    visuals: Publisher
    performance: Publisher


class GazeboOutput:
    """Publishes the simulator's outputs; all calls come from the simulation's thread.

    Order at one instant: clock, joints, odometry, ground truth, IMU, contacts, further sensors, scan. The
    scan comes last, so a node that gets it has the other messages already. Streams that hold back their
    messages send poses just before the scan. They send the rest after it, while other nodes work on the
    scan.
    """

    def __init__(
        self,
        simulation: Simulation,
        topics: Topics,
        frames: FrameNames | None = None,
        frame_prefix: str = "",
        model_states_period_us: int = 100_000,
        payload: PayloadOutput | None = None,
    ) -> None:
        self._simulation = simulation
        uav = simulation.uav
        self._lidar_frame = frame_prefix + (uav.lidar.frame if uav.lidar else "")
        self._imu_frame = frame_prefix + (uav.imu.frame if uav.imu else "")
        self._topics = topics
        self._frames = frames or FrameNames()
        self._prefix = frame_prefix
        self._model_states_period_us = model_states_period_us
        self._payload = payload
        self._drawn_names: set[str] = set()
        self.restart()

    def restart(self) -> None:
        """Begin again at the simulation's time, as after a reset. Publish the clock at once."""
        self._model_states_due_us = self._simulation.time_us
        self._touching: frozenset = frozenset()
        self._contact_due_us = 0
        self._topics.clock.publish(conversions.clock_message(self._simulation.time_us))
        self.flush()
        self.publish_visuals()

    def flush(self) -> None:
        """Send what the streams have held back."""
        topics = self._topics
        for stream in (topics.clock, topics.joint_states, topics.odometry, topics.ground_truth, topics.imu):
            stream.flush()
        self._flush_due_us = self._simulation.time_us + HELD_US

    def publish(self, output: StepOutput) -> None:
        """Publish everything that one instant brings."""
        topics, time_us = self._topics, output.time_us
        contacts_due = self._are_contacts_due(output)
        if output.ground_truth is not None or output.imu is not None or contacts_due or output.payload:
            topics.clock.publish(conversions.clock_message(time_us))
        if output.ground_truth is not None:
            self._publish_joints(time_us)
            self._publish_poses(output)
            if time_us >= self._model_states_due_us:
                self._publish_models(time_us)
        if output.imu is not None and topics.imu.get_num_connections():
            topics.imu.publish(conversions.imu_message(time_us, output.imu, self._imu_frame))
        late = output.scan is None and time_us >= self._flush_due_us
        if contacts_due or output.payload or late:
            self.flush()
        if contacts_due:
            world = self._frames.world
            topics.collision.publish(conversions.contacts_message(time_us, output.contacts, world))
        if output.payload and self._payload is not None:
            self._payload.publish(time_us, output.payload)
        lidar = self._simulation.lidar
        if output.scan is not None and lidar is not None:
            topics.odometry.flush()
            topics.ground_truth.flush()
            topics.scan.publish(conversions.scan_message(time_us, output.scan, lidar, self._lidar_frame))
            self.flush()

    def report(self, figures: PerformanceFigures, paused: bool) -> None:
        """Publish the performance figures."""
        now = conversions.stamp(self._simulation.time_us)
        self._topics.performance.publish(conversions.performance_message(now, figures, paused))

    def publish_visuals(self) -> None:
        """Publish what the whole world and the UAV look like."""
        world, uav = self._simulation.world, self._simulation.uav_name
        names = world.model_names()
        gone = self._drawn_names - set(names)
        self._drawn_names = set(names)
        self._moving_poses: dict[str, Pose] = {}
        markers = []
        for name in names:
            model = world.model(name).placed(name=name)
            if name == uav:
                gimbal = self._simulation.gimbal
                turned = {link: self._prefix + link for link in gimbal.carries} if gimbal else None
                markers += model_markers(model, self._frames.base, Pose.identity(), True, turned)
                continue
            pose = world.get_state(name).pose
            markers += model_markers(model, self._frames.world, pose, moves_with_frame=False)
            if model.script is not None or not model.static:
                self._moving_poses[name] = pose
        self._topics.visuals.publish(all_markers(markers, replace=bool(gone)))

    def _publish_joints(self, time_us: int) -> None:
        """Publish the angle of every moving joint in the world, with Gazebo's joint names."""
        if not self._topics.joint_states.get_num_connections():
            return
        angles = self._simulation.joint_angles()
        if angles:
            self._topics.joint_states.publish(conversions.joint_state_message(time_us, angles))

    def _publish_poses(self, output: StepOutput) -> None:
        frames = self._frames
        for sample, topic, parent in (
            (output.odometry, self._topics.odometry, frames.odom),
            (output.ground_truth, self._topics.ground_truth, frames.world),
        ):
            if sample is not None and topic.get_num_connections():
                topic.publish(conversions.odometry_message(output.time_us, sample, parent, frames.base))

    def _publish_models(self, time_us: int) -> None:
        self._model_states_due_us += self._model_states_period_us
        world = self._simulation.world
        if self._topics.model_states.get_num_connections():
            states = {name: world.get_state(name) for name in world.model_names()}
            self._topics.model_states.publish(conversions.model_states_message(states))
        drawn = self._moving_poses.items()
        if any(_distance(world.get_state(name).pose, pose) > VISIBLE_MOVE_M for name, pose in drawn):
            self.publish_visuals()

    def _are_contacts_due(self, output: StepOutput) -> bool:
        """Whether contacts began or ended, or have lasted long enough to be published again."""
        if not (output.contacts or self._touching):
            return False
        touching = frozenset((contact.collision_1, contact.collision_2) for contact in output.contacts)
        if touching == self._touching and output.time_us < self._contact_due_us:
            return False
        self._touching = touching
        self._contact_due_us = output.time_us + CONTACT_PERIOD_US
        return True


def _distance(a: Pose, b: Pose) -> float:
    return max(
        *(abs(p - q) for p, q in zip(a.position_m, b.position_m)),
        *(abs(p - q) for p, q in zip(a.orientation_xyzw, b.orientation_xyzw)),
    )
