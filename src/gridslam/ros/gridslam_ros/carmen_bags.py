"""The commands carmen_to_bag and bag_to_carmen."""

from __future__ import annotations

import argparse
import gzip
import math
import os
import sys
from collections import Counter
from pathlib import Path
from typing import Callable, Sequence

import numpy as np
import rosbag
import rospy
from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from gridslam import SlamError, se2
from gridslam.inputs.attitude import matrix_of_quaternion, roll_pitch_yaw_of
from gridslam.logs.carmen import (
    RANGE_MIN_M,
    CarmenError,
    CarmenOdometry,
    CarmenScan,
    StampOrder,
    format_odometry,
    format_scan,
    read_log,
)
from gridslam_ros.bags import BagCount, BagError, BagScans, open_bag, topic_of
from gridslam_ros.conversions import pose_message
from gridslam_ros.frames.odometry_frames import FrameError, OdometryFrames, Pose
from gridslam_ros.remarks import Remarks
from node_tools.conversions import set_yaw, xyz, xyzw

STAMPS_END_S = 2.0**32
"""The stamps of a bag count seconds from 1970 in 32 bits."""
SAME = 0.01
"""m, rad: if the lidar's pose on the robot varies by less, it is fixed to the robot."""


def carmen_to_bag(argv: list[str] | None = None) -> int:
    """Run the command; returns the exit code."""
    parser = _parser("carmen_to_bag", "Turns a CARMEN log into a bag of scans, odometry and TF.")
    parser.add_argument("log", help="CARMEN log, plain or .gz")
    parser.add_argument(
        "bag", nargs="?", help="bag to write (default: beside the log, with .bag; it is new then)"
    )
    parser.add_argument("--range-max", type=float, metavar="M", help="longer readings count as no return, m")
    parser.add_argument(
        "--period", type=float, metavar="S", help="for a log without stamps: time from scan to scan, s"
    )
    parser.add_argument("--lidar-frame", default="laser", help="(default: %(default)s)")
    parser.add_argument(
        "--lidar-pose",
        type=float,
        nargs=3,
        metavar=("X", "Y", "YAW"),
        help="pose of the lidar on the robot, m and rad (default: that of the log)",
    )
    parser.add_argument("--odometry", default="/odom", help="topic of ODOM lines (default: %(default)s)")
    arguments = parser.parse_args(argv)
    return _run("carmen_to_bag", _write_bag, arguments, arguments.log, arguments.bag, ".bag")


def bag_to_carmen(argv: list[str] | None = None) -> int:
    """Run the command; returns the exit code."""
    parser = _parser("bag_to_carmen", "Turns a bag's scans and TF into a CARMEN log.")
    parser.add_argument("bag", help="bag to read")
    parser.add_argument(
        "log",
        nargs="?",
        help="log to write, .gz packs it (default: beside the bag, with .log; it is new then)",
    )
    parser.add_argument("--odometry", metavar="TOPIC", help="nav_msgs/Odometry to write as ODOM lines too")
    arguments = parser.parse_args(argv)
    return _run("bag_to_carmen", _write_log, arguments, arguments.bag, arguments.log, ".log")


def _parser(name: str, description: str) -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog=name, description=description)
    parser.add_argument(
        "--scan", default="/scan", metavar="TOPIC", help="topic of the scans (default: %(default)s)"
    )
    parser.add_argument("--odom-frame", default="odom", help="(default: %(default)s)")
    parser.add_argument("--base-frame", default="base_link", help="(default: %(default)s)")
    return parser


def _run(
    name: str,
    convert: Callable[[argparse.Namespace, str], str],
    arguments: argparse.Namespace,
    source: str,
    target: str | None,
    ending: str,
) -> int:
    """Convert into a file beside the target, and rename it at the end. So a fault leaves no partial file.

    target: None: beside the source, with another ending.
    """
    try:
        target = _target(source, target, ending)
        try:
            print(f"{name}: {convert(arguments, target)} in {target}")
        finally:
            Path(_part(target)).unlink(missing_ok=True)
    except SlamError as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 1
    return 0


