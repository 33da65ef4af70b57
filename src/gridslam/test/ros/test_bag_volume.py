"""The map of voxels that gridslam_replay makes of a bag's clouds, on a way that is known."""

import json

import numpy as np
import pytest
from scipy.spatial import cKDTree

from gridslam import se2
from gridslam.filter.grid_slam import GridSlam
from gridslam.volume import read_octree
from gridslam.volume.drawing.centres import occupied_centres

replay = pytest.importorskip("gridslam_ros.replay", reason="the workspace is not built, or not sourced")
rosbag = pytest.importorskip("rosbag", reason="needs ROS")
test_replay = pytest.importorskip("test_replay")
PointCloud2 = pytest.importorskip("sensor_msgs.msg").PointCloud2
Header = pytest.importorskip("std_msgs.msg").Header
messages = pytest.importorskip("gridslam_ros.volume.messages")

HEIGHTS_M = (-0.1, 0.0, 0.4)
"""Of a cloud's points, above the lidar, which is 0.2 m above the base."""
way = test_replay.way


def wall_points(scan):
    """Where beams ended, in the lidar's plane (n, 2)."""
    angles = test_replay.LIDAR.angles_rad
    met = np.isfinite(scan.ranges_m) & (scan.ranges_m < scan.range_max_m)
    return (scan.ranges_m[:, None] * np.column_stack((np.cos(angles), np.sin(angles))))[met]


@pytest.fixture(scope="module")
def bag(way, tmp_path_factory):
    """The way with a cloud at each scan: its beams' ends, at several heights."""
    path = tmp_path_factory.mktemp("clouds") / "way.bag"
    test_replay.write_bag(path, [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)])
    with rosbag.Bag(str(path), "a") as opened:
        for scan in way.scans:
            flat = wall_points(scan)
            points = np.concatenate([np.column_stack((flat, np.full(len(flat), z))) for z in HEIGHTS_M])
            stamp = test_replay.stamp_of(scan.stamp_s)
            opened.write("/cloud", messages.cloud_of(points, Header(stamp=stamp, frame_id="laser")), stamp)
    return path


def errors_m(path, way, poses):
    """Distances of the map's occupied voxels from where beams ended, given poses of the base."""
    ends = [se2.transform(tuple(pose), wall_points(scan)) for pose, scan in zip(poses, way.scans)]
    centres = occupied_centres(read_octree(path))
    return centres, cKDTree(np.concatenate(ends)).query(centres[:, :2])[0]


@pytest.mark.parametrize("ending", ["bt", "ot"])
def test_the_voxels_lie_along_the_corrected_path(bag, way, tmp_path, ending):
    target = tmp_path / f"map.{ending}"
    words = (str(bag), *test_replay.FEW, "--output", str(tmp_path / "slam"), "--volume", str(target))
    assert replay.main(list(words)) == 0
    centres, errors = errors_m(target, way, way.truth.poses_in_map)
    assert sorted(set(np.round(centres[:, 2], 6))) == [0.15, 0.25, 0.65]
    assert np.percentile(errors, 95) < 0.15
    _, along_odometry = errors_m(target, way, way.odometry)
    assert errors.mean() < along_odometry.mean()
    told = json.loads((tmp_path / "slam" / "timing.json").read_text())["volume"]
    assert 0 < told["clouds_integrated"] <= told["clouds_read"] == len(way.scans)


def test_loops_are_closed_by_the_clouds_too(bag, way, tmp_path, monkeypatch):
    kept, add = [], GridSlam.add_cloud
    monkeypatch.setattr(GridSlam, "add_cloud", lambda slam, cloud: kept.append(cloud) or add(slam, cloud))
    target = tmp_path / "map.bt"
    words = (str(bag), *test_replay.FEW, "clouds:=true", "--output", str(tmp_path / "slam"))
    assert replay.main([*words, "--volume", str(target)]) == 0
    told = json.loads((tmp_path / "slam" / "timing.json").read_text())
    assert len(kept) == told["scans_integrated"]
    assert np.unique(kept[0].points_m[:, 2].round(2)).tolist() == [0.1, 0.2, 0.6]
    _, errors = errors_m(target, way, way.truth.poses_in_map)
    assert np.percentile(errors, 95) < 0.15


def test_clouds_without_tf_are_one_sentence(bag, way, tmp_path, capsys):
    path = tmp_path / "lost.bag"
    test_replay.write_bag(path, [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)])
    with rosbag.Bag(str(path), "a") as opened:
        cloud = messages.cloud_of(
            np.ones((5, 3)), Header(stamp=test_replay.stamp_of(1.0), frame_id="nowhere")
        )
        opened.write("/cloud", cloud, test_replay.stamp_of(1.0))
    words = (str(path), *test_replay.FEW, "--output", str(tmp_path / "slam"))
    assert replay.main([*words, "--volume", str(tmp_path / "map.bt")]) == 1
    assert "None of the 1 clouds on /cloud could be used: 1 are without TF" in capsys.readouterr().err
    assert not (tmp_path / "map.bt").exists()
