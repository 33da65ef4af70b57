"""Bags that lack something, or tell it wrong: mapped as if it were right, or refused in one sentence."""

import dataclasses
import io

import numpy as np
import planar_world
import pytest

from gridslam import se2
from gridslam.files.tum import read_tum

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
replay = pytest.importorskip("gridslam_ros.replay", reason="the workspace is not built, or not sourced")
carmen_bags = pytest.importorskip("gridslam_ros.carmen_bags")
rospy = pytest.importorskip("rospy")
TFMessage = pytest.importorskip("tf2_msgs.msg").TFMessage
LaserScan = pytest.importorskip("sensor_msgs.msg").LaserScan
String = pytest.importorskip("std_msgs.msg").String
from test_replay import LIDAR, START_S, message_of, stamp_of, transform  # noqa: E402

FEW = ("particles:=5", "linearUpdate:=0.5", "angularUpdate:=0.3", "loop_closure:=false")
ROUTE = np.array([(-8.0, -5.0), (-4.0, -5.0), (-4.0, -1.0), (-7.0, -1.0)])


@pytest.fixture(scope="module")
def way():
    return planar_world.drive(planar_world.hold(), planar_world.along(ROUTE, 0.25), LIDAR, seed=4)


START, IN_MM = np.array((-8.0, -5.0, 0.0)), np.array((1e3, 1e3, 1.0))


def mounting(parent="base_link", upside_down=False, turned_rad=0.0):
    edge = transform(parent, "laser", rospy.Time(), (0.0, 0.0, turned_rad), z=0.2)
    if upside_down:
        edge.transform.rotation.x, edge.transform.rotation.w = 1.0, 0.0
    return edge


def as_it_is(index, stamp, base):
    return [transform("odom", "base_link", stamp, base)]


def from_elsewhere(stamp, base):
    """The same base in a frame of its own, as by a simulator's truth."""
    return transform("world", "base_link", stamp, (*base[:2] + 5.0, 0.4))


def without(index, stamp, base):
    return []


def write(
    path, way, static=(), edges=as_it_is, scans=None, order=None, stamps=stamp_of, changed=None, scan_of=None
):
    """Write a bag: a static edge at most, and scans with ``edges(index, stamp, base)``, in an order.

    changed: changes each scan's message. scan_of: returns another message in its place.
    """
    with rosbag.Bag(str(path), "w") as opened:
        for edge in static:
            opened.write("/tf_static", TFMessage([edge]), stamp_of(0.0))
        for place, index in enumerate(range(len(way.scans)) if order is None else order):
            scan = way.scans[index] if scans is None else scans[index]
            stamp, recorded = stamps(scan.stamp_s), stamp_of(0.5 * place)
            message = message_of(scan, stamp, LIDAR.angles_rad)
            if changed is not None:
                changed(message)
            if scan_of is not None:
                message = scan_of(message)
                opened._topic_connections.pop("/scan", None)  # as if each came from a publisher of its own
            opened.write("/scan", message, recorded)
            for edge in edges(index, stamp, way.odometry[index]):
                opened.write("/tf", TFMessage([edge]), recorded)
    return str(path)


def refused(bag, capsys):
    """Replay a bag that cannot be mapped; return the sentence."""
    assert replay.main([bag, *FEW]) == 1
    said = capsys.readouterr().err
    assert "Traceback" not in said
    return [line for line in said.splitlines() if "gridslam_replay:" in line][-1]


def error_m(bag, way):
    """Map a bag; return the greatest error of the path (m) and the number of its poses."""
    assert replay.main([bag, *FEW]) == 0
    found = read_tum(bag.replace(".bag", "_slam") + "/trajectory_online.tum")
    index = np.round((found.stamps_s - START_S) / 0.5).astype(int)
    first = way.truth.poses_in_map[index] - way.truth.poses_in_map[index[0]]
    moved = found.poses_in_map - found.poses_in_map[0]
    return float(np.hypot(*(moved - first)[:, :2].T).max()), len(index)