def _target(source: str, target: str | None, ending: str) -> str:
    """Return the file to write. Without a name it is a new one, so that no log is lost."""
    is_named = target is not None
    if target is None:
        path = Path(source)
        for suffix in (".gz", ".log", ".bag"):
            path = path.with_suffix("") if path.suffix == suffix else path
        target = str(path.with_name(path.name + ending))
    if os.path.exists(target) and os.path.exists(source) and os.path.samefile(source, target):
        raise CarmenError(f"{target} is the file to read; name another one to write.")
    if os.path.exists(target) and not is_named:
        raise CarmenError(f"{target} exists already; name it as the second argument to replace it.")
    return target


def _part(target: str) -> str:
    folder, name = os.path.split(target)
    return os.path.join(folder, f".part-{name}")


def _write_bag(arguments: argparse.Namespace, target: str) -> str:
    counts = {CarmenScan: 0, CarmenOdometry: 0}
    remarks = Remarks(lambda sentence: print(f"carmen_to_bag: {sentence}", file=sys.stderr))
    arguments.lidar_pose = arguments.lidar_pose or _lidar_pose(arguments.log)
    if arguments.period is not None and not 0.001 <= arguments.period <= 3600.0:
        raise CarmenError(f"--period {arguments.period:g} is no time from scan to scan: 0.001 to 3600 s.")
    order, others = StampOrder(arguments.log), Counter[str]()
    with open_bag(_part(target), "w") as bag:
        for record in read_log(
            arguments.log,
            arguments.range_max,
            _left_out(remarks),
            arguments.period,
            lambda name: others.update([name]),
        ):
            if isinstance(record, CarmenScan):
                order.add(record.stamp_s)
            if not 0.0 <= record.stamp_s < STAMPS_END_S:
                remarks.say(_without_stamp(arguments.log, record.stamp_s))
                continue
            stamp = max(rospy.Time.from_sec(record.stamp_s), rospy.Time(0, 1))
            if isinstance(record, CarmenScan):
                _write_scan(bag, record, stamp, arguments)
            else:
                _write_odometry(bag, record, stamp, arguments)
            counts[type(record)] += 1
    remarks.sum_up()
    also = ", ".join(f"{count} of {name}" for name, count in others.items())
    if not counts[CarmenScan]:
        raise CarmenError(
            f"{arguments.log} holds no FLASER or ROBOTLASER1 line that can be used; nothing is written."
            + (f" Its other scans hold no pose, or are of another lidar: {also}." if also else "")
        )
    if also:
        remarks.say(f"Only FLASER and ROBOTLASER1 are scans of the bag; these are left out: {also}.")
    os.replace(_part(target), target)
    return f"{counts[CarmenScan]} scans and {counts[CarmenOdometry]} readings of odometry"


def _left_out(remarks: Remarks) -> Callable[[CarmenError], None]:
    return lambda error: remarks.say(f"{error} The line is left out.")


def _without_stamp(log: str, stamp_s: float) -> str:
    """Return a sentence on a line whose stamp no bag can hold."""
    why = "before 1970" if stamp_s < 0.0 else "after 2106; perhaps the log counts milliseconds"
    return f"{log}: The stamp {stamp_s:.6f} s is {why}. A bag cannot hold it, so the line is left out."


def _lidar_pose(log: str) -> np.ndarray:
    """Return the pose of the lidar on the robot. A log with corrected poses does not tell it."""
    poses = [
        se2.between(record.robot_in_odom, record.lidar_in_odom)
        for record in read_log(log, on_bad=lambda _: None)
        if isinstance(record, CarmenScan)
    ]
    if poses and np.abs(se2.between(poses[0], poses)).max() < SAME:
        return poses[0]
    if poses:
        print(
            "carmen_to_bag: the lidar's pose on the robot changes, so the log holds corrected poses. The "
            "lidar is assumed in the robot's middle; --lidar-pose sets another place.",
            file=sys.stderr,
        )
    return np.zeros(3)


def _write_scan(
    bag: rosbag.Bag, record: CarmenScan, stamp: rospy.Time, arguments: argparse.Namespace
) -> None:
    edges = [
        _transform(arguments.odom_frame, arguments.base_frame, record.robot_in_odom, stamp),
        _transform(arguments.base_frame, arguments.lidar_frame, arguments.lidar_pose, stamp),
    ]
    bag.write("/tf", TFMessage(edges), stamp)
    message = LaserScan(range_min=RANGE_MIN_M, range_max=record.range_max_m, ranges=record.ranges_m)
    message.header.stamp, message.header.frame_id = stamp, arguments.lidar_frame
    message.angle_min, message.angle_increment = record.angle_min_rad, record.angle_increment_rad
    message.angle_max = record.angle_min_rad + (record.ranges_m.size - 1) * record.angle_increment_rad
    bag.write(arguments.scan, message, stamp)


