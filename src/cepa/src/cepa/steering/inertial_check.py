"""Whether odometry and IMU agree on how the UAV moves: then what moves alike around it is no drift."""

from __future__ import annotations

import math
from collections import deque
from typing import Callable, NamedTuple

import numpy as np

from cepa.motion import DOUBTED, Doubt, rotation_matrix
from cepa.steering.inertial_path import InertialPath, InertialReading
from cepa.steering.own_motion import OwnState

LAG_NS = 100_000_000
"""So much older than the scan is the newest odometry that counts. Its readings have come by then, however
slow the machine is, so the outcome does not depend on which message was faster."""
WINDOW_S = 1.0
"""Both are compared over so long."""
PERIOD_NS = 20_000_000
"""Odometry that comes more often is thinned to this."""
LONGEST_GAP_NS = 200_000_000
"""After a longer time without a reading, or without odometry, the comparison begins anew."""
BACK_NS = 500_000_000
"""If the stamp of a reading is older than the last by this much, the IMU's clock went back."""
KEPT_READINGS = 4096
SILENT_NS = 1_000_000_000
"""A silence that lasts longer is told."""

SIGNIFICANCE = 3.0
"""Standard deviations by which odometry and IMU may differ."""
GYRO_BIAS_RAD_S = 0.005
ACCELERATION_BIAS_M_S2 = 0.1
"""Standard deviations, also for an attitude that is wrong by 0.01 rad."""
YAW_NOISE_RAD, PLACE_NOISE_M = 0.005, 0.03
"""Standard deviations of the odometry from message to message."""
DOUBTED_S = 5.0
"""What the IMU did not confirm is doubted for so long. After a change of speed that the IMU has not felt, the
odometry may drift on at a steady speed, which no IMU feels."""
GRAVITY_M_S2 = np.array([0.0, 0.0, 9.80665])


class _Instant(NamedTuple):
    """Odometry at an instant, and what the IMU felt since the last one."""

    time_s: float
    position_m: tuple[float, float, float]
    axes: np.ndarray
    """(3, 3): of the body by odometry, in the odometry's frame, as columns."""
    felt_axes: np.ndarray
    """(3, 3): the same by the gyroscope, in axes that nothing but its errors turns."""
    gain_m_s: np.ndarray
    way_m: np.ndarray
    """Speed and way (3,) in these axes, as if gravity were an acceleration upwards."""


