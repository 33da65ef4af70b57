"""A planar lidar that nods while the UAV hovers, as the nodes `lidar_nodder` and `level_beams` let it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from inspection_tools import LevelBeamsParameters, LevelFrame, ScanGeometry, is_whole, level_part
from simulation_tools.geometry import Pose, Vector3
from simulation_tools.running.nod_while_hovering import NodTiming, NodWhileHovering, Order
from simulation_tools.simulation import Simulation
from simulation_tools.vehicle.nod import Nod


class SweptScan(NamedTuple):
    """A scan as it was measured: ranges (beams,) m; the lidar's pose on the UAV, and the UAV's true one."""

    t_s: float
    ranges: np.ndarray
    lidar_in_base: Pose
    truth: Pose


class LevelScan(NamedTuple):
    """What lies near the level plane: ranges (beams,) m, NaN: untold. is_whole: every beam does."""

    ranges: np.ndarray
    is_whole: bool


class NoddingLidar:
    """The lidar of a simulation. swept: its scans so far.

    Raises:
        SimulationToolsError: the gimbal cannot follow, or there is none.
        ScanError: the lidar does not stand upright.
    """

    def __init__(self, simulation: Simulation, nod: Nod) -> None:
        lidar = simulation.lidar
        assert lidar is not None  # the closed loop has looked
        simulation.nod_lidar(nod)
        self._simulation, self._lidar, self._nod = simulation, lidar, nod
        self._decide = NodWhileHovering(NodTiming(max(nod.sweeps, 1) * nod.period_s))
        self._parameters = LevelBeamsParameters()
        self._level = LevelFrame.below(lidar.pose_in_body.position_m, lidar.pose_in_body.orientation_xyzw)
        self.swept: list[SweptScan] = []
        self._order(Order.LEVEL)

    def on_odometry(self, t_s: float, velocity_m_s: Vector3, goal_reached: bool) -> None:
        """Begin or end a nod, by what the UAV does."""
        order = self._decide.update(t_s, math.hypot(*velocity_m_s), goal_reached)
        if order is not None:
            self._order(order)

    def _order(self, order: Order) -> None:
        nod = self._nod if order is Order.NOD else replace(self._nod, amplitude_rad=0.0)
        self._simulation.nod_lidar(nod)

    def level(self, t_s: float, ranges: np.ndarray, truth: Pose) -> LevelScan:
        """Keep a scan of this instant, and return its level part."""
        lidar, mount = self._lidar, self._lidar.pose_in_body
        self.swept.append(SweptScan(t_s, np.array(ranges, np.float32), mount, truth))
        rotation, translation = self._level.pose_of(mount.position_m, mount.orientation_xyzw)
        geometry = ScanGeometry(lidar.beams, lidar.angle_min, lidar.angle_increment)
        limits_m = lidar.range_min, lidar.range_max
        level = level_part(ranges, geometry, limits_m, rotation, translation, self._parameters)
        return LevelScan(level, is_whole(rotation, self._parameters))
