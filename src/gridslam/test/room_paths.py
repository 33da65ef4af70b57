"""Paths along which each scan shows a square room about the vehicle."""

from __future__ import annotations

import math

import numpy as np
from planar_world import Log

from gridslam.loop_closure import LoopClosureParameters
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.snapshot import Snapshot
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan

HALF_M = 3.0


def room_scan(stamp_s: float, seen_rad: float = math.pi) -> PlanarScan:
    """A scan in the middle of a room of 6 x 6 m. Beams farther than ``seen_rad`` to the side see nothing."""
    angles = np.linspace(-math.pi, math.pi, 240, endpoint=False)
    ranges = HALF_M / np.maximum(np.abs(np.cos(angles)), np.abs(np.sin(angles)))
    ranges[np.abs(angles) > seen_rad] = math.inf
    return PlanarScan(stamp_s, angles, ranges, (0.0, 0.0, 0.0), 10.0)


def snapshot_along(
    poses: np.ndarray,
    odometry: np.ndarray | None = None,
    seen_rad: float = math.pi,
    first_in_map: int = 0,
    heights_m: np.ndarray | None = None,
) -> Snapshot:
    """A filter that has come along poses (k, 3), with a scan a second; by default as odometry has it, too.

    heights_m: (k,) in the map; None: not known.
    """
    poses, parameters = np.array(poses, float), SlamParameters()
    scans = [room_scan(float(second), seen_rad) for second in range(len(poses))]
    return Snapshot(
        np.arange(len(poses), dtype=float),
        poses,
        poses if odometry is None else odometry,
        np.full(len(poses), np.nan) if heights_m is None else heights_m,
        tuple(scans),
        (None,) * len(poses),
        tuple(scans),
        first_in_map,
        np.ones(len(poses), bool),
        parameters,
    )


def snapshot_of(log: Log, poses: np.ndarray) -> Snapshot:
    """A filter that has come along the first poses of a log."""
    count, parameters = len(poses), SlamParameters()
    return Snapshot(
        np.array([scan.stamp_s for scan in log.scans[:count]]),
        poses,
        log.odometry[:count],
        np.full(count, np.nan),
        tuple(log.scans[:count]),
        (None,) * count,
        tuple(log.scans[:count]),
        0,
        np.ones(count, bool),
        parameters,
    )


def maps_of(snapshot: Snapshot, parameters: LoopClosureParameters) -> LocalMaps:
    """The local maps of a snapshot."""
    maps = LocalMaps(parameters)
    maps.extend(snapshot.scans)
    return maps


def path_of(snapshot: Snapshot, parameters: LoopClosureParameters) -> MeasuredPath:
    """The measured path of a snapshot."""
    return MeasuredPath.empty().followed(snapshot, maps_of(snapshot, parameters).informations, parameters)


def path_along(poses: np.ndarray, odometry: np.ndarray | None = None) -> MeasuredPath:
    """The measured path along poses."""
    return path_of(snapshot_along(poses, odometry), LoopClosureParameters())
