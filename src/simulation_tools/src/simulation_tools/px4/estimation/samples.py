"""What other computers measure for the flight controller: external vision and distance to the ground."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.geometry import Quaternion, Vector3

NAN = math.nan
UNKNOWN: Vector3 = (NAN, NAN, NAN)


@dataclass(frozen=True)
class ExternalVision:
    """One sample of a vision or lidar odometry, as PX4's `vehicle_visual_odometry`.

    time_us: of the measurement, in the autopilot's clock. None: not measured.
    position_m: in the vision's local frame (NED, or FRD: a level frame of another heading).
    velocity_m_s: in that frame too, or, with `velocity_in_body`, in the body's FRD.
    attitude: of FRD in that frame, w x y z; only its yaw is used.
    *_variance*: NaN: the parameter's value counts (EKF2_EVP_NOISE, EKF2_EVV_NOISE, EKF2_EVA_NOISE).
    Numbers may be NaN or nonsense: the estimator answers as PX4 does.
    """

    time_us: int
    position_m: Vector3 | None = None
    velocity_m_s: Vector3 | None = None
    attitude: Quaternion | None = None
    position_variance_m2: Vector3 = UNKNOWN
    velocity_variance_m2_s2: Vector3 = UNKNOWN
    yaw_variance_rad2: float = NAN
    velocity_in_body: bool = False


@dataclass(frozen=True)
class RangeSample:
    """One distance along the body's down axis (MAVLink's DISTANCE_SENSOR, orientation 25).

    time_us: of the measurement, in the autopilot's clock. A distance outside of range_min_m to range_max_m is
    no measurement.
    quality: 0 bad to 100 good; negative: unknown.
    """

    time_us: int
    distance_m: float
    range_min_m: float
    range_max_m: float
    quality: int = -1
