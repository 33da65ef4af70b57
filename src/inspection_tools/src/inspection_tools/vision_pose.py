"""The pose that the flight controller flies by without GNSS: odometry, checked and never jumping.

Odometry in the continuous frame comes in. Only good poses go out. So the flight controller knows when it has
lost its pose.
"""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from flight_basics.checks import check_parameters, limited
from flight_basics.geometry import Quaternion, Vector3, multiply, rotate, yaw_of

_X, _Y, _Z, _YAW = 0, 7, 14, 35  # of a covariance matrix of 6 x 6, row by row


class VisionState(enum.Enum):
    """Whether the flight controller gets a pose, and if not, why. The value is the state's name."""

    WAITING = "waiting"
    GOOD = "good"
    STALE = "stale"
    INVALID = "invalid"
    UNCERTAIN = "uncertain"
    JUMPED = "jumped"


@dataclass(frozen=True)
class VisionPoseParameters:
    """When a pose is good enough to fly by.

    Raises:
        ParameterError: a value out of range.
    """

    max_age: float = limited(0.3, 0.02, 10.0)
    """A pose older than this is stale, s. If none comes for this time, the last one is stale."""
    max_speed: float = limited(6.0, 0.1, 100.0)
    """The greatest speed of the UAV, m/s."""
    jump: float = limited(0.2, 0.0, 100.0)
    """A pose has jumped if it moved by this much more than max_speed allows, m."""
    jump_turn: float = limited(0.6, 0.01, math.pi)
    """A heading that changes by more than this between two poses has jumped, rad."""
    settle_time: float = limited(0.5, 0.0, 60.0)
    """After a jump the poses must be steady for this time, s. They then go on as if the UAV had flown on
    steadily between the last pose before the jump and the first one after it.
    """
    max_deviation: float = limited(0.5, 1e-3, 1e6)
    """The greatest standard deviation of the position, along any axis, m."""
    max_yaw_deviation: float = limited(0.3, 1e-3, 1e6)
    """The greatest standard deviation of the heading, rad."""
    sure_time: float = limited(0.5, 0.0, 60.0)
    """After it was uncertain, the odometry must be sure for this time, s. One that is lost finds a wrong
    place now and then, and a UAV that lands by such poses tips over.
    """
    min_rate: float = limited(30.0, 0.0, 1000.0)
    """Poses at this rate or more, Hz; 0: one for each pose that comes in. The poses between two that came in
    are interpolated.
    """

    def __post_init__(self) -> None:
        check_parameters(self)


@dataclass(frozen=True)
class Motion:
    """One nav_msgs/Odometry.

    Attributes:
        stamp_ns: Time of the measurement.
        position_m, orientation_xyzw: Of the body in the odometry's frame; a unit quaternion.
        velocity_m_s, rates_rad_s: In the body's frame.
        pose_covariance, twist_covariance: 6 x 6, row by row: x, y, z and the turns about them. The pose's is
            in the odometry's frame, the twist's in the body's.
    Position and orientation are finite.
    """

    stamp_ns: int
    position_m: Vector3
    orientation_xyzw: Quaternion
    velocity_m_s: Vector3
    rates_rad_s: Vector3
    pose_covariance: Sequence[float]
    twist_covariance: Sequence[float]

    @property
    def stamp_s(self) -> float:
        """Time of the measurement."""
        return 1e-9 * self.stamp_ns