class InertialCheck:
    """Takes in IMU and odometry, in any order, and tells at each scan what of the odometry is in doubt.

    Over a window, the odometry's turn about the vertical is compared with the gyroscope's rates, and its
    changes of speed with the integrated specific force. Where they differ by less than their uncertainty, no
    doubt is left. What the IMU does not tell is doubted. warn: takes a sentence whenever something begins to
    be wrong.
    """

    def __init__(self, warn: Callable[[str], None]) -> None:
        self._warn = warn
        self._is_told = False  # that the IMU is silent
        self.restart()

    def restart(self) -> None:
        """Forget everything, as after a clock that jumped back."""
        self._readings: deque[tuple[int, InertialReading]] = deque(maxlen=KEPT_READINGS)
        self._states: deque[tuple[int, OwnState]] = deque(maxlen=KEPT_READINGS)
        self.newest_ns: int | None = None
        """Stamp of the newest reading."""
        self._compared_ns: int | None = None
        self._first_scan_ns: int | None = None
        self._doubted_until_s = [-math.inf, -math.inf]  # turn and shift
        self._begin_anew()

    def _begin_anew(self) -> None:
        self._path: InertialPath | None = None
        self._instants: deque[_Instant] = deque()

    def on_reading(self, stamp_ns: int, reading: InertialReading) -> None:
        """Take in a reading. One that is not newer than the last is left out."""
        if self.newest_ns is not None and stamp_ns <= self.newest_ns:
            if stamp_ns < self.newest_ns - BACK_NS:
                self._warn("The IMU's stamps went back; the odometry is compared with it anew.")
                self.restart()
            else:
                return
        self.newest_ns = stamp_ns
        self._readings.append((stamp_ns, reading))

    def on_odometry(self, stamp_ns: int, state: OwnState) -> None:
        """Take in odometry. What is not newer than the last by `PERIOD_NS` is left out."""
        last_ns = self._states[-1][0] if self._states else self._compared_ns
        numbers = (*state.position_m, *state.orientation_xyzw)
        is_due = last_ns is None or stamp_ns - last_ns >= PERIOD_NS
        if is_due and all(map(math.isfinite, numbers)) and abs(math.hypot(*numbers[3:]) - 1.0) < 0.01:
            self._states.append((stamp_ns, state))

    def doubt_at(self, scan_ns: int) -> Doubt:
        """Return what of the odometry is in doubt at a scan."""
        while self._states and self._states[0][0] <= scan_ns - LAG_NS:
            self._compare(*self._states.popleft())
        self._tell_silence(scan_ns)
        if not self._instants or scan_ns - (self._compared_ns or 0) > 3 * LAG_NS:
            return DOUBTED
        if self._instants[-1].time_s - self._instants[0].time_s < 0.9 * WINDOW_S:
            return DOUBTED
        return self._doubt()

    def _tell_silence(self, scan_ns: int) -> None:
        self._first_scan_ns = self._first_scan_ns or scan_ns
        is_silent = scan_ns - max(self._first_scan_ns, self.newest_ns or 0) > SILENT_NS
        if is_silent and not self._is_told:
            self._warn(
                f"No reading of the IMU has come for {1e-9 * SILENT_NS:g} s; the odometry is not compared "
                "with it, so things that move alike may count as its drift. Check the topic imu."
            )
        if is_silent or self.newest_ns is not None:  # a clock that jumps back is no reason to say it again
            self._is_told = is_silent

    def _compare(self, stamp_ns: int, state: OwnState) -> None:
        """Follow the IMU up to odometry's stamp, and keep both for the window."""
        last_ns, self._compared_ns = self._compared_ns, stamp_ns
        if last_ns is not None and stamp_ns - last_ns > LONGEST_GAP_NS:
            self._begin_anew()
        if not self._follow(stamp_ns):
            self._begin_anew()
            return
        assert self._path is not None
        time_s, axes = 1e-9 * stamp_ns, rotation_matrix(state.orientation_xyzw)
        self._instants.append(
            _Instant(time_s, state.position_m, axes, self._path.axes(), *self._path.next_leg())
        )
        while time_s - self._instants[0].time_s > WINDOW_S + 1e-6:
            self._instants.popleft()

    def _follow(self, stamp_ns: int) -> bool:
        """Integrate the readings up to a stamp; return whether there are any without a gap."""
        while self._readings and self._readings[0][0] <= stamp_ns:
            read_ns, reading = self._readings.popleft()
            if self._path is None or read_ns - self._path.read_ns > LONGEST_GAP_NS:
                self._begin_anew()
                self._path = InertialPath(read_ns, reading)
            else:
                self._path.take(read_ns, reading)
        if self._path is None or stamp_ns - self._path.read_ns > LONGEST_GAP_NS:
            return False
        later = self._readings[0] if self._readings else None
        is_gap = later is None or later[0] - self._path.read_ns > LONGEST_GAP_NS
        self._path.go_on(stamp_ns, None if is_gap else later)
        return True

    def _doubt(self) -> Doubt:
        """Compare both over the window."""
        now_s = self._instants[-1].time_s
        for number, agrees in enumerate((self._turns_alike(), self._speeds_up_alike())):
            if not agrees:
                self._doubted_until_s[number] = now_s + DOUBTED_S
        turn, shift = (now_s < until_s for until_s in self._doubted_until_s)
        return Doubt(turn, shift)

    def _turns_alike(self) -> bool:
        """Whether odometry and gyroscope turn about the vertical as fast."""
        axes, felt_axes = self._axes()
        off = axes @ (axes[0] @ felt_axes[0].T @ felt_axes).transpose(0, 2, 1)
        off_rad = np.unwrap(np.arctan2(off[:, 1, 0], off[:, 0, 0]))
        rate, deviation = _fitted(self._times_s(), off_rad[:, None], 1)
        limit_rad_s = SIGNIFICANCE * math.hypot(GYRO_BIAS_RAD_S, YAW_NOISE_RAD * deviation)
        return bool(abs(rate[0]) <= limit_rad_s)

    def _speeds_up_alike(self) -> bool:
        """Whether the speed changes by odometry as the specific force tells.

        Nobody knows the speed at the window's beginning. So only what bends between both ways is a change.
        """
        times_s, (axes, felt_axes) = self._times_s(), self._axes()
        into_odometry = axes[0] @ felt_axes[0].T
        gains = np.array([instant.gain_m_s for instant in self._instants])[1:] @ into_odometry.T
        ways = np.array([instant.way_m for instant in self._instants])[1:] @ into_odometry.T
        speeds = np.cumsum(gains, axis=0) - gains
        felt_m = np.zeros((len(times_s), 3))
        felt_m[1:] = np.cumsum(np.diff(times_s)[:, None] * speeds + ways, axis=0)
        felt_m -= 0.5 * GRAVITY_M_S2 * (times_s - times_s[0])[:, None] ** 2
        off_m = np.array([instant.position_m for instant in self._instants]) - felt_m
        bends, deviation = _fitted(times_s, off_m, 2)
        window_s = times_s[-1] - times_s[0]
        noise_m_s = 2.0 * window_s * PLACE_NOISE_M * deviation
        limit_m_s = SIGNIFICANCE * math.hypot(ACCELERATION_BIAS_M_S2 * window_s, noise_m_s)
        return bool((2.0 * window_s * np.abs(bends) <= limit_m_s).all())  # NaN fails, too

    def _times_s(self) -> np.ndarray:
        return np.array([instant.time_s for instant in self._instants])

    def _axes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the body's axes (n, 3, 3) by odometry, and by the gyroscope."""
        by_odometry = np.array([instant.axes for instant in self._instants])
        return by_odometry, np.array([instant.felt_axes for instant in self._instants])


def _fitted(times_s: np.ndarray, values: np.ndarray, degree: int) -> tuple[np.ndarray, float]:
    """Return the leading coefficients (k,) of polynomials through values (n, k), and their error by noise.

    The second value is their standard deviation if the values have one of 1.
    """
    powers = np.vander(times_s - times_s.mean(), degree + 1)
    inverse = np.linalg.inv(powers.T @ powers)
    return (inverse @ (powers.T @ values))[0], math.sqrt(inverse[0, 0])
