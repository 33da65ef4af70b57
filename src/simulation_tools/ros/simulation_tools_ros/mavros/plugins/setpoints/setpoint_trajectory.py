"""MAVROS's plugin `setpoint_trajectory`."""

from __future__ import annotations

import threading
from typing import Any

import rospy
from geometry_msgs.msg import Point, Pose, PoseStamped
from nav_msgs.msg import Path
from std_msgs.msg import Header
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse
from trajectory_msgs.msg import MultiDOFJointTrajectory

from node_tools.conversions import xyz, xyzw
from simulation_tools.mavros.trajectory import TrajectoryClock, TrajectoryPoint, trajectory_target
from simulation_tools_ros.mavros.plugins.setpoints.mav_frame import MavFrame
from simulation_tools_ros.mavros.uas import Uas

_TOPIC = "setpoint_trajectory/local"
_JUMP_MS = 1000


class SetpointTrajectoryPlugin:
    """Takes setpoint_trajectory/local, publishes setpoint_trajectory/desired, serves .../{reset,mav_frame}.

    Each point goes out once; see `TrajectoryClock` for when. A trajectory without points, or with a number
    that is none, is refused. Parameter: ~setpoint_trajectory/frame_id, of `desired`.
    """

    def __init__(self, uas: Uas) -> None:
        self._uas = uas
        self._frame = MavFrame(uas, "setpoint_trajectory")
        self._frame_id = str(rospy.get_param("~setpoint_trajectory/frame_id", "map"))
        self._lock = threading.Lock()  # of the next three
        self._clock = TrajectoryClock()
        self._number = self._frame.number
        self._last_ms = 0
        self._desired = uas.advertise("setpoint_trajectory/desired", Path)
        uas.subscribe(_TOPIC, MultiDOFJointTrajectory, self._on_trajectory, queue_size=10)
        uas.serve("setpoint_trajectory/reset", Trigger, self._on_reset)
        for name in ("ATTITUDE_QUATERNION", "LOCAL_POSITION_NED"):  # tell the flight controller's time
            uas.client.on(name, self._on_time)

    def _on_trajectory(self, message: MultiDOFJointTrajectory) -> None:
        frame = self._frame.number
        try:
            points = [_point(i, point) for i, point in enumerate(message.points)]
            if not points:
                raise ValueError("it has no points")
            for i, point in enumerate(points):
                self._check(i, frame, point)
        except ValueError as error:
            rospy.logwarn(f"A trajectory on {_TOPIC} is refused: {error}.")
            return
        with self._lock:
            self._number = frame
            self._clock.start(points)
        self._desired.publish(lambda: self._path(message))

    def _check(self, i: int, frame: int, point: TrajectoryPoint) -> None:
        try:
            trajectory_target(self._uas.client.target, 0, frame, point)
        except ValueError as error:
            raise ValueError(f"of point {i}, {error}") from error

    def _on_time(self, _message: object) -> None:
        """Send what is due."""
        now_ms = self._uas.heard.time_boot_ms
        with self._lock:
            if now_ms < self._last_ms - _JUMP_MS and self._clock.is_running:
                rospy.logwarn("The flight controller's clock jumped back: mavros forgets the trajectory.")
                self._clock.stop()
            self._last_ms = now_ms
            points, frame = self._clock.due(now_ms), self._number
        target = self._uas.client.target
        for point in points:
            self._uas.send_setpoint(
                _TOPIC, None, lambda ms, point=point: trajectory_target(target, ms, frame, point)
            )

    def _on_reset(self, _request: TriggerRequest) -> TriggerResponse:
        with self._lock:
            if not self._clock.is_running:
                return TriggerResponse(False, "Trajectory reset denied: Empty trajectory")
            self._clock.stop()
        return TriggerResponse(success=True)

    def _path(self, message: MultiDOFJointTrajectory) -> Path:
        """Return the places of a trajectory; as in MAVROS, its poses have no header."""
        path = Path(header=Header(stamp=rospy.get_rostime(), frame_id=self._frame_id))
        for point in message.points:
            if point.transforms:
                place, turn = point.transforms[0].translation, point.transforms[0].rotation
                path.poses.append(PoseStamped(pose=Pose(Point(*xyz(place)), turn)))
        return path


def _point(i: int, point: Any) -> TrajectoryPoint:
    """MultiDOFJointTrajectoryPoint to a setpoint: the first joint counts. Raises ValueError."""
    wait_ms = point.time_from_start.to_nsec() // 1_000_000
    if wait_ms < 0:
        raise ValueError(f"of point {i}, time_from_start is negative")
    move, speed, push = (
        some[0] if some else None for some in (point.transforms, point.velocities, point.accelerations)
    )
    return TrajectoryPoint(
        wait_ms,
        xyz(move.translation) if move else None,
        xyzw(move.rotation) if move else None,
        xyz(speed.linear) if speed else None,
        speed.angular.z if speed else 0.0,
        xyz(push.linear) if push else None,
    )
