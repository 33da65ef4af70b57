"""One exploring flight in the closed loop without ROS and without GNSS."""

from __future__ import annotations

import numpy as np

from gridslam.odometry import OdometryEstimate
from gridslam.volume import VolumeParameters
from inspection_tools.exploration import (
    Exploration,
    ExplorationParameters,
    Explored,
    Explorer,
    ExplorerParameters,
)
from inspection_tools.planning import PathPlanner, PlannerParameters
from master_thesis.exploring.flown_clouds import FlownClouds
from master_thesis.exploring.volume_of_flight import VolumeOfFlight
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase


class ExploringFlight:
    """Leads a closed loop from view to view, and home.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        planner, explorer, volume: their parameters.
        parameters: of the exploration.

    Raises:
        FlightError: the UAV has no clouds or flies by GNSS.
    """

    def __init__(
        self,
        loop: ClosedLoop,
        planner: PlannerParameters,
        explorer: ExplorerParameters,
        volume: VolumeParameters,
        parameters: ExplorationParameters | None = None,
    ) -> None:
        self._loop = loop
        self.volume = VolumeOfFlight(PathPlanner(planner), volume)
        self.exploration = Exploration(self.volume.planner, Explorer(explorer), parameters)
        self._clouds = FlownClouds(loop, self.volume, "Exploration")
        self._setpoint_m: np.ndarray | None = None

    def run(self) -> Explored:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            self._clouds.take(output)
            if self._clouds.newest is not None:
                self._lead(self._clouds.newest, loop.monitor.course.phase is Phase.FLYING)
        return self.exploration.told

    def _lead(self, estimate: OdometryEstimate, is_flying: bool) -> None:
        here_m, now_s = np.array(estimate.position_xyz), self._loop.time_s
        if is_flying and not self.exploration.has_begun:
            self.exploration.begin(now_s, here_m)
        if self.exploration.follow(now_s, here_m):
            self.volume.tell_planner()
            self.exploration.look(now_s, here_m)
        setpoint_m = self.exploration.setpoint_m
        if is_flying and setpoint_m is not None and setpoint_m is not self._setpoint_m:
            self._setpoint_m = setpoint_m
            self._loop.position_controller.set_setpoint(setpoint_m.tolist())
        if self.exploration.is_home:
            self._loop.monitor.on_goal_reached(True)
        elif self.exploration.must_land:
            self._loop.monitor.land_here(f"The UAV did not come home: {self.exploration.told.reason}")
