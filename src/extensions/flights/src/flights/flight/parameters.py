"""Everything that a flight without ROS can be asked for; every default is the nodes'."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Sequence

from cepa import ALGORITHMS, SLOW_DETOURS, STEADY_SIDE, CepaParameters
from flights.errors import FlightError
from flights.flight.conditions import Conditions
from flights.flight.course import PhaseLimits
from flights.flight.mission_time import MissionTime
from inspection_tools import (
    MedianFilterParameters,
    PaddingParameters,
    PositionControllerParameters,
    Waypoint,
    YawRegulatorParameters,
    hold_s,
    way_m,
)
from simulation_tools.publisher import PublisherParameters
from simulation_tools.simulation import SimulationParameters
from simulation_tools.vehicle.nod import Nod

POSE_SOURCES = ("ground_truth", "odometry")
CEPA = CepaParameters(speed_fractions=SLOW_DETOURS)
"""CEPA's parameters in the thesis's experiments."""
STEADY_CEPA = replace(CEPA, k_previous=STEADY_SIDE)
"""Those of config/cepa.yaml, with which everything else flies."""
LED_CEPA = replace(STEADY_CEPA, window_m=0.0, height_min=-1000.0)
"""As mapped.launch has them, where a planner knows the ways. CEPA's own search would find none in a room that
is closed at its height, or lead away from a place before a wall: it thinks that the reference leads far
ahead, for the UAV aims ahead on its way. No least height counts: a place may go on below the start, through a
hole or down a ramp, and range finders see the floor."""


@dataclass(frozen=True)
class ClosedLoopParameters:
    """The parameters of a flight.

    Every default is the nodes'. goal_xyz_m: in the frame of `pose_source`; None: no goal, so v_ref stays
    zero. mission: waypoints instead of the goal. The goal counts as reached after the last one, or after
    duration_s. return_to_start: after duration_s the UAV flies back to its start, and the goal counts as
    reached there. patience_s: if a waypoint takes longer, the run fails. algorithm: of `cepa.ALGORITHMS`.
    range_finders: CEPA uses those that look up and down: see the node's. imu: CEPA compares the odometry with
    the flight controller's IMU. nod: of the lidar wherever the UAV stops; None: none. conditions: those that
    are worse than the simulation's own parameters.
    """

    simulation: SimulationParameters
    goal_xyz_m: tuple[float, float, float] | None = (40.0, 0.0, 2.0)
    mission: Sequence[Waypoint] = ()
    duration_s: float = math.inf
    return_to_start: bool = False
    patience_s: float = 60.0
    algorithm: str = "improved"
    range_finders: bool = False
    imu: bool = False
    nod: Nod | None = None
    pose_source: str = "ground_truth"
    cepa: CepaParameters = STEADY_CEPA
    median_filter: MedianFilterParameters = field(default_factory=MedianFilterParameters)
    padding: PaddingParameters = field(default_factory=PaddingParameters)
    position_controller: PositionControllerParameters = field(default_factory=PositionControllerParameters)
    yaw_regulator: YawRegulatorParameters = field(default_factory=YawRegulatorParameters)
    publisher: PublisherParameters = field(default_factory=PublisherParameters)
    limits: PhaseLimits = field(default_factory=PhaseLimits)
    conditions: Conditions = field(default_factory=Conditions)

    def __post_init__(self) -> None:
        if self.algorithm not in ALGORITHMS:
            choices = ", ".join(ALGORITHMS)
            raise FlightError(f"There is no algorithm '{self.algorithm}'; choose one of {choices}.")
        if self.pose_source not in POSE_SOURCES:
            choices = ", ".join(POSE_SOURCES)
            raise FlightError(f"There is no pose source '{self.pose_source}'; choose one of {choices}.")

    @property
    def mission_time(self) -> MissionTime:
        """What ends the mission before its last waypoint."""
        return MissionTime(self.duration_s, self.return_to_start)

    @property
    def limits_of_way(self) -> PhaseLimits:
        """The limits, with enough time for the path to the goal or through the mission."""
        start, waits_s = self.simulation.spawn_pose.position_m, 0.0
        if self.mission:
            length_m, waits_s = way_m(self.mission, start), hold_s(self.mission)
        elif self.goal_xyz_m is not None:
            length_m = math.dist(self.goal_xyz_m[:2], start[:2])
        else:
            return self.limits
        return self.limits.for_way(length_m, max(self.position_controller.max_speed, 0.01), waits_s)
