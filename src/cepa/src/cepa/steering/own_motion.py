"""The lidar's motion by odometry, for algorithms that remember."""

from __future__ import annotations

import math
from typing import Callable, NamedTuple

from cepa.errors import MotionError
from cepa.motion import DOUBTED, Doubt, Motion, Quaternion, Vector3
from cepa.steering.mount import Mount
from input_checks.velocity import VelocityCheck
from stamp_pairing.pairing import Paired

MAX_AGE_NS = 500_000_000
JUMP_M, SPEED_FACTOR = 0.3, 1.5
"""From scan to scan the lidar moves no farther than this, and this times its speed."""
JUMP_RAD, TURN_RATE_RAD_S = 0.2, 6.0


class OwnState(NamedTuple):
    """What CEPA takes of odometry, in the odometry's frame."""

    velocity_m_s: Vector3 | None
    """Along the body's axes; None: it makes no sense."""
    position_m: Vector3
    orientation_xyzw: Quaternion
    is_told_in_odometry: bool = False
    """Whether the velocity is still along the axes of the odometry's frame, as its source has told it."""

    def checked(self, stamp_ns: int, check: VelocityCheck) -> OwnState:
        """Return the state with the velocity that its places confirm, along the body's axes."""
        if self.velocity_m_s is None:
            return self
        told = self.velocity_m_s, self.position_m, self.orientation_xyzw, self.is_told_in_odometry
        return self._replace(velocity_m_s=check.velocity(stamp_ns, *told), is_told_in_odometry=False)


def yaw_of(state: OwnState | None) -> float | None:
    """Return the body's yaw; None if it is not known, or its orientation makes no sense."""
    if state is None or not abs(math.hypot(*state.orientation_xyzw) - 1.0) < 0.01:
        return None
    x, y, z, w = state.orientation_xyzw
    return math.atan2(2.0 * (x * y + w * z), 1.0 - 2.0 * (y * y + z * z))


class OwnMotion:
    """Turns odometry into motions, and finds odometry that no UAV can have flown."""

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self.restart()

    def restart(self) -> None:
        """Forget the last motion, as after a clock that jumped back."""
        self._last: Motion | None = None

    def at(
        self, paired: Paired, mount: Mount, climb_ref_m_s: float, doubt: Doubt = DOUBTED
    ) -> tuple[Motion | None, bool]:
        """Return the lidar's motion for a scan, and whether it goes on from that for the last scan.

        The motion is None, with a warning, if odometry does not tell it.
        """
        last, self._last = self._last, None
        try:
            self._last = _motion(paired, mount, climb_ref_m_s, doubt)
        except MotionError as error:
            self._warn(f"{error} Nothing is remembered, and the last command counts as own velocity.")
        return self._last, self._last is None or last is None or not self._has_jumped(last, self._last)

    def _has_jumped(self, last: Motion, motion: Motion) -> bool:
        period_s = abs((motion.stamp_s - motion.age_s) - (last.stamp_s - last.age_s))
        speed = max(math.hypot(*last.velocity_m_s), math.hypot(*motion.velocity_m_s))
        way_m = math.dist(last.position_m, motion.position_m)
        cosine = abs(sum(a * b for a, b in zip(last.orientation_xyzw, motion.orientation_xyzw)))
        turn_rad = 2.0 * math.acos(min(1.0, cosine))
        if (
            way_m <= JUMP_M + SPEED_FACTOR * speed * period_s
            and turn_rad <= JUMP_RAD + TURN_RATE_RAD_S * period_s
        ):
            return False
        self._warn(
            f"The odometry jumped by {way_m:.2f} m and {math.degrees(turn_rad):.0f} degrees within "
            f"{period_s:.3f} s; what was seen is forgotten. Check its source."
        )
        return True


def _motion(paired: Paired, mount: Mount, climb_ref_m_s: float, doubt: Doubt) -> Motion:
    """Raises MotionError."""
    odometry = paired.values["odometry"]
    if odometry is None:
        raise MotionError("No odometry has come yet.")
    age_ns = paired.leader.stamp_ns - odometry.stamp_ns
    state: OwnState = odometry.value
    if abs(age_ns) > MAX_AGE_NS:
        how = "older" if age_ns > 0 else "newer"
        raise MotionError(f"The odometry is {1e-9 * abs(age_ns):.2f} s {how} than the scan.")
    if state.velocity_m_s is None:
        raise MotionError("The odometry tells no velocity.")
    body = state.position_m, state.orientation_xyzw, state.velocity_m_s
    age_s = 1e-9 * max(0, age_ns)
    return Motion.of_mounted(1e-9 * paired.leader.stamp_ns, *body, *mount[1:], climb_ref_m_s, age_s, doubt)
