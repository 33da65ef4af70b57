"""External vision as EKF2 reads it: what is missing or not finite, and what noise it is believed to have."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from simulation_tools.px4.estimation.samples import ExternalVision
from simulation_tools.px4.estimation.settings import FilterSettings

_POSITION_FLOOR, _VELOCITY_FLOOR, _YAW_FLOOR = 0.01**2, 0.05**2, 0.01**2  # least variances


class VisionMeasurement(NamedTuple):
    """Position m, velocity m/s (in NED, or in FRD if `in_body`) and yaw rad, each with its variances."""

    position: np.ndarray
    position_variance: np.ndarray
    velocity: np.ndarray
    velocity_variance: np.ndarray
    in_body: bool
    yaw_rad: float
    yaw_variance: float


def vision_measurement(sample: ExternalVision, settings: FilterSettings) -> VisionMeasurement:
    """Return a sample as EKF2 fuses it.

    A part that is missing or not finite counts as zero with the least variance: EKF2 of July 2021 does not
    ask whether it was there. A variance counts if it is greater than the parameter's, for velocities always.
    """
    fixed = settings.vision_noise_is_fixed
    position, usual = sample.position_m, settings.vision_position.variance
    told = np.maximum(sample.position_variance_m2, usual)
    position_variance = np.full(3, usual) if fixed or not _finite(sample.position_variance_m2) else told
    if not _finite(position):
        position, position_variance = (0.0, 0.0, 0.0), np.zeros(3)

    velocity, usual = sample.velocity_m_s, settings.vision_velocity.variance
    told = np.array(sample.velocity_variance_m2_s2)
    velocity_variance = np.full(3, usual) if fixed or not _finite(told) else told
    if not _finite(velocity):
        velocity, velocity_variance = (0.0, 0.0, 0.0), np.zeros(3)

    yaw_rad, yaw_variance = 0.0, 0.0
    if sample.attitude is not None and _finite(sample.attitude):
        yaw_rad = _yaw_of(sample.attitude)
        yaw_variance = settings.vision_yaw.variance
        if not fixed and math.isfinite(sample.yaw_variance_rad2):
            yaw_variance = max(yaw_variance, sample.yaw_variance_rad2)
    return VisionMeasurement(
        np.array(position),
        np.maximum(position_variance, _POSITION_FLOOR),
        np.array(velocity),
        np.maximum(velocity_variance, _VELOCITY_FLOOR),
        sample.velocity_in_body,
        yaw_rad,
        max(yaw_variance, _YAW_FLOOR),
    )


def _finite(values: Sequence[float] | np.ndarray | None) -> bool:
    return values is not None and all(map(math.isfinite, values))


def _yaw_of(q: Sequence[float]) -> float:
    """Return the heading of a quaternion w x y z of any length; 0 for one without direction."""
    w, x, y, z = q
    return math.atan2(2.0 * (w * z + x * y), w * w + x * x - y * y - z * z)
