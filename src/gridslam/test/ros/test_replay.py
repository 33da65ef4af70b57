"""A bag through gridslam_replay: map, trajectories and timing of a way that is known."""

import dataclasses
import json
import math
import resource
import weakref
from pathlib import Path

import numpy as np
import planar_world
import pytest

from gridslam.files.map_file import read_map
from gridslam.files.tum import read_tum
from gridslam.session import SlamSession

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
replay = pytest.importorskip("gridslam_ros.replay", reason="the workspace is not built, or not sourced")
rospy = pytest.importorskip("rospy")
Odometry = pytest.importorskip("nav_msgs.msg").Odometry
TransformStamped = pytest.importorskip("geometry_msgs.msg").TransformStamped
LaserScan = pytest.importorskip("sensor_msgs.msg").LaserScan
TFMessage = pytest.importorskip("tf2_msgs.msg").TFMessage

START_S = 1_500_000_000.0
LIDAR = planar_world.Lidar(6.2, 180, 20.0, 0.01, 10.0)
FEW = ("particles:=5", "linearUpdate:=0.5", "--angularUpdate:=0.3", "srr:=0.02", "srt:=0.02", "stt:=0.05")


def stamp_of(seconds):
    return rospy.Time.from_sec(START_S + seconds)


def transform(parent, child, stamp, pose, z=0.0):
    edge = TransformStamped(child_frame_id=child)
    edge.header.stamp, edge.header.frame_id = stamp, parent
    t, q = edge.transform.translation, edge.transform.rotation
    t.x, t.y, t.z = (*pose[:2], z)
    q.z, q.w = math.sin(pose[2] / 2), math.cos(pose[2] / 2)
    return edge


def message_of(scan, stamp, angles_rad):
    message = LaserScan(range_min=0.02, range_max=scan.range_max_m, ranges=scan.ranges_m)
    message.header.stamp, message.header.frame_id = stamp, "laser"
    message.angle_min, message.angle_increment = angles_rad[0], angles_rad[1] - angles_rad[0]
    return message


@pytest.fixture(scope="module")
def way():
    route = np.array([(-8.0, -5.0), (0.0, -5.0)])
    return planar_world.drive(planar_world.hold(), planar_world.along(route, 0.2), LIDAR, seed=4)


@pytest.fixture(scope="module")
def bag(way, tmp_path_factory):
    """The way as a bag: TF comes 30 ms after each scan, the lidar's mounting once and for all."""
    path = tmp_path_factory.mktemp("bag") / "way.bag"
    write_bag(path, [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)])
    return path


def write_bag(path, entries, repeat=1):
    """Write (s that the clock is ahead, scan, odometry), in this order, each edge so often."""
    with rosbag.Bag(str(path), "w") as opened:
        mounting = transform("base_link", "laser", rospy.Time(), (0.0, 0.0, 0.0), z=0.2)
        opened.write("/tf_static", TFMessage([mounting]), stamp_of(0.0))
        for index, (ahead_s, scan, odometry) in enumerate(entries):
            stamp, recorded = stamp_of(scan.stamp_s + ahead_s), stamp_of(0.5 * index)
            opened.write("/scan", message_of(scan, stamp, LIDAR.angles_rad), recorded)
            edge = transform("odom", "base_link", stamp, odometry)
            for _ in range(repeat):
                opened.write("/tf", TFMessage([edge]), recorded + rospy.Duration(0.03))


@pytest.fixture(scope="module")
def results(bag):
    assert replay.main([str(bag), *FEW]) == 0
    return bag.parent / "way_slam"


def test_everything_is_written(results):
    assert sorted(path.name for path in results.iterdir()) == [
        "map.pgm",
        "map.png",
        "map.yaml",
        "timing.json",
        "trajectory_final.tum",
        "trajectory_online.tum",
    ]


@pytest.mark.parametrize("name", ["online", "final"])
def test_the_trajectories_are_the_vehicles(results, way, name):
    found = read_tum(results / f"trajectory_{name}.tum")
    index = np.round((found.stamps_s - START_S) / 0.5).astype(int)
    np.testing.assert_allclose(found.stamps_s, START_S + 0.5 * index, atol=1e-5)
    error_m = np.hypot(*(found.poses_in_map - way.truth.poses_in_map[index])[:, :2].T)
    assert error_m.max() < 0.15
    assert len(index) == len(way.scans)


def test_the_map_is_the_holds(results):
    walls = read_map(results / "map.yaml").occupied_xy()
    in_sides = (np.abs(walls[:, 0]) > 14.3) | (np.abs(walls[:, 1]) > 9.3)  # 15 x 10 m, with beams of 0.5 m
    outside = (np.abs(walls[:, 0]) > 15.1) | (np.abs(walls[:, 1]) > 10.1)
    assert len(walls) > 300
    assert in_sides.mean() > 0.98
    assert outside.mean() < 0.02


