"""Checks that a lidar's scans can be padded to a full turn and read by CEPA."""

from __future__ import annotations

import numpy as np

from cepa import CepaError, LaserScan2D
from flight_basics.errors import FlightBasicsError
from flights.errors import ScenarioError
from inspection_tools import LidarPadding, ScanGeometry
from simulation_tools.vehicle.uav import load_uav


def check_beams(model: str, lidar: str) -> None:
    """Check a lidar of the model path, by the classes of the nodes that take its scans in flight.

    Raises:
        ScenarioError: a node would drop every scan, and the UAV would hover for ever.
        SimulationToolsError: the UAV cannot be loaded.
    """
    mounted = load_uav(model, lidar).lidar
    if mounted is None:
        raise ScenarioError(f"The model lidar_{lidar} has no ray sensor, so there are no scans to fly by.")
    sensor, axis = mounted.sensor, mounted.sensor.horizontal
    # Rounded as in a sensor_msgs/LaserScan
    rounded = np.array((axis.min_angle_rad, axis.increment_rad), np.float32)
    angle_min_rad, increment_rad = rounded.tolist()
    limits_m = sensor.range_min_m, sensor.range_max_m
    try:
        geometry = ScanGeometry(axis.samples, angle_min_rad, increment_rad)
        padded = LidarPadding().pad(np.full(axis.samples, np.inf, np.float32), geometry, *limits_m)
        turn = padded.geometry
        LaserScan2D(padded.ranges, turn.angle_min_rad, turn.angle_increment_rad, *limits_m, padded.seen)
    except (FlightBasicsError, CepaError) as error:
        raise ScenarioError(
            f"The lidar {lidar} cannot steer a flight: {error} Change the samples, angles or ranges in the "
            f"model.sdf of lidar_{lidar}."
        ) from None
