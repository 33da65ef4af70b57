"""One exploring flight in the closed loop without ROS and without GNSS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exploration.energy import EnergyWatch
from exploration.next_view import (
    Exploration,
    ExplorationParameters,
    Explored,
    Explorer,
    ExplorerParameters,
)
from exploration.planning import Limits, PathPlanner, PlannerParameters
from flights.exploring.battery_swap import BatterySwap
from flights.exploring.drift import Drift
from flights.exploring.flown_clouds import FlownClouds
from flights.exploring.itinerary import Itinerary, Next
from flights.exploring.volume_of_flight import VolumeOfFlight
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.due import Due
from gridslam.odometry import OdometryEstimate
from gridslam.volume import VolumeParameters
from simulation_tools.geometry import Pose, Vector3

BATTERY_US = 2_000_000
"""Period of PX4's BATTERY_STATUS on the offboard link."""


@dataclass(frozen=True)
class Landing:
    """A landing. end, reason: why the exploration had ended. charge: 0..1. place_m: true (x, y, z)."""

    stamp_s: float
    end: str
    reason: str
    charge: float
    place_m: tuple[float, float, float]


class ExploringFlight:
    """Leads a closed loop from view to view, and home.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        planner, explorer, volume: their parameters.
        parameters: of the exploration.
        energy: watches the battery of the loop; None: the battery does not count.
        swaps: of the battery, at most.
        drift: of SLAM's poses; None: there is none.
        limits: where the UAV may not go.

    Attributes:
        landings: those that have ended, in their order.

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
        energy: EnergyWatch | None = None,
        swaps: int = 0,
        drift: Drift | None = None,
        limits: Limits | None = None,
    ) -> None:
        self._loop, self._energy, self._drift = loop, energy, drift
        self.volume = VolumeOfFlight(PathPlanner(planner, limits), volume)
        asked = parameters or ExplorationParameters()
        chooses = Explorer(explorer, asked.steep)
        self.exploration = Exploration(self.volume.planner, chooses, asked, energy)
        self.landings: list[Landing] = []
        self._clouds = FlownClouds(loop, self.volume, "Exploration")
        self._setpoint_m: np.ndarray | None = None
        self._here_m: np.ndarray | None = None
        self._itinerary = Itinerary(1, swaps)
        self._swap = BatterySwap(loop, self._take_battery, self.volume)
        self._battery_is_due = Due(BATTERY_US)
        self._is_active = self._has_ended = False
        self._loops_closed = 0
        if drift is not None:
            self._clouds.drift, loop.correct = drift, self._in_map

    def run(self) -> Explored:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            self._clouds.take(output)
            if self._here_m is not None:
                self._swap.follow(self._here_m)
            if self._clouds.newest is not None:
                self._lead(self._clouds.newest, loop.monitor.course.phase is Phase.FLYING)
        if loop.outcome.landed:
            self._note_landing()
        return self.exploration.explored

    def _in_map(self, stamp_s: float, pose: Pose) -> tuple[Vector3, float]:
        assert self._drift is not None
        odom = self._drift.odom_in_map(stamp_s)
        x, y, z = (odom.rotation @ np.array(pose.position_m) + odom.translation).tolist()
        return (x, y, z), pose.yaw_rad + float(np.arctan2(odom.rotation[1, 0], odom.rotation[0, 0]))

    def _lead(self, estimate: OdometryEstimate, is_flying: bool) -> None:
        here_m, now_s = np.array(estimate.position_xyz), self._loop.time_s
        if self._drift is not None:
            odom, closed = self._drift.odom_in_map(now_s), self._drift.closed_until(now_s)
            here_m = odom.rotation @ here_m + odom.translation
            if closed > self._loops_closed:
                self._loops_closed = closed
                self.volume.close_loop()
        self._here_m = here_m
        if is_flying and not (self._is_active or self._has_ended or self._swap.is_under_way):
            self._begin(now_s, here_m)
        is_due = self.exploration.follow(now_s, here_m)
        if not (self._is_active and is_flying):
            return
        self.exploration.explored.note_height(estimate.height_uncertain_m)
        if self._energy is not None and self._battery_is_due(round(1e6 * now_s)):
            self._energy.offer(now_s, self._loop.charge)
        if is_due:
            self.volume.tell_planner()
            self.exploration.look(now_s, here_m)
        setpoint_m = self.exploration.setpoint_m
        if setpoint_m is not None and setpoint_m is not self._setpoint_m:
            self._setpoint_m = setpoint_m
            self._loop.position_controller.set_setpoint(setpoint_m.tolist())
        if self.exploration.is_home or self.exploration.must_land:
            self._end()

    def _begin(self, now_s: float, here_m: np.ndarray) -> None:
        self.exploration.begin(now_s, here_m)
        self._is_active = True
        if self._energy is not None:
            self._energy.offer(now_s, self._loop.charge)

    def _end(self) -> None:
        """Land: for a full battery, or for good."""
        explored = self.exploration.explored
        end = "" if explored.end is None else explored.end.value
        follows = self._itinerary.after(end, self.exploration.is_home)
        self._is_active, self._has_ended = False, follows is not Next.AGAIN
        if follows is Next.LOST:
            self._loop.monitor.land_here(f"The UAV did not come home: {explored.reason}")
        elif follows is Next.OVER:
            self._loop.monitor.on_goal_reached(True)
        else:
            self._swap.begin()

    def _take_battery(self) -> bool:
        self._note_landing()
        return self._itinerary.take_battery()

    def _note_landing(self) -> None:
        explored = self.exploration.explored
        end = "" if explored.end is None else explored.end.value
        _, x, y, z, *_ = self._loop.log.truth.rows[-1]
        power = self._loop.simulation.power
        charge = self._loop.charge if power is None else power.battery.remaining
        self.landings.append(Landing(self._loop.time_s, end, explored.reason, charge, (x, y, z)))
