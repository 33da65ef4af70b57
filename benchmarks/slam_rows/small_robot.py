"""A small robot in rooms of a few metres: a lidar of 5.6 m, turns of 186 degrees/s, gaps of 5 s.

    python -m benchmarks.slam_rows.small_robot small_robot 1        seed 1

prints metrics as JSON; see `driven`. Keys that end in `_without_time` are of a driver that leaves
`time_increment` 0, so that turns skew the scans. The tests' `small_robot` makes truth, scans and odometry.
"""

from __future__ import annotations

import json
import sys

from benchmarks.shared.results import ROOT
from benchmarks.slam_rows.driven import driven


def main() -> None:
    """Drive once, and print."""
    sys.path.insert(0, str(ROOT / "src/gridslam/test"))
    from small_robot import small_robot  # type: ignore[import-not-found]

    seed = int(sys.argv[2])
    told, skewed = (driven(small_robot(seed, tells_time=tells)[0], seed) for tells in (True, False))
    without = {f"{name}_without_time": skewed[name] for name in ("lost_share", "tracking_wrong_share")}
    without["final_error_max_m_without_time"] = skewed["final_error_max_m"]
    print(json.dumps({**told, **without}))


if __name__ == "__main__":
    main()
