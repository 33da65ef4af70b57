"""`lidar_odometry` with scans and nothing else: a robot that drives, and turns on the spot at full speed.

    python -m benchmarks.slam_rows.no_imu no_imu 1      seed 1

prints metrics as JSON: greatest errors of the path (m and degrees), the share of scans that a remark says do
not match, and CPU time a scan. Truth and scans are made here. The keys that begin with `clouds_` are of
clouds alone: a lidar of 16 rings flies through a room, and turns by up to 126 degrees/s to both sides.
"""

from __future__ import annotations

import json
import math
import sys
import time

import numpy as np

from benchmarks.shared.results import ROOT
from gridslam import se2
from gridslam.cloud_odometry import CloudOdometry
from gridslam.odometry import LidarOdometry
from gridslam.odometry.warm_up import warm_up_odometry

PERIOD_S, SPEED_MPS, TURN_RADPS = 0.1, 0.4, math.radians(186.0)
CLOUDS = 320
ROUTE_M = np.array([(-8.0, -5.0), (4.0, -5.0), (4.0, 3.0), (-6.0, 3.0), (-6.0, -2.0), (2.0, -2.0)])
AT_BASE = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))


def main() -> None:
    """Drive once, and print."""
    sys.path.insert(0, str(ROOT / "src/gridslam/test"))
    from planar_world import UST, along, scan_at, scattered_boxes

    seed = int(sys.argv[2])
    rng = np.random.default_rng(seed)
    truth = along(ROUTE_M, SPEED_MPS * PERIOD_S, TURN_RADPS * PERIOD_S)
    walls = scattered_boxes(seed, truth)
    odometry = LidarOdometry(start=truth[0])
    warm_up_odometry()
    angles = float(UST.angles_rad[0]), float(UST.angles_rad[1] - UST.angles_rad[0])
    found, unmatched, cpu_s = [], 0, 0.0
    for index, pose in enumerate(truth):
        ranges_m, began_s = scan_at(walls, pose, UST, rng).ranges_m, time.process_time()
        estimate = odometry.on_scan(PERIOD_S * index, ranges_m, angles, (0.05, UST.range_m), AT_BASE)
        cpu_s += time.process_time() - began_s
        found.append((*estimate.position_xyz[:2], estimate.roll_pitch_yaw[2]))
        unmatched += "does not match" in estimate.remark
    error = np.array(found) - truth
    metrics = {
        "error_max_m": float(np.hypot(error[:, 0], error[:, 1]).max()),
        "turn_error_max_deg": float(np.degrees(np.abs(se2.wrap(error[:, 2])).max())),
        "unmatched_share": unmatched / len(truth),
        "cpu_ms_per_scan": 1e3 * cpu_s / len(truth),
    }
    print(json.dumps({**metrics, **by_clouds(seed)}))


def by_clouds(seed: int) -> dict[str, float]:
    """Return the metrics of clouds alone."""
    from puck_in_a_room import LEVEL, cloud, heading, place_at  # type: ignore[import-not-found]

    rng, start = np.random.default_rng(seed), place_at(0.0)
    odometry, off, unmatched = CloudOdometry(start=(*start[:2], 0.0)), [], 0
    for index in range(CLOUDS):
        time_s = PERIOD_S * index
        place = place_at(time_s - 0.5)
        yaw = 2.0 * (1.0 - math.cos(1.1 * max(time_s - 1.5, 0.0)))
        estimate = odometry.on_cloud(time_s, cloud(place, heading(yaw), rng), LEVEL)
        turn_error = math.remainder(estimate.roll_pitch_yaw[2] - yaw, 2.0 * math.pi)
        off.append((math.dist(estimate.position_xyz[:2], place[:2]), abs(turn_error)))
        unmatched += "does not match" in estimate.remark
    error_m, error_rad = np.max(off, axis=0)
    return {
        "clouds_error_max_m": float(error_m),
        "clouds_turn_error_max_deg": math.degrees(error_rad),
        "clouds_unmatched_share": unmatched / CLOUDS,
    }


if __name__ == "__main__":
    main()
