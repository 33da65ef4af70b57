"""A mission: waypoints flown one after the other, each within its tolerance and held for its time."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

from flight_basics.bounds import FARTHEST_M
from flight_basics.checks import check_number, check_parameters, limited
from flight_basics.errors import MissionError, PoseError
from stamp_pairing.clock_steps import SteadyTime

LONGEST_HOLD_S = 86_400.0


@dataclass(frozen=True)
class Waypoint:
    """A place to fly to.

    Attributes:
        position_m: (x, y, z) in the poses' frame.
        yaw_rad: Heading of the setpoint, or None for any. With position setpoints the UAV turns to it. With
            the yaw regulator the UAV turns to its direction of flight. The mission does not wait for the
            heading.
        tolerance_m: The UAV has arrived if it is nearer than this (in space).
        hold_s: Time that the UAV must stay there without a break; 0: it flies on at once.

    Raises:
        ParameterError: a value out of range.
    """

    position_m: tuple
    yaw_rad: float | None = limited(None, -100.0, 100.0, named="yaw")
    tolerance_m: float = limited(0.3, 0.01, 100.0, named="tolerance")
    hold_s: float = limited(0.0, 0.0, LONGEST_HOLD_S, named="hold")

    def __post_init__(self) -> None:
        for axis, value in zip("xyz", self.position_m):
            check_number(axis, value, -FARTHEST_M, FARTHEST_M)
        check_parameters(self)


def headings_shown(waypoints: Sequence[Waypoint]) -> list[float]:
    """Return the heading of an arrow at each waypoint, rad: its yaw, or else towards the next place.

    Without a yaw, the last arrow points along the leg to its place. So does an arrow whose next place is
    straight above or below.
    """
    legs = zip(waypoints, [*waypoints[1:], waypoints[-1]])
    ways = [_way(here.position_m, there.position_m) for here, there in legs]
    way_rad = next((way for way in ways if way is not None), 0.0)
    headings = []
    for waypoint, way in zip(waypoints, ways):
        way_rad = way_rad if way is None else way
        headings.append(way_rad if waypoint.yaw_rad is None else waypoint.yaw_rad)
    return headings


def _way(here_m: tuple, there_m: tuple) -> float | None:
    """Heading from one place to another, rad; None if one is straight above the other."""
    ahead_m, left_m = there_m[0] - here_m[0], there_m[1] - here_m[1]
    return math.atan2(left_m, ahead_m) if math.hypot(ahead_m, left_m) > 1e-3 else None


@dataclass(frozen=True)
class MissionStatus:
    """Answer to one pose.

    Attributes:
        target: The waypoint to fly to; after the end the last one.
        reached: Number of waypoints done.
        of: Number of all waypoints.
        distance_m: From this pose to the target before this pose, m.
        holding_s: Time that the UAV has been there.
        target_changed: Whether `target` is new with this pose.
        done: Whether all waypoints are done.
        stalled: Whether the mission's patience is over before the target is reached.
    """

    target: Waypoint
    reached: int
    of: int
    distance_m: float
    holding_s: float
    target_changed: bool
    done: bool
    stalled: bool


class Mission:
    """Flies one list of waypoints. Poses and their stamps drive it, not a clock."""

    def __init__(
        self,
        waypoints: Sequence[Waypoint],
        patience_s: float = math.inf,
        reached: int = 0,
        nearer_m: float = math.inf,
    ) -> None:
        """Begin at the first waypoint that is not reached yet.

        Args:
            waypoints: To fly to, in this order.
            patience_s: If a waypoint is not reached within this time, the mission has stalled. The time of
                hold does not count.
            reached: Number of waypoints that are done already; at least one must be left.
            nearer_m: The patience begins anew whenever the UAV is this much nearer to the waypoint than when
                it began last. So a long leg needs no longer patience. Infinite: only with a new waypoint.

        Raises:
            MissionError: there is no waypoint, or none that is not reached.
        """
        if not waypoints:
            raise MissionError("The mission has no waypoints; give at least one.")
        if not 0 <= reached < len(waypoints):
            raise MissionError(f"Of {len(waypoints)} waypoints {reached} cannot be done already.")
        self._waypoints = tuple(waypoints)
        self._patience_s, self._nearer_m = patience_s, nearer_m
        self._under_way_s: float | None = None  # when the patience began
        self._began_at_m = math.inf  # how far the target was then
        self._reached = reached
        self._told = -1
        self._arrived_s: float | None = None
        self._time = SteadyTime()

    def update(self, stamp_s: float, position_m: Sequence[float]) -> MissionStatus:
        """Take in a pose.

        At most one waypoint is done by it. Hold and patience count what passes: a clock that is set, ahead or
        back, changes neither.

        Args:
            stamp_s: The pose's time.
            position_m: (x, y, z) in the waypoints' frame.

        Raises:
            PoseError: a value is not finite. The state does not change then.
        """
        if not all(math.isfinite(value) for value in (stamp_s, *position_m)):
            raise PoseError("The pose has a value that is not finite.")
        now_s = self._time.at(stamp_s)
        target = self._target()
        distance_m = math.dist(position_m, target.position_m)
        holding_s = self._hold(now_s, distance_m <= target.tolerance_m)
        is_nearer = distance_m <= self._began_at_m - self._nearer_m
        if self._under_way_s is None or self._arrived_s is not None or is_nearer:
            self._under_way_s, self._began_at_m = now_s, distance_m
        if self._arrived_s is not None and holding_s >= target.hold_s and not self.done:
            self._reached += 1
            self._arrived_s = None
            self._began_at_m = math.dist(position_m, self._target().position_m)
        changed, self._told = self._told != self._index(), self._index()
        return MissionStatus(
            target=self._target(),
            reached=self._reached,
            of=len(self._waypoints),
            distance_m=distance_m,
            holding_s=holding_s,
            target_changed=changed,
            done=self.done,
            stalled=not self.done and now_s - self._under_way_s > self._patience_s,
        )

    @property
    def done(self) -> bool:
        """Whether every waypoint is done."""
        return self._reached == len(self._waypoints)

    def _index(self) -> int:
        return min(self._reached, len(self._waypoints) - 1)

    def _target(self) -> Waypoint:
        return self._waypoints[self._index()]

    def _hold(self, now_s: float, there: bool) -> float:
        if not there:
            self._arrived_s = None
            return 0.0
        if self._arrived_s is None:
            self._arrived_s = now_s
        return now_s - self._arrived_s


def way_m(waypoints: Sequence[Waypoint], start_m: Sequence[float]) -> float:
    """Return the length of the straight legs from `start_m` (x, y, z) through all waypoints, m."""
    places = [tuple(start_m), *(waypoint.position_m for waypoint in waypoints)]
    return sum(math.dist(a, b) for a, b in zip(places, places[1:]))


def hold_s(waypoints: Sequence[Waypoint]) -> float:
    """Return the time that the UAV must stay at all waypoints together, s."""
    return sum(waypoint.hold_s for waypoint in waypoints)


def way_home(waypoints: Sequence[Waypoint], reached: int, start_m: Sequence[float]) -> tuple[Waypoint, ...]:
    """Return the waypoints back to the start, along the legs of the mission, which are known to be free.

    The way leads on to the next waypoint that is at the start, or back through those that are done. It is the
    shorter one. The UAV holds at none of them.

    Args:
        waypoints: The mission.
        reached: Number of waypoints done.
        start_m: (x, y) or (x, y, z) of the start. The height is that of the mission there.
    """
    done, left = waypoints[:reached], waypoints[reached:]
    back, on = _before_start(done[::-1], start_m), _before_start(left, start_m)
    here_m = waypoints[max(reached - 1, 0)].position_m
    ways = [tuple(done[::-1]) if back is None else back, *([] if on is None else [on])]
    return min((_ending_at(start_m, way, here_m) for way in ways), key=lambda way: way_m(way, here_m))


def _before_start(waypoints: Sequence[Waypoint], start_m: Sequence[float]) -> tuple[Waypoint, ...] | None:
    """Return the waypoints before the first one that is at the start; None if there is no such one."""
    for i, waypoint in enumerate(waypoints):
        if math.dist(waypoint.position_m[:2], start_m[:2]) <= waypoint.tolerance_m:
            return tuple(waypoints[:i])
    return None


def _ending_at(
    start_m: Sequence[float], way: Sequence[Waypoint], here_m: Sequence[float]
) -> tuple[Waypoint, ...]:
    height_m = way[-1].position_m[2] if way else here_m[2]
    passed = (replace(waypoint, hold_s=0.0) for waypoint in way)
    return (*passed, Waypoint((start_m[0], start_m[1], height_m)))
