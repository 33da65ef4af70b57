"""Reading bags: scans with the transforms of their time, in the order of the bag."""

from __future__ import annotations

import contextlib
import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Callable, Iterable, Iterator

import numpy as np
import rosbag
from nav_msgs.msg import Odometry
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import LaserScan, PointCloud2
from tf2_msgs.msg import TFMessage

from gridslam import SlamError
from gridslam.errors import reason_of
from gridslam_ros.beside.beside_scans import BesideScans
from gridslam_ros.frames.odometry_frames import OdometryFrames
from gridslam_ros.intake import OUT_OF_ORDER, Intake
from gridslam_ros.scan_queue import ScanQueue
from node_tools.bags import DAMAGE

LASER_SCAN, ODOMETRY = "sensor_msgs/LaserScan", "nav_msgs/Odometry"
POINT_CLOUD = "sensor_msgs/PointCloud2"
KINDS = {LASER_SCAN: "scans", ODOMETRY: "odometry", POINT_CLOUD: "clouds"}
CLASSES = {LASER_SCAN: LaserScan, ODOMETRY: Odometry, POINT_CLOUD: PointCloud2}
_DRIVER = "The lidar's own driver makes clouds"
MADE_OF: dict[str, dict[str, str]] = {
    LASER_SCAN: {
        "sensor_msgs/MultiEchoLaserScan": "The node laser_proc makes scans",
        POINT_CLOUD: "The node pointcloud_to_laserscan makes scans",
    },
    ODOMETRY: {},
    POINT_CLOUD: {
        "velodyne_msgs/VelodyneScan": _DRIVER,
        "ouster_ros/PacketMsg": _DRIVER,
        "livox_ros_driver/CustomMsg": _DRIVER + " (xfer_format:=0)",
        "livox_ros_driver2/CustomMsg": _DRIVER + " (xfer_format:=0)",
        LASER_SCAN: "The node laser_assembler makes clouds",
    },
}
"""For what a bag lacks: which other messages it can be made of, and how."""
OF_ROS_2 = (b"\x89MCAP", b"SQLite format 3")
"""First bytes of ROS 2's bags."""
NEWEST_FORMAT = 200
"""Bags of 2.0 have been written since 2010; some of the classic ones are of 1.2."""
LOOKED_AHEAD = 20
"""Messages of a lidar that tell what it means by its readings."""
TF_TOPICS = ("/tf", "/tf_static", "tf", "tf_static")


class BagError(SlamError):
    """A bag cannot be read or written, or lacks a topic."""


@dataclass
class BagCount:
    """Counts of a bag's scans."""

    read: int = 0
    without_tf: int = 0
    skipped: int = 0
    """Left out by throttle_scans, or out of order."""
    begun_anew: int = 0
    """Number of times that the clock went back."""
    of_one_stamp: int = 0
    """Left out because the scan before, with other ranges, has the same stamp."""
    lidar_frame: str = ""
    """Of the newest scan; once scans were left out without TF, of the newest of these."""


def open_bag(path: str, mode: str = "r") -> rosbag.Bag:
    """Open a bag.

    Raises:
        BagError: it cannot be opened.
    """
    try:
        bag = rosbag.Bag(path, mode)
        if mode == "r" and bag.version < NEWEST_FORMAT:
            _make_readable(bag)
        return bag
    except rosbag.ROSBagUnindexedException:
        raise BagError(
            f"The bag {path} has no index (its recording was cut off): rosbag reindex {path}"
        ) from None
    except DAMAGE as error:
        if _is_of_ros_2(Path(path)):
            raise BagError(
                f"{path} is a bag of ROS 2; make one of ROS 1 of it first: pip install rosbags, "
                f"rosbags-convert --src {path} --dst new.bag"
            ) from None
        raise BagError(f"The bag {path} cannot be opened: {reason_of(error)}.") from None