class VisionPose:
    """Decides for each odometry which poses the flight controller gets.

    Attributes:
        state: the present one. reason: one sentence about it.
    """

    def __init__(self, parameters: VisionPoseParameters | None = None) -> None:
        self.parameters = parameters or VisionPoseParameters()
        self.reset()

    def reset(self) -> None:
        """Start anew, as after a clock that jumped back."""
        self._enter(VisionState.WAITING, "No odometry has come yet.")
        self._last: Motion | None = None  # of the odometry
        self._sent: Motion | None = None
        self._steady_since_s = self._unsure_s = -math.inf
        self._shift_m: Vector3 = (0.0, 0.0, 0.0)  # with the turn: from the odometry's frame to what goes out
        self._turn_rad = 0.0

    def update(self, motion: Motion, now_s: float) -> list[Motion]:
        """Take in an odometry at the present time. Return the poses for the flight controller, oldest first.

        The last of them is of the odometry's own time.
        """
        if not _is_known(motion):
            self.refuse("The odometry's covariance has a value that is negative or not finite.")
            return []
        before, self._last = self._last, motion
        if before is not None and motion.stamp_ns <= before.stamp_ns:
            self._last = before
            return []
        jump, unsure = self._jump(before, motion), self._uncertainty(motion)
        if unsure and self._sent is not None:  # before the first pose nothing was lost
            self._unsure_s = motion.stamp_s
        if before is not None and jump:
            self._steady_since_s = motion.stamp_s
            self._anchor(before, motion)
        if now_s - motion.stamp_s > self.parameters.max_age:
            self._enter(VisionState.STALE, f"The odometry is {now_s - motion.stamp_s:.2f} s old.")
        elif jump or motion.stamp_s - self._steady_since_s < self.parameters.settle_time:
            if jump:
                self._enter(VisionState.JUMPED, jump)
        elif unsure or motion.stamp_s - self._unsure_s < self.parameters.sure_time:
            if unsure:
                self._enter(VisionState.UNCERTAIN, unsure)
        else:
            return self._send(motion)
        return []

    def refuse(self, reason: str) -> None:
        """Take in that a message came that is not odometry. reason: one sentence."""
        self._enter(VisionState.INVALID, reason)

    def watch(self, now_s: float) -> None:
        """Notice that no odometry comes any more."""
        if self._last is None or self.state in (VisionState.WAITING, VisionState.STALE):
            return
        silence_s = now_s - self._last.stamp_s
        if silence_s > self.parameters.max_age:
            self._enter(VisionState.STALE, f"No odometry has come for {silence_s:.2f} s.")

    def _enter(self, state: VisionState, reason: str) -> None:
        self.state, self.reason = state, reason

    def _jump(self, before: Motion | None, motion: Motion) -> str:
        """Return how the pose jumped, in a sentence; empty if it did not."""
        if before is None:
            return ""
        p = self.parameters
        moved_m = math.dist(before.position_m, motion.position_m)
        if moved_m > p.max_speed * (motion.stamp_s - before.stamp_s) + p.jump:
            return f"The odometry jumped by {moved_m:.2f} m."
        turned_rad = _turn(before.orientation_xyzw, motion.orientation_xyzw)
        if abs(turned_rad) > p.jump_turn:
            return f"The odometry's heading jumped by {turned_rad:.2f} rad."
        return ""

    def _uncertainty(self, motion: Motion) -> str:
        """Return what is uncertain, in a sentence; empty if nothing is."""
        p, covariance = self.parameters, motion.pose_covariance
        for what, variance, limit, unit in (
            ("position", max(covariance[_X], covariance[_Y]), p.max_deviation, "m"),
            ("height", covariance[_Z], p.max_deviation, "m"),
            ("heading", covariance[_YAW], p.max_yaw_deviation, "rad"),
        ):
            deviation = math.sqrt(variance)
            if deviation > limit:
                return f"The odometry's {what} is uncertain: standard deviation {deviation:.2f} {unit}."
        return ""

    def _send(self, motion: Motion) -> list[Motion]:
        self._enter(VisionState.GOOD, "The flight controller gets every pose.")
        motion = self._moved(motion)
        between, self._sent = self._between(self._sent, motion), motion
        return between

    def _anchor(self, before: Motion, motion: Motion) -> None:
        """Let the poses go on over a jump, from the last one before it to the first one after it.

        The UAV flies and turns on as before for the time between both.
        """
        if self._sent is None:
            return  # nobody knows where it was
        there = self._moved(_flown_on(before, motion.stamp_s, self.parameters))
        self._turn_rad = _turn(motion.orientation_xyzw, there.orientation_xyzw)
        turned_m = rotate(_about_z(self._turn_rad), motion.position_m)
        x, y, z = (a - b for a, b in zip(there.position_m, turned_m))
        self._shift_m = (x, y, z)

    def _moved(self, motion: Motion) -> Motion:
        if self._turn_rad == 0.0 and not any(self._shift_m):
            return motion
        turn = _about_z(self._turn_rad)
        x, y, z = (a + b for a, b in zip(rotate(turn, motion.position_m), self._shift_m))
        cos, sin = math.cos(self._turn_rad), math.sin(self._turn_rad)
        both = np.kron(np.eye(2), np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0))))
        covariance = both @ np.reshape(motion.pose_covariance, (6, 6)) @ both.T
        return replace(
            motion,
            position_m=(x, y, z),
            orientation_xyzw=multiply(turn, motion.orientation_xyzw),
            pose_covariance=covariance.ravel().tolist(),
        )

    def _between(self, before: Motion | None, motion: Motion) -> list[Motion]:
        """Return the poses that fill the time since the last one, and this one.

        All together say no more than this one alone, so the covariance of each is multiplied by their number.
        """
        gap_s = 0.0 if before is None else motion.stamp_s - before.stamp_s
        count = max(1, math.ceil(gap_s * self.parameters.min_rate - 1e-6))
        if before is None or count == 1 or gap_s > self.parameters.max_age:
            return [motion]
        return [_blend(before, motion, (i + 1) / count, count) for i in range(count)]