def swapped(first, second):
    return lambda index, stamp, base: [
        edge
        for name in (first, second)
        for edge in (as_it_is(index, stamp, base) if name == "odom" else [from_elsewhere(stamp, base)])
    ]


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"edges": without}, "no TF has come at all"),
        (
            {"static": [mounting], "edges": without},
            'no transform from "odom" to "base_link" has come; send odometry (lidar_odometry makes it of',
        ),
        ({}, 'mounting lacks: no transform from "base_link" to "laser" has come; check /tf_static'),
        (
            {"static": [lambda: mounting("base_footprint")]},
            'two roots: "laser" hangs on "base_footprint", and "base_link" on "odom"',
        ),
        (
            {"static": [mounting], "edges": lambda index, stamp, base: [from_elsewhere(stamp, base)]},
            'odometry lacks: "base_link" hangs on "world", not on "odom"; set odom_frame:=world',
        ),
        (
            {"static": [mounting], "edges": lambda index, stamp, base: as_it_is(index, stamp, base * 0.0)},
            "Odometry stands still in the whole bag, but the scans change",
        ),
        (
            {
                "static": [mounting],
                "edges": lambda index, stamp, base: as_it_is(index, stamp, (base - START) * IN_MM),
            },
            "check whether its positions are in metres",
        ),
        ({"static": [mounting], "stamps": lambda _: rospy.Time(5)}, "have the stamp of the scan before"),
        (
            {"static": [lambda: mounting(turned_rad=2.0)]},
            "degrees less), or odometry's axes, or its yaw, are. No map is written.",
        ),
    ],
    ids=[
        "no_tf",
        "no_odometry",
        "no_mounting",
        "two_roots",
        "other_root",
        "at_rest",
        "in_mm",
        "one_stamp",
        "turned",
    ],
)
def test_what_lacks_is_named(way, tmp_path, capsys, given, sentence):
    given = {**given, "static": [edge() for edge in given.get("static", [])]}
    assert sentence in refused(write(tmp_path / "bad.bag", way, **given), capsys)


@pytest.mark.parametrize(
    ("told", "sentence"),
    [
        (
            (1.0, 1.0, 0.0),
            "Odometry's yaw is the same in the whole bag, but the scans turn: the driver must fill",
        ),
        (
            (0.0, 0.0, 1.0),
            "Odometry's position is the same in the whole bag, but the scans move: the driver ",
        ),
        ((1.0, 1.0, np.degrees(1.0)), "its yaw is wrong; check whether it is in radians, not in degrees"),
    ],
    ids=["same_yaw", "same_position", "yaw_in_degrees"],
)
def test_odometry_of_which_a_part_is_wrong_is_refused(tmp_path, capsys, told, sentence):
    truth = planar_world.along(ROUTE, 0.25)
    way = planar_world.drive(planar_world.scattered_boxes(1, truth), truth, LIDAR, seed=4)
    bag = write(
        tmp_path / "part.bag",
        way,
        [mounting()],
        lambda index, stamp, base: as_it_is(index, stamp, base * told),
    )
    assert sentence in refused(bag, capsys)


def without_a_frame(message):
    message.header.frame_id = ""


def in_degrees(message):
    message.angle_min, message.angle_increment = np.degrees((message.angle_min, message.angle_increment))


def in_millimetres(message):
    message.ranges = 1e3 * np.array(message.ranges)


def with_no_return(message):
    message.ranges = np.full(len(message.ranges), np.inf)


def with_intensities_only(message):
    message.intensities, message.ranges = message.ranges, []


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        (without_a_frame, "the scans have no frame_id; the driver must set it"),
        (in_degrees, "None of the 57 scans on /scan could be used"),
        (in_millimetres, "whether ranges and range_max are in metres"),
        (with_no_return, "No beam of the 57 scans has met anything nearer than range_max"),
        (with_intensities_only, "None of the 57 scans on /scan could be used"),
    ],
    ids=lambda value: getattr(value, "__name__", ""),
)
def test_scans_that_no_map_can_be_made_of_are_refused(way, tmp_path, capsys, changed, sentence):
    assert sentence in refused(write(tmp_path / "bad.bag", way, [mounting()], changed=changed), capsys)