def _is_of_ros_2(path: Path) -> bool:
    if path.is_dir():
        return (path / "metadata.yaml").is_file()
    try:
        with path.open("rb") as file:
            return file.read(16).startswith(OF_ROS_2)
    except OSError:
        return False


def _make_readable(bag: rosbag.Bag) -> None:
    """Let a bag of format 1.2 be read: rosbag gives its reader an argument more than it takes."""
    reader = bag._reader
    read = reader.read_messages
    reader.read_messages = lambda *arguments: read(*arguments[:5])


def topics_of(bag: rosbag.Bag, message_type: str) -> list[str]:
    """Return the topics of a bag's messages of a type."""
    return sorted({one.topic for one in bag._get_connections() if one.datatype == message_type})


def topic_of(bag: rosbag.Bag, topic: str, message_type: str = LASER_SCAN) -> str:
    """Return the topic as the bag has it.

    Raises:
        BagError: there are no messages of this type on it that this ROS can read. The sentence names the
            topics that have some.
    """
    of_type = [one for one in bag._get_connections() if one.datatype == message_type]
    own, others = CLASSES[message_type]._md5sum, topics_of(bag, message_type)
    for name in (topic, "/" + topic.lstrip("/"), topic.lstrip("/")):
        if name in others:
            if any(one.topic == name and one.md5sum == own for one in of_type):
                return name
            raise BagError(
                f"The bag's messages on {name} are of another definition of {message_type} than this ROS's "
                f"(md5sum {own}): their fields differ. Change the bag: rosbag fix."
            )
    kind = KINDS[message_type]
    hint = f"It has {kind} on {', '.join(others)}." if others else _without(bag, message_type)
    raise BagError(f"The bag has no {kind} on {topic}. {hint}")


def _without(bag: rosbag.Bag, message_type: str) -> str:
    """Return sentences on a bag without messages of a type: what it has that can be made into some."""
    told = [f"It holds no {message_type} at all."]
    found = sorted({(one.datatype, one.topic) for one in bag._get_connections()})
    for datatype, topic in found:
        if how := MADE_OF[message_type].get(datatype):
            told.append(f"{how} of the {datatype} on {topic}.")
    return " ".join(told)


def read_raw(
    bag: rosbag.Bag, classes: dict[str, Any], say: Callable[[str], None]
) -> Iterator[tuple[str, bytes]]:
    """Yield (topic, bytes) of the messages on topics, and of TF.

    Messages of another type or definition are left out, because their bytes mean something else.

    Args:
        bag: it.
        classes: of the messages, by topic. All other topics are TF's.
        say: is called with a sentence for each topic of which some are left out.

    Raises:
        BagError: the bag is damaged.
    """

    def is_known(topic: str, _: str, md5sum: str, *__: object) -> bool:
        return md5sum == classes.get(topic, TFMessage)._md5sum

    topics = [*classes, *TF_TOPICS]
    for topic in sorted(_unknown(bag._get_connections(topics), is_known)):
        say(f"Some messages on {topic} are of another type or definition; they are left out.")
    try:
        # Raw messages: tf2 warns of rosbag's own message classes, and arrays are faster
        for name, (_, data, *_), _ in bag.read_messages(topics, connection_filter=is_known, raw=True):
            yield name, data
    except DAMAGE as error:
        raise BagError(f"The bag {bag.filename} is damaged ({error}).") from None


def first_of(bag: rosbag.Bag, topic: str, message_type: str) -> Iterator[Any]:
    """Yield the first messages of a topic, up to the first damage."""
    read = read_raw(bag, {topic: CLASSES[message_type]}, lambda _: None)
    with contextlib.suppress(BagError, *DAMAGE):
        for data in itertools.islice((data for name, data in read if name == topic), LOOKED_AHEAD):
            yield CLASSES[message_type]().deserialize(data)