def test_the_timing_tells_what_was_done(results, way):
    timing = json.loads((results / "timing.json").read_text())
    way_m = np.hypot(*np.diff(way.truth.poses_in_map[:, :2], axis=0).T).sum()
    assert timing["scans_read"] == len(way.scans)
    assert abs(timing["scans_integrated"] - way_m / 0.5) < 4  # linearUpdate
    assert (timing["scans_without_tf"], timing["scans_unusable"], timing["loops_closed"]) == (0, 0, 0)
    assert timing["first_closure_s"] is None
    assert 0.0 < timing["cpu_ms_per_integrated_scan"] <= timing["cpu_s"] * 1e3
    assert timing["parameters"]["particles"] == 5


def test_the_peak_of_the_memory_is_that_of_the_whole_run(bag, tmp_path, monkeypatch):
    # Given a picture of the map that needs more memory than all before it
    write_picture, missing_mb = replay.write_picture, peak_mb() - present_mb() + 50.0

    def wasteful(*given):
        np.ones(int(missing_mb * 2**20 / 8.0))
        write_picture(*given)

    monkeypatch.setattr(replay, "write_picture", wasteful)
    assert replay.main([str(bag), "--output", str(tmp_path), "throttle_scans:=3", *FEW]) == 0
    told_mb = json.loads((tmp_path / "timing.json").read_text())["peak_mb"]
    assert told_mb == pytest.approx(peak_mb(), abs=10.0)


def test_no_map_of_the_filter_is_kept_while_the_files_are_written(bag, tmp_path, monkeypatch):
    filters, write_picture = [], replay.write_picture
    begin = SlamSession._begin

    def begun(session, base):
        slam = begin(session, base)
        filters.append(weakref.ref(slam._map))
        return slam

    def looked_at(*given):
        filters.append(filters[0]())
        write_picture(*given)

    monkeypatch.setattr(SlamSession, "_begin", begun)
    monkeypatch.setattr(replay, "write_picture", looked_at)
    assert replay.main([str(bag), "--output", str(tmp_path), "throttle_scans:=3", *FEW]) == 0
    assert filters[1:] == [None]


def peak_mb():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0


def present_mb():
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 2**20


def test_the_same_again_is_the_same(bag, results, tmp_path):
    assert replay.main([str(bag), "--output", str(tmp_path / "again"), *FEW]) == 0
    for name in ("map.pgm", "trajectory_online.tum", "trajectory_final.tum"):
        assert (tmp_path / "again" / name).read_bytes() == (results / name).read_bytes()


def test_only_every_third_scan(bag, tmp_path, way):
    assert replay.main([str(bag), "--output", str(tmp_path), "throttle_scans:=3", *FEW]) == 0
    assert len(read_tum(tmp_path / "trajectory_online.tum").stamps_s) == len(way.scans) // 3


def test_on_a_starting_map(bag, results, tmp_path, way):
    given = (f"starting_map:={results / 'map.yaml'}", "starting_pose:=-7.9 -5.1 0", "localisation_only:=true")
    assert replay.main([str(bag), "--output", str(tmp_path), *given, *FEW]) == 0
    last = read_tum(tmp_path / "trajectory_online.tum").poses_in_map[-1]
    np.testing.assert_allclose(last[:2], way.truth.poses_in_map[-1, :2], atol=0.15)


