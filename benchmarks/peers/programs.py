"""Peers that no package registry has. They fly if the caller says where their program is."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Callable

from benchmarks.peers import gazebo_flight, px4_flight
from benchmarks.shared.speed import Speed


@dataclass(frozen=True)
class Program:
    """A program of this machine that flies, or simulates, beside ours.

    flies: what it does, for the table. path: what the option's path names. fly: takes that path; raises
    PeerError.
    """

    flies: str
    path: str
    fly: Callable[[Path], Speed]


PROGRAMS = {
    "px4": Program(
        "PX4 SITL flies our physics in lockstep: hover, PyBullet at 250 Hz, no lidar",
        "folder build/px4_sitl_default of PX4, which you build yourself (make px4_sitl)",
        px4_flight.fly,
    ),
    "gazebo": Program(
        "Gazebo classic: our forest at 250 Hz, UST at 40 Hz on the ground, no UAV and no flight controller",
        "Gazebo classic's program gzserver",
        gazebo_flight.fly,
    ),
}