def _flown_on(motion: Motion, until_s: float, p: VisionPoseParameters) -> Motion:
    """Return where a steady flight leads, for max_age at most. A velocity that cannot be counts as zero."""
    lasts_s = min(until_s - motion.stamp_s, p.max_age)
    if not (math.hypot(*motion.velocity_m_s) <= p.max_speed and math.isfinite(motion.rates_rad_s[2])):
        return motion
    turn_rad = lasts_s * motion.rates_rad_s[2]
    velocity_m_s = rotate(multiply(_about_z(0.5 * turn_rad), motion.orientation_xyzw), motion.velocity_m_s)
    x, y, z = (a + lasts_s * b for a, b in zip(motion.position_m, velocity_m_s))
    return replace(
        motion, position_m=(x, y, z), orientation_xyzw=multiply(_about_z(turn_rad), motion.orientation_xyzw)
    )


def _blend(a: Motion, b: Motion, share: float, weight: int) -> Motion:
    def mix(first: Sequence[float], second: Sequence[float]) -> tuple:
        return tuple(x + share * (y - x) for x, y in zip(first, second))

    sign = math.copysign(1.0, sum(x * y for x, y in zip(a.orientation_xyzw, b.orientation_xyzw)))
    mixed = mix(a.orientation_xyzw, [sign * component for component in b.orientation_xyzw])
    length = math.sqrt(sum(component * component for component in mixed))
    x, y, z, w = (component / length for component in mixed)
    return Motion(
        a.stamp_ns + round(share * (b.stamp_ns - a.stamp_ns)),
        mix(a.position_m, b.position_m),
        (x, y, z, w),
        mix(a.velocity_m_s, b.velocity_m_s),
        mix(a.rates_rad_s, b.rates_rad_s),
        [weight * value for value in b.pose_covariance],
        [weight * value for value in b.twist_covariance],
    )


def _is_known(motion: Motion) -> bool:
    """Whether the pose's covariance is one."""
    variances = (motion.pose_covariance[i] for i in (_X, _Y, _Z, _YAW))
    return all(map(math.isfinite, motion.pose_covariance)) and all(value >= 0.0 for value in variances)


def _turn(a_xyzw: Quaternion, b_xyzw: Quaternion) -> float:
    """Heading of b less that of a, in [-pi, pi]."""
    return math.remainder(yaw_of(b_xyzw) - yaw_of(a_xyzw), 2.0 * math.pi)


def _about_z(turn_rad: float) -> Quaternion:
    return (0.0, 0.0, math.sin(0.5 * turn_rad), math.cos(0.5 * turn_rad))
