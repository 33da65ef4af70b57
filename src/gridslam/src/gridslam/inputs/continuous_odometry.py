"""Removes jumps from odometry for the filter, and says when it may have missed a part of the way."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Callable, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from gridslam import se2
from gridslam.errors import ScanError
from gridslam.inputs.usual_motion import UsualMotion, UsualMotionState

FASTEST_MPS, FASTEST_RADPS = 20.0, 12.0
"""If odometry moves or turns faster than this, it has jumped."""
LEEWAY_M, LEEWAY_RAD = 0.5, 0.5
"""Error that odometry may have from one reading to the next."""

RESTART_SHARE, SUSPICIOUS_SHARE = 1.5, 3.0
"""A step to the origin that is this many times the longest one so far is a restart; one to anywhere else that
is so many times the longest makes the pose doubtful.
"""
EXACT, NEAR_M, NEAR_RAD = 1e-6, 0.1, 0.1
"""m and rad: odometry this near its origin is there exactly, or has just begun to move."""
SILENCE_S, SILENCE_SHARE, SILENCE_MEANS = 5.0, 3.0, 20.0
"""Without readings for so long, a part of the way is missing, if that is so many times the longest time so
far and so many times the mean one, or if the step is longer than usual. Some vehicles give no scans at rest.
"""
MOVING_SHARE = 0.5
"""If odometry has moved by more than this share of its mean way, it went on while scans lacked."""
DETOUR_M, DETOUR_RAD = 1.0, 0.3
"""Deviations that a missing part of the way adds at most. What errs more is left to the search."""
DETOUR_M_PER_SQRT_M, DETOUR_RAD_PER_SQRT_M = 0.1, 0.1


class Doubt(NamedTuple):
    """Why the vehicle may be elsewhere than odometry says."""

    reason: str
    deviations: tuple[float, float, float]
    """m, m, rad: by which the motion is more uncertain."""
    is_way_known: bool = False
    """Whether odometry has moved as usual meanwhile, so that it tells the whole way and only scans lack."""


@dataclass(frozen=True, eq=False)
class OdometryState:
    """A `ContinuousOdometry` to save.

    Raises:
        ValueError: a pose is none.
    """

    last_s: float | None
    """None: there was no reading yet."""
    last: np.ndarray | None
    """(3,) the newest reading."""
    first: np.ndarray
    """(3,) the first reading since odometry began, or began anew."""
    odom_in_continuous: np.ndarray
    """(3,)"""
    usual: UsualMotionState

    def __post_init__(self) -> None:
        poses = [self.first, self.odom_in_continuous] + ([] if self.last is None else [self.last])
        for pose in poses:
            if pose.shape != (3,) or not np.isfinite(pose).all():
                raise ValueError("the odometry's state is not a pose")


class ContinuousOdometry:
    """Odometry without jumps (a reset, a wheel in the air). During a jump the vehicle counts as at rest.

    Odometry may begin anew, at zero or where it began first. Slow scans would excuse such a step by its
    speed. So it is also compared with the steps so far.
    """

    def __init__(self, say: Callable[[str], None]):
        self._say = say
        self._last: tuple[float, np.ndarray] | None = None  # stamp in s, and pose
        self._first = np.zeros(3)
        self._usual = UsualMotion()
        self.odom_in_continuous = np.zeros(3)
        self.doubt: Doubt | None = None
        """Why the newest reading may not tell the whole way since the one before; None: nothing is odd."""
        self.has_jumped = False
        """Whether the newest reading was a jump from the one before."""

    @property
    def last_s(self) -> float:
        """Stamp of the newest pose, s; NaN before the first one."""
        return math.nan if self._last is None else self._last[0]

    def follow(self, stamp_s: float, base_in_odom: ArrayLike) -> np.ndarray:
        """Return the base in a frame in which it never jumps. At first this is the odometry's own frame.

        Raises:
            ScanError: the pose is not finite.
        """
        base_in_odom = np.asarray(base_in_odom, dtype=float)
        if base_in_odom.shape != (3,) or not np.isfinite(base_in_odom).all():
            raise ScanError(f"The odometry's pose {base_in_odom.tolist()} is not finite x, y, yaw.")
        self.doubt, self.has_jumped = None, False
        if self._last is None:
            self._first = base_in_odom
        else:
            last_s, last = self._last
            self._follow_step(stamp_s - last_s, last, base_in_odom)
        self._last = stamp_s, base_in_odom
        return se2.compose(self.odom_in_continuous, base_in_odom)

    def turned(self, covariance: np.ndarray) -> np.ndarray:
        """Return a pose's covariance (3, 3) in the frame without jumps."""
        cos, sin = math.cos(self.odom_in_continuous[2]), math.sin(self.odom_in_continuous[2])
        turn = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
        return turn @ covariance @ turn.T

    def _follow_step(self, seconds: float, last: np.ndarray, base_in_odom: np.ndarray) -> None:
        x, y, yaw = se2.between(last, base_in_odom)
        way_m, turn_rad, past_s = math.hypot(x, y), abs(yaw), max(seconds, 0.0)
        is_too_fast = (
            way_m > LEEWAY_M + FASTEST_MPS * past_s or turn_rad > LEEWAY_RAD + FASTEST_RADPS * past_s
        )
        if is_too_fast or self._has_begun_anew(past_s, way_m, turn_rad, base_in_odom):
            self._mend(seconds, last, base_in_odom, (way_m, yaw))
            return
        self.doubt = self._doubt_of(past_s, way_m, turn_rad)
        self._usual.add(past_s, way_m, turn_rad)

    def _has_begun_anew(
        self, seconds: float, way_m: float, turn_rad: float, base_in_odom: np.ndarray
    ) -> bool:
        """Return whether a step has led to the origin, and is no usual one."""
        if not self._usual.is_known:
            return False
        most_m, most_rad = self._usual.most(seconds)
        mean_m, mean_rad = self._usual.mean(seconds)
        for origin in (np.zeros(3), self._first):
            x, y, yaw = se2.between(origin, base_in_odom)
            off_m, off_rad = math.hypot(x, y), abs(yaw)
            if off_m < EXACT and off_rad < EXACT and (way_m > most_m or turn_rad > most_rad):
                return True
            is_near = off_m <= NEAR_M + mean_m and off_rad <= NEAR_RAD + mean_rad
            is_unusual = (
                way_m > LEEWAY_M + RESTART_SHARE * most_m or turn_rad > LEEWAY_RAD + RESTART_SHARE * most_rad
            )
            if is_near and is_unusual:
                return True
        return False

    def _doubt_of(self, seconds: float, way_m: float, turn_rad: float) -> Doubt | None:
        if not self._usual.is_known:
            return None
        if self._is_silence(seconds, way_m):
            reason, missing_m = f"{seconds:.1f} s before this scan are missing", self._usual.mean(seconds)[0]
            if way_m > MOVING_SHARE * missing_m and not self._is_suspicious(seconds, way_m, turn_rad=0.0):
                return Doubt(reason, (0.0, 0.0, 0.0), is_way_known=True)
            deviation_m = min(DETOUR_M, DETOUR_M_PER_SQRT_M * math.sqrt(missing_m))
            deviation_rad = min(DETOUR_RAD, DETOUR_RAD_PER_SQRT_M * math.sqrt(missing_m))
            deviations = (deviation_m, deviation_m, deviation_rad)
            return Doubt(reason, deviations)
        if self._is_suspicious(seconds, way_m, turn_rad):
            reason = f"odometry has moved by {way_m:.2f} m and {math.degrees(turn_rad):.0f} degrees at once"
            return Doubt(reason, (DETOUR_M, DETOUR_M, DETOUR_RAD))
        return None

    def _is_suspicious(self, seconds: float, way_m: float, turn_rad: float) -> bool:
        most_m, most_rad = self._usual.most(seconds)
        is_far = way_m > LEEWAY_M + SUSPICIOUS_SHARE * most_m
        return is_far or turn_rad > LEEWAY_RAD + SUSPICIOUS_SHARE * most_rad

    def is_silence(self, seconds: float) -> bool:
        """Return whether so long a time without a reading that counts is no usual one.

        The longest time so far tells nothing here: one silence does not make the next one usual.
        """
        usual = self._usual
        mean_s = usual.seconds / usual.readings if usual.is_known else 0.0
        return seconds > max(SILENCE_S, SILENCE_MEANS * mean_s)

    def _is_silence(self, seconds: float, way_m: float) -> bool:
        usual = self._usual
        is_unusual = seconds > max(
            SILENCE_SHARE * usual.longest_s, SILENCE_MEANS * usual.seconds / usual.readings
        )
        is_long = way_m > LEEWAY_M + SUSPICIOUS_SHARE * usual.longest_m
        return seconds > SILENCE_S and (is_unusual or is_long)

    def _mend(
        self, seconds: float, last: np.ndarray, base_in_odom: np.ndarray, step: tuple[float, float]
    ) -> None:
        """Let the vehicle be at rest during a jump, by a step of way in m and turn in rad."""
        self.has_jumped = True
        meanwhile = (
            f"in {seconds:.3f} s" if seconds >= 0.0 else f"while the clock went back by {-seconds:.3f} s"
        )
        self._say(
            f"Odometry jumped by {step[0]:.2f} m and {math.degrees(step[1]):.0f} degrees {meanwhile}; "
            "the vehicle counts as at rest during the jump."
        )
        at_rest = se2.compose(self.odom_in_continuous, last)
        self.odom_in_continuous = se2.compose(at_rest, se2.inverse(base_in_odom))
        self._first = base_in_odom
        way_m, turn_rad = self._usual.mean(max(seconds, 0.0))
        deviations = (min(DETOUR_M, way_m), min(DETOUR_M, way_m), min(DETOUR_RAD, turn_rad))
        self.doubt = Doubt("odometry has jumped", deviations)

    def state(self) -> OdometryState:
        """Return all that is known of the odometry."""
        last_s, last = (None, None) if self._last is None else self._last
        return OdometryState(last_s, last, self._first, self.odom_in_continuous, self._usual.state())

    def restore(self, state: OdometryState) -> None:
        """Go on from a state."""
        if state.last_s is not None and state.last is not None:
            self._last = (float(state.last_s), state.last)
        self._first, self.odom_in_continuous = state.first, state.odom_in_continuous
        self._usual.restore(state.usual)
