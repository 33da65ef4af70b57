"""The command identify_response and its recorder: frames of commands, bags, and what cannot be done."""

import math
import runpy
import sys
from pathlib import Path

import numpy as np
import pytest

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
recorders = pytest.importorskip(
    "cepa_ros.response_recorder", reason="the workspace is not built, or not sourced"
)

import rospy  # noqa: E402
from geometry_msgs.msg import TwistStamped  # noqa: E402
from nav_msgs.msg import Odometry  # noqa: E402

from cepa.identification.recording import IdentificationError  # noqa: E402

COMMAND = Path(__file__).resolve().parents[2] / "nodes" / "identify_response"
COMMANDS, ODOMETRY = "/UAV/vel_setpoint/final/body", "/UAV/odometry"


def odometry(t, yaw=0.0, velocity=(0.0, 0.0)):
    """A UAV that flies at a velocity in its own axes."""
    message = Odometry()
    message.header.stamp, message.header.frame_id = rospy.Time.from_sec(t), "odom"
    message.child_frame_id = "base_frame"
    message.pose.pose.orientation.z, message.pose.pose.orientation.w = math.sin(yaw / 2), math.cos(yaw / 2)
    message.twist.twist.linear.x, message.twist.twist.linear.y = velocity
    return message


def command(t, velocity, frame="base_frame"):
    """A velocity command."""
    message = TwistStamped()
    message.header.stamp, message.header.frame_id = rospy.Time.from_sec(t), frame
    message.twist.linear.x, message.twist.linear.y = velocity
    return message


@pytest.mark.parametrize(
    ("frame", "expected"),
    [("base_frame", (0.0, 1.0)), ("/base_frame", (0.0, 1.0)), ("", (0.0, 1.0)), ("odom", (1.0, 0.0))],
)
def test_commands_and_velocities_are_turned_into_the_odometrys_axes(frame, expected):
    recorder = recorders.ResponseRecorder("base_frame")
    recorder.on_command(command(1.0, (1.0, 0.0), frame))
    recorder.on_odometry(odometry(1.0, yaw=math.pi / 2, velocity=(2.0, 0.0)))
    recording = recorder.recording()
    assert recording.commands[0] == pytest.approx([1.0, *expected, 0.0])
    assert recording.velocities[0] == pytest.approx([1.0, 0.0, 2.0, 0.0])


def test_a_command_in_an_unknown_frame_is_refused():
    recorder = recorders.ResponseRecorder("base_frame")
    recorder.on_command(command(1.0, (1.0, 0.0), "map"))
    recorder.on_odometry(odometry(1.0))
    with pytest.raises(IdentificationError, match="'map'"):
        recorder.recording()


def write_flight(path, seconds=30.0):
    """Write a flight of steps in which the UAV follows with 1.2 / s, and turns all the time."""
    rng, velocity, wanted = np.random.default_rng(1), np.zeros(2), np.zeros(2)
    with rosbag.Bag(str(path), "w") as bag:
        for k in range(round(seconds / 0.025)):
            t, yaw = 10.0 + 0.025 * k, 0.01 * k
            if k % 60 == 0:
                wanted = rng.uniform(-2.0, 2.0, 2)
            turn = np.array([[math.cos(yaw), math.sin(yaw)], [-math.sin(yaw), math.cos(yaw)]])
            stamp = rospy.Time.from_sec(t)
            bag.write(ODOMETRY, odometry(t, yaw, turn @ velocity), stamp)
            bag.write(COMMANDS, command(t, turn @ wanted), stamp)
            velocity = wanted + (velocity - wanted) * math.exp(-1.2 * 0.025)


def test_the_command_tells_the_response_of_a_bag(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_flight("flight.bag")
    monkeypatch.setattr(sys, "argv", ["identify_response", "flight.bag"])
    assert not runpy.run_path(str(COMMAND))["main"]()
    told = capsys.readouterr().out
    lines = dict(line.split(": ") for line in told.splitlines() if not line.startswith("#"))
    assert float(lines["response_p"]) == pytest.approx(1.2, rel=0.03)
    assert (tmp_path / "response.png").exists()


def refused(words, monkeypatch, capsys):
    """Run the command, which fails, and return what it says."""
    monkeypatch.setattr(sys, "argv", ["identify_response", *words])
    assert runpy.run_path(str(COMMAND))["main"]() == 1
    return capsys.readouterr().err


@pytest.mark.parametrize("topic", ["/nothing", ODOMETRY])
def test_a_topic_without_commands_is_one_sentence(topic, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_flight("flight.bag", seconds=1.0)
    assert refused(["flight.bag", "--commands", topic], monkeypatch, capsys) == (
        f"identify_response: The bag flight.bag lacks {topic} (geometry_msgs/TwistStamped); it holds "
        f"{ODOMETRY} (nav_msgs/Odometry), {COMMANDS} (geometry_msgs/TwistStamped). Choose other topics with "
        "--commands and --odometry.\n"
    )


def test_a_bag_that_was_cut_off_tells_how_to_mend_it(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_flight("flight.bag", seconds=1.0)
    whole = Path("flight.bag").read_bytes()
    Path("flight.bag").write_bytes(whole[: len(whole) // 2])
    said = refused(["flight.bag"], monkeypatch, capsys)
    assert said == (
        "identify_response: The bag flight.bag has no index (its recording was cut off): "
        "rosbag reindex flight.bag\n"
    )
