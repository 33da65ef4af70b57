"""The filter's settings, read from PX4's parameters at power-on."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from simulation_tools.px4.parameters import Px4Parameters

_USE_GPS, _USE_VISION_POSITION, _USE_VISION_YAW, _USE_VISION_VELOCITY = 1, 8, 16, 256  # EKF2_AID_MASK


class HeightSource(enum.IntEnum):
    """What gives the height: EKF2_HGT_MODE."""

    BAROMETER = 0
    GNSS = 1
    RANGE_FINDER = 2
    VISION = 3


@dataclass(frozen=True)
class Gate:
    """A measurement's noise (1 sigma) and how many standard deviations its innovation may have."""

    noise: float
    gate: float

    @property
    def variance(self) -> float:
        """Square of the noise."""
        return self.noise**2


@dataclass(frozen=True)
class FilterSettings:
    """One filter's settings: times in us or s, angles in rad, lengths in m."""

    uses_gnss: bool
    uses_magnetometer: bool
    uses_vision_position: bool
    uses_vision_velocity: bool
    uses_vision_yaw: bool
    height_source: HeightSource
    gnss_delay_us: int
    vision_delay_us: int
    range_delay_us: int
    gnss_position: Gate
    gnss_velocity: Gate
    vision_position: Gate
    vision_velocity: Gate
    vision_yaw: Gate
    vision_noise_is_fixed: bool
    magnetic_heading: Gate
    barometer: Gate
    range_finder: Gate
    range_scale_error: float
    ground_clearance_m: float
    no_aiding_noise_m: float
    no_aiding_timeout_us: int
    gnss_wait_us: int
    acceleration_noise_m_s2: float
    rate_noise_rad_s: float
    acceleration_bias_noise_m_s3: float
    rate_bias_noise_rad_s2: float
    initial_tilt_rad: float
    initial_acceleration_bias_m_s2: float
    initial_rate_bias_rad_s: float
    acceleration_bias_limit_m_s2: float
    velocity_time_constant_s: float
    position_time_constant_s: float

    @classmethod
    def of(cls, p: Px4Parameters) -> FilterSettings:
        """Read PX4's parameters."""
        mask = int(p["EKF2_AID_MASK"])
        return cls(
            uses_gnss=bool(mask & _USE_GPS) and p["SYS_HAS_GPS"] == 1,
            uses_magnetometer=p["SYS_HAS_MAG"] == 1,
            uses_vision_position=bool(mask & _USE_VISION_POSITION),
            uses_vision_velocity=bool(mask & _USE_VISION_VELOCITY),
            uses_vision_yaw=bool(mask & _USE_VISION_YAW),
            height_source=HeightSource(int(p["EKF2_HGT_MODE"])),
            gnss_delay_us=round(1e3 * p["EKF2_GPS_DELAY"]),
            vision_delay_us=round(1e3 * p["EKF2_EV_DELAY"]),
            range_delay_us=round(1e3 * p["EKF2_RNG_DELAY"]),
            gnss_position=Gate(p["EKF2_GPS_P_NOISE"], p["EKF2_GPS_P_GATE"]),
            gnss_velocity=Gate(p["EKF2_GPS_V_NOISE"], p["EKF2_GPS_V_GATE"]),
            vision_position=Gate(p["EKF2_EVP_NOISE"], p["EKF2_EVP_GATE"]),
            vision_velocity=Gate(p["EKF2_EVV_NOISE"], p["EKF2_EVV_GATE"]),
            vision_yaw=Gate(p["EKF2_EVA_NOISE"], p["EKF2_HDG_GATE"]),
            vision_noise_is_fixed=p["EKF2_EV_NOISE_MD"] == 1,
            magnetic_heading=Gate(p["EKF2_HEAD_NOISE"], p["EKF2_HDG_GATE"]),
            barometer=Gate(p["EKF2_BARO_NOISE"], p["EKF2_BARO_GATE"]),
            range_finder=Gate(p["EKF2_RNG_NOISE"], p["EKF2_RNG_GATE"]),
            range_scale_error=p["EKF2_RNG_SFE"],
            ground_clearance_m=p["EKF2_MIN_RNG"],
            no_aiding_noise_m=p["EKF2_NOAID_NOISE"],
            no_aiding_timeout_us=int(p["EKF2_NOAID_TOUT"]),
            gnss_wait_us=round(1e6 * p["EKF2_REQ_GPS_H"]),
            acceleration_noise_m_s2=p["EKF2_ACC_NOISE"],
            rate_noise_rad_s=p["EKF2_GYR_NOISE"],
            acceleration_bias_noise_m_s3=p["EKF2_ACC_B_NOISE"],
            rate_bias_noise_rad_s2=p["EKF2_GYR_B_NOISE"],
            initial_tilt_rad=p["EKF2_ANGERR_INIT"],
            initial_acceleration_bias_m_s2=p["EKF2_ABIAS_INIT"],
            initial_rate_bias_rad_s=p["EKF2_GBIAS_INIT"],
            acceleration_bias_limit_m_s2=p["EKF2_ABL_LIM"],
            velocity_time_constant_s=p["EKF2_TAU_VEL"],
            position_time_constant_s=p["EKF2_TAU_POS"],
        )

    @property
    def horizon_delay_us(self) -> int:
        """How far the filter runs behind: the greatest delay of a measurement in use."""
        vision = self.uses_vision_position or self.uses_vision_velocity or self.uses_vision_yaw
        by_range = self.height_source is HeightSource.RANGE_FINDER
        return max(
            _LEAST_DELAY_US,
            self.gnss_delay_us if self.uses_gnss else 0,
            self.vision_delay_us if vision else 0,
            self.range_delay_us if by_range else 0,
        )


_LEAST_DELAY_US = 5_000  # EKF2_AVEL_DELAY, which PX4 always counts
