"""The doctor at a real graph, a real bag, and where there is neither."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pytest

pytestmark = pytest.mark.ros

PROBE = Path(__file__).parent / "doctor_probe.py"
DOCTOR = (str(Path(__file__).resolve().parents[2] / "devel/lib/doctor/doctor"),)
PATIENCE_S = 90.0

EXPECTED = {
    "frame base_frame": "has 2 parents: map (from /probe) and odom (from /probe)",
    "tf": "is in 2 pieces",
    "/scan": "NaN in every beam",
    "/cmd_vel": "both publish commands",
    "/probe/algorithm": 'is "banana" on the parameter server, and must be improved or original',
    "/probe/gain": "is 7 on the parameter server, out of 0 to 1",
}


@pytest.fixture
def graph(ros_master):
    """A graph with known faults: its master, when all of it has come up. It ends with the test."""
    import rosgraph

    ros_master.start(sys.executable, str(PROBE))
    ros_master.start("rostopic", "pub", "-r", "5", "/cmd_vel", "geometry_msgs/Twist", "{}")
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    end = time.monotonic() + PATIENCE_S
    while {"/scan", "/tf"} - publishing(master, 1) or "/cmd_vel" not in publishing(master, 2):
        assert time.monotonic() < end, "the graph did not come up"
        time.sleep(0.1)
    return ros_master


def publishing(master, least: int) -> set[str]:
    """Return the topics that have at least so many publishers."""
    return {topic for topic, nodes in master.getSystemState()[0] if len(nodes) >= least}


def test_faults_of_a_running_graph(graph):
    """On a busy machine not everything may be heard in one short look: the doctor is called until it was."""
    end = time.monotonic() + PATIENCE_S
    while True:
        done = graph.run(*DOCTOR, "--live", "--listen", "2", "--json", timeout_s=PATIENCE_S)
        missing = EXPECTED.items() - {
            (where, what) for where, what in EXPECTED.items() if what in told(done.stdout).get(where, "")
        }
        if not missing or time.monotonic() > end:
            break
    assert not missing, done.stdout
    assert done.returncode == 1


def told(said: str) -> dict[str, str]:
    """Return all that the doctor's JSON says of each place; an interpreter's warnings may come before it."""
    found: dict[str, str] = {}
    for one in json.loads(said[said.index("{") :])["findings"]:
        found[one["where"]] = f"{found.get(one['where'], '')} {one['what']}"
    return found


def test_a_bag_and_what_is_none(tmp_path):
    from launch_files import run

    path = tmp_path / "small.bag"
    write_bag(path)
    done = run(*DOCTOR, "--bag", str(path))
    assert done.returncode == 1
    for line in (
        'error   /scan: its frame "hokuyo" is not in TF.',
        "warning /scan: 33.3 % of its ranges are finite and below range_min",
        "warning /scan: its stamps go back 1 times.",
        "note    gridslam: cannot be fed from this bag",
        "Examined: 30 messages on 1 topics",
    ):
        assert line in done.stdout
    (tmp_path / "text.bag").write_text("no bag")
    done = run(*DOCTOR, "--bag", str(tmp_path / "text.bag"))
    said = done.stdout + done.stderr
    assert (done.returncode, said.count("\n")) == (2, 1), said
    assert "text.bag cannot be read" in said


def write_bag(path: Path) -> None:
    """Write 3 s of scans without TF; each has a zero in it, and one an old stamp."""
    import rosbag
    import rospy
    from sensor_msgs.msg import LaserScan

    with rosbag.Bag(str(path), "w") as bag:
        for tenth in range(30):
            scan = LaserScan(angle_max=1.0, angle_increment=0.5, range_min=0.1, range_max=10.0)
            scan.ranges = [0.0, 1.0, 2.0]
            scan.header.frame_id = "hokuyo"
            scan.header.stamp = rospy.Time.from_sec(100.0 + 0.1 * (tenth if tenth != 20 else 15))
            bag.write("/scan", scan, rospy.Time.from_sec(100.0 + 0.1 * tenth))


# -- bags ---------------------------------------------------------------------------------------------------


def written(path, turn_w=1.0):
    """A bag of a few transforms and scans, whose rotations are as long as `turn_w`."""
    import rosbag
    import rospy
    from geometry_msgs.msg import TransformStamped
    from sensor_msgs.msg import LaserScan
    from tf2_msgs.msg import TFMessage

    with rosbag.Bag(str(path), "w") as bag:
        for index in range(8):
            stamp = rospy.Time(1.0 + 0.1 * index)
            edge = TransformStamped()
            edge.header.stamp, edge.header.frame_id, edge.child_frame_id = stamp, "odom", "base_frame"
            edge.transform.rotation.w = turn_w
            scan = LaserScan(angle_min=-1.0, angle_max=1.0, angle_increment=0.1, range_max=5.0)
            scan.header.stamp, scan.header.frame_id, scan.ranges = stamp, "base_frame", [2.0] * 21
            bag.write("/tf", TFMessage([edge]), stamp)
            bag.write("/scan", scan, stamp)
    return path.read_bytes()


def test_no_damaged_byte_of_a_bag_ends_the_doctor(tmp_path):
    import random

    doctor_bag = pytest.importorskip("doctor_ros.bag")
    whole, path, read = written(tmp_path / "whole.bag"), tmp_path / "damaged.bag", []
    rng = random.Random(1)
    for _ in range(150):
        content = bytearray(whole)
        where, length = rng.randrange(len(content)), rng.choice((1, 4, 40))
        content[where : where + length] = bytes(rng.randrange(256) for _ in range(length))
        path.write_bytes(content)
        try:
            read.append(doctor_bag.read(path))
        except doctor_bag.BagError as error:
            read.append(str(error))
    sentences = [one for one in read if isinstance(one, str)]
    assert 20 < len(sentences) < 150
    assert all(sentence.endswith(".") or "rosbag reindex" in sentence for sentence in sentences)


def test_a_rotation_beyond_all_numbers_is_broken_not_the_end(tmp_path):
    doctor_bag = pytest.importorskip("doctor_ros.bag")
    written(tmp_path / "far.bag", turn_w=1e300)
    recording, _ = doctor_bag.read(tmp_path / "far.bag")
    assert [transform.broken for transform in recording.transforms] == [True]
