"""Whether the velocity that odometry tells fits its places, and in which axes it is told."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, NamedTuple

Vector3 = tuple[float, float, float]

WINDOW_S = 0.8
"""Velocity and places are compared over so long, in two halves. Only what holds in both counts. So one jump
of the places, as when a map corrects them, is no contradiction.
"""
PERIOD_S = 0.015
"""Odometry that comes more often is thinned to this."""
LONGEST_GAP_S = 0.3
"""After a longer gap nobody knows the way between two velocities; the comparison begins anew."""
JUDGED_S = 0.1
"""They are compared so often."""
SLACK_M_S, SLACK_SHARE = 0.5, 0.2
"""By so much, and by this share of the faster one, both may differ: drift, noise, and a twist that is told of
another point of a body that turns."""
LAG_S = 0.2
"""A filter's velocity may be so much older than its place."""
LEAST_M_S = 1.0
"""A slower UAV does not tell whether a reading is right: near a standstill a velocity of zero fits, too."""
REGAINED_S = 5.0
"""A reading that did not fit is believed again after it has fitted in motion for so long."""

TOLD_AXES = (
    "along the axes of the body",
    "along the axes of the odometry's own frame (header.frame_id)",
    "along the axes of the body, with y to the right and z down (FRD)",
    "along the axes of the odometry's own frame (header.frame_id), with y to the right and z down",
)
REMEDIES = (
    "set child_frame_id to the frame of the body",
    "set child_frame_id to header.frame_id, or turn the twist into the axes of the body",
    "let its source tell y to the left and z up (REP-103)",
    "let its source tell y to the left and z up, along the axes of the body",
)
BODY, ODOMETRY, PLACES = 0, 1, len(TOLD_AXES)
"""Readings of a told velocity; PLACES: none of them, but the difference of places."""


class _Instant(NamedTuple):
    time_s: float
    place_m: Vector3
    velocities_m_s: tuple[Vector3, ...]
    """By each reading, along the axes of the odometry's frame."""
    ways_m: tuple[Vector3, ...]
    """The same, integrated from any beginning."""


