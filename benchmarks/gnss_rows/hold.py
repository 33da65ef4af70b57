"""The flight that the rows `killed` and `stops` disturb."""

from __future__ import annotations

from dataclasses import replace

from flights.flight.closed_loop import ClosedLoop
from gridslam.odometry.warm_up import warm_up_odometry
from gridslam.warm_up import warm_up
from master_thesis.experiments_3_4.without_gnss.flight import SlamPose, parameters_without_gnss

WORLD = "hold"


def loop_in_hold(lidar: str, seed: int, backwards: bool = False) -> ClosedLoop:
    """Return the round of Experiment 4 without GNSS, with SLAM; backwards: in the other direction."""
    warm_up()
    warm_up_odometry()
    parameters = parameters_without_gnss(WORLD, lidar, seed)
    if backwards:
        parameters = replace(parameters, mission=tuple(reversed(tuple(parameters.mission)[:-1])))
    loop = ClosedLoop(parameters)
    SlamPose(loop, WORLD, seed)
    return loop
