"""One exploring flight in the closed loop without ROS and without GNSS."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field
from enum import Enum

import numpy as np

from gridslam.errors import SlamError
from gridslam.inputs.attitude import matrix_of_quaternion
from gridslam.odometry import OdometryEstimate
from gridslam.volume import Pose, VolumeParameters
from inspection_tools.errors import NoPathError
from inspection_tools.exploration import Explorer, ExplorerParameters, Leftover, Why
from inspection_tools.planning import PathPlanner, PlannerParameters
from master_thesis.errors import FlightError
from master_thesis.exploring.volume_of_flight import VolumeOfFlight
from master_thesis.flight.closed_loop import ClosedLoop
from master_thesis.flight.course import Phase
from simulation_tools.geometry import quaternion_from_rpy
from simulation_tools.sensors.cloud import Cloud, CloudLidar

CLOUD_S = 0.2
"""The map takes a cloud so often."""
LOOK_S = 1.0
"""The way is checked, and the next view is decided anew, so often."""
REST_S = 0.3
"""At a view, so that clouds come before the next decision."""
ARRIVED_M = 0.3
TRACK_M = 0.5
"""Between the places that the UAV remembers, to come back the way it came."""
FIRST_SINK_M = 0.7
"""The hover's height is the border of what the climb has shown: the UAV begins this much below."""


class End(Enum):
    """Why an exploration has ended."""

    EXPLORED = "explored"
    TIME = "time"
    SHUT_IN = "shut in"


@dataclass
class Explored:
    """What an exploration did.

    end: why it ended; None: it flies. ended_s: when. views: that were decided. known_m3: time in s, and the
    free and occupied volume. leftovers: what stays unknown. cpu_s: CPU time of each decision.
    """

    end: End | None = None
    views: int = 0
    known_m3: list[tuple[float, float]] = field(default_factory=list)
    leftovers: tuple[Leftover, ...] = ()
    cpu_s: list[float] = field(default_factory=list)
    ended_s: float = math.nan

    def left_m2(self, why: Why) -> float:
        """Return the area of the border that stays unknown for a reason."""
        return sum(leftover.area_m2 for leftover in self.leftovers if leftover.why is why)

    def time_of(self, share: float) -> float:
        """Return when this share of the volume known at the end was known, s; NaN if nothing was."""
        rows = np.array(self.known_m3).reshape(-1, 2)
        enough = rows[rows[:, 1] >= share * rows[:, 1].max(initial=0.0)]
        return float(enough[0, 0]) if len(enough) else math.nan


