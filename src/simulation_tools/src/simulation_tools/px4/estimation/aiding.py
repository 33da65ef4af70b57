"""Which measurements the filter uses, and what it does without them: the decisions of PX4's EKF2.

The filter uses GNSS or vision. Without both it fuses a position that does not change, so that the tilt does
not drift.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.px4.estimation.delay_buffer import DelayBuffer
from simulation_tools.px4.estimation.error_state_filter import ErrorStateFilter
from simulation_tools.px4.estimation.height import HeightAiding
from simulation_tools.px4.estimation.kernels.states import ROTATION_ERROR
from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.estimation.sensors import Fix
from simulation_tools.px4.estimation.settings import FilterSettings
from simulation_tools.px4.estimation.vision import VisionMeasurement, vision_measurement

LEAST_INTERVAL_US = 20_000  # EKF2_MIN_OBS_DT
_RECENT_US = 400_000  # vision counts as arriving
_RESET_US = 7_000_000  # without an accepted position: reset to the measurement, or stop to wait for it
_GNSS_GONE_US = 10_000_000
_PROBATION_US = 1_000_000  # of aiding until the position counts as valid
_TILT_KNOWN_RAD = math.radians(3.0)
_FAKE_PERIOD_US, _FAKE_PAUSE_US = 200_000, 400_000
_RESTING_NOISE_M, _FAKE_GATE = 0.1, 100.0
_UNKNOWN_VELOCITY_VARIANCE = 25.0  # m2/s2
_VERTICAL_SPEED_FACTOR = 1.5  # GNSS measures a climb worse than a speed over ground


class Aiding:
    """Fuses everything but the IMU. `height` has the vertical part.

    *_ratio: of the last measurement, innovation^2 over its gate; NaN: none. uses_*: is fused now.
    """

    def __init__(self, settings: FilterSettings, estimator: ErrorStateFilter) -> None:
        self._settings = settings
        self._filter = estimator
        length = max(math.ceil(1.5 * estimator.delay_us / LEAST_INTERVAL_US), 2)
        self.visions: DelayBuffer[VisionMeasurement] = DelayBuffer(length, LEAST_INTERVAL_US)
        self._fixes: DelayBuffer[Fix] = DelayBuffer(length)
        self._barometers: DelayBuffer[float] = DelayBuffer(length)
        self._headings: DelayBuffer[np.ndarray] = DelayBuffer(length)
        self.height = HeightAiding(settings, estimator)

    def start(self, now_us: int) -> None:
        """Begin on the ground without any aiding."""
        for buffer in (self.visions, self._fixes, self._barometers, self._headings):
            buffer.clear()
        self.height.start(now_us)
        self.tilt_known = self.yaw_known = False
        self.uses_gnss = self.uses_vision_position = self.uses_vision_velocity = self.uses_vision_yaw = False
        self.position_ratio = self.velocity_ratio = self.yaw_ratio = math.nan
        self._started_us = now_us
        self._fix_us: int | None = None
        self._position_us = self._velocity_us = now_us
        self._fake_us: int | None = None
        self._last_known = np.zeros(2)
        self._aided_since_us: int | None = None

    # What arrives, with the time of its measurement

    def offer_vision(self, sample: ExternalVision) -> None:
        """Take in a sample of external vision."""
        time_us = sample.time_us - self._settings.vision_delay_us
        self.visions.push(time_us, vision_measurement(sample, self._settings))

    def offer_own(
        self, now_us: int, fix: Fix | None, height_m: float | None, field: np.ndarray | None
    ) -> None:
        """Take in a GNSS fix, a barometer's height and a magnetic field (FRD) that arrive now."""
        if fix is not None and self._settings.uses_gnss:
            self._fixes.push(now_us - self._settings.gnss_delay_us, fix)
        if height_m is not None:
            self._barometers.push(now_us, height_m)
        if field is not None and self._settings.uses_magnetometer:
            self._headings.push(now_us, field)

    # Fusion

    def fuse(self, in_air: bool, declination_rad: float) -> None:
        """Take in every measurement that the horizon has reached, and decide what to use."""
        horizon_us = self._filter.horizon_us
        vision, fix = self.visions.pop(horizon_us), self._fixes.pop(horizon_us)
        barometer_m, field = self._barometers.pop(horizon_us), self._headings.pop(horizon_us)
        if not self.tilt_known:
            variance = self._filter.covariance[ROTATION_ERROR, ROTATION_ERROR]
            variance += self._filter.covariance[ROTATION_ERROR + 1, ROTATION_ERROR + 1]
            self.tilt_known = bool(variance < _TILT_KNOWN_RAD**2)
        if field is not None and not self.uses_vision_yaw:
            self._fuse_magnetic_heading(field, in_air, declination_rad)
        self._use_gnss(fix)
        self.height.fuse(barometer_m, fix, vision, self._vision_is_recent, self.tilt_known, in_air)
        self._use_vision(vision, in_air)
        if not self.is_aided:
            self._stand_still(in_air)
        self._judge()

    def _fuse_magnetic_heading(self, field: np.ndarray, in_air: bool, declination_rad: float) -> None:
        """Fuse the direction of the field's horizontal part, levelled by the estimated tilt."""
        if not self.tilt_known:
            return
        north, east, _ = self._filter.rotation() @ field
        yaw_rad = self._filter.yaw_rad + declination_rad - math.atan2(east, north)
        noise = self._settings.magnetic_heading
        if self.yaw_known:
            self.yaw_ratio = self._filter.fuse_yaw(yaw_rad, noise.variance, noise.gate, not in_air)
        else:
            self._filter.reset_yaw(yaw_rad, noise.variance)
            self.yaw_known = True

    def _use_gnss(self, fix: Fix | None) -> None:
        now_us, s = self._filter.now_us, self._settings
        if fix is None:
            if self.uses_gnss and self._fix_us is not None and now_us - self._fix_us > _GNSS_GONE_US:
                self.uses_gnss = False
            return
        self._fix_us = now_us
        if not self.uses_gnss:
            waited = now_us - self._started_us >= s.gnss_wait_us
            if not (waited and self.tilt_known and self.yaw_known):
                return
            self.uses_gnss = True
            self._reset_to_fix(fix)
        elif now_us - self._position_us > _RESET_US:
            self._reset_to_fix(fix)
        speed_variances = np.full(2, s.gnss_velocity.variance)
        over_ground = self._filter.fuse_velocity(0, fix.velocity[:2], speed_variances, s.gnss_velocity.gate)
        climb_variance = _VERTICAL_SPEED_FACTOR**2 * speed_variances[:1]
        climb = self._filter.fuse_velocity(2, fix.velocity[2:], climb_variance, s.gnss_velocity.gate)
        self._velocity_fused(over_ground, climb)
        variances = np.full(2, s.gnss_position.variance)
        self._position_fused(self._filter.fuse_position(0, fix.position[:2], variances, s.gnss_position.gate))

    def _reset_to_fix(self, fix: Fix) -> None:
        s = self._settings
        self._filter.reset_velocity(0, fix.velocity, np.full(3, s.gnss_velocity.variance))
        self._filter.reset_position(0, fix.position[:2], np.full(2, s.gnss_position.variance))

    @property
    def _vision_is_recent(self) -> bool:
        newest_us = self.visions.newest_us
        return newest_us is not None and self._filter.now_us - newest_us <= _RECENT_US

    def _use_vision(self, vision: VisionMeasurement | None, in_air: bool) -> None:
        """PX4 starts yaw first; position and velocity need a known heading."""
        newest_us = self.visions.newest_us
        if vision is None:
            if newest_us is not None and self._filter.now_us - newest_us > _RESET_US:
                self.uses_vision_position = self.uses_vision_velocity = self.uses_vision_yaw = False
            return
        s = self._settings
        if self._vision_is_recent and self.tilt_known:
            if self.yaw_known and not self.uses_gnss:
                self._start_vision(vision)
            if s.uses_vision_yaw and not self.uses_vision_yaw:
                self._filter.reset_yaw(vision.yaw_rad, vision.yaw_variance)
                self.uses_vision_yaw = self.yaw_known = True
        if self.uses_vision_position:
            if self._filter.now_us - self._position_us > _RESET_US:
                self._reset_to_vision(vision)
            measured, variances = vision.position[:2], vision.position_variance[:2]
            self._position_fused(self._filter.fuse_position(0, measured, variances, s.vision_position.gate))
        if self.uses_vision_velocity:
            velocity, variances = self._velocity_ned(vision)
            gate = s.vision_velocity.gate
            over_ground = self._filter.fuse_velocity(0, velocity[:2], variances[:2], gate)
            climb = self._filter.fuse_velocity(2, velocity[2:], variances[2:], gate)
            self._velocity_fused(over_ground, climb)
        if self.uses_vision_yaw:
            gate = s.vision_yaw.gate
            self.yaw_ratio = self._filter.fuse_yaw(vision.yaw_rad, vision.yaw_variance, gate, not in_air)

    def _start_vision(self, vision: VisionMeasurement) -> None:
        s = self._settings
        if s.uses_vision_position and not self.uses_vision_position:
            self.uses_vision_position = True
            self._filter.reset_position(0, vision.position[:2], vision.position_variance[:2])
        if s.uses_vision_velocity and not self.uses_vision_velocity:
            self.uses_vision_velocity = True
            self._filter.reset_velocity(0, *self._velocity_ned(vision))

    def _reset_to_vision(self, vision: VisionMeasurement) -> None:
        """Reset the position; the velocity to vision's, or to zero when it has none."""
        if self.uses_vision_velocity:
            self._filter.reset_velocity(0, *self._velocity_ned(vision))
        else:
            self._filter.reset_velocity(0, np.zeros(2), np.full(2, _UNKNOWN_VELOCITY_VARIANCE))
        self._filter.reset_position(0, vision.position[:2], vision.position_variance[:2])

    def _velocity_ned(self, vision: VisionMeasurement) -> tuple[np.ndarray, np.ndarray]:
        """Return vision's velocity in NED and its variances, (3,) each."""
        if not vision.in_body:
            return vision.velocity, vision.velocity_variance
        turned = self._filter.rotation()
        return turned @ vision.velocity, turned**2 @ vision.velocity_variance

    def _stand_still(self, in_air: bool) -> None:
        """Fuse the last known position now and then, so that the tilt stays right without any aiding."""
        now_us = self._filter.now_us
        if self._fake_us is not None and now_us - self._fake_us < _FAKE_PERIOD_US:
            return
        noise = self._settings.no_aiding_noise_m
        if self._fake_us is None or now_us - self._fake_us > _FAKE_PAUSE_US:
            self._last_known[:] = self._filter.position[:2]
            self._filter.reset_position(0, self._last_known, np.full(2, noise**2))
            self._filter.reset_velocity(0, np.zeros(2), np.full(2, _UNKNOWN_VELOCITY_VARIANCE))
        self._fake_us = now_us
        variances = np.full(2, (noise if in_air else _RESTING_NOISE_M) ** 2)
        self._filter.fuse_position(0, self._last_known, variances, _FAKE_GATE)
        self.position_ratio = self.velocity_ratio = math.nan

    # How good it is

    def _position_fused(self, ratio: float) -> None:
        self.position_ratio = ratio
        if ratio <= 1.0:
            self._position_us = self._filter.now_us

    def _velocity_fused(self, over_ground: float, climb: float) -> None:
        self.velocity_ratio = max(over_ground, climb)
        if over_ground <= 1.0:
            self._velocity_us = self._filter.now_us

    @property
    def is_aided(self) -> bool:
        """Whether a source of horizontal position or velocity is in use."""
        return self.uses_gnss or self.uses_vision_position or self.uses_vision_velocity

    def _judge(self) -> None:
        """Note since when measurements have been accepted without a pause of EKF2_NOAID_TOUT."""
        now_us = self._filter.now_us
        last_us = max(self._position_us, self._velocity_us)
        if now_us - last_us > self._settings.no_aiding_timeout_us or not self.is_aided:
            self._aided_since_us = None
        elif self._aided_since_us is None:
            self._aided_since_us = now_us

    @property
    def horizontal_valid(self) -> bool:
        """Whether position and velocity over ground are good to fly by."""
        since_us = self._aided_since_us
        return since_us is not None and self._filter.now_us - since_us >= _PROBATION_US
