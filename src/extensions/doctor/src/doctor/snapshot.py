"""The observations of a ROS graph, live or in a bag, as plain values.

Times are seconds. `received_s` is the graph's own clock at the message's arrival: simulated time if there is
one (NaN before its first message), in a bag the recorder's. Stamps are those of the messages' headers.

Who listens on a busy machine takes messages in late, and `/clock` as well. So simulated time may have been
later at a message's arrival than `received_s`: up to `latest_s`. It is as long as `received_s`, or empty: the
same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

FIRST_WALL_S = 1e9
"""Wall time in 2001. Simulated times are below it."""


@dataclass(frozen=True)
class Topic:
    """A topic and its received messages.

    publishers, subscribers: names of nodes; in a bag only publishers. stamps_s: NaN for a message without a
    header, and for a latched one, which may be old.
    """

    name: str
    type: str
    publishers: tuple[str, ...] = ()
    subscribers: tuple[str, ...] = ()
    received_s: tuple[float, ...] = ()
    stamps_s: tuple[float, ...] = ()
    latest_s: tuple[float, ...] = ()


@dataclass(frozen=True)
class Transform:
    """An edge of TF from one publisher. broken: NaN, or a rotation that is not of unit length."""

    parent: str
    child: str
    publisher: str
    static: bool = False
    received_s: tuple[float, ...] = ()
    stamps_s: tuple[float, ...] = ()
    broken: bool = False
    latest_s: tuple[float, ...] = ()


@dataclass(frozen=True)
class Scan:
    """One sensor_msgs/LaserScan: angles in radians, ranges in metres (beams)."""

    topic: str
    frame: str
    angle_min: float
    angle_max: float
    angle_increment: float
    range_min: float
    range_max: float
    ranges: np.ndarray


@dataclass(frozen=True)
class Autopilot:
    """The last mavros_msgs/State of a topic."""

    topic: str
    connected: bool
    armed: bool
    mode: str


@dataclass(frozen=True)
class Recording:
    """All received messages. clock_s: values of /clock. end_s: the clock at the end."""

    topics: dict[str, Topic] = field(default_factory=dict)
    transforms: tuple[Transform, ...] = ()
    scans: tuple[Scan, ...] = ()
    autopilots: tuple[Autopilot, ...] = ()
    clock_s: tuple[float, ...] = ()
    end_s: float = 0.0

    @property
    def is_simulated(self) -> bool:
        """Whether its time began at 0, and not in 1970."""
        return self.end_s < FIRST_WALL_S

    def of_type(self, *types: str) -> list[Topic]:
        """Return the topics with messages of one of these types."""
        return [topic for topic in self.topics.values() if topic.type in types and topic.received_s]


@dataclass(frozen=True)
class Node:
    """A node that the master knows. answers: whether it answered a ping. package: of its program."""

    name: str
    answers: bool = True
    package: str = ""


@dataclass(frozen=True)
class Launched:
    """A node that a roslaunch has started. running: its process lives. starts: number of starts."""

    name: str
    running: bool = True
    starts: int = 1


@dataclass(frozen=True)
class Parameter:
    """A parameter that dynamic_reconfigure describes.

    on_server: its value on the parameter server, None if it is missing or no number. in_use: the node's own
    value. text_on_server: the server's text, if that is neither a number nor a choice. choices: the allowed
    values, if it is not a number.
    """

    node: str
    name: str
    minimum: float
    maximum: float
    on_server: float | None = None
    in_use: float | None = None
    text_on_server: str | None = None
    choices: tuple[str, ...] = ()


@dataclass(frozen=True)
class Graph:
    """A running graph and its received messages.

    wall_s: wall time of the observation. waited_share: of the time in which the doctor had work, the part in
    which it waited for a processor. load: programs that want a processor, for each one that there is. factor:
    the simulator's real-time factor that was asked for; 0: as fast as possible, or there is no simulator.
    """

    recording: Recording
    nodes: tuple[Node, ...] = ()
    launched: tuple[Launched, ...] = ()
    parameters: tuple[Parameter, ...] = ()
    use_sim_time: bool = False
    wall_s: float = 0.0
    waited_share: float = 0.0
    load: float = 0.0
    factor: float = 0.0

    @property
    def kept_factor(self) -> float:
        """The simulator's real-time factor; NaN without its clock."""
        ticks = self.recording.clock_s
        return (ticks[-1] - ticks[0]) / self.wall_s if len(ticks) > 1 and self.wall_s > 0.0 else math.nan