class Exploration:
    """Leads a closed loop from view to view, and home.

    Args:
        loop: a flight without GNSS, with a lidar that has clouds, and without a goal.
        planner, explorer, volume: their parameters.
        time_s: of simulation; after that the UAV flies home.

    Raises:
        FlightError: the UAV has no clouds or flies by GNSS.
    """

    def __init__(
        self,
        loop: ClosedLoop,
        planner: PlannerParameters,
        explorer: ExplorerParameters,
        volume: VolumeParameters,
        time_s: float = math.inf,
    ) -> None:
        lidars = [sensor for sensor in loop.simulation.payload if isinstance(sensor.device, CloudLidar)]
        if not lidars or loop.own_odometry is None:
            raise FlightError("Exploration needs a lidar with clouds and a flight without GNSS.")
        self._loop, self._own, self._lidar = loop, loop.own_odometry, lidars[0]
        mount = self._lidar.mount.pose
        self._lidar_in_base = Pose(mount.rotation, np.array(mount.position_m))
        self.volume = VolumeOfFlight(PathPlanner(planner), volume)
        self._planner, self._explorer = self.volume.planner, Explorer(explorer)
        self._time_s, self._radius_m = time_s, planner.radius
        self._clouds: dict[int, np.ndarray] = {}
        self._seen = 0
        self._cloud_s = self._look_s = -math.inf
        self._way: list[np.ndarray] = []
        self._home: np.ndarray | None = None
        self._track: list[np.ndarray] = []
        self.told = Explored()

    def run(self) -> Explored:
        """Fly until the UAV has landed, or the run has failed."""
        loop = self._loop
        while not loop.is_over:
            output = loop.step()
            if self._lidar in output.payload:
                cloud = self._lidar.shared()
                assert isinstance(cloud, Cloud)
                self._clouds[output.time_us] = cloud.points_m
            for estimate in self._own.estimates[self._seen :]:
                self._map(estimate)
            self._seen = len(self._own.estimates)
            if loop.monitor.course.phase is Phase.FLYING and self._own.estimates:
                self._lead(self._own.estimates[-1])
        return self.told

    def _map(self, estimate: OdometryEstimate) -> None:
        stamp_us = round(1e6 * estimate.stamp_s)
        points = self._clouds.pop(stamp_us, None)
        self._clouds = {key: cloud for key, cloud in self._clouds.items() if key > stamp_us}
        if points is None or estimate.stamp_s < self._cloud_s + CLOUD_S or estimate.remark:
            return
        self._cloud_s = estimate.stamp_s
        self._planner.take_as_free(np.array(estimate.position_xyz), self._radius_m)
        rotation = matrix_of_quaternion(quaternion_from_rpy(*estimate.roll_pitch_yaw))
        base = Pose(rotation, np.array(estimate.position_xyz))
        try:
            self.volume.add(estimate.stamp_s, points, base @ self._lidar_in_base)
        except SlamError:
            return  # a cloud without a point

    def _lead(self, estimate: OdometryEstimate) -> None:
        here, now_s = np.array(estimate.position_xyz), self._loop.time_s
        self._planner.take_as_free(here, self._radius_m)
        if self._home is None:
            self._home = here - (0.0, 0.0, FIRST_SINK_M)
            self._fly([self._home])
        if not self._track or math.dist(here, self._track[-1]) > TRACK_M:
            self._track.append(here)
        if self._way and math.dist(here, self._way[0]) < ARRIVED_M:
            self._fly(self._way[1:])
        if now_s < self._look_s + (LOOK_S if self._way else REST_S):
            return
        self._look_s = now_s
        self.volume.tell_planner()
        if self.volume.is_empty:
            return  # it hovers until a cloud has come
        if self.told.views and self._way and self._planner.is_clear(np.array([here, *self._way]), now_s):
            if self.told.end is not None or len(self._way) > 1:
                return
        elif self._way and not self.told.views and math.dist(here, self._way[-1]) > ARRIVED_M:
            return  # still on the first way down
        self._decide(here, now_s)

    def _decide(self, here: np.ndarray, now_s: float) -> None:
        self.told.known_m3.append((now_s, self._known_m3()))
        if self.told.end is None:
            started = time.thread_time()
            self._next_view(here, now_s)
            self.told.cpu_s.append(time.thread_time() - started)
            self.told.ended_s = now_s
        if self.told.end is not None:
            assert self._home is not None
            if math.dist(here, self._home) < 2 * ARRIVED_M:
                self._loop.monitor.on_goal_reached(True)
                return
            if not self._plan(here, self._home, now_s):
                self._fly(self._track[::-1])  # the way it came

    def _next_view(self, here: np.ndarray, now_s: float) -> None:
        if now_s - self._loop.outcome.times_s[Phase.FLYING] > self._time_s:
            self.told.end = End.TIME
            return
        decision = self._explorer.decide(self._planner.space(now_s, here), here)
        self.told.views += 1
        if decision.goal_m is not None:
            goal = np.array(decision.goal_m)
            if not self._plan(here, goal, now_s):
                self._planner.close(goal, now_s)
                self._fly([])
            return
        self.told.leftovers = decision.leftovers
        self.told.end = End.SHUT_IN if decision.is_shut_in else End.EXPLORED

    def _plan(self, here: np.ndarray, goal: np.ndarray, now_s: float) -> bool:
        """Set out for a goal; return whether there is a way."""
        try:
            self._fly(list(self._planner.plan(here, goal, now_s).points_m[1:]))
        except NoPathError:
            return False
        return True

    def _fly(self, way: list[np.ndarray]) -> None:
        self._way = way
        if way:
            self._loop.position_controller.set_setpoint(way[0].tolist())

    def _known_m3(self) -> float:
        space = self._planner.space(self._loop.time_s, np.zeros(3))
        return float(np.count_nonzero(space.grid.kinds)) * space.grid.resolution_m**3
