"""Reading bags: scans with the transforms of their time, in the order of the bag."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Iterator

import numpy as np
import rosbag
from rospy.numpy_msg import numpy_msg
from sensor_msgs.msg import LaserScan
from tf2_msgs.msg import TFMessage

from gridslam import SlamError
from gridslam_ros.odometry_frames import OdometryFrames

LASER_SCAN = "sensor_msgs/LaserScan"
TF_TOPICS = ("/tf", "/tf_static", "tf", "tf_static")


class BagError(SlamError):
    """A bag that cannot be read or written, or lacks what is needed."""


@dataclass
class BagCount:
    """What became of a bag's scans."""

    read: int = 0
    without_tf: int = 0


def open_bag(path: str, mode: str = "r") -> rosbag.Bag:
    """Open a bag.

    Raises:
        BagError: it cannot be opened.
    """
    try:
        return rosbag.Bag(path, mode)
    except rosbag.ROSBagUnindexedException:
        raise BagError(
            f"The bag {path} has no index (its recording was cut off): rosbag reindex {path}"
        ) from None
    except (OSError, rosbag.ROSBagException) as error:
        raise BagError(f"The bag {path} cannot be opened: {error}.") from None


def scan_topic_of(bag: rosbag.Bag, topic: str) -> str:
    """Return the topic as the bag has it.

    Raises:
        BagError: there are no scans on it; the sentence names the topics that have some.
    """
    topics = bag.get_type_and_topic_info().topics
    for name in (topic, "/" + topic.lstrip("/"), topic.lstrip("/")):
        if name in topics and topics[name].msg_type == LASER_SCAN:
            return name
    others = sorted(name for name, info in topics.items() if info.msg_type == LASER_SCAN)
    hint = f"There are scans on {', '.join(others)}." if others else f"It holds no {LASER_SCAN} at all."
    raise BagError(f"The bag has no scans on {topic}. {hint}")


def scans_of(bag: rosbag.Bag, topic: str, frames: OdometryFrames, count: BagCount) -> Iterator:
    """Yield the LaserScan messages of a topic as soon as the bag's TF has come as far as their stamps."""
    # Read raw, because rosbag makes message classes of its own, which tf2 warns of, and arrays are faster
    scan_type = numpy_msg(LaserScan)
    waiting: deque = deque()
    for name, (_, data, *_), _ in bag.read_messages(topics=[topic, *TF_TOPICS], raw=True):
        if name == topic:
            count.read += 1
            waiting.append(scan_type().deserialize_numpy(data, np))
        else:
            frames.add(TFMessage().deserialize(data).transforms, static=name.endswith("tf_static"))
        while waiting and frames.know(waiting[0]):
            yield waiting.popleft()
    count.without_tf += len(waiting)
