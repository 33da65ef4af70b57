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


# -- clouds as drivers and other SLAMs send them ------------------------------------------------------------

HALF_M = np.array((20.0, 10.0, 4.0))
"""Of a hall about the origin, in which the lidar sees up to 8 m."""
REACH_M = 8.0


def in_the_hall(places, ways):
    """Distances (n,) from places (n, 3) along ways (n, 3) to the hall's walls."""
    with np.errstate(divide="ignore"):
        return np.where(ways != 0, (np.sign(ways) * HALF_M - places) / ways, np.inf).min(axis=1)


def off_the_walls(path):
    """Distances of the map's occupied voxels from the hall's walls, m."""
    centres = occupied_centres(read_octree(path))
    return np.abs(HALF_M - np.abs(centres)).min(axis=1)


def hall_bag(path, cloud_of, frame="laser", rate_rad_s=0.0):
    """A level way of 3 s through the hall, 5 m beside its wall, with scans and with what cloud_of makes.

    cloud_of: (pose of the lidar at a time, the stamp) -> points (n, 3), or an array with more fields.
    """

    def pose_at(seconds):
        return np.array((-3.0 + seconds, 5.0, 0.2)), 1e-3 * seconds + rate_rad_s * seconds

    step = 2.0 * np.pi / 360
    with rosbag.Bag(str(path), "w") as opened:
        mounting = test_replay.transform(
            "base_link", "laser", test_replay.stamp_of(0.0), (0.0, 0.0, 0.0), z=0.2
        )
        opened.write("/tf_static", test_replay.TFMessage([mounting]), test_replay.stamp_of(0.0))
        for tick in range(320):
            (x, y, _), yaw = pose_at(0.01 * tick)
            stamp = test_replay.stamp_of(0.01 * tick)
            edge = test_replay.transform("odom", "base_link", stamp, (x, y, yaw))
            opened.write("/tf", test_replay.TFMessage([edge]), stamp)
            if tick % 10 or tick > 300 or not tick:
                continue
            place, yaw = pose_at(0.01 * tick)
            angles = yaw + step * np.arange(360)
            level = np.column_stack((np.cos(angles), np.sin(angles), np.zeros(360)))
            ranges = in_the_hall(place, level)
            scan = test_replay.LaserScan(angle_increment=step, angle_max=359 * step, ranges=ranges)
            scan.range_min, scan.range_max = 0.1, 60.0
            scan.header.stamp, scan.header.frame_id = stamp, "laser"
            opened.write("/scan", scan, stamp)
            cloud = cloud_of(pose_at, 0.01 * tick)
            opened.write("/cloud", as_message(cloud, Header(stamp=stamp, frame_id=frame)), stamp)


def as_message(rows, header):
    """Points (n, 3), or a structured array, as a message."""
    if rows.dtype.names is None:
        return messages.cloud_of(rows, header)
    kinds = {"<f4": 7, "<u4": 6, "<f8": 8}
    fields = [
        messages.PointField(name, rows.dtype.fields[name][1], kinds[rows.dtype[name].str], 1)
        for name in rows.dtype.names
    ]
    size = rows.dtype.itemsize
    cloud = PointCloud2(header=header, height=1, width=len(rows), fields=fields, point_step=size)
    cloud.row_step, cloud.data, cloud.is_dense = size * len(rows), rows.tobytes(), True
    return cloud


RINGS = np.radians(np.arange(-15.0, 16.0, 2.0))
COLUMNS = np.linspace(0.0, -2.0 * np.pi, 300, endpoint=False)
AZIMUTHS, ELEVATIONS = np.repeat(COLUMNS, len(RINGS)), np.tile(RINGS, len(COLUMNS))


def ways_of(yaw):
    """Directions (n, 3) of the beams; yaw: of the lidar, at all of them or at each."""
    level = np.cos(ELEVATIONS)
    return np.column_stack(
        (level * np.cos(AZIMUTHS + yaw), level * np.sin(AZIMUTHS + yaw), np.sin(ELEVATIONS))
    )