def test_two_lidars_in_one_frame_are_refused(way, tmp_path, capsys):
    # given every second scan by a lidar that looks back, in the frame of the one that looks ahead
    rng, scans = np.random.default_rng(1), list(way.scans)
    for index in range(1, len(scans), 2):
        pose = se2.compose(way.truth.poses_in_map[index], np.array((-0.4, 0.0, np.pi)))
        scans[index] = planar_world.scan_at(planar_world.hold(), pose, LIDAR, rng, scans[index].stamp_s)
    assert "two lidars send scans in one frame" in refused(
        write(tmp_path / "two.bag", way, [mounting()], scans=scans), capsys
    )


def with_every_second_range(message):
    message.angle_max, message.ranges = LIDAR.angles_rad[-1], np.array(message.ranges)[::2]


class OlderScan(rospy.AnyMsg):
    """A LaserScan of another definition, without intensities."""

    _type, _md5sum = LaserScan._type, 32 * "0"
    _full_text = LaserScan._full_text.replace("float32[] intensities", "")

    def __init__(self, scan):
        super().__init__()
        written = io.BytesIO()
        scan.serialize(written)
        self.header, self._buff = scan.header, written.getvalue()[:-4]


def test_scans_of_another_definition_are_refused(way, tmp_path, capsys):
    bag = write(tmp_path / "a.bag", way, [mounting()], scan_of=OlderScan)
    assert "/scan are of another definition of sensor_msgs/LaserScan" in refused(bag, capsys)


def test_messages_of_other_definitions_and_types_beside_the_scans_are_left_out(way, tmp_path, capsys):
    def scan_of(message):
        if message.header.stamp == stamp_of(way.scans[0].stamp_s):
            return String(data="the first message tells the topic's type to rosbag")
        return OlderScan(message) if message.header.stamp.nsecs else message

    path = tmp_path / "a.bag"
    _, poses = error_m(write(path, way, [mounting()], scan_of=scan_of), way)
    assert poses == sum(scan.stamp_s % 1.0 == 0.0 for scan in way.scans[1:])
    assert "Some messages on /scan are of another type or definition" in capsys.readouterr().err


@pytest.mark.parametrize("first", [b"\x89MCAP0\r\n", b"SQLite format 3\0"])
def test_a_bag_of_ros_2_is_called_so(tmp_path, capsys, first):
    path = tmp_path / "a.bag"
    path.write_bytes(first + bytes(100))
    assert f"{path} is a bag of ROS 2" in refused(str(path), capsys)


def test_fewer_ranges_than_angles_are_told(way, tmp_path, capsys):
    bag = write(tmp_path / "half.bag", way, [mounting()], order=range(8), changed=with_every_second_range)
    replay.main([bag, *FEW])
    assert (
        "The scan has 90 ranges, but angle_min, angle_max and angle_increment tell 180"
        in capsys.readouterr().err
    )


@pytest.mark.parametrize("order", [("odom", "world"), ("world", "odom")])
def test_of_two_parents_the_one_counts_that_leads_to_odometry(way, tmp_path, capsys, order):
    bag = write(tmp_path / "two.bag", way, [mounting()], edges=swapped(*order))
    worst_m, poses = error_m(bag, way)
    assert worst_m < 0.2
    assert poses >= len(way.scans) - 1
    assert '"base_link" has two parents in TF, "odom" and "world"' in capsys.readouterr().err


def test_stamps_out_of_order_are_refused(way, tmp_path, capsys):
    # Given scans and TF in an order that is wrong by up to 3 s
    places = np.arange(len(way.scans)) + np.random.default_rng(0).uniform(0.0, 6.0, len(way.scans))
    bag = write(tmp_path / "mixed.bag", way, [mounting()], order=np.argsort(places))
    assert "The stamps of the scans are out of order" in refused(bag, capsys)


def test_a_lidar_upside_down_is_mapped_if_tf_tells_and_refused_if_not(way, tmp_path, capsys):
    scans = [dataclasses.replace(scan, ranges_m=scan.ranges_m[::-1].copy()) for scan in way.scans]
    told = write(tmp_path / "told.bag", way, [mounting(upside_down=True)], scans=scans)
    assert error_m(told, way)[0] < 0.2
    untold = write(tmp_path / "untold.bag", way, [mounting()], scans=scans)
    assert "the lidar hangs upside down and TF does not tell" in refused(untold, capsys)


