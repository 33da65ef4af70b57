"""The script of an SDF actor: where it is at which time."""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.geometry import Pose


@dataclass(frozen=True)
class Waypoint:
    """A pose in the world frame, and its time since the trajectory's start."""

    time_s: float
    pose: Pose


@dataclass(frozen=True)
class Trajectory:
    """Waypoints (one or more) in the order of their times; the last time is above zero.

    tension: 0 for a Catmull-Rom spline, 1 for a halt at each waypoint.
    """

    waypoints: tuple[Waypoint, ...]
    tension: float = 0.0

    @property
    def duration_s(self) -> float:
        """Time of the last waypoint."""
        return self.waypoints[-1].time_s


@dataclass(frozen=True)
class Script:
    """Trajectories, one after the other. delay_s: before each round. starts: by itself, or never."""

    trajectories: tuple[Trajectory, ...]
    loop: bool = True
    delay_s: float = 0.0
    starts: bool = True