def _write_odometry(
    bag: rosbag.Bag, record: CarmenOdometry, stamp: rospy.Time, arguments: argparse.Namespace
) -> None:
    message = Odometry(child_frame_id=arguments.base_frame)
    message.header.stamp, message.header.frame_id = stamp, arguments.odom_frame
    message.pose.pose = pose_message(*record.robot_in_odom)
    message.twist.twist.linear.x, message.twist.twist.angular.z = record.speed_mps, record.turn_rate_radps
    bag.write(arguments.odometry, message, stamp)


def _transform(parent: str, child: str, pose: Sequence[float], stamp: rospy.Time) -> TransformStamped:
    x, y, yaw = (float(value) for value in pose)
    transform = TransformStamped(child_frame_id=child)
    transform.header.stamp, transform.header.frame_id = stamp, parent
    transform.transform.translation.x, transform.transform.translation.y = x, y
    set_yaw(transform.transform.rotation, yaw)
    return transform


def _write_log(arguments: argparse.Namespace, target: str) -> str:
    remarks = Remarks(lambda sentence: print(f"bag_to_carmen: {sentence}", file=sys.stderr))
    frames, count = OdometryFrames(arguments.odom_frame, arguments.base_frame, remarks.say), BagCount()
    lines: list[tuple[float, str]] = []
    with open_bag(arguments.bag) as bag:
        topic = topic_of(bag, arguments.scan)
        scans_of_bag = BagScans(
            topic,
            frames,
            count,
            remarks.say,
            lambda seconds: remarks.say(
                f"The clock goes back by {seconds:.3f} s; the log is sorted by stamps."
            ),
        )
        for message in scans_of_bag.of(bag):
            try:
                lines.append((message.header.stamp.to_sec(), format_scan(_carmen_scan(message, frames))))
            except FrameError:
                count.without_tf += 1
        remarks.sum_up()
        scans = len(lines)
        if arguments.odometry:
            lines += [_odometry_line(message) for _, message, _ in bag.read_messages([arguments.odometry])]
    if not scans:
        lacks = frames.what_lacks(count.lidar_frame) or "the transforms are of other times than the scans"
        raise BagError(
            f"None of the {count.read} scans could be used: {lacks}; see --base-frame and --odom-frame."
        )
    lines.sort(key=lambda line: line[0])
    try:
        with (gzip.open if target.endswith(".gz") else open)(_part(target), "wt") as log:
            log.write("# CARMEN Logfile\n" + "".join(line + "\n" for _, line in lines))
        os.replace(_part(target), target)
    except OSError as error:
        raise CarmenError(f"{target} cannot be written: {error.strerror}.") from None
    lost = f" ({count.without_tf} scans without TF are left out)" if count.without_tf else ""
    return f"{scans} scans and {len(lines) - scans} readings of odometry{lost}"


def _carmen_scan(message: LaserScan, frames: OdometryFrames) -> CarmenScan:
    poses = frames.look_up(message)
    base_in_odom, lidar_in_base = (_planar(pose) for pose in poses)
    side = math.copysign(1.0, matrix_of_quaternion(poses[1][1])[2, 2])  # -1: the lidar is upside down
    return CarmenScan(
        stamp_s=message.header.stamp.to_sec(),
        ranges_m=np.asarray(message.ranges),
        angle_min_rad=side * message.angle_min,
        angle_increment_rad=side * message.angle_increment,
        range_max_m=message.range_max,
        robot_in_odom=base_in_odom,
        lidar_in_odom=tuple(se2.compose(base_in_odom, lidar_in_base).tolist()),
    )


def _planar(pose: Pose) -> tuple[float, float, float]:
    (x, y, _), orientation = pose
    return x, y, roll_pitch_yaw_of(matrix_of_quaternion(orientation))[2]


def _odometry_line(message: Odometry) -> tuple[float, str]:
    pose = _planar((xyz(message.pose.pose.position), xyzw(message.pose.pose.orientation)))
    twist = message.twist.twist
    stamp_s = message.header.stamp.to_sec()
    return stamp_s, format_odometry(CarmenOdometry(stamp_s, pose, twist.linear.x, twist.angular.z))
