"""Turns a LaserScan message and TF into the filter's input, for the node and the replay of bags."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, Iterable

import numpy as np
from sensor_msgs.msg import LaserScan

from gridslam import PlanarScan
from gridslam.inputs.levelling import Levelling
from gridslam.inputs.scan_watch import ScanWatch
from gridslam.inputs.turns_watch import TurnsWatch
from gridslam.tracking.evidence import COMPARED_MIN
from gridslam.watches.clock_watch import ClockWatch
from gridslam.watches.mounting_watch import MountingWatch
from gridslam.watches.way_watch import WayWatch
from gridslam.watches.yaw_watch import YawWatch
from gridslam_ros.frames.odometry_frames import FrameError, OdometryFrames
from input_checks_ros.lidar_readings import LidarReadings
from node_tools.conversions import yaw_of_xyzw

EMPTY_MAX = 10
"""After so many scans in a row without a return, that is told."""
TURNS = 3
"""Two lidars come in turns if they have changed places this often in twice as many scans."""


class ScanSource:
    """Projects scans with the poses that TF knows for their stamps.

    Args:
        frames: the transforms.
        say: is called with a sentence when something about the scans is odd.
        levelling: whether to correct for the base frame's lean and to drop beams at the floor.
        floor_z_m: height of the floor in the odometry's frame; None: unknown, no beam is dropped for it.
    """

    def __init__(
        self,
        frames: OdometryFrames,
        say: Callable[[str], None],
        levelling: bool = True,
        floor_z_m: float | None = 0.0,
    ):
        self._frames = frames
        self._say, self._readings = say, LidarReadings(say)
        self._levelling, self._watch = Levelling(levelling, floor_z_m), ScanWatch()
        self._mounting: dict[str, MountingWatch] = {}
        """By the lidar's frame."""
        self._ways: dict[str, WayWatch] = {}
        """By the lidar's frame."""
        self._yaws: dict[str, YawWatch] = {}
        """By the lidar's frame."""
        self._clocks: dict[str, ClockWatch] = {}
        """By the lidar's frame."""
        self._in_turns: dict[tuple[str, int], TurnsWatch] = {}
        """By the lidar's frame and number of beams."""
        self._empty = 0
        """Number of scans in a row without a return."""
        self._has_told_few = False
        self._lidars: deque[tuple[str, int]] = deque(maxlen=2 * TURNS)  # frames and numbers of beams

    def look_ahead(self, scans: Iterable[LaserScan]) -> None:
        """See `LidarReadings.look_ahead`."""
        self._readings.look_ahead(scans)

    def planar(self, scan: LaserScan) -> tuple[PlanarScan, tuple[float, float, float]]:
        """Return (levelled scan, base in odom as x, y, yaw) of a message whose frames are known.

        Raises:
            FrameError: TF does not know where the lidar was.
            ScanError: the scan or its frames make no sense, or no lidar measures such a scan.
            MountingError: the lidar is upside down or turned, and TF does not tell, or two lidars have one
                frame, or odometry's metre or its yaw is wrong.
        """
        base_in_odom, lidar_in_base = self._frames.look_up(scan)
        scan = self._readings.scan(scan)
        ranges_m = np.asarray(scan.ranges)
        planar, base = self._levelling.level(
            scan.header.stamp.to_sec(),
            ranges_m,
            (scan.angle_min, scan.angle_increment),
            (scan.range_min, scan.range_max),
            lidar_in_base,
            base_in_odom,
            self._frames.last_base(scan),
        )
        self._watch_lidar(scan)
        self._watch_beams(scan, planar)
        self._watch.check(ranges_m, planar, base)
        self._yaws.setdefault(scan.header.frame_id, YawWatch()).check(planar, base)
        self._mounting.setdefault(scan.header.frame_id, MountingWatch()).check(planar, base)
        self._ways.setdefault(scan.header.frame_id, WayWatch()).check(planar, base)
        lidar = (scan.header.frame_id, len(scan.ranges))
        self._in_turns.setdefault(lidar, TurnsWatch()).check(planar, base)
        if sentence := self._clocks.setdefault(scan.header.frame_id, ClockWatch()).check(planar, base):
            self._say(sentence)
        return planar, base

    def base_of(self, scan: LaserScan) -> tuple[float, float, float] | None:
        """Return the base in odom (x, y, yaw) at a scan; None: TF does not know it."""
        try:
            (x, y, _), rotation = self._frames.look_up(scan)[0]
        except FrameError:
            return None
        return x, y, yaw_of_xyzw(rotation)

    def _watch_beams(self, scan: LaserScan, planar: PlanarScan) -> None:
        self._empty = 0 if np.isfinite(planar.ranges_m).any() else self._empty + 1
        if self._empty == EMPTY_MAX:
            self._say(
                f"No beam of the last {EMPTY_MAX} scans has met anything nearer than range_max, "
                f"{scan.range_max:g} m: odometry alone tells the way."
            )
        if len(scan.ranges) < COMPARED_MIN and not self._has_told_few:
            self._has_told_few = True
            self._say(
                f"The scan has {len(scan.ranges)} beam{'s' if len(scan.ranges) > 1 else ''}: scans of fewer "
                f"than {COMPARED_MIN} cannot be compared with the map, and odometry alone tells the way."
            )
        span_rad = scan.angle_max - scan.angle_min
        if scan.angle_max == 0.0 or not math.isfinite(span_rad):  # some drivers leave it out
            return
        told = round(span_rad / scan.angle_increment) + 1
        if abs(told - len(scan.ranges)) > 1 and len(scan.ranges) > 1:
            self._say(
                f"The scan has {len(scan.ranges)} ranges, but angle_min, angle_max and angle_increment tell "
                f"{told}: one of them is wrong. Mapping takes angle_min and angle_increment."
            )

    def _watch_lidar(self, scan: LaserScan) -> None:
        lidar = (scan.header.frame_id, len(scan.ranges))
        before = self._lidars[-1] if self._lidars else lidar
        self._lidars.append(lidar)
        if lidar == before:
            return
        last = list(self._lidars)
        changes = sum(one != next_one for one, next_one in zip(last, last[1:]))
        if changes >= TURNS and len(set(last)) == 2:
            self._say(
                f'Scans of {before[1]} beams in "{before[0]}" and of {lidar[1]} beams in "{lidar[0]}" come '
                "in turns; mapping uses both, but two lidars need two topics, of which SLAM gets one."
            )
        else:
            self._say(
                f'The scans changed from {before[1]} beams in "{before[0]}" to {lidar[1]} beams in '
                f'"{lidar[0]}"; mapping goes on with them.'
            )
