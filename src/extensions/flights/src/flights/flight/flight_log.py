"""The time series of one flight. The node records them from topics, the closed loop directly.

Frames and units: `truth` is the UAV's pose and velocity in `world`, `odometry` the same in `odom`; commands
are body velocities (x forward, y left, z up); seconds of simulation time, metres, radians. `computation_ms`
is processor time.
"""

from __future__ import annotations

import bisect
from dataclasses import dataclass, field
from typing import Any, Iterator, Sequence

import numpy as np

POSE_COLUMNS = ("t_s", "x_m", "y_m", "z_m", "qx", "qy", "qz", "qw")
TWIST_COLUMNS = ("t_s", "vx_m_s", "vy_m_s", "vz_m_s", "yaw_rate_rad_s")
DECISION_COLUMNS = ("t_s", "computation_ms", "directions_tested", "cost", "emergency", "reason")
CONTACT_COLUMNS = ("t_s", "collision_1", "collision_2")
HIT_COLUMNS = ("t_s", "x_m", "y_m", "z_m")
HIT_THINNING = 4
"""Every fourth beam of the kept scans is written and drawn."""


class Series:
    """Rows of one kind of measurement in the order of time."""

    def __init__(self, columns: tuple[str, ...]) -> None:
        self.columns = columns
        self._width = len(columns)
        self.rows: list[tuple] = []

    def __len__(self) -> int:
        return len(self.rows)

    def __iter__(self) -> Iterator[tuple]:
        return iter(self.rows)

    def add(self, *values: Any) -> None:
        """Append one row. A row that is not later than the last one is a repetition and is left out."""
        if len(values) != self._width:
            raise ValueError(f"a row has {len(self.columns)} values ({', '.join(self.columns)})")
        if not self.rows or values[0] > self.rows[-1][0]:
            self.rows.append(values)

    def add_simultaneous(self, *values: Any) -> None:
        """Append one row of several that may share a stamp (contacts)."""
        self.rows.append(values)

    def since(self, t_s: float) -> np.ndarray:
        """Return the rows (n, len(columns)) at t_s and later as floats. Their first column is time."""
        first = bisect.bisect_left(self.rows, t_s, key=lambda row: row[0])
        return np.array(self.rows[first:], dtype=float).reshape(-1, len(self.columns))

    def array(self, *names: str) -> np.ndarray:
        """Return the named columns (n, len(names)) as floats."""
        indices = [self.columns.index(name) for name in names]
        return np.array([[row[i] for i in indices] for row in self.rows], dtype=float).reshape(
            -1, len(indices)
        )


@dataclass(frozen=True)
class LoggedScan:
    """A lidar's scan: stamp, ranges (n,), angle of the first beam and between beams."""

    t_s: float
    ranges_m: np.ndarray
    angle_min_rad: float
    angle_increment_rad: float


@dataclass
class FlightLog:
    """All series of a flight. `scans` holds one scan every `scan_period_s`, enough for a picture."""

    scan_period_s: float = 0.25
    truth: Series = field(default_factory=lambda: Series(POSE_COLUMNS))
    odometry: Series = field(default_factory=lambda: Series(POSE_COLUMNS))
    v_ref: Series = field(default_factory=lambda: Series(TWIST_COLUMNS))
    v_safe: Series = field(default_factory=lambda: Series(TWIST_COLUMNS))
    v_final: Series = field(default_factory=lambda: Series(TWIST_COLUMNS))
    decisions: Series = field(default_factory=lambda: Series(DECISION_COLUMNS))
    contacts: Series = field(default_factory=lambda: Series(CONTACT_COLUMNS))
    scans: list[LoggedScan] = field(default_factory=list)

    def series(self) -> dict[str, Series]:
        """Return the series by name."""
        return {name: value for name, value in vars(self).items() if isinstance(value, Series)}

    def add_scan(
        self,
        t_s: float,
        ranges_m: np.ndarray | Sequence[float],
        angle_min_rad: float,
        angle_increment_rad: float,
    ) -> None:
        """Keep this scan if the last one kept is at least `scan_period_s` older."""
        if not self.scans or t_s - self.scans[-1].t_s >= self.scan_period_s - 1e-6:
            ranges = np.asarray(ranges_m, dtype=np.float32)
            self.scans.append(LoggedScan(t_s, ranges, angle_min_rad, angle_increment_rad))

    def between(self, start_s: float, end_s: float) -> np.ndarray:
        """Return the true poses (n, 8: t, position, quaternion xyzw) with start <= t <= end."""
        poses = self.truth.array(*POSE_COLUMNS)
        return poses[(poses[:, 0] >= start_s) & (poses[:, 0] <= end_s)]

    def speeds(self) -> np.ndarray:
        """Return (n, 2) of time and true speed in m/s, by differences over a tenth of a second."""
        poses = self.truth.array("t_s", "x_m", "y_m", "z_m")
        if len(poses) < 2:
            return np.empty((0, 2))
        times = poses[:, 0]
        before, after = (np.searchsorted(times, times + step - 1e-6) for step in (-0.05, 0.05))
        after = np.minimum(after, len(times) - 1)
        steps = np.linalg.norm(poses[after, 1:] - poses[before, 1:], axis=1)
        return np.column_stack((times, steps / np.maximum(times[after] - times[before], 1e-9)))

    def hits(self, lidar_in_body_xyz_m: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return the ends of the kept scans' beams, (n, 4): t, x, y, z in `world`.

        The true pose of a scan's own stamp gives its place. Scans without such a pose are left out.
        """
        poses = self.truth.array(*POSE_COLUMNS)
        found = [np.empty((0, 4))]
        for scan in self.scans:
            index = int(np.searchsorted(poses[:, 0], scan.t_s - 1e-6))
            if index < len(poses) and abs(poses[index, 0] - scan.t_s) < 1e-3:
                found.append(_scan_in_world(scan, poses[index], lidar_in_body_xyz_m))
        return np.concatenate(found)


def _scan_in_world(scan: LoggedScan, pose: np.ndarray, lidar_xyz_m: tuple[float, float, float]) -> np.ndarray:
    finite = np.flatnonzero(np.isfinite(scan.ranges_m))
    angles = scan.angle_min_rad + finite * scan.angle_increment_rad
    ranges = scan.ranges_m[finite].astype(float)
    body = np.column_stack((ranges * np.cos(angles), ranges * np.sin(angles), np.zeros(len(ranges))))
    x, y, z, w = pose[4:8]
    rotation = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
    points = (body + np.array(lidar_xyz_m)) @ rotation.T + pose[1:4]
    return np.column_stack((np.full(len(points), scan.t_s), points))
