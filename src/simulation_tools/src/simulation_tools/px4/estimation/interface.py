"""What the flight controller asks of an estimator, and what the estimator says of itself."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from simulation_tools.autopilot import VehicleState
from simulation_tools.geometry import ORIGIN, Vector3
from simulation_tools.px4.estimation.samples import ExternalVision, RangeSample

ESTIMATE_DTYPE = np.dtype(
    [
        ("position", np.float64, (3,)),  # m, NED, from where the vehicle stood at power-on
        ("velocity", np.float64, (3,)),  # m/s, NED
        ("acceleration", np.float64, (3,)),  # m/s2, NED, gravity taken out: 0 at rest
        ("attitude", np.float64, (4,)),  # FRD in NED, w x y z
        ("rates", np.float64, (3,)),  # rad/s, FRD
        ("specific_force", np.float64, (3,)),  # m/s2, FRD: (0, 0, -g) at rest
        ("yaw", np.float64),  # rad, from the attitude
    ]
)


class SolutionFlag(enum.IntFlag):
    """MAVLink's ESTIMATOR_STATUS_FLAGS."""

    ATTITUDE = 1
    VELOCITY_HORIZ = 2
    VELOCITY_VERT = 4
    POS_HORIZ_REL = 8
    POS_HORIZ_ABS = 16
    POS_VERT_ABS = 32
    POS_VERT_AGL = 64
    CONST_POS_MODE = 128
    PRED_POS_HORIZ_REL = 256
    PRED_POS_HORIZ_ABS = 512
    GPS_GLITCH = 1024
    ACCEL_ERROR = 2048


AIDED = (
    SolutionFlag.ATTITUDE
    | SolutionFlag.VELOCITY_HORIZ
    | SolutionFlag.VELOCITY_VERT
    | SolutionFlag.POS_HORIZ_REL
    | SolutionFlag.POS_HORIZ_ABS
    | SolutionFlag.POS_VERT_ABS
    | SolutionFlag.PRED_POS_HORIZ_REL
    | SolutionFlag.PRED_POS_HORIZ_ABS
)
"""In the air, with GPS or external vision: 831."""


@dataclass(frozen=True)
class EstimatorStatus:
    """What MAVLink's ESTIMATOR_STATUS, ODOMETRY and ALTITUDE tell of an estimate.

    flags: `SolutionFlag` bits. *_ratio: innovation over
    its gate; above 1 the measurement is rejected; NaN: none is fused. *_accuracy_m: 1 sigma.
    *_variance*: diagonal of the covariance; attitude: of a small rotation about the axes of NED.
    height_over_ground_m: NaN without a range finder. resets: times the position jumped to a measurement.
    """

    flags: int = 0
    velocity_ratio: float = math.nan
    horizontal_position_ratio: float = math.nan
    vertical_position_ratio: float = math.nan
    magnetometer_ratio: float = math.nan
    height_over_ground_ratio: float = math.nan
    airspeed_ratio: float = math.nan
    horizontal_accuracy_m: float = math.nan
    vertical_accuracy_m: float = math.nan
    position_variance_m2: Vector3 = ORIGIN
    velocity_variance_m2_s2: Vector3 = ORIGIN
    height_over_ground_m: float = math.nan
    resets: int = 0


class Estimator(Protocol):
    """Turns the vehicle's motion into an estimate of it, with the errors of a real one."""

    @property
    def estimate(self) -> np.ndarray:
        """The newest estimate, one record of ESTIMATE_DTYPE, shape (1,); the same array each time."""
        ...

    @property
    def origin_m(self) -> Vector3 | None:
        """Where the local frame begins in the world (ENU); None before the first update."""
        ...

    @property
    def uses_gnss(self) -> bool:
        """Whether there is a GNSS receiver. Without one there is no place on earth."""
        ...

    @property
    def horizontal_valid(self) -> bool:
        """Whether there is a position and a velocity over ground. PX4 then sends LOCAL_POSITION_NED."""
        ...

    @property
    def vertical_valid(self) -> bool:
        """Whether there is a height and a climb rate."""
        ...

    @property
    def status(self) -> EstimatorStatus:
        """How good the estimate is."""
        ...

    def reset(self) -> None:
        """Go back to power-on; all noise repeats."""
        ...

    def update(self, state: VehicleState, dt_s: float, in_air: bool) -> None:
        """Take in the true state, dt_s after the one before. in_air: the land detector's opinion."""
        ...

    def offer_external_vision(self, sample: ExternalVision) -> None:
        """Take in a sample of an external vision."""
        ...

    def offer_range(self, sample: RangeSample) -> None:
        """Take in a distance to the ground."""
        ...
