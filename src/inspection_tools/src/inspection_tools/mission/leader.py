"""A mission as a leader of an errand: see `flight_basics.errand.leader`."""

from __future__ import annotations

import math
from typing import Any, Callable, Mapping, NamedTuple, Sequence

from flight_basics.errand.leader import Here, Outcome
from flight_basics.geometry import Vector3
from flight_basics.pose.trust import Trust
from inspection_tools.mission.waypoints import Mission, MissionStatus, Waypoint

NEARER_M = 0.5
"""A UAV that has come this much nearer to its waypoint is under way, however long the leg is."""


class Target(NamedTuple):
    """Where to fly: (x, y, z) and the heading in rad, None for any."""

    position_m: Vector3
    yaw_rad: float | None


class MissionLeader:
    """Sends one waypoint after the other. A mission that is cancelled or stalls leaves the UAV where it is.

    Args:
        read: returns the waypoints of a goal. patience_s: as that of `Mission`, with `NEARER_M`.
        on_begin: told the waypoints.

    Attributes:
        status: of the newest pose; None: there is none. reached: waypoints that are done.
    """

    reason = ""
    is_paused = is_busy = False
    has_map = True

    def __init__(
        self,
        read: Callable[[Any], tuple[Waypoint, ...]],
        patience_s: float = math.inf,
        on_begin: Callable[[tuple[Waypoint, ...]], None] = lambda _: None,
    ) -> None:
        self._read, self._patience_s, self._on_begin = read, patience_s, on_begin
        self._mission: Mission | None = None
        self._is_cancelled = False
        self._outcome: Outcome | None = None
        self.setpoint: Target | None = None
        self.kept: Mapping[str, Any] = {}
        self.status: MissionStatus | None = None
        self.reached = 0

    @property
    def end(self) -> str:
        """In a word, that it is cancelled; empty: it is not."""
        return "canceled" if self._is_cancelled else ""

    def prepare(self, content: Any) -> tuple[Waypoint, ...]:
        """Return the waypoints of a goal. Raises FlightBasicsError."""
        waypoints = self._read(content)
        Mission(waypoints)
        return waypoints

    def begin(self, plan: tuple[Waypoint, ...], here: Here | None, kept: Mapping[str, Any] | None) -> str:
        """Begin, or go on after the waypoints that are done. Raises MissionError."""
        reached = (kept or {}).get("reached", 0)
        self._mission = Mission(plan, self._patience_s, reached, NEARER_M)
        self._is_cancelled, self._outcome, self.status = False, None, None
        self.reached, self.kept = reached, {"reached": reached}
        self._on_begin(plan)
        if reached:
            return f"The mission goes on after {reached} of {len(plan)} waypoints."
        return f"A mission of {len(plan)} waypoint{'s' if len(plan) > 1 else ''} begins."

    def note(self, here: Here) -> None:
        """Nothing is noted while nothing is flown."""

    def follow(self, here: Here) -> bool:
        """Take a pose. Nothing is left to be decided then."""
        if self._mission is None:
            return False
        if self._is_cancelled:
            self.reached = 0
            self._stop_at(here, "canceled", "The mission was cancelled; the UAV holds its place.")
            return False
        self.status = status = self._mission.update(here.stamp_s, tuple(map(float, here.place_m)))
        self.reached = status.reached
        if status.stalled:
            number, patience = status.reached + 1, f"{self._patience_s:g} s"
            words = f"The UAV has come no nearer to waypoint {number} of {status.of} for {patience}."
            log = f"{words} The mission ends, and the UAV holds its place."
            self._stop_at(here, "aborted", words, log)
            return False
        if status.target_changed:
            self.kept = {"reached": status.reached}
            self.setpoint = Target(status.target.position_m, status.target.yaw_rad)
        if status.done:
            self._mission = None
            log = f"All {status.of} waypoints are done." if status.of > 1 else "The waypoint is done."
            self._outcome = Outcome("", log=log)
        return False

    def _stop_at(self, here: Here, end: str, words: str, log: str = "") -> None:
        self._mission, self._outcome = None, Outcome(words, end, log=log)
        x_m, y_m, z_m = map(float, here.place_m)
        self.setpoint = Target((x_m, y_m, z_m), None)

    def look(self, here: Here, readings: Sequence[tuple[float, float]]) -> list[str]:
        """Nothing takes long."""
        return []

    def rest(self) -> None:
        """Nothing goes on while nothing is flown."""

    def trust(self, trust: Trust, why: str, here: Here) -> None:
        """A mission flies on."""

    def pause(self, here: Here) -> None:
        """Nobody offers it."""

    def resume(self) -> None:
        """Nobody offers it."""

    def abort(self, reason: str) -> None:
        """Hold the place of the next pose."""
        self._is_cancelled = True

    def strand(self, why: str, here: Here | None) -> None:
        """Hold the last place."""
        end = "canceled" if self._is_cancelled else "aborted"
        if here is None:
            self._mission, self._outcome = None, Outcome(why, end, log=why)
        elif self._outcome is None:
            self._stop_at(here, end, f"{why} The mission ends, and the UAV holds its place.")

    def give_way(self) -> None:
        """Keep to the last setpoint until the other mission begins."""
        self._mission, self._outcome = None, Outcome("", "canceled")

    def stop_waiting(self) -> str:
        """Nothing goes on while nothing is flown."""
        return ""

    def outcome(self) -> Outcome | None:
        """Return the end of the mission."""
        return self._outcome
