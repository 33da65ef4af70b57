"""The parameters of the node `gazebo`, read and checked."""

from __future__ import annotations

from dataclasses import fields

import rospy

from simulation_tools import values
from simulation_tools.bounds import MAX_MAGNITUDE
from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.geometry import Pose
from simulation_tools.px4.estimation.choice import STEADY
from simulation_tools.running.pacing import PacingParameters
from simulation_tools.sensors.odometry import OdometryParameters
from simulation_tools.simulation import SimulationParameters
from simulation_tools.transforms.edge_pairing import FrameNames
from simulation_tools.vehicle.energy.battery import WARM_C, BatteryStart
from simulation_tools.vehicle.uav import NO_LIDAR

ENDLESS = "endless"
"""Value of ~battery for a battery that never gets empty."""


def number(name: str, default: float, least: float = -MAX_MAGNITUDE, most: float = MAX_MAGNITUDE) -> float:
    """Return a private parameter as a number within limits; ParameterError otherwise."""
    return values.number(name, rospy.get_param("~" + name, default), least, most)


def port(name: str, default: int) -> int:
    """Return a private parameter as a port; ParameterError otherwise."""
    return values.port(name, rospy.get_param("~" + name, default))


def simulation_parameters() -> SimulationParameters:
    """Read what is simulated from the node's private parameters."""
    lidar = str(rospy.get_param("~lidar", "ust"))
    usual = OdometryParameters()
    errors = {
        field.name: number("odometry/" + field.name, getattr(usual, field.name)) for field in fields(usual)
    }
    drift = rospy.get_param("~odometry/drift", True)
    odometry = OdometryParameters(**errors) if drift else OdometryParameters.none()
    return SimulationParameters(
        world=str(rospy.get_param("~world", "")),
        model=str(rospy.get_param("~model", "iris")),
        lidar=None if lidar in NO_LIDAR else lidar,
        lidar_range_max_m=number("lidar_range_max", 0.0, least=0.0),
        spawn_pose=Pose.from_xyz_rpy(
            number("x", 0.0), number("y", 0.0), number("z", 0.0), yaw=number("yaw", 0.0)
        ),
        seed=int(number("seed", 1.0, least=0.0, most=2.0**63)),
        odometry=odometry,
        time_step_s=number("time_step", 0.004),
        gui=bool(rospy.get_param("~gui", False)),
        sensors=tuple(str(rospy.get_param("~sensors", "")).split()),
        static_models=bool(rospy.get_param("~static_models", False)),
        estimator=str(rospy.get_param("~estimator", STEADY)),
        gnss=bool(rospy.get_param("~gnss", True)),
        px4_parameters=dict(rospy.get_param("~px4_parameters", {})),
        level_lidar=bool(rospy.get_param("~level_lidar", False)),
        battery=_battery_start(),
        origin=GeodeticOrigin(
            number("latitude", GeodeticOrigin.latitude_deg),
            number("longitude", GeodeticOrigin.longitude_deg),
            number("altitude", GeodeticOrigin.altitude_m),
        ),
    )


def _battery_start() -> BatteryStart | None:
    charge = str(rospy.get_param("~battery", "")).strip()
    if charge == ENDLESS:
        return None
    return BatteryStart(
        charge=values.number("battery", charge, 0.0, 1.0) if charge else None,
        temperature_c=number("battery_temperature", WARM_C),
    )


def pacing_parameters() -> PacingParameters:
    """Read the pacing from the node's private parameters. dynamic_reconfigure adds factor and pause."""
    return PacingParameters(
        real_time_factor=number("real_time_factor", 1.0, least=0.0),
        lockstep=bool(rospy.get_param("~lockstep", False)),
        participants=frozenset(str(rospy.get_param("~lockstep_participants", "")).split()),
        pose_sender=str(rospy.get_param("~lockstep_poses", "")).strip(),
        lockstep_timeout_s=number("lockstep_timeout", 1.0, least=0.001),
    )


def frame_names() -> FrameNames:
    """Read the names of the frames from the node's private parameters."""
    return FrameNames(
        odom=rospy.get_param("~odom_frame", "odom"),
        base=rospy.get_param("~base_frame", "base_frame"),
        world=rospy.get_param("~world_frame", "world"),
    )