def test_after_the_clock_went_back_the_results_are_of_what_follows(way, results, tmp_path, capsys):
    # Given a bag in which the way is run a third, and then anew from its start, its clock set back
    entries = [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)]
    first = [(1000.0, scan, odometry) for _, scan, odometry in entries[: len(entries) // 3]]
    write_bag(tmp_path / "back.bag", [*first, *entries])
    assert replay.main([str(tmp_path / "back.bag"), *FEW]) == 0
    # Then the results are those of the whole way alone, and one warning tells
    for name in ("map.pgm", "trajectory_online.tum", "trajectory_final.tum"):
        assert (tmp_path / "back_slam" / name).read_bytes() == (results / name).read_bytes()
    said = [line for line in capsys.readouterr().err.splitlines() if "gridslam_replay:" in line]
    assert len(said) == 1
    assert f"jumped back by {1000.0 + first[-1][1].stamp_s:.3f} s; mapping starts anew" in said[0]
    assert json.loads((tmp_path / "back_slam/timing.json").read_text())["begun_anew"] == 1


def test_scans_and_tf_out_of_order_are_left_out(way, results, tmp_path, capsys):
    # Given a bag with every fifth pair of scans swapped, all written twice, and a default scan
    entries = [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)]
    for index in range(5, len(entries) - 1, 5):
        entries[index], entries[index + 1] = entries[index + 1], entries[index]
    write_bag(tmp_path / "mixed.bag", [entry for entry in entries for _ in range(2)], repeat=2)
    with rosbag.Bag(str(tmp_path / "mixed.bag"), "a") as opened:
        opened.write("/scan", LaserScan(), stamp_of(3.2))
    assert replay.main([str(tmp_path / "mixed.bag"), *FEW]) == 0
    # Then stamps ascend, each kind of fault is told once and counted, and it is the same way
    online, whole = (
        read_tum(folder / "trajectory_online.tum") for folder in (tmp_path / "mixed_slam", results)
    )
    assert np.all(np.diff(online.stamps_s) > 0.0)
    index = np.searchsorted(whole.stamps_s, online.stamps_s)
    error_m = np.hypot(*(online.poses_in_map - whole.poses_in_map[index])[:, :2].T)
    assert error_m.max() < 0.15
    said = [line for line in capsys.readouterr().err.splitlines() if "gridslam_replay:" in line]
    assert [sum(words in line for line in said) for words in ("A scan is older", "A scan is 15", "TF ")] == [
        2,
        1,
        2,
    ]
    timing = json.loads((tmp_path / "mixed_slam/timing.json").read_text())
    assert timing["scans_read"] == 2 * len(entries) + 1
    assert timing["scans_skipped"] == timing["scans_read"] - len(online.stamps_s)


def test_scans_that_would_make_the_map_absurdly_large_are_left_out(way, tmp_path, capsys):
    # Given ten scans in a row of walls 10,000 km away, two of them due to be integrated at least
    entries = [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)]
    for index in range(10, 20):
        scan = dataclasses.replace(way.scans[index], range_max_m=1e8)
        scan = dataclasses.replace(scan, ranges_m=1e7 + np.arange(len(scan.ranges_m)))
        entries[index] = (0.0, scan, way.odometry[index])
    write_bag(tmp_path / "far.bag", entries)
    assert replay.main([str(tmp_path / "far.bag"), *FEW]) == 0
    # Then the way is mapped without them, and one sentence tells
    timing = json.loads((tmp_path / "far_slam/timing.json").read_text())
    assert 2 <= timing["scans_unusable"] <= 10
    assert capsys.readouterr().err.count("The map would grow to") == 2  # at once, and counted at the end
    final = read_tum(tmp_path / "far_slam/trajectory_final.tum")
    assert np.hypot(*(final.poses_in_map[-1] - way.truth.poses_in_map[-1])[:2]) < 0.15


def test_where_odometry_begins_anew_the_final_path_is_the_vehicles(tmp_path):
    """Given 0.8 m from scan to scan, when odometry begins anew at the 13th, nobody tells that step."""
    truth = planar_world.along(np.array([(-9.0, -5.0), (9.0, -5.0)]), 0.8)
    log = planar_world.drive(
        planar_world.hold(), truth, LIDAR, 4, planar_world.Drift(0.0, 0.0, 0.0, 0.0, 0.0)
    )
    odometry = np.where(np.arange(len(truth))[:, None] < 13, truth, truth - truth[13])
    write_bag(tmp_path / "anew.bag", [(0.0, *each) for each in zip(log.scans, odometry)])
    words = [str(tmp_path / "anew.bag"), "linearUpdate:=3.0", "loop_closure:=false"]
    assert replay.main(words) == 0
    for name in ("final", "online"):
        found = read_tum(tmp_path / f"anew_slam/trajectory_{name}.tum")
        error_m = np.hypot(*(found.poses_in_map - truth)[:, :2].T)
        assert error_m.max() < 0.1, name


def test_constant_scans_are_left_out_with_one_sentence(way, tmp_path, capsys):
    entries = [(0.0, scan, odometry) for scan, odometry in zip(way.scans, way.odometry)]
    for index in range(10):
        scan = dataclasses.replace(way.scans[index], ranges_m=np.full_like(way.scans[index].ranges_m, 4.0))
        entries[index] = (0.0, scan, way.odometry[index])
    write_bag(tmp_path / "constant.bag", entries)
    assert replay.main([str(tmp_path / "constant.bag"), *FEW]) == 0
    assert json.loads((tmp_path / "constant_slam/timing.json").read_text())["scans_unusable"] == 10
    assert capsys.readouterr().err.count("tell the same range, 4 m") == 2  # at once, and counted at the end


