"""A wheel slips in a turn that no scan spans: twice round a hall, seen with a lidar of 100 degrees.

    python -m benchmarks.slam_rows.slipped_step slipped_step 1        seed 1

prints metrics as JSON; see `driven`. Truth, scans and odometry are made here. At one corner odometry misses
19 degrees of the turn.
"""

from __future__ import annotations

import dataclasses
import json
import math
import sys
from typing import Any

import numpy as np

from benchmarks.shared.results import ROOT
from benchmarks.slam_rows.driven import driven
from gridslam import se2

SLIP_RAD = math.radians(-19.0)
STEP_M = 0.5


def slipped(seed: int) -> Any:
    """Return the log of a seed."""
    from planar_world import Lidar, along, drive, rectangle_route, scattered_boxes

    truth = along(rectangle_route(12.0, 7.0, 0.5, laps=2.0), STEP_M, turn_rad=2.0)
    lidar = Lidar(math.radians(100.0), 91, 8.0, 0.01, 10.0)
    log = drive(scattered_boxes(seed, truth), truth, lidar, seed=seed)
    turns = np.flatnonzero(np.abs(se2.between(truth[:-1], truth[1:])[:, 2]) > 1.0) + 1
    corner = int(turns[2])
    slip, odometry = np.array((0.0, 0.0, SLIP_RAD)), log.odometry
    after = se2.compose(slip, se2.between(odometry[corner], odometry[corner:]))
    bent = np.vstack([odometry[:corner], se2.compose(odometry[corner], after)])
    return dataclasses.replace(log, odometry=bent)


def main() -> None:
    """Drive once, and print."""
    sys.path.insert(0, str(ROOT / "src/gridslam/test"))
    seed = int(sys.argv[2])
    print(json.dumps(driven(slipped(seed), seed)))


if __name__ == "__main__":
    main()
