"""Turns ROS messages, live or out of a bag, into the doctor's plain snapshot."""

from __future__ import annotations

import ast
import math
from collections import defaultdict
from dataclasses import dataclass, field
from typing import Any, Callable, Collection, Mapping

import numpy as np

from doctor.snapshot import FIRST_WALL_S, Autopilot, Parameter, Recording, Scan, Topic, Transform
from input_checks_ros.lidar_readings import UNSEEN_INTENSITY

SCANS_KEPT, EVERY_LATER_SCAN = 50, 20
"""Keep the first scans of each topic, and later one of this many."""
CLOCK_LATE_S = 0.5
"""Wall time by which /clock may be taken in later than another message of the same instant."""
ALIKE = 3
"""If so many nodes' stamps are early, it is the recorder's clock that is late."""
NOT_NEEDED = (
    "sensor_msgs/Image",
    "sensor_msgs/CompressedImage",
    "sensor_msgs/PointCloud2",
    "nav_msgs/OccupancyGrid",
)
"""Types that no check needs. They take most of the time to read, and a subscriber makes a camera render."""


@dataclass
class _Heard:
    type: str
    spans_s: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Of each publisher: when its first and its last message came."""
    received_s: list[float] = field(default_factory=list)
    stamps_s: list[float] = field(default_factory=list)
    wall_s: list[float] = field(default_factory=list)

    def add(self, publisher: str, received_s: float, stamp_s: float, wall_s: float) -> None:
        """Take in a message."""
        self.spans_s[publisher] = self.spans_s.get(publisher, (received_s,))[0], received_s
        self.received_s.append(received_s)
        self.stamps_s.append(stamp_s)
        self.wall_s.append(wall_s)

    def publishers(self) -> list[str]:
        """Return who publishes, sorted, without those that others took over from: they were restarted."""
        newest_s = max((first_s for first_s, _ in self.spans_s.values()), default=0.0)
        return sorted(name for name, (_, last_s) in self.spans_s.items() if not last_s < newest_s)


class Recorder:
    """Stores the input of the checks. Not thread-safe."""

    def __init__(self) -> None:
        self._heard: dict[str, _Heard] = {}
        self._edges: dict[tuple[str, str, str, bool], _Heard] = {}
        self._broken: set[tuple[str, str, str, bool]] = set()
        self._scans: dict[str, list[Scan]] = defaultdict(list)
        self._scans_seen: dict[str, int] = defaultdict(int)
        self._autopilots: dict[str, Autopilot] = {}
        self._ranges: dict[tuple[str, str], list] = {}
        self._choices: dict[tuple[str, str], tuple[str, ...]] = {}
        self._in_use: dict[tuple[str, str], float] = {}
        self._clock_s: list[float] = []
        self._clock_wall_s: list[float] = []

    def hear(
        self,
        topic: str,
        kind: str,
        publisher: str,
        message: Any,
        received_s: float,
        latched: bool = False,
        wall_s: float = math.nan,
    ) -> None:
        """Take in a message.

        kind: its type, e.g. sensor_msgs/LaserScan. received_s: the graph's clock. wall_s: wall time, if live.
        """
        heard = self._heard.setdefault(topic, _Heard(kind))
        stamped = hasattr(message, "header") and not latched
        heard.add(publisher, received_s, message.header.stamp.to_sec() if stamped else math.nan, wall_s)
        if topic == "/clock":
            self._clock_s.append(message.clock.to_sec())
            self._clock_wall_s.append(wall_s)
        elif kind == "tf2_msgs/TFMessage" or kind == "tf/tfMessage":
            self._hear_transforms(message, publisher, topic.endswith("_static"), received_s, wall_s)
        elif kind == "sensor_msgs/LaserScan":
            self._hear_scan(topic, message)
        elif kind == "mavros_msgs/State":
            self._autopilots[topic] = Autopilot(topic, message.connected, message.armed, message.mode)
        elif kind == "dynamic_reconfigure/ConfigDescription":
            self._hear_description(topic.rpartition("/")[0], message)
        elif kind == "dynamic_reconfigure/Config":
            self._hear_configuration(topic.rpartition("/")[0], message)

    def _hear_transforms(
        self, message: Any, publisher: str, static: bool, received_s: float, wall_s: float
    ) -> None:
        for transform in message.transforms:
            parent, child = transform.header.frame_id.lstrip("/"), transform.child_frame_id.lstrip("/")
            key = (parent, child, publisher, static)
            edge = self._edges.setdefault(key, _Heard("tf"))
            edge.add(publisher, received_s, transform.header.stamp.to_sec(), wall_s)
            shift, turn = transform.transform.translation, transform.transform.rotation
            length = math.hypot(turn.x, turn.y, turn.z, turn.w)
            if not math.isfinite(shift.x + shift.y + shift.z) or not abs(length - 1.0) < 1e-2:
                self._broken.add(key)

    def _hear_scan(self, topic: str, message: Any) -> None:
        self._scans_seen[topic] += 1
        kept = self._scans[topic]
        if len(kept) >= SCANS_KEPT and self._scans_seen[topic] % EVERY_LATER_SCAN:
            return
        limits = (
            message.angle_min,
            message.angle_max,
            message.angle_increment,
            message.range_min,
            message.range_max,
        )
        ranges, intensities = np.asarray(message.ranges, np.float32), np.asarray(message.intensities)
        if len(intensities) == len(ranges):
            ranges = np.where(intensities == UNSEEN_INTENSITY, np.float32(np.nan), ranges)
        kept.append(Scan(topic, message.header.frame_id, *limits, ranges))

    def _hear_description(self, node: str, message: Any) -> None:
        for low, high in ((low, high) for low in _numbers(message.min) for high in _numbers(message.max)):
            if low[0] == high[0]:
                self._ranges[node, low[0]] = [low[1], high[1]]
        for parameter in (one for group in message.groups for one in group.parameters):
            choices = _choices(parameter.edit_method) if parameter.type == "str" else ()
            if choices:
                self._choices[node, parameter.name] = choices

    def _hear_configuration(self, node: str, message: Any) -> None:
        for name, value in _numbers(message):
            self._in_use[node, name] = value

    def parameters(self, server: Callable[[str], Any] | None = None) -> tuple[Parameter, ...]:
        """Return all parameters described so far. server: name of a parameter to its value on the server."""
        found = []
        for (node, name), (minimum, maximum) in sorted(self._ranges.items()):
            value = server(f"{node}/{name}") if server else None
            on_server = (
                float(value) if isinstance(value, (int, float)) and not isinstance(value, bool) else None
            )
            text = str(value) if isinstance(value, (str, list, dict)) else None
            in_use = self._in_use.get((node, name))
            found.append(Parameter(node, name, minimum, maximum, on_server, in_use, text))
        for (node, name), choices in sorted(self._choices.items()):
            value = server(f"{node}/{name}") if server else None
            text = None if value is None else str(value)
            found.append(Parameter(node, name, -math.inf, math.inf, None, None, text, choices))
        return tuple(found)

    def recording(
        self,
        end_s: float,
        publishers: Mapping[str, Collection[str]] | None = None,
        subscribers: Mapping[str, Collection[str]] | None = None,
        types: Mapping[str, str] | None = None,
    ) -> Recording:
        """Return everything received so far.

        end_s: the graph's clock now. publishers, subscribers: topic to names of nodes, from the master; in a
        bag None. types: topic to type.
        """
        latest = self._latest_clock if publishers is not None else self._clock_of_a_bag(end_s)
        names = {*self._heard, *(publishers or {}), *(subscribers or {})}
        topics = {}
        for name in sorted(names):
            heard = self._heard.get(name, _Heard((types or {}).get(name, "")))
            topics[name] = Topic(
                name,
                heard.type,
                tuple(heard.publishers() if publishers is None else sorted(publishers.get(name, ()))),
                tuple(sorted((subscribers or {}).get(name, ()))),
                tuple(heard.received_s),
                tuple(heard.stamps_s),
                latest(heard),
            )
        transforms = tuple(
            Transform(*key, tuple(edge.received_s), tuple(edge.stamps_s), key in self._broken, latest(edge))
            for key, edge in sorted(self._edges.items())
        )
        scans = tuple(scan for kept in self._scans.values() for scan in kept)
        return Recording(
            topics, transforms, scans, tuple(self._autopilots.values()), tuple(self._clock_s), end_s
        )

    def _latest_clock(self, heard: _Heard) -> tuple[float, ...]:
        """Return the simulated time that each message may have come at; empty on wall time."""
        if not self._clock_wall_s:
            return ()
        ticks = np.searchsorted(self._clock_wall_s, np.array(heard.wall_s) + CLOCK_LATE_S, side="right") - 1
        return tuple(np.array(self._clock_s)[np.maximum(ticks, 0)].tolist())

    def _clock_of_a_bag(self, end_s: float) -> Callable[[_Heard], tuple[float, ...]]:
        """Return a function like `_latest_clock`. When rosbag hears /clock late, all stamps seem early."""
        leads_s: dict[str, list[float]] = defaultdict(list)
        for heard in (*self._heard.values(), *self._edges.values()):
            for publisher in heard.spans_s:
                leads_s[publisher] += (stamp - come for come, stamp in zip(heard.received_s, heard.stamps_s))
        medians_s = sorted(
            float(np.nanmedian(leads)) for leads in leads_s.values() if np.isfinite(leads).any()
        )
        common_s = max(medians_s[-ALIKE], 0.0) if end_s < FIRST_WALL_S and len(medians_s) >= ALIKE else 0.0
        return lambda heard: tuple(received_s + common_s for received_s in heard.received_s)


def _choices(edit_method: str) -> tuple[str, ...]:
    """Return a parameter's choices. dynamic_reconfigure writes an enum as the text of a Python dictionary."""
    try:
        return tuple(str(choice["value"]) for choice in ast.literal_eval(edit_method)["enum"])
    except (ValueError, SyntaxError, KeyError, TypeError):
        return ()


def _numbers(configuration: Any) -> list[tuple[str, float]]:
    """Return the numbers among a dynamic_reconfigure/Config."""
    return [(entry.name, float(entry.value)) for entry in [*configuration.ints, *configuration.doubles]]
