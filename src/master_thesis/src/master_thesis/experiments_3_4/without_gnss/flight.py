"""Experiments 3 and 4 without GNSS and without ROS, flown by lidar, IMU and range finder."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, replace

import numpy as np

from flight_basics.correction import SlowCorrection
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Outcome
from flights.flight.flight_recording import LidarGeometry
from flights.flight.parameters import ClosedLoopParameters
from flights.flight.without_gnss import SLAM
from flights.mapping.mapping_flight import SCENARIOS, parameters_of
from flights.mapping.slam_run import SlamParticipant
from flights.mapping.slam_setup import read_setup
from gridslam.odometry.warm_up import warm_up_odometry
from gridslam.warm_up import warm_up
from simulation_tools.geometry import Pose, Vector3

LOOKAHEAD_S = 0.5
"""The position controller follows the legs between the waypoints, as in mapping.launch."""
CORRECTION_LAG_S = 0.25
"""From a scan to when its correction counts: gridslam stamps it 0.05 s ahead, the controller waits 0.2 s."""


@dataclass(frozen=True)
class FlownWithoutGnss:
    """A flight with the truth about it.

    truth, odometry, flown_by: rows of time in s and position in m, (n, 4): the true pose, the lidar's
    odometry, and the pose in `map` by which the mission is flown. way_xy: start and waypoints, (k, 2).
    cpu_ms: mean CPU time of the odometry per scan.
    """

    outcome: Outcome
    truth: np.ndarray
    odometry: np.ndarray
    flown_by: np.ndarray
    way_xy: np.ndarray
    flight_height_m: float
    cpu_ms: float

    def metrics(self) -> dict:
        """Return how the flight ended, and its errors in m."""
        in_air = self.truth[:, 3] > 0.8 * self.flight_height_m
        odometry_off, flown_by_off = (_errors(rows, self.truth) for rows in (self.odometry, self.flown_by))
        return {
            "flown": self.outcome.reached_goal and self.outcome.landed,
            "contact": self.outcome.collision,
            "failure": self.outcome.failure,
            "landed_off_m": math.dist(self.truth[-1, 1:3], self.way_xy[0]),
            "ate_m": _rms(np.hypot(*flown_by_off[:, :2].T)),
            "odometry_ate_m": _rms(np.hypot(*odometry_off[:, :2].T)),
            "path_p95_m": float(np.percentile(distances(self.truth[in_air, 1:3], self.way_xy), 95)),
            "height_p95_m": float(np.percentile(np.abs(odometry_off[:, 2]), 95)),
            "cpu_ms": self.cpu_ms,
        }

    def path_xy(self, every_m: float) -> list[list[float]]:
        """Return places of the true path that are at least this far apart, and its last one."""
        places = self.truth[:, 1:3]
        way_m = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(places, axis=0).T))))
        chosen = np.searchsorted(way_m, np.append(np.arange(0.0, way_m[-1], every_m), way_m[-1]))
        return np.round(places[chosen], 3).tolist()


def parameters_without_gnss(world: str, lidar: str, seed: int) -> ClosedLoopParameters:
    """Return the closed loop of a scenario, flown by the UAV's own odometry. It ends over its start.

    Raises:
        ScenarioError: there is no such scenario.
    """
    parameters = parameters_of(world, lidar, seed)
    return replace(
        parameters,
        simulation=replace(parameters.simulation, sensors=("range_finder",), gnss=False),
        position_controller=replace(parameters.position_controller, lookahead=LOOKAHEAD_S),
        pose_source="odometry",
        return_to_start=True,
    )


def fly_without_gnss(world: str, seed: int, parameters: ClosedLoopParameters) -> FlownWithoutGnss:
    """Fly a scenario to its end: odometry from the lidar, SLAM with loop closure, the mission in `map`."""
    warm_up()
    warm_up_odometry()
    with ClosedLoop(parameters) as loop:
        own = loop.own_odometry
        assert own is not None  # there is no GNSS
        pose = SlamPose(loop, world, seed)
        outcome = loop.run()
        scenario = SCENARIOS[world]
        return FlownWithoutGnss(
            outcome,
            np.array(loop.log.truth.rows)[:, :4],
            np.array([(e.stamp_s, *e.position_xyz) for e in own.estimates]),
            np.array(pose.rows),
            np.array([scenario.start_xyz_yaw[:2], *(w.position_m[:2] for w in parameters.mission)]),
            scenario.flight_height_m,
            float(np.mean(own.cpu_ms)),
        )


class SlamPose:
    """SLAM beside a closed loop, whose mission it lets fly in `map`. SLAM that died begins a new map.

    rows: time in s and position, of every odometry. map_to_odom: x, y in m, yaw in rad and z in m, the newest
    that counts at the time of `settle`. slow: lets it count slowly.
    """

    def __init__(self, loop: ClosedLoop, world: str, seed: int) -> None:
        self._setup, self._seed, self._loop = read_setup(world), seed, loop
        self._slam: SlamParticipant | None = None
        self.slow = SlowCorrection()
        self.map_to_odom = (0.0, 0.0, 0.0, 0.0)
        self._coming: deque[tuple[float, tuple[float, float, float, float]]] = deque()
        self.rows: list[tuple[float, ...]] = []
        loop.listeners.append(self)
        loop.correct = self.of

    def on_scan(self, t_s: float, ranges: np.ndarray, odometry: Pose, truth: Pose) -> None:
        """Take a scan, as a ScanListener."""
        if self._loop.outage is not None and self._loop.outage.holds(SLAM, t_s):
            self._slam = None
            return
        own = self._loop.own_odometry
        assert own is not None  # there is no GNSS
        if self._slam is None:
            session = self._setup.session(self._seed, loop_closure=True, odometry_in_space=own.uses_clouds)
            self._slam = SlamParticipant(session, LidarGeometry.of(self._loop.lidar))
        estimate = next(e for e in reversed(own.estimates) if e.stamp_s == t_s)
        covariance = estimate.planar_covariance
        self._slam.on_scan(t_s, ranges, odometry, truth, covariance, lambda: own.level_cloud(t_s, odometry))
        session = self._slam.session
        if session.map_to_odom is not None:
            self._coming.append((t_s + CORRECTION_LAG_S, (*session.map_to_odom, session.rise_m)))

    def settle(self, t_s: float) -> None:
        """Let the corrections count that are old enough."""
        while self._coming and self._coming[0][0] <= t_s + 1e-6:
            self.map_to_odom = self._coming.popleft()[1]

    def of(self, t_s: float, pose: Pose) -> tuple[Vector3, float]:
        """Return position and heading in `map` of a pose in `odom`."""
        self.settle(t_s)
        x, y, yaw, z = self.map_to_odom
        turn = (0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
        position_m, yaw_rad = self.slow.apply(t_s, (pose.position_m, pose.yaw_rad), (x, y, z), turn)
        self.rows.append((t_s, *position_m))
        return position_m, yaw_rad


def distances(points_xy: np.ndarray, way_xy: np.ndarray) -> np.ndarray:
    """Return (n,) distances of points (n, 2) from a way of straight lines (k, 2)."""
    begin, along = way_xy[:-1], np.diff(way_xy, axis=0)
    length2 = np.maximum((along**2).sum(axis=1), 1e-12)
    to_points = points_xy[:, None] - begin
    share = np.clip((to_points * along).sum(axis=2) / length2, 0.0, 1.0)
    return np.hypot(*np.moveaxis(to_points - share[..., None] * along, 2, 0)).min(axis=1)


def _errors(found: np.ndarray, truth: np.ndarray) -> np.ndarray:
    """Return (n, 3) found less true positions; both rows begin with the time."""
    return found[:, 1:4] - np.column_stack(
        [np.interp(found[:, 0], truth[:, 0], truth[:, i]) for i in (1, 2, 3)]
    )


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(values**2)))
