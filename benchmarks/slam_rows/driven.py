"""Drives through simulated places with SLAM, and sets its state beside the true error."""

from __future__ import annotations

import time
from typing import Any

import numpy as np

from gridslam import SlamParameters, se2
from gridslam.session import SlamSession
from gridslam.warm_up import warm_up

WRONG_M = 0.5
"""m: a pose that is off by more should not be called `tracking`."""


def driven(log: Any, seed: int) -> dict[str, float]:
    """Return the metrics of SLAM with its defaults on a log: scans, odometry (k, 3) at each, and the truth.

    `lost_share`, `uncertain_share` and `drifting_share` are of all scans. `tracking_wrong_share` is of all
    scans, too: the state is `tracking`, and the pose is off by more than WRONG_M. `final_error_max_m` is of
    the corrected path.
    """
    truth, said = log.truth.poses_in_map, list[str]()
    start = tuple(truth[0].tolist())
    session = SlamSession(SlamParameters(seed=seed, threads=1), starting_pose=start, say=said.append)
    warm_up()
    states, online, began_s = [], [], time.process_time()
    for scan, base in zip(log.scans, log.odometry):
        session.process(scan, base)
        states.append("" if session.tracking is None else session.tracking.state)
        online.append(se2.compose(np.array(session.map_to_odom), base))
    session.finish()
    cpu_s = time.process_time() - began_s
    errors_m = np.hypot(*(np.array(online) - truth)[:, :2].T)
    path = session.trajectory()
    at_nodes = truth[np.searchsorted(log.truth.stamps_s, path.stamps_s)]
    final_m = np.hypot(*(path.poses_in_map - at_nodes)[:, :2].T)
    state = np.array(states)
    return {
        "lost_share": float(np.mean(state == "lost")),
        "uncertain_share": float(np.mean(state == "uncertain")),
        "drifting_share": float(np.mean(state == "drifting")),
        "tracking_wrong_share": float(np.mean((state == "tracking") & (errors_m > WRONG_M))),
        "error_max_m": float(errors_m.max()),
        "final_error_max_m": float(final_m.max()),
        "odometry_error_max_m": float(np.hypot(*(log.odometry - truth)[:, :2].T).max()),
        "closures": len(session.closures),
        "cpu_ms_per_node": 1e3 * cpu_s / len(path.stamps_s),
    }
