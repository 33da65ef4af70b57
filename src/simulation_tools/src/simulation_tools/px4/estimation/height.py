"""What gives the height: one source at a time, with fall-backs and resets as PX4's EKF2 has them."""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.px4.estimation.delay_buffer import DelayBuffer
from simulation_tools.px4.estimation.error_state_filter import PERIOD_S, ErrorStateFilter
from simulation_tools.px4.estimation.samples import RangeSample
from simulation_tools.px4.estimation.sensors import Fix
from simulation_tools.px4.estimation.settings import FilterSettings, HeightSource
from simulation_tools.px4.estimation.terrain import Terrain
from simulation_tools.px4.estimation.vision import VisionMeasurement

_TIMEOUT_US = 5_000_000
_LEAST_COS_TILT = 0.7071  # a range finder that looks further aside is not used
_OFFSET_RATE = 0.1  # 1/s, at which an idle barometer's offset follows the height
_UNKNOWN_CLIMB_VARIANCE = 10.0  # m2/s2, after a reset
_GNSS_VERTICAL = 1.5  # a GNSS height is worse than a position by this factor


class HeightAiding:
    """Fuses the height. source: what is in use. ratio: of the last measurement, not yet a root."""

    def __init__(self, settings: FilterSettings, estimator: ErrorStateFilter) -> None:
        self._settings = settings
        self._filter = estimator
        self.ranges: DelayBuffer[RangeSample] = DelayBuffer(8)
        self.terrain = Terrain()

    def start(self, now_us: int) -> None:
        """Begin on the ground, with the barometer."""
        self.source = HeightSource.BAROMETER
        self.ratio = math.nan
        self.ranges.clear()
        self.terrain.reset()
        self._fused_us = now_us
        self._barometer_offset_m = 0.0
        self._barometer_samples = 0
        self._range_offset_m = 0.0
        self._range_us: int | None = None
        self._newest_m: dict[HeightSource, float] = {}

    def fuse(
        self,
        barometer_m: float | None,
        fix: Fix | None,
        vision: VisionMeasurement | None,
        vision_is_recent: bool,
        settled: bool,
        in_air: bool,
    ) -> None:
        """Take in what the horizon has reached. settled: the tilt is known, so the barometer's zero is, too.

        vision_is_recent: samples of vision keep arriving.
        """
        measured = self._measured(barometer_m, fix, vision, settled, in_air)
        self._newest_m.update((source, down_m) for source, (down_m, _) in measured.items())
        now_us = self._filter.now_us
        if now_us - self._fused_us > _TIMEOUT_US:
            self._fall_back(vision_is_recent)
            self._fused_us = now_us
        wanted = self._settings.height_source
        usable = settled and (wanted is not HeightSource.VISION or vision_is_recent)
        if self.source is not wanted and wanted in measured and usable:
            self._use(wanted)
        if self.source in measured and settled:
            down_m, variance = measured[self.source]
            gate = self._gate(self.source)
            self.ratio = self._filter.fuse_position(2, np.array([down_m]), np.array([variance]), gate)
            if self.ratio <= 1.0:
                self._fused_us = now_us

    def _measured(
        self,
        barometer_m: float | None,
        fix: Fix | None,
        vision: VisionMeasurement | None,
        settled: bool,
        in_air: bool,
    ) -> dict[HeightSource, tuple[float, float]]:
        """Return each source's downward position and its variance."""
        s, found = self._settings, {}
        if barometer_m is not None:
            self._watch_barometer(barometer_m, settled)
            found[HeightSource.BAROMETER] = (self._barometer_offset_m - barometer_m, s.barometer.variance)
        if fix is not None:
            variance = (_GNSS_VERTICAL * s.gnss_position.noise) ** 2
            found[HeightSource.GNSS] = (float(fix.position[2]), variance)
        if vision is not None:
            found[HeightSource.VISION] = (float(vision.position[2]), float(vision.position_variance[2]))
        distance_m = self._distance(in_air)
        if distance_m is not None:
            variance = s.range_finder.variance + (s.range_scale_error * distance_m) ** 2
            self._watch_ground(distance_m, variance)
            if self.source is not HeightSource.RANGE_FINDER:
                ground = float(self._filter.position[2]) + distance_m
                self._range_offset_m = ground if in_air else s.ground_clearance_m
            found[HeightSource.RANGE_FINDER] = (self._range_offset_m - distance_m, variance)
        return found

    def _watch_barometer(self, barometer_m: float, settled: bool) -> None:
        """Find the barometer's zero: the mean while the filter settles, later the height of other sources."""
        if not settled:
            self._barometer_samples += 1
            self._barometer_offset_m += (barometer_m - self._barometer_offset_m) / self._barometer_samples
        elif self.source is not HeightSource.BAROMETER:
            gap = barometer_m + float(self._filter.position[2]) - self._barometer_offset_m
            self._barometer_offset_m += PERIOD_S * min(max(_OFFSET_RATE * gap, -0.1), 0.1)

    def _distance(self, in_air: bool) -> float | None:
        """Return the height over ground that the range finder sees now, m, or None."""
        self.terrain.predict(PERIOD_S, float(np.hypot(*self._filter.velocity[:2])))
        if not in_air:
            self.terrain.stand(float(self._filter.position[2]) + self._settings.ground_clearance_m)
        sample = self.ranges.pop(self._filter.horizon_us)
        if sample is None or not sample.range_min_m <= sample.distance_m <= sample.range_max_m:
            return None
        cos_tilt = float(self._filter.rotation()[2, 2])
        if sample.quality == 0 or cos_tilt < _LEAST_COS_TILT:
            return None
        self._range_us = self._filter.now_us
        return sample.distance_m * cos_tilt

    def _watch_ground(self, distance_m: float, variance: float) -> None:
        down_m = float(self._filter.position[2]) + distance_m
        self.terrain.measure(self._filter.now_us, down_m, variance, self._settings.range_finder.gate)

    def _gate(self, source: HeightSource) -> float:
        s = self._settings
        return {
            HeightSource.BAROMETER: s.barometer,
            HeightSource.GNSS: s.barometer,  # PX4 has one gate for both
            HeightSource.RANGE_FINDER: s.range_finder,
            HeightSource.VISION: s.vision_position,
        }[source].gate

    def _fall_back(self, vision_is_recent: bool) -> None:
        """Reset the height to the source in use if it is alive, else to another one."""
        range_is_recent = self._range_us is not None and self._filter.now_us - self._range_us < 1_000_000
        alive = {
            HeightSource.VISION: vision_is_recent,
            HeightSource.RANGE_FINDER: range_is_recent,
            HeightSource.GNSS: False,
            HeightSource.BAROMETER: True,
        }
        order = (self.source, HeightSource.RANGE_FINDER, HeightSource.BAROMETER)
        self._use(next(source for source in order if alive[source]), jumps=True)

    def _use(self, source: HeightSource, jumps: bool = False) -> None:
        """Change the source. The height jumps to vision's, because that has a zero of its own."""
        self.source = source
        if source in self._newest_m and (jumps or source is HeightSource.VISION):
            variance = np.array([self._gate_variance(source)])
            self._filter.reset_position(2, np.array([self._newest_m[source]]), variance)
            self._filter.reset_velocity(2, np.zeros(1), np.array([_UNKNOWN_CLIMB_VARIANCE]))

    def _gate_variance(self, source: HeightSource) -> float:
        s = self._settings
        return {
            HeightSource.BAROMETER: s.barometer,
            HeightSource.GNSS: s.gnss_position,
            HeightSource.RANGE_FINDER: s.range_finder,
            HeightSource.VISION: s.vision_position,
        }[source].variance
