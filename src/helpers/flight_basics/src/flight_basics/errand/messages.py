"""What comes into an errand's inbox."""

from __future__ import annotations

import time
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import Any, Callable, NamedTuple

import numpy as np


@dataclass(frozen=True, eq=False)
class Goal:
    """A goal of the action. content: what it asks for.

    identity: tells it from all others, also after a restart. stamp_s: when its sender made it, by his
    clock. handle: whatever the node answers it with. came_ns: when the node heard of it, wall time.
    """

    name: str
    content: Any
    identity: str
    stamp_s: float = 0.0
    handle: Any = None
    came_ns: int = field(default_factory=time.monotonic_ns)


@dataclass(frozen=True)
class Cancel:
    """The sender of a goal does not want it any more. came_ns: as that of a goal."""

    name: str
    came_ns: int = field(default_factory=time.monotonic_ns)


class Pose(NamedTuple):
    """A pose of the UAV. place_m: (x, y, z) in the frame of the goals; None: it makes no sense.

    off_m, off_rad: what it still lacks of SLAM's correction. more: what else the leader wants to know of it.
    fault: why it makes no sense, to be told while something is flown; empty: it was told already.
    """

    stamp_s: float
    place_m: np.ndarray | None
    off_m: float = 0.0
    off_rad: float = 0.0
    more: Any = None
    fault: str = ""


class Battery(NamedTuple):
    """A charge, as it was told, right or wrong. more: for the feedback."""

    stamp_s: float
    charge: float
    more: Any = None


class MapCame(NamedTuple):
    """The planner knows a map of this time."""

    stamp_s: float


class MapId(NamedTuple):
    """Which map SLAM makes. Places of another one are in another frame."""

    word: str


class SlamState(NamedTuple):
    """What SLAM says of itself, in its word."""

    word: str


class Scan(NamedTuple):
    """In lockstep, a scan to acknowledge. header: what the acknowledgement repeats."""

    stamp_s: float
    header: Any


class Steered(NamedTuple):
    """In lockstep, the position controller has answered the pose of this time."""

    stamp_s: float


class Heard(NamedTuple):
    """In lockstep, the position controller has taken the newest setpoint."""


class Answer(NamedTuple):
    """What a person is told."""

    success: bool
    words: str


@dataclass(frozen=True, eq=False)
class Command:
    """What a person asks for by a service: pause, resume or abort. reply: gets an `Answer`.

    came_ns: as that of a goal.
    """

    name: str
    reply: Future[Any] = field(default_factory=Future)
    came_ns: int = field(default_factory=time.monotonic_ns)


@dataclass(frozen=True, eq=False)
class Question:
    """What takes long to answer.

    answer: called in the worker's thread with the UAV's place (x, y, z), or None if nobody knows it.
    needs_flight: it is asked of a flight, and refused while there is none. reply: gets what `answer`
    returns.
    """

    answer: Callable[[np.ndarray | None], Any]
    needs_flight: bool = False
    reply: Future[Any] = field(default_factory=Future)


@dataclass(frozen=True, eq=False)
class Prepared:
    """The worker has read what a goal names. why: it cannot be flown; empty: it can."""

    goal: Goal
    plan: Any = None
    why: str = ""


class Looked(NamedTuple):
    """The worker has decided. warnings: what it has found wrong. fault: why it could not decide."""

    warnings: tuple[str, ...] = ()
    fault: str = ""


class Due(NamedTuple):
    """It is time to decide anew, for another reason than a pose, such as a photograph that was taken."""


class Tick(NamedTuple):
    """Some wall time has passed. stamp_s: by ROS's clock; None: that is not known."""

    stamp_s: float | None = None


Message = (
    Goal | Cancel | Pose | Battery | MapCame | MapId | SlamState | Scan | Steered | Heard | Command | Question
    | Prepared | Looked | Due | Tick
)  # fmt: skip
