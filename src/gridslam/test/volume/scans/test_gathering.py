"""Scans of a nodding lidar become clouds: their points stay where they are, and the clouds end in time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from gridslam.volume import PlacedCloud, Pose, ScanGathering, points_of_scan

STILL = Pose.identity()


def scan(stamp_s, rotation=(0.0, 0.0, 0.0), place=(0.0, 0.0, 0.0), points=((2.0, 0.0, 0.0), (0.0, 3.0, 0.0))):
    sensor = Pose(Rotation.from_rotvec(rotation).as_matrix(), np.array(place))
    return PlacedCloud(stamp_s, np.array(points, np.float32), sensor, STILL)


def gathered(scans, resolution_m=0.1):
    """All clouds of scans."""
    gathering = ScanGathering(resolution_m)
    clouds = [gathering.add(each) for each in scans]
    return [cloud for cloud in [*clouds, gathering.take()] if cloud is not None]


def in_odom(clouds):
    return np.concatenate([cloud.sensor_in_odom.of_points(cloud.points) for cloud in clouds])


def test_points_stay_where_they_are_in_odom():
    scans = [scan(5.0 + 0.025 * k, (0.0, 0.02 * k, 0.01), (0.001 * k, 0.0, 0.0)) for k in range(30)]
    clouds = gathered(scans)
    assert [cloud.stamp_s for cloud in clouds] == [5.0]
    np.testing.assert_allclose(in_odom(clouds), in_odom(scans), atol=1e-6)


def test_a_cloud_ends_after_a_second():
    stamps = [cloud.stamp_s for cloud in gathered([scan(k / 8) for k in range(20)])]
    assert stamps == [0.0, 1.0, 2.0]


def test_a_cloud_ends_before_its_rays_would_begin_in_another_voxel():
    clouds = gathered([scan(k / 64, place=(k / 64, 0.0, 0.0)) for k in range(11)])  # at 1 m/s
    assert [cloud.stamp_s for cloud in clouds] == [0.0, 5 / 64, 10 / 64]  # 0.078 m is above 0.75 voxels


def test_a_clock_that_goes_back_ends_a_cloud():
    assert [cloud.stamp_s for cloud in gathered([scan(9.0), scan(9.1), scan(3.0)])] == [9.0, 3.0]


def test_beams_without_return_stay_free_when_they_are_gathered():
    free = points_of_scan(np.full(90, np.inf), (0.0, 0.07), (0.1, 10.0), 10.0)
    (cloud,) = gathered([scan(0.0, points=free), scan(0.1, place=(0.07, 0.0, 0.0), points=free)])
    lengths = np.linalg.norm(cloud.points, axis=1)
    assert (lengths > 10.0).all()  # or the map would hold their ends


def test_nothing_gathered_is_no_cloud():
    gathering = ScanGathering(0.1)
    assert gathering.take() is None
    gathering.add(scan(1.0))
    assert len(gathering.take().points) == 2
    assert gathering.take() is None


@pytest.mark.table("resolution_m", [0.05, 0.2])
def test_coarser_voxels_allow_a_longer_way(resolution_m):
    way_m = 0.75 * resolution_m
    assert len(gathered([scan(0.0), scan(0.1, place=(0.0, way_m - 1e-6, 0.0))], resolution_m)) == 1
    assert len(gathered([scan(0.0), scan(0.1, place=(0.0, way_m + 1e-6, 0.0))], resolution_m)) == 2
