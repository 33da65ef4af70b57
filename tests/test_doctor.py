"""The doctor at a real graph, a real bag, and where there is neither."""

from __future__ import annotations

import json
import sys
import time
from pathlib import Path

import pytest
import rosbag
import rospy
from sensor_msgs.msg import LaserScan

pytestmark = pytest.mark.ros

PROBE = Path(__file__).parent / "doctor_probe.py"
DOCTOR = ("rosrun", "master_thesis", "doctor")
PATIENCE_S = 60.0


def findings(said: str) -> dict[str, str]:
    """Return where to what of the doctor's JSON; warnings of an interpreter may stand before it."""
    return {one["where"]: one["what"] for one in json.loads(said[said.index("{") :])["findings"]}


@pytest.fixture
def graph(ros_master):
    """A graph with known faults, and its master; ends with the test."""
    ros_master.start(sys.executable, str(PROBE))
    ros_master.start(
        "rosrun", "rostopic", "rostopic", "pub", "-r", "5", "/cmd_vel", "geometry_msgs/Twist", "{}"
    )
    ros_master.start(
        "rosrun", "rostopic", "rostopic", "pub", "-r", "5", "/cmd_vel", "geometry_msgs/Twist", "{}"
    )
    return ros_master


EXPECTED = {
    "frame base_frame": "has 2 parents: map (from /probe) and odom (from /probe)",
    "tf": "is in 2 pieces",
    "/scan": "NaN in every beam",
    "/cmd_vel": "both publish commands",
    "/probe/gain": "is 7 on the parameter server, out of 0 to 1",
}


def test_faults_of_a_running_graph(graph):
    """However slowly the graph comes up, the doctor finds in the end what is wrong with it."""
    end = time.monotonic() + PATIENCE_S
    while True:
        done = graph.run(*DOCTOR, "--live", "--listen", "1", "--json", timeout_s=PATIENCE_S)
        found = findings(done.stdout) if done.returncode == 1 else {}
        missing = [where for where, what in EXPECTED.items() if what not in found.get(where, "")]
        if not missing or time.monotonic() > end:
            break
    assert not missing, done.stdout
    assert done.returncode == 1


def test_a_bag_and_what_cannot_be_examined(processes, tmp_path):
    path = tmp_path / "small.bag"
    with rosbag.Bag(str(path), "w") as bag:
        for tenth in range(30):
            stamp = rospy.Time.from_sec(100.0 + 0.1 * (tenth if tenth != 20 else 5))
            scan = LaserScan(
                angle_max=1.0, angle_increment=0.5, range_min=0.1, range_max=10.0, ranges=[0.0, 1.0, 2.0]
            )
            scan.header.stamp, scan.header.frame_id = stamp, "hokuyo"
            bag.write("/scan", scan, rospy.Time.from_sec(100.0 + 0.1 * tenth))
    done = processes.run(*DOCTOR, "--bag", str(path), timeout_s=PATIENCE_S)
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
    for arguments in (["--bag", str(tmp_path / "none.bag")], ["--bag", str(tmp_path / "text.bag")]):
        done = processes.run(*DOCTOR, *arguments, timeout_s=PATIENCE_S)
        assert (done.returncode, done.stdout.count("\n"), "Traceback" in done.stdout) == (2, 1, False), (
            done.stdout
        )