class VelocityCheck:
    """Takes in odometry, and returns the velocity that its places confirm, along the body's axes.

    say: takes a sentence when the velocity is read in another way than before.
    """

    def __init__(self, say: Callable[[str], None]) -> None:
        self._say = say
        self.restart()

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self._told, self.reading = BODY, BODY
        """Of the axes that child_frame_id names, and of those that count."""
        self.refuted: set[int] = set()
        """Readings that did not fit the places at some time."""
        self._instants: deque[_Instant] = deque()
        self._fitted_s = [0.0] * PLACES  # for how long each reading has fitted in motion
        self._judged_s = -math.inf

    @property
    def is_confirmed(self) -> bool:
        """Whether the motion has shown that only the told axes can be meant."""
        return self.reading == self._told and len(self.refuted) == PLACES - 1

    def velocity(
        self,
        stamp_ns: int,
        told_m_s: Vector3,
        place_m: Vector3,
        orientation_xyzw: tuple[float, float, float, float],
        is_of_odometry: bool = False,
    ) -> Vector3:
        """Return the velocity along the body's axes (x ahead, y left, z up), m/s.

        told_m_s: finite. place_m, orientation_xyzw: the body's pose in the odometry's frame. is_of_odometry:
        whether child_frame_id says that the velocity is along the axes of that frame, not of the body.
        """
        told = ODOMETRY if is_of_odometry else BODY
        if told != self._told:
            self.restart()
            self._told = self.reading = told
        time_s = 1e-9 * stamp_ns
        is_early = self._instants and 0.0 <= time_s - self._instants[-1].time_s < PERIOD_S
        if (is_early and self.reading == BODY) or not math.isfinite(sum(place_m) + sum(orientation_xyzw)):
            return told_m_s
        axes = _axes(orientation_xyzw)
        if not is_early and self._take(time_s, place_m, _readings(told_m_s, axes)):
            self._judge()
        if self.reading == BODY:
            return told_m_s
        if self.reading == PLACES:
            return _along(self._by_places(), axes)
        return _along(_readings(told_m_s, axes)[self.reading], axes)

    def _take(self, time_s: float, place_m: Vector3, velocities: tuple[Vector3, ...]) -> bool:
        """Take in an instant; return whether it is time to compare."""
        last = self._instants[-1] if self._instants else None
        passed_s = time_s - last.time_s if last else 0.0
        if last is None or not 0.0 <= passed_s <= LONGEST_GAP_S:
            self._judged_s = time_s
            self._instants = deque((_Instant(time_s, place_m, velocities, ((0.0, 0.0, 0.0),) * PLACES),))
            return False
        half_s = 0.5 * passed_s
        ways = tuple(
            (x + half_s * (a + d), y + half_s * (b + e), z + half_s * (c + f))
            for (x, y, z), (a, b, c), (d, e, f) in zip(last.ways_m, last.velocities_m_s, velocities)
        )
        self._instants.append(_Instant(time_s, place_m, velocities, ways))
        while self._instants[1].time_s <= time_s - WINDOW_S:
            self._instants.popleft()
        is_full = len(self._instants) > 4 and time_s - self._instants[0].time_s > 0.9 * WINDOW_S
        return is_full and time_s - self._judged_s >= JUDGED_S

    def _judge(self) -> None:
        """Compare each reading with the window's places, and take another one if that in use does not fit."""
        first, middle, last = self._instants[0], self._instants[len(self._instants) // 2], self._instants[-1]
        fits = [_fit(first, middle, last, reading) for reading in range(PLACES)]
        passed_s, self._judged_s = last.time_s - self._judged_s, last.time_s
        moves = math.dist(first.place_m, last.place_m) > LEAST_M_S * (last.time_s - first.time_s)
        for reading, fit in enumerate(fits):
            if fit.is_refuted:
                self.refuted.add(reading)
                self._fitted_s[reading] = 0.0
            elif fit.is_confirmed and moves:
                self._fitted_s[reading] += passed_s
        if self.reading != PLACES and fits[self.reading].is_refuted:
            fitting = [reading for reading in range(PLACES) if fits[reading].is_confirmed]
            self._read_as(min(fitting, key=lambda reading: fits[reading].miss_m, default=PLACES))
        elif self.reading == PLACES and max(self._fitted_s) >= REGAINED_S:
            self._read_as(self._fitted_s.index(max(self._fitted_s)))

    def _read_as(self, reading: int) -> None:
        self.reading = reading
        self._fitted_s = [0.0] * PLACES
        if reading == self._told:
            return
        what = (
            f"The odometry's velocity (twist) is told {TOLD_AXES[self._told]}, and does not fit its places."
        )
        if reading == PLACES:
            self._say(
                f"{what} It fits along no axes, so the change of the places counts instead. Look whether its "
                "source leaves the twist empty, sends an old one, or has another unit than m/s."
            )
        else:
            self._say(f"{what} It is read {TOLD_AXES[reading]}, where it fits: {REMEDIES[reading]}.")

    def _by_places(self) -> Vector3:
        """Return the velocity by the newest places, as if the UAV went on speeding up as between them."""
        newest = [one for one in self._instants if one.time_s >= self._instants[-1].time_s - 0.5 * WINDOW_S]
        if len(newest) < 3:
            return 0.0, 0.0, 0.0
        first, middle, last = newest[0], newest[len(newest) // 2], newest[-1]
        one_s, other_s = middle.time_s - first.time_s, last.time_s - middle.time_s
        x, y, z = (
            (c - b) / other_s + ((c - b) / other_s - (b - a) / one_s) * other_s / (one_s + other_s)
            for a, b, c in zip(first.place_m, middle.place_m, last.place_m)
        )
        return x, y, z


class _Fit(NamedTuple):
    """How well a reading fits the places of both halves of the window; both may be false."""

    is_confirmed: bool
    is_refuted: bool
    miss_m: float


def _fit(first: _Instant, middle: _Instant, last: _Instant, reading: int) -> _Fit:
    beyond, misses = [], 0.0
    for one, other in ((first, middle), (middle, last)):
        passed_s = other.time_s - one.time_s
        way_m = _less(other.place_m, one.place_m)
        told_m = _less(other.ways_m[reading], one.ways_m[reading])
        miss_m = math.dist(way_m, told_m)
        change_m_s = math.dist(one.velocities_m_s[reading], other.velocities_m_s[reading])
        farthest_m = max(math.hypot(*way_m), math.hypot(*told_m))
        beyond.append(miss_m > SLACK_M_S * passed_s + SLACK_SHARE * farthest_m + LAG_S * change_m_s)
        misses += miss_m
    return _Fit(not any(beyond), all(beyond), misses)


def _readings(told: Vector3, axes: tuple[Vector3, Vector3, Vector3]) -> tuple[Vector3, ...]:
    """Return a told velocity along the odometry's axes by each reading, in the order of TOLD_AXES."""
    x, y, z = told
    ahead, left, up = axes
    along = [(a * x, b * y + c * z) for a, b, c in zip(ahead, left, up)]
    (a, d), (b, e), (c, f) = along
    return (a + d, b + e, c + f), told, (a - d, b - e, c - f), (x, -y, -z)


def _axes(orientation_xyzw: tuple[float, float, float, float]) -> tuple[Vector3, Vector3, Vector3]:
    """Return the body's axes x, y and z along the odometry's, of a unit quaternion."""
    x, y, z, w = orientation_xyzw
    return (
        (1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y + w * z), 2.0 * (x * z - w * y)),
        (2.0 * (x * y - w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z + w * x)),
        (2.0 * (x * z + w * y), 2.0 * (y * z - w * x), 1.0 - 2.0 * (x * x + y * y)),
    )


def _along(vector: Vector3, axes: tuple[Vector3, Vector3, Vector3]) -> Vector3:
    """Return the components of a vector along three axes."""
    x, y, z = vector
    ahead, left, up = ((a * x + b * y + c * z) for a, b, c in axes)
    return ahead, left, up


def _less(one: Vector3, other: Vector3) -> Vector3:
    return one[0] - other[0], one[1] - other[1], one[2] - other[2]