def test_with_odometry_covariance_each_scan_counts_with_that_of_its_stamp(way, tmp_path, monkeypatch):
    # Given odometry 0.1 s after the scans, whose variances grow by 1, 2 and 3 each, but for the last scan
    count = len(way.scans) // 3
    write_bag(tmp_path / "way.bag", [(0.0, *pair) for pair in zip(way.scans[:count], way.odometry)])
    with rosbag.Bag(str(tmp_path / "way.bag"), "a") as opened:
        for index, scan in enumerate(way.scans[: count - 1]):
            message = Odometry()
            message.header.stamp = stamp_of(scan.stamp_s)
            message.pose.covariance = np.diag(
                [index + 1.0, 2.0 * index + 2.0, 9, 9, 9, 3.0 * index + 3.0]
            ).ravel()
            opened.write("/UAV/odometry", message, stamp_of(0.5 * index + 0.1))
    told = []
    process = SlamSession.process
    monkeypatch.setattr(SlamSession, "process", lambda *given: told.append(given[3]) or process(*given))
    words = ("odometry_covariance:=true", "--odometry", "/UAV/odometry")
    assert replay.main([str(tmp_path / "way.bag"), *words, *FEW]) == 0
    expected = [np.diag([1.0, 2.0, 3.0]) * (index + 1) for index in range(count - 1)]
    np.testing.assert_array_equal(told[:-1], expected)
    assert told[-1] is None


@pytest.mark.parametrize(
    ("words", "answer"),
    [
        (
            ["BAG", "odometry_covariance:=true"],
            "no odometry on /odometry. It holds no nav_msgs/Odometry at all.",
        ),
        (["BAG", "clouds:=true"], "no clouds on /cloud"),
        (["BAG", "partcles:=5"], "no parameter partcles"),
        (["BAG", "particles:=0"], "particles must be at least 1"),
        (["BAG", "particles:=["], "particles:=[ cannot be read"),
        (["BAG", "--scan", "/front"], "It has scans on /scan."),
        (["BAG", "base_frame:=robot"], "base_frame:=..."),
        (["BAG", "starting_map:=/nothing.yaml"], "/nothing.yaml cannot be read"),
        (["/nothing.bag"], "/nothing.bag cannot be opened"),
        (["BAG", "--volume", "map.bt"], "no clouds on /cloud"),
        (["BAG", "--volume", "map.stl"], "map.stl: a map of voxels is a file .bt or .ot"),
        (["BAG", "--volume", "/nothing/map.bt"], "/nothing/map.bt: cannot be written"),
        (["BAG", "--volume", "map.bt", "--resolution", "0"], "resolution"),
    ],
)
def test_what_cannot_be_done_is_one_sentence(bag, capsys, tmp_path, words, answer):
    words = [str(bag) if word == "BAG" else word for word in words]
    assert replay.main([*words, "--output", str(tmp_path / "none")]) == 1
    said = capsys.readouterr().err
    assert answer in said
    assert "Traceback" not in said
    assert not (tmp_path / "none").exists()


def test_a_damaged_bag_is_one_sentence(bag, tmp_path, capsys):
    content = bytearray(bag.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 3000] = b"\xff" * 3000
    (tmp_path / "damaged.bag").write_bytes(content)
    assert replay.main([str(tmp_path / "damaged.bag"), *FEW]) == 1
    said = [line for line in capsys.readouterr().err.splitlines() if "gridslam_replay:" in line]
    assert f"The bag {tmp_path}/damaged.bag is damaged" in said[-1]
    assert not (tmp_path / "damaged_slam").exists()


@pytest.mark.parametrize("where", [4, 20, 120])  # its first line, its header, its first chunk
def test_a_bag_that_begins_with_nonsense_is_one_sentence(bag, tmp_path, capsys, where):
    content = bytearray(bag.read_bytes())
    content[where : where + 8] = b"\x98\xff" * 4
    (tmp_path / "odd.bag").write_bytes(content)
    assert replay.main([str(tmp_path / "odd.bag"), *FEW]) in (0, 1)
    said = capsys.readouterr().err
    assert "Traceback" not in said


@pytest.mark.parametrize("folder", ["/proc/none", "BAG/inside"])
def test_where_nothing_can_be_written_is_told_before_the_run(bag, capsys, monkeypatch, folder):
    monkeypatch.setattr(replay, "warm_up", lambda: pytest.fail("it ran"))
    assert replay.main([str(bag), "--output", folder.replace("BAG", str(bag))]) == 1
    assert "The results cannot be written to" in capsys.readouterr().err


def test_parameters_and_other_words():
    given, rest = replay.split_parameters(
        ["a.bag", "--particles:=60", "_delta:=0.1", "map_frame:=m", "--scan", "/s"]
    )
    assert given == {"particles": 60, "delta": 0.1, "map_frame": "m"}
    assert rest == ["a.bag", "--scan", "/s"]
