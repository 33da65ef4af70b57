"""The source of a node's poses: odometry, ground truth, or odometry corrected by SLAM."""

from __future__ import annotations

import rospy
from nav_msgs.msg import Odometry

from flight_basics.correction import CorrectionParameters, SlowCorrection
from flight_basics.errors import ParameterError, PoseError
from flight_basics.geometry import Quaternion, Vector3, yaw_of
from flight_basics_ros import pose_messages
from flight_basics_ros.frames import Frames
from node_tools.newest_transforms import FrameError
from node_tools.parameters import read_parameters

POSE_SOURCES = ("odometry", "ground_truth", "slam")
SETTLED_S = 0.2
"""SLAM's correction counts so long after its stamp. Every node has it by then: flights in lockstep repeat."""


class NoCorrectionError(PoseError):
    """SLAM has not told yet where `odom` is in its map."""


class PoseSource:
    """The source that the private parameters pose_source and {base, odom, map, world}_frame name.

    With SLAM, its correction reaches the pose slowly: correction_speed, correction_turn_rate.

    Attributes:
        topic: of nav_msgs/Odometry: odometry, or ground_truth. goal_frame: the frame of poses and goals:
            odom, world or map. is_corrected: the poses are SLAM's. whole: the last pose (position, yaw) with
            all
        of SLAM's correction, for what is measured; the pose itself is for flying. off_m, off_rad: between
        both.
        odom_in_map: SLAM's correction of that pose (x, y, z) and yaw; None: there is none.

    Raises:
        ParameterError: there is no such source.
    """

    def __init__(self) -> None:
        self._source = rospy.get_param("~pose_source", "odometry")
        if self._source not in POSE_SOURCES:
            raise ParameterError(
                f"pose_source is {self._source!r}; it must be one of {', '.join(POSE_SOURCES)}."
            )
        self.base_frame = rospy.get_param("~base_frame", "base_frame")
        self._odom_frame = rospy.get_param("~odom_frame", "odom")
        self._map_frame = rospy.get_param("~map_frame", "map")
        world_frame = rospy.get_param("~world_frame", "world")
        self.topic = "ground_truth" if self._source == "ground_truth" else "odometry"
        self._pose_frame = world_frame if self._source == "ground_truth" else self._odom_frame
        self.goal_frame = self._map_frame if self._source == "slam" else self._pose_frame
        self.is_corrected = self._source == "slam"
        self._frames = Frames()
        self.whole: tuple[Vector3, float] = ((0.0, 0.0, 0.0), 0.0)
        self.off_m = self.off_rad = 0.0
        self.odom_in_map: tuple[Vector3, float] | None = None
        if self._source == "slam":
            self._correction = SlowCorrection(read_parameters(CorrectionParameters))
            self._frames.listen()

    def pose(self, odometry: Odometry) -> tuple[Vector3, float]:
        """Return position (x, y, z) and yaw of a nav_msgs/Odometry in `goal_frame`, without waiting for TF.

        Raises:
            PoseError: another frame is expected, this is not a pose, or TF does not know SLAM's correction.
        """
        pose_messages.require_frames(odometry, self._pose_frame, self.base_frame)
        position_m, orientation = pose_messages.pose_of(odometry.pose.pose)
        pose = position_m, yaw_of(orientation)
        if self._source != "slam":
            self.whole = pose
            return pose
        correction = self._map_to_odom(odometry.header.stamp)
        pose = self._correction.apply(odometry.header.stamp.to_sec(), pose, *correction)
        self.whole, self.odom_in_map = self._correction.whole, (correction[0], yaw_of(correction[1]))
        self.off_m, self.off_rad = self._correction.off_m, self._correction.off_rad
        return pose

    def _map_to_odom(self, stamp: rospy.Time) -> tuple[Vector3, Quaternion]:
        """Return SLAM's correction for a pose. This never waits, because the next pose asks again."""
        settled = rospy.Time(max(0.0, stamp.to_sec() - SETTLED_S))
        try:
            return self._frames.look_up_at(self._map_frame, self._odom_frame, settled)
        except FrameError as error:
            raise NoCorrectionError(f"{error} Is SLAM running?") from None