def _unknown(connections: Iterable, is_known: Callable[[str, str, str], bool]) -> set[str]:
    return {one.topic for one in connections if not is_known(one.topic, one.datatype, one.md5sum)}


class BagScans:
    """The LaserScan messages of a topic. Each is yielded when the bag's TF has reached its stamp.

    Args:
        topic: of the scans.
        frames: learn the bag's TF.
        count: takes the counts of the scans.
        say: is called with a sentence when something is odd.
        start_anew: is called with the seconds that the clock has gone back by, before the next scan.
        throttle: one of so many scans is yielded.
        beside: learns what else belongs to a scan.
        topics: of the odometry and of the clouds, as far as they count.
    """

    def __init__(
        self,
        topic: str,
        frames: OdometryFrames,
        count: BagCount,
        say: Callable[[str], None],
        start_anew: Callable[[float], None],
        throttle: int = 1,
        beside: BesideScans | None = None,
        topics: tuple[str, str] = ("", ""),
    ):
        self._beside = beside or BesideScans(frames, None, None)
        self._odometry_topic, self._cloud_topic = topics
        self._topic, self._frames, self._count, self._begin_again = topic, frames, count, start_anew
        self._say = say
        self._queue = ScanQueue(waiting_max=None, ready_max=None)
        self._intake = Intake(frames, throttle, say, self._queue.offer, self._skip, self._start_anew)

    def of(self, bag: rosbag.Bag) -> Iterator:
        """Yield them.

        Raises:
            BagError: the bag is damaged, or its stamps are out of order.
        """
        for name, message in self._messages(bag):
            if name == self._topic:
                self._count.read += 1
                if not self._count.without_tf:
                    self._count.lidar_frame = message.header.frame_id
                self._intake.add_scan(message)
            elif self._beside.covariances is not None and name == self._odometry_topic:
                self._beside.covariances.add(message)
            elif self._beside.clouds is not None and name == self._cloud_topic:
                self._beside.clouds.add(message)
            elif name.endswith("tf_static"):
                self._frames.add(message.transforms, static=True)
            else:
                self._intake.add_transforms(message.transforms)
            yield from self._ready(self._beside.know)
        yield from self._ready(self._frames.know)  # whose odometry or cloud never came
        self._intake.drop_held()
        self._count.of_one_stamp = self._intake.of_one_stamp
        self._leave_out(self._queue.clear())

    def _messages(self, bag: rosbag.Bag) -> Iterator[tuple]:
        """Yield (topic, message) of scans, TF, odometry and clouds."""
        scan_type = numpy_msg(LaserScan)
        beside = ((self._odometry_topic, Odometry), (self._cloud_topic, PointCloud2))
        classes = {self._topic: LaserScan, **{topic: each for topic, each in beside if topic}}
        try:
            for name, data in read_raw(bag, classes, self._say):
                if name == self._topic:
                    yield name, scan_type().deserialize_numpy(data, np)
                else:
                    yield name, classes.get(name, TFMessage)().deserialize(data)
        except DAMAGE as error:
            raise BagError(f"The bag {bag.filename} is damaged ({error}).") from None

    def _ready(self, is_ready: Callable[[LaserScan], bool]) -> Iterator:
        while len(self._queue):
            scan, _, without_tf = self._queue.take(is_ready)
            self._leave_out(without_tf)
            if scan is None:
                return
            yield scan

    def _leave_out(self, scans: list) -> None:
        self._count.without_tf += len(scans)
        if scans:
            self._count.lidar_frame = scans[-1].header.frame_id

    def _skip(self, _scan: LaserScan) -> None:
        self._count.skipped += 1

    def _start_anew(self, seconds: float) -> None:
        self._count.begun_anew += 1
        if self._intake.is_out_of_order:
            raise BagError(f"{OUT_OF_ORDER} The bag cannot be mapped; sort it by the headers' stamps.")
        self._leave_out(self._queue.clear())
        self._begin_again(seconds)
