"""The Intel Research Lab's log, judged by hand-verified relations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from gridslam import GridSlam, PlanarScan, SlamParameters
from gridslam.evaluation.relations import read_relations, relation_errors
from gridslam.logs.carmen import CarmenScan, read_log
from gridslam.trajectory import Trajectory

DATA = Path(__file__).resolve().parents[4] / "shared/data"
MEAN_MAX_M = 0.036
"""Of 40 runs that differ in seed and starting pose the means were 0.015 to 0.033 m, two above 0.026 m."""


@pytest.mark.skipif(not (DATA / "intel_dense.log.gz").exists(), reason=f"needs the Intel log in {DATA}")
def test_the_path_agrees_with_the_relations():
    slam = GridSlam(SlamParameters(maxUrange=40.0, seed=1))
    stamps, odometry = [], []
    for entry in read_log(DATA / "intel_dense.log.gz"):
        if not isinstance(entry, CarmenScan) or (stamps and entry.stamp_s <= stamps[-1]):
            continue
        angles = entry.angle_min_rad + np.arange(entry.ranges_m.size) * entry.angle_increment_rad
        scan = PlanarScan(entry.stamp_s, angles, entry.ranges_m, (0.0, 0.0, 0.0), entry.range_max_m)
        slam.process(scan, entry.robot_in_odom)
        stamps.append(entry.stamp_s)
        odometry.append(entry.robot_in_odom)
    stamps, odometry = np.array(stamps), np.array(odometry)
    relations = read_relations(DATA / "intel.relations.gz").exact(stamps)
    path = Trajectory(stamps, slam.trajectory().filled(stamps, odometry))
    assert len(relations) > 50
    assert relation_errors(path, relations).translation_mean_m <= MEAN_MAX_M