def test_a_log_that_begins_in_motion_is_mapped(way, tmp_path):
    bag = write(tmp_path / "cut.bag", way, [mounting()], order=range(len(way.scans) // 4, len(way.scans)))
    worst_m, poses = error_m(bag, way)
    assert worst_m < 0.2
    assert poses == len(way.scans) - len(way.scans) // 4


def test_odometry_without_scans_is_refused(way, tmp_path, capsys):
    with rosbag.Bag(str(tmp_path / "none.bag"), "w") as opened:
        for scan, base in zip(way.scans, way.odometry):
            stamp = stamp_of(scan.stamp_s)
            opened.write("/tf", TFMessage(as_it_is(0, stamp, base)), stamp)
    assert "The bag has no scans on /scan" in refused(str(tmp_path / "none.bag"), capsys)


def test_odometry_that_is_not_in_tf_is_named(way, tmp_path, capsys):
    bag = write(tmp_path / "messages.bag", way, [mounting()], edges=without)
    with rosbag.Bag(bag, "a") as opened:
        opened.write("/wheels/odom", pytest.importorskip("nav_msgs.msg").Odometry(), stamp_of(1.0))
    assert "The bag has nav_msgs/Odometry on /wheels/odom, but SLAM reads odometry from TF" in refused(
        bag, capsys
    )
    mapped = write(tmp_path / "both.bag", way)
    with rosbag.Bag(mapped, "a") as opened:
        opened.write("/wheels/odom", pytest.importorskip("nav_msgs.msg").Odometry(), stamp_of(1.0))
    assert "nav_msgs/Odometry" not in refused(mapped, capsys)  # it is the mounting that lacks


@pytest.mark.parametrize(
    ("kind", "saying"),
    [
        (
            "MultiEchoLaserScan",
            "The node laser_proc makes scans of the sensor_msgs/MultiEchoLaserScan on /s.",
        ),
        ("PointCloud2", "The node pointcloud_to_laserscan makes scans of the sensor_msgs/PointCloud2 on /s."),
    ],
)
def test_what_scans_can_be_made_of_is_told(tmp_path, capsys, kind, saying):
    with rosbag.Bag(str(tmp_path / "other.bag"), "w") as opened:
        opened.write("/s", getattr(pytest.importorskip("sensor_msgs.msg"), kind)(), stamp_of(0.0))
    assert refused(str(tmp_path / "other.bag"), capsys).endswith(saying)


def test_scans_that_end_before_odometry_are_told(way, tmp_path, capsys):
    bag = write(tmp_path / "end.bag", way, [mounting()], order=range(20))
    with rosbag.Bag(bag, "a") as opened:
        for second in range(10, 90):
            edge = transform("odom", "base_link", stamp_of(second), way.odometry[20])
            opened.write("/tf", TFMessage([edge]), stamp_of(second))
    assert replay.main([bag, *FEW]) == 0
    assert capsys.readouterr().err.count("without a scan; check the lidar") == 1


def test_a_log_without_stamps_is_refused_unless_its_period_is_given(tmp_path, capsys):
    from test_bags import written

    log = written(tmp_path / "a.log", count=12, stamp_s=0.0)
    assert carmen_bags.carmen_to_bag([log, str(tmp_path / "a.bag")]) == 1
    assert "do not ascend" in capsys.readouterr().err
    assert carmen_bags.carmen_to_bag([log, str(tmp_path / "a.bag"), "--period", "0.5"]) == 0
    with rosbag.Bag(str(tmp_path / "a.bag")) as bag:
        stamps_s = [scan.header.stamp.to_sec() for _, scan, _ in bag.read_messages(["/scan"])]
    np.testing.assert_allclose(stamps_s, 0.5 * np.arange(1, 13))
    assert carmen_bags.carmen_to_bag([log, str(tmp_path / "b.bag"), "--period", "0"]) == 1
    assert "--period 0 is no time" in capsys.readouterr().err
