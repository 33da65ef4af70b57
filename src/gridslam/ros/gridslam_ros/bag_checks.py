"""Why a bag gives no map, or none that is worth anything: one sentence each."""

from __future__ import annotations

import numpy as np

from gridslam import PlanarScan
from gridslam.localisation.standstill import Standstill
from gridslam.watches.still_part import StillPart
from gridslam_ros.bags import ODOMETRY, BagCount, BagError
from gridslam_ros.frames.odometry_frames import OdometryFrames

WITHOUT_TF, WITHOUT_TF_SHARE = 3, 0.02
"""More scans than both say may be left out because TF does not reach them, as at a bag's begin and end."""
CHANGES = 3
"""So many times scans have changed while odometry stood still, and it has never moved: there is none."""
INSTEAD = "play the bag to lidar_odometry, which makes odometry of scans"
PARTS = {True: ("yaw", "turn", "rotation"), False: ("position", "move", "translation")}
"""What has never changed, and what scans do, by whether the position has moved."""


class BagChecks:
    """Judges a bag by its count, its frames, and whether odometry has moved at all, and in all its parts.

    Args:
        topic: of the scans.
        count: of the scans.
        frames: know the bag's TF.
    """

    def __init__(self, topic: str, count: BagCount, frames: OdometryFrames) -> None:
        self.odometry_topics: list[str] = []
        """Of the bag's messages of nav_msgs/Odometry, which SLAM does not read in place of TF."""
        self._topic, self._count, self._frames = topic, count, frames
        self._standstill, self._changes = Standstill(), 0
        self._part = StillPart()
        self._has_met = False

    def add(self, scan: PlanarScan, base_in_odom: tuple[float, float, float]) -> None:
        """Take in a scan that is used, with the base in odom."""
        self._has_met = self._has_met or bool(np.isfinite(scan.ranges_m).any())
        self._part.add(scan, base_in_odom)
        if not (self._part.has_moved or self._part.has_turned):
            self._changes += self._standstill.has_changed(scan, np.array(base_in_odom))

    def check(self, integrated: int, used: int, jumps: int) -> None:
        """Judge the whole bag, of which so many scans were integrated.

        Args:
            integrated: number of scans in the map.
            used: number of scans whose place TF tells.
            jumps: before so many of these odometry has jumped.

        Raises:
            BagError: no map can be right.
        """
        read = self._count.read
        if 2 * self._count.of_one_stamp > read:
            raise BagError(
                f"{self._count.of_one_stamp} of the {read} scans have the stamp of the scan before, though "
                "they see other things; the driver must stamp each scan."
            )
        if not integrated:
            raise BagError(self._why_nothing())
        if 2 * jumps > used:
            raise BagError(
                f"Odometry jumps before {jumps} of {used} scans, farther than any vehicle moves; check "
                "whether its positions are in metres."
            )
        if not self._has_met:
            raise BagError(
                f"No beam of the {read} scans has met anything nearer than range_max; check the lidar, and "
                "whether ranges and range_max are in metres."
            )
        self._check_odometry(read)

    def _check_odometry(self, read: int) -> None:
        part = self._part
        if not (part.has_moved or part.has_turned) and self._changes >= CHANGES:
            raise BagError(
                f"Odometry stands still in the whole bag, but the scans change: none of the {read} scans has "
                f"odometry; {INSTEAD}."
            )
        if part.is_wrong:
            same, changes, filled = PARTS[part.has_moved]
            edge = f'"{self._frames.odom_frame}" -> "{self._frames.base_frame}"'
            raise BagError(
                f"Odometry's {same} is the same in the whole bag, but the scans {changes}: the driver must "
                f"fill the {filled} of TF {edge}; or {INSTEAD}."
            )

    def what_is_left_out(self) -> str:
        """Return a sentence if TF does not tell where many of the scans were; else nothing."""
        count = self._count
        if count.without_tf <= max(WITHOUT_TF, WITHOUT_TF_SHARE * count.read):
            return ""
        return f"{count.without_tf} of the {count.read} scans are not in the map: {self._why_without_tf()}."

    def _why_without_tf(self) -> str:
        return self._frames.what_lacks(self._count.lidar_frame) or (
            "the transforms are of other times than the scans; check the clocks that stamp both"
        )

    def _why_nothing(self) -> str:
        if self._count.without_tf:
            why = f"{self._why_without_tf()}.{self._beside()}"
            return f"None of the {self._count.read} scans could be used: {why}"
        return f"None of the {self._count.read} scans on {self._topic} could be used."

    def _beside(self) -> str:
        """Return a sentence if the bag has odometry, and not as TF."""
        if not self.odometry_topics or self._frames.has_odometry:
            return ""
        return (
            f" The bag has {ODOMETRY} on {', '.join(self.odometry_topics)}, but SLAM reads odometry from TF: "
            "let its driver send TF, too, or robot_localization make TF of it."
        )
