"""What the UAV knows of its surroundings: one interface, in the plane and in space, and its values.

A scan becomes an `Observation`. `Knowledge` takes it in and returns a `Snapshot`. If the reference is not
clear, it also returns an `Outlook`: what the candidates are judged by.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import NamedTuple, Sequence

import numpy as np

from cepa.dynamic.cost_to_go.course import Course, Reference
from cepa.dynamic.free_space.free_ranges import FreeRanges
from cepa.dynamic.heading import Heading
from cepa.dynamic.kernels.surroundings import Surroundings
from cepa.dynamic.remembered.space_memory import RecalledSpace
from cepa.dynamic.threats import is_within
from cepa.motion import Cloud, Motion, Ranging
from cepa.scan import Beams

ANYWHERE = np.zeros(2)
NO_COLUMNS, NO_WALLS = np.empty((0, 8)), np.empty((0, 3))


class Observation(NamedTuple):
    """What came with one scan. Arrays are along the odometry's axes, with the lidar at the origin."""

    motion: Motion
    """At the scan's stamp."""
    state: np.ndarray
    """(3, 4): of the UAV when an answer shows its effect, see kernels/response.py."""
    beams: Beams
    range_max: float
    """m: of the lidar."""
    points: np.ndarray
    """(n, 3) m: the ends of the beams."""
    is_moving: np.ndarray
    """(n,) bool: which of them belong to what moves."""
    standing: np.ndarray
    """(m, 3) m: the others, and the walls at the height of the body."""
    free: FreeRanges
    """How far each direction is free."""
    movers: np.ndarray
    """(k, 6): what moves, see `Surroundings`."""
    threats: np.ndarray
    """(j, 6): those of the movers and columns that the UAV may meet."""
    walls: np.ndarray = NO_WALLS
    """(w, 3) m: points on the walls of keep-out boxes."""
    columns: np.ndarray = NO_COLUMNS
    """(c, 8): discs that something sinks or rises into, as movers that stand; in how many s it arrives, and
    whether from above (1) or from below (-1)."""
    falling: np.ndarray = NO_COLUMNS
    """(f, 8): those of ``columns`` that clouds have shown."""
    cloud: Cloud | None = None
    rangings: Sequence[Ranging] = ()
    is_held: bool = False
    """Whether the UAV has got nowhere for long, see `HoldUp`."""

    @property
    def moving(self) -> np.ndarray:
        """(m, 2) m: where the beams meet what moves."""
        return self.points[self.is_moving, :2]


class Snapshot(NamedTuple):
    """What is known at one scan, once its observation was taken in."""

    observed: Observation
    near: np.ndarray
    """(n, 2) m: what stands at the height of the body."""
    state: np.ndarray
    """(3, 4): the observation's; in space its height counts from the middle layer of `space`."""
    space: RecalledSpace | None = None
    """What is known in three dimensions; None: the UAV flies in a plane."""
    warnings: tuple[str, ...] = ()


class Outlook(NamedTuple):
    """Everything that candidates are judged by."""

    around: Surroundings
    """Distance field, free space, what moves, and the cost-to-go."""
    has_way: bool
    """Whether there is a way out."""
    remembered: np.ndarray
    """(k, 2) or (k, 3) m: all remembered points."""
    is_hidden: np.ndarray
    """(k,) bool: which of them were not seen just now."""
    blind_way: np.ndarray = ANYWHERE
    """(2,): the UAV may only fly back along this direction; 0: anywhere."""
    climb_m_s: float = 0.0
    """Climb of the candidates, towards the height to fly at."""
    height_m: float | None = None
    """To fly at, in the axes of `Snapshot.state`; None: the UAV stays level."""
    search_climb: float = 0.0
    """1.0 or -1.0: it climbs or sinks on the spot, to look for a way at other heights; 0.0: it flies on."""


class Knowledge(ABC):
    """Keeps what the UAV knows from scan to scan. `PlaneKnowledge` and `SpaceKnowledge` are its two kinds."""

    @abstractmethod
    def take_in(self, observed: Observation) -> Snapshot:
        """Take in what came with a scan."""

    @abstractmethod
    def clear_reference(self, snapshot: Snapshot, reference: Reference, commit_s: float) -> np.ndarray | None:
        """Return the reference as a command (3,), m/s, if it may be flown as it is; else None.

        Its own path must have a clearance of r_UB, and all of it must have been seen free.
        """

    @abstractmethod
    def outlook(self, snapshot: Snapshot, reference: Reference, course: Course) -> Outlook:
        """Return the clearances, the free space and the cost-to-go around the UAV."""

    @abstractmethod
    def with_climbs(self, level: np.ndarray, climb_m_s: float) -> np.ndarray:
        """Return the commands (m, 3), m/s, to judge: ``level`` (n, 3), with climbs if the UAV can climb."""

    @abstractmethod
    def remembered(self, snapshot: Snapshot) -> tuple[np.ndarray, np.ndarray]:
        """Return all remembered points (n, 3), m, and which are hidden (n,). It changes nothing."""

    @abstractmethod
    def give_up_height(self) -> None:
        """Take in that the UAV cannot climb, or sink, any further in search of a way."""

    @property
    @abstractmethod
    def knows_one_height(self) -> bool:
        """Whether ways are known at the height of flight only."""


class Step(NamedTuple):
    """What one step works with, as soon as it is known what surrounds the UAV."""

    knowledge: Knowledge
    """Keeps what is known from step to step."""
    snapshot: Snapshot
    """What is known at this step."""
    reference: Reference
    heading: Heading
    last_command: np.ndarray
    """(3,) m/s: the last answer, along the odometry's axes."""
    commit_s: float
    """How long the answer must be safe to fly."""

    def with_climbs(self, level: np.ndarray, climb_m_s: float) -> np.ndarray:
        """Return ``level`` (n, 3), m/s, with climbs; none under what comes down: out to the side only."""
        if is_within(self.snapshot.observed.columns):
            level[:, 2] = 0.0
            return level
        return self.knowledge.with_climbs(level, climb_m_s)