def volume_of(path, tmp_path, *words):
    target = tmp_path / "hall.bt"
    few = (*test_replay.FEW, "loop_closure:=false", "--output", str(tmp_path / "slam"))
    return replay.main([str(path), *few, "--volume", str(target), *words]), target


def test_points_at_the_far_value_are_no_walls(tmp_path, capsys):
    rng = np.random.default_rng(2)

    def cloud_of(pose_at, seconds):
        place, yaw = pose_at(seconds)
        ranges = in_the_hall(place, ways_of(yaw)) + rng.normal(0.0, 0.01, len(AZIMUTHS))
        return ways_of(0.0) * np.minimum(ranges, REACH_M)[:, None]

    hall_bag(tmp_path / "far.bag", cloud_of)
    code, target = volume_of(tmp_path / "far.bag", tmp_path)
    assert code == 0
    off_m = off_the_walls(target)
    assert len(off_m) > 100
    assert off_m.max() < 0.2
    assert "8 m" in capsys.readouterr().err


TIMES = {
    "velodyne, to the stamp": ("time", "<f4", 1.0, -0.1),
    "velodyne, from the stamp": ("time", "<f4", 1.0, 0.0),
    "ouster": ("t", "<u4", 1e9, 0.0),
    "hesai": ("timestamp", "<f8", 1.0, test_replay.START_S),
}


@pytest.mark.parametrize("maker", TIMES)
def test_points_with_times_lie_where_they_were_measured(maker, tmp_path):
    """The lidar turns by 0.1 rad in a sweep: at 8 m that is 0.8 m."""
    field, kind, per_s, begin_s = TIMES[maker]

    def cloud_of(pose_at, seconds):
        when = np.repeat(np.linspace(0.0, 0.1, len(COLUMNS)), len(RINGS)) + min(begin_s, 0.0)
        places, yaws = zip(*(pose_at(seconds + each) for each in when))
        ends = ways_of(0.0) * in_the_hall(np.array(places), ways_of(np.array(yaws)))[:, None]
        rows = np.zeros(len(ends), [("x", "<f4"), ("y", "<f4"), ("z", "<f4"), (field, kind)])
        rows["x"], rows["y"], rows["z"] = ends.T
        rows[field] = np.round((when + (begin_s + seconds if begin_s > 1.0 else 0.0)) * per_s, 9)
        return rows

    hall_bag(tmp_path / "swept.bag", cloud_of, rate_rad_s=1.0)
    code, target = volume_of(tmp_path / "swept.bag", tmp_path)
    assert code == 0
    assert np.percentile(off_the_walls(target), 99) < 0.15


def registered(pose_at, seconds):
    """A cloud in the frame of odometry, as many SLAMs publish it."""
    place, yaw = pose_at(seconds)
    return place + ways_of(yaw) * in_the_hall(place, ways_of(yaw))[:, None]


def test_clouds_in_a_fixed_frame_are_refused_in_a_sentence(tmp_path, capsys):
    hall_bag(tmp_path / "fixed.bag", registered, "odom")
    code, target = volume_of(tmp_path / "fixed.bag", tmp_path)
    assert code == 1
    assert not target.exists()
    assert '"odom" does not move with "base_link"' in capsys.readouterr().err


def test_clouds_in_a_fixed_frame_are_mapped_from_where_their_lidar_was(tmp_path):
    own = {}
    for name, cloud_of, frame, words in (
        ("fixed", registered, "odom", ("--sensor-frame", "laser")),
        ("own", lambda at, s: ways_of(0.0) * in_the_hall(at(s)[0], ways_of(at(s)[1]))[:, None], "laser", ()),
    ):
        hall_bag(tmp_path / f"{name}.bag", cloud_of, frame)
        code, target = volume_of(tmp_path / f"{name}.bag", tmp_path, *words)
        assert code == 0
        own[name] = {tuple(each) for each in np.round(occupied_centres(read_octree(target)), 3).tolist()}
    assert len(own["fixed"] ^ own["own"]) < 0.02 * len(own["own"])  # those on a voxel's edge
