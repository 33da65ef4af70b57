"""All plugins of the node `mavros`."""

from __future__ import annotations

from simulation_tools_ros.mavros.plugins.altitude import AltitudePlugin
from simulation_tools_ros.mavros.plugins.command import CommandPlugin
from simulation_tools_ros.mavros.plugins.distance_sensor import DistanceSensorPlugin
from simulation_tools_ros.mavros.plugins.extras.geofence import GeofencePlugin
from simulation_tools_ros.mavros.plugins.extras.payload import (
    CameraPlugin,
    CamImuSyncPlugin,
    MountControlPlugin,
)
from simulation_tools_ros.mavros.plugins.extras.to_fcu import (
    ManualControlPlugin,
    MocapPlugin,
    ObstacleDistancePlugin,
    StatusTextPlugin,
)
from simulation_tools_ros.mavros.plugins.global_position import GlobalPositionPlugin
from simulation_tools_ros.mavros.plugins.home_position import HomePositionPlugin
from simulation_tools_ros.mavros.plugins.imu import ImuPlugin
from simulation_tools_ros.mavros.plugins.local_position import LocalPositionPlugin
from simulation_tools_ros.mavros.plugins.param import ParamPlugin
from simulation_tools_ros.mavros.plugins.rc_io import RcIoPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_accel import SetpointAccelPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_attitude import SetpointAttitudePlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_position import SetpointPositionPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_raw import SetpointRawPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_trajectory import SetpointTrajectoryPlugin
from simulation_tools_ros.mavros.plugins.setpoints.setpoint_velocity import SetpointVelocityPlugin
from simulation_tools_ros.mavros.plugins.sys_status import SysStatusPlugin
from simulation_tools_ros.mavros.plugins.sys_time import SysTimePlugin
from simulation_tools_ros.mavros.plugins.vehicle_info import VehicleInfoPlugin
from simulation_tools_ros.mavros.plugins.vfr_hud import VfrHudPlugin
from simulation_tools_ros.mavros.plugins.vision.odometry import OdometryPlugin
from simulation_tools_ros.mavros.plugins.vision.vision_pose import VisionPosePlugin
from simulation_tools_ros.mavros.plugins.vision.vision_speed import VisionSpeedPlugin
from simulation_tools_ros.mavros.plugins.waypoint import WaypointPlugin

# The plugins advertise in this order. Services that clients wait for, and that end a flight, come first. A
# client that finds them finds the others a moment later.
PLUGINS = (
    SysStatusPlugin,
    CommandPlugin,
    LocalPositionPlugin,
    ImuPlugin,
    GlobalPositionPlugin,
    HomePositionPlugin,
    SetpointRawPlugin,
    SetpointPositionPlugin,
    SetpointVelocityPlugin,
    SetpointAttitudePlugin,
    SetpointAccelPlugin,
    SetpointTrajectoryPlugin,
    VisionPosePlugin,
    VisionSpeedPlugin,
    OdometryPlugin,
    ParamPlugin,
    AltitudePlugin,
    DistanceSensorPlugin,
    VfrHudPlugin,
    SysTimePlugin,
    RcIoPlugin,
    VehicleInfoPlugin,
    WaypointPlugin,
    GeofencePlugin,
    ObstacleDistancePlugin,
    MocapPlugin,
    StatusTextPlugin,
    ManualControlPlugin,
    MountControlPlugin,
    CameraPlugin,
    CamImuSyncPlugin,
)
