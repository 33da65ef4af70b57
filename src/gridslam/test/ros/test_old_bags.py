"""Bags of format 1.2, as ROS wrote them before 2010; wiki.ros.org/Bags/Format/1.2 describes the records."""

from __future__ import annotations

import io
import struct

import pytest

rosbag = pytest.importorskip("rosbag", reason="needs ROS")
bags = pytest.importorskip("gridslam_ros.bags", reason="the workspace is not built, or not sourced")
from rospy import Time  # noqa: E402
from sensor_msgs.msg import LaserScan  # noqa: E402

HEADER_BYTES = 4096
DEFINITION, DATA, HEADER, INDEX = b"\x01", b"\x02", b"\x03", b"\x04"


def field(name, value):
    text = name.encode() + b"=" + value
    return struct.pack("<I", len(text)) + text


def record(fields, data):
    header = b"".join(field(*one) for one in fields.items())
    return struct.pack("<I", len(header)) + header + struct.pack("<I", len(data)) + data


def file_header(index_at):
    header = {"op": HEADER, "index_pos": struct.pack("<Q", index_at)}
    length = len(record(header, b""))
    return record(header, b" " * (HEADER_BYTES - length))


def old_bag(path, count):
    """Write a bag of format 1.2 with scans of one topic, a second apart."""
    start = b"#ROSRECORD V1.2\n"
    kind = {"topic": b"/scan", "md5": LaserScan._md5sum.encode(), "type": LaserScan._type.encode()}
    records, index = b"", b""
    for second in range(1, count + 1):
        at = len(start) + HEADER_BYTES + len(records)
        if second == 1:
            records += record({"op": DEFINITION, **kind, "def": LaserScan._full_text.encode()}, b"")
        scan, body = LaserScan(ranges=[float(second)], range_max=10.0), io.BytesIO()
        scan.header.stamp = Time(second)
        scan.serialize(body)
        time = {"sec": struct.pack("<I", second), "nsec": struct.pack("<I", 0)}
        records += record({"op": DATA, **kind, **time}, body.getvalue())
        index += struct.pack("<IIQ", second, 0, at)
    facts = {**kind, "ver": struct.pack("<I", 0), "count": struct.pack("<I", count)}
    header = file_header(len(start) + HEADER_BYTES + len(records))
    path.write_bytes(start + header + records + record({"op": INDEX, **facts}, index))
    return str(path)


def test_a_bag_of_format_1_2_is_read(tmp_path):
    with bags.open_bag(old_bag(tmp_path / "old.bag", 3)) as bag:
        assert bag.version == 102
        assert bags.topic_of(bag, "/scan") == "/scan"
        found = [(message.ranges[0], stamp.to_sec()) for _, message, stamp in bag.read_messages(["/scan"])]
    assert found == [(1.0, 1.0), (2.0, 2.0), (3.0, 3.0)]
