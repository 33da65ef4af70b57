"""The simulator's services for the experiments: stop time, place obstacles, change its pace."""

from __future__ import annotations

import contextlib
import threading
from typing import Any, Callable, Sequence

import rospy
from dynamic_reconfigure.msg import Config, DoubleParameter
from dynamic_reconfigure.srv import Reconfigure
from gazebo_msgs.srv import GetModelState, GetWorldProperties, SpawnModel
from geometry_msgs.msg import Point, Quaternion
from geometry_msgs.msg import Pose as PoseMessage
from std_srvs.srv import Empty

from flights.errors import FlightError
from flights.worlds.placements import Obstacle, freeze_frame
from flights_ros.drivers.messages import pose_values
from node_tools.services import ServiceCall
from simulation_tools.geometry import Pose

SERVICE_PATIENCE_S = 20.0
SLOW = 0.1
"""Real-time factor after a flight."""
MAVROS_WAITS = "/mavros/conn/timeout"
"""Real MAVROS's parameter: wall time without a heartbeat until the connection counts as lost, s."""
HEARTBEATS = 3.0
"""In this time, 1 s of simulated time apart. One may be late."""


class SimulatorServices:
    """Calls gazebo/{pause_physics,unpause_physics,spawn_sdf_model,get_model_state,get_world_properties}.

    A call that fails raises FlightError, rospy.ServiceException or rospy.ROSException.
    """

    def __init__(self) -> None:
        """Wait for the services; raises FlightError if one is missing."""
        self.pause = _service("gazebo/pause_physics", Empty)
        self.unpause = _service("gazebo/unpause_physics", Empty)
        self._spawn = _service("gazebo/spawn_sdf_model", SpawnModel)
        self._get_state = _service("gazebo/get_model_state", GetModelState)
        self._get_world = _service("gazebo/get_world_properties", GetWorldProperties)

    def place(self, uav: str, obstacles: Sequence[Obstacle]) -> tuple[float, Pose]:
        """Place obstacles around the UAV; return the time, s, and the UAV's pose in `world`."""
        frozen_s = _succeed(self._get_world()).sim_time
        pose = pose_of(_succeed(self._get_state(uav, "")).pose)
        frame = freeze_frame(pose)
        for obstacle in obstacles:
            at = obstacle.pose(frame)
            message = PoseMessage(Point(*at.position_m), Quaternion(*at.orientation_xyzw))
            _succeed(self._spawn(obstacle.name, obstacle.sdf, "", message, "world"))
        return frozen_s, pose


def slow_down() -> None:
    """Let simulated time pass slowly. Else the simulation slows down the work on the results of its flight.

    If time stood still, MAVROS would miss heartbeats.
    """
    _ask(lambda: slow_pace(rospy.get_param(MAVROS_WAITS, None)))


def slow_pace(mavros_waits_s: float | None) -> float:
    """Return the real-time factor at which enough heartbeats come.

    mavros_waits_s: wall time in which real MAVROS must get one; None: this is our stand-in.
    """
    return SLOW if mavros_waits_s is None else min(max(SLOW, HEARTBEATS / max(mavros_waits_s, 0.001)), 1.0)


def set_pace(real_time_factor: float) -> None:
    """Set the simulator's pace. One that hangs or is gone is not waited for."""
    _ask(lambda: real_time_factor)


def _ask(pace: Callable[[], float]) -> None:
    def ask() -> None:
        with contextlib.suppress(rospy.ServiceException, rospy.ROSException, OSError):
            asked = Config(doubles=[DoubleParameter("real_time_factor", pace())])
            ServiceCall("gazebo/set_parameters", Reconfigure)(asked)

    threading.Thread(target=ask, name="set_pace", daemon=True).start()


def pose_of(message: PoseMessage) -> Pose:
    """Return a geometry_msgs/Pose as the library's type; raises ValueError as `pose_values` does."""
    x, y, z, qx, qy, qz, qw = pose_values(message)
    return Pose((x, y, z), (qx, qy, qz, qw))


def _service(name: str, service_class: Any) -> ServiceCall:
    service = ServiceCall(name, service_class, SERVICE_PATIENCE_S)
    try:
        service.wait_for_service(SERVICE_PATIENCE_S)
    except rospy.ROSException as error:
        raise FlightError(f"There is no service {service.name}; is the simulator running?") from error
    return service


def _succeed(response: Any) -> Any:
    if not response.success:
        raise FlightError(response.status_message)
    return response
