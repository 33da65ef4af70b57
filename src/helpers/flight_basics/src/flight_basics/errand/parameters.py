"""What differs between errands, and what an errand is made of beside its leader."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True)
class ErrandParameters:
    """What differs between errands.

    name: in sentences, such as "survey". idle: the answer while nothing is flown. restart_s: wall time in
    which a node that starts again in a flight hears its pose and the battery. tell_s: between two feedbacks.
    needs_pose: a goal begins when the pose is known, not before. needs_battery: also when the battery is.
    has_map: a map that tells nothing for long sends the UAV home. photographs: a pose must be right to
    centimetres. leaves_out_jumps: a single pose that is far off does not count. tells_setpoints: feedback
    with each new setpoint. rests: the leader works on while nothing is flown.
    """

    name: str
    idle: str
    restart_s: float = 30.0
    tell_s: float = 0.5
    needs_pose: bool = True
    needs_battery: bool = False
    has_map: bool = True
    photographs: bool = False
    leaves_out_jumps: bool = True
    tells_setpoints: bool = False
    rests: bool = False


class Readings(Protocol):
    """As `exploration.energy.Readings`: charges that wait for the next look."""

    def add(self, stamp_s: float, charge: float) -> None:
        """Take in a reading."""

    def begin(self, stamp_s: float, charge: float) -> None:
        """Begin a flight with the newest reading."""

    def drain(self) -> list[tuple[float, float]]:
        """Return what waits."""
