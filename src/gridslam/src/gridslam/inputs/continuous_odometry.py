"""Removes jumps from odometry for the filter."""

from __future__ import annotations

import math
from typing import Callable

import numpy as np
from numpy.typing import ArrayLike

from gridslam import se2
from gridslam.errors import ScanError

FASTEST_MPS, FASTEST_RADPS = 20.0, 12.0
"""If odometry moves or turns faster than this, it has jumped."""
LEEWAY_M, LEEWAY_RAD = 0.5, 0.5
"""Error that odometry may have from one reading to the next."""


class ContinuousOdometry:
    """Odometry without jumps (a reset, a wheel in the air). During a jump the vehicle counts as at rest."""

    def __init__(self, say: Callable[[str], None]):
        self._say = say
        self._last: tuple[float, np.ndarray] | None = None  # stamp in s, and pose
        self.odom_in_continuous = np.zeros(3)

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
        if self._last is not None:
            last_s, last = self._last
            self._mend(stamp_s - last_s, last, base_in_odom)
        self._last = stamp_s, base_in_odom
        return se2.compose(self.odom_in_continuous, base_in_odom)

    def turned(self, covariance: np.ndarray) -> np.ndarray:
        """Return a pose's covariance (3, 3) in the frame without jumps."""
        cos, sin = math.cos(self.odom_in_continuous[2]), math.sin(self.odom_in_continuous[2])
        turn = np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))
        return turn @ covariance @ turn.T

    def _mend(self, seconds: float, last: np.ndarray, base_in_odom: np.ndarray) -> None:
        x, y, yaw = se2.between(last, base_in_odom)
        way_m, past_s = math.hypot(x, y), max(seconds, 0.0)
        if way_m <= LEEWAY_M + FASTEST_MPS * past_s and abs(yaw) <= LEEWAY_RAD + FASTEST_RADPS * past_s:
            return
        meanwhile = (
            f"in {seconds:.3f} s" if seconds >= 0.0 else f"while the clock went back by {-seconds:.3f} s"
        )
        self._say(
            f"Odometry jumped by {way_m:.2f} m and {math.degrees(yaw):.0f} degrees {meanwhile}; "
            "the vehicle counts as at rest during the jump."
        )
        at_rest = se2.compose(self.odom_in_continuous, last)
        self.odom_in_continuous = se2.compose(at_rest, se2.inverse(base_in_odom))

    def state(self) -> dict:
        """Return the input of ``restore``."""
        last_s, last = (None, None) if self._last is None else (self._last[0], self._last[1].tolist())
        return {"last_s": last_s, "last": last, "odom": self.odom_in_continuous.tolist()}

    def restore(self, state: dict) -> None:
        """Go on from a state.

        Raises:
            ValueError: it is none.
        """
        begun = state["last"] is not None
        self._last = (float(state["last_s"]), _pose(state["last"])) if begun else None
        self.odom_in_continuous = _pose(state["odom"])


def _pose(values: ArrayLike) -> np.ndarray:
    pose = np.array(values, dtype=float)
    if pose.shape != (3,) or not np.isfinite(pose).all():
        raise ValueError("the odometry's state is not a pose")
    return pose
