"""PX4's EKF2 in short: an error-state Kalman filter on the flight controller's own sensors.

See `kernels` for the filter, `aiding` and `height` for what it uses when.
"""

from __future__ import annotations

import math

import numpy as np

from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import Vector3
from simulation_tools.px4.estimation.aiding import Aiding
from simulation_tools.px4.estimation.error_state_filter import ErrorStateFilter
from simulation_tools.px4.estimation.interface import AIDED, ESTIMATE_DTYPE, EstimatorStatus, SolutionFlag
from simulation_tools.px4.estimation.kernels.horizon import publish
from simulation_tools.px4.estimation.kernels.states import POSITION, VELOCITY
from simulation_tools.px4.estimation.samples import ExternalVision, RangeSample
from simulation_tools.px4.estimation.sensors import OwnSensors, SensorErrors
from simulation_tools.px4.estimation.settings import FilterSettings
from simulation_tools.px4.parameters import Px4Parameters


class EkfEstimator:
    """An `Estimator` that knows the truth only through its sensors.

    Parameters are read at power-on and `reset`, as PX4 reads those that it filters by.
    """

    def __init__(self, errors: SensorErrors, rng: np.random.Generator, parameters: Px4Parameters) -> None:
        """rng: every `reset` goes back to its state at this call, so that flights repeat exactly."""
        self._errors = errors
        self._rng = rng
        self._parameters = parameters
        self._first_rng_state = rng.bit_generator.state
        self._rates, self._force = np.zeros(3), np.zeros(3)
        self.estimate = np.zeros(1, ESTIMATE_DTYPE)
        self.reset()

    def reset(self) -> None:
        """Go back to power-on; all noise repeats."""
        self._rng.bit_generator.state = self._first_rng_state
        self.settings = FilterSettings.of(self._parameters)
        self.filter = ErrorStateFilter(self.settings)
        self.aiding = Aiding(self.settings, self.filter)
        self.sensors = OwnSensors(self._errors, self.settings.uses_gnss, self._rng)
        self.sensors.restart()
        self.origin_m: Vector3 | None = None
        self._running = self._in_air = False
        self.estimate[:] = np.zeros(1, ESTIMATE_DTYPE)
        self.estimate["attitude"][0, 0] = 1.0

    def offer_external_vision(self, sample: ExternalVision) -> None:
        """Take in a sample; it counts when the filter's horizon has reached its time."""
        if self._running:
            self.aiding.offer_vision(sample)

    def offer_range(self, sample: RangeSample) -> None:
        """Take in a distance to the ground."""
        if self._running:
            self.aiding.height.ranges.push(sample.time_us - self.settings.range_delay_us, sample)

    def update(self, state: VehicleState, dt_s: float, in_air: bool = False) -> None:
        """Measure the true state, dt_s after the one before, and take the measurements in."""
        if self.origin_m is None:
            self.origin_m = state.pose.position_m
        rates, force = self._rates, self._force
        self.sensors.imu(state, dt_s, rates, force)
        if not math.isfinite(rates.sum() + force.sum()):
            return  # the IMU dropped out: the estimate waits for the next sample
        if not self._running:
            self._running = self.filter.start(force)
            self.aiding.start(state.time_us)
            if not self._running:
                return
        self._in_air = in_air
        self._measure(state)
        if self.filter.advance(state.time_us, dt_s, rates, force):
            self.aiding.fuse(in_air, self._errors.declination_rad)
            self.filter.follow()
        publish(self.filter.now, self._rates, self._force, self.estimate)

    def _measure(self, state: VehicleState) -> None:
        """Give the filter what barometer, magnetometer and GNSS measure now."""
        assert self.origin_m is not None
        fix = self.sensors.fix(state, self.origin_m)
        height_m, field = None, None
        if self.sensors.is_due(state.time_us):
            height_m = self.sensors.height_m(state, self.origin_m[2])
            field = self.sensors.magnetic_field(state)
        self.aiding.offer_own(state.time_us, fix, height_m, field)

    @property
    def uses_gnss(self) -> bool:
        """Whether there is a GNSS receiver, and the filter takes its fixes."""
        return self.settings.uses_gnss

    @property
    def horizontal_valid(self) -> bool:
        """Whether there is a position and a velocity over ground."""
        return self._running and self.aiding.horizontal_valid

    @property
    def vertical_valid(self) -> bool:
        """Whether there is a height and a climb rate."""
        return self._running and self.aiding.tilt_known

    @property
    def status(self) -> EstimatorStatus:
        """What PX4 says in ESTIMATOR_STATUS."""
        if not self._running:
            return EstimatorStatus()
        aiding, height, terrain = self.aiding, self.aiding.height, self.aiding.height.terrain
        variances = np.diag(self.filter.covariance)
        position, velocity = variances[POSITION : POSITION + 3], variances[VELOCITY : VELOCITY + 3]
        sees_ground = terrain.is_valid(self.filter.now_us) or not self._in_air
        over_ground = terrain.down_m - float(self.filter.now[POSITION + 2]) if sees_ground else math.nan
        return EstimatorStatus(
            flags=int(self._flags(sees_ground)),
            velocity_ratio=_root(aiding.velocity_ratio),
            horizontal_position_ratio=_root(aiding.position_ratio),
            vertical_position_ratio=_root(height.ratio),
            magnetometer_ratio=_root(aiding.yaw_ratio),
            height_over_ground_ratio=_root(terrain.ratio),
            horizontal_accuracy_m=math.sqrt(position[0] + position[1]),
            vertical_accuracy_m=math.sqrt(position[2]),
            position_variance_m2=tuple(position.tolist()),
            velocity_variance_m2_s2=tuple(velocity.tolist()),
            height_over_ground_m=over_ground,
            resets=self.filter.resets,
        )

    def _flags(self, sees_ground: bool) -> SolutionFlag:
        flag, aiding = SolutionFlag, self.aiding
        flags = flag.VELOCITY_VERT | flag.POS_VERT_ABS
        if aiding.tilt_known and aiding.yaw_known:
            flags |= flag.ATTITUDE
        if aiding.uses_gnss or aiding.uses_vision_position:
            flags |= AIDED & ~flag.ATTITUDE
        elif aiding.uses_vision_velocity:
            flags |= flag.VELOCITY_HORIZ
        else:
            flags |= flag.CONST_POS_MODE
        if sees_ground:
            flags |= flag.POS_VERT_AGL
        return flags


def _root(ratio: float) -> float:
    return math.sqrt(ratio) if ratio >= 0.0 else math.nan
