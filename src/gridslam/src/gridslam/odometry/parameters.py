"""Every parameter of the lidar odometry, checked once."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

from gridslam.errors import ParameterError

SHARES = ("overlap_min", "match_min")


def refuse_all_but_positive(parameters: Any) -> None:
    """Check each field of a dataclass.

    Raises:
        ParameterError: one is not a positive, finite number.
    """
    for field in fields(parameters):
        value = getattr(parameters, field.name)
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{field.name} must be a number, not {value!r}.")
        if not 0.0 < value < math.inf:
            raise ParameterError(f"{field.name} must be positive and finite, not {value:g}.")


@dataclass(frozen=True)
class LidarOdometryParameters:
    """How scans are matched, and how far each sensor is trusted.

    Raises ParameterError, in one sentence, for values that make no sense.
    """

    range_m: float = 30.0
    """m: beams are used up to here."""
    cell_m: float = 0.1
    """m: cells of the local map; beams that end closer together are averaged."""
    reach_m: float = 0.2
    """m: a beam's end is compared with surfaces within this distance."""
    keyframe_m: float = 0.4
    """m: a scan is added to the local map after this much travel ..."""
    keyframe_rad: float = 0.3
    """rad: ... or this much turning ..."""
    overlap_min: float = 0.75
    """... or if a smaller share of its beams finds the local map."""
    keyframes: int = 60
    """Number of scans in the local map."""
    match_min: float = 0.3
    """If a smaller share of the beams finds the local map, the scan does not count."""
    beam_noise_m: float = 0.03
    """m: standard deviation of a beam's end across the surface that it hit."""
    beams_per_reading: float = 10.0
    """So many beams err together and count as one reading."""
    told_m: float = 0.05
    """m: a scan tells a direction if it alone gives the place along it to this standard deviation."""
    acceleration_noise: float = 0.25
    """m/s2 in one second (m/s/sqrt(s)): white noise of the horizontal acceleration by the IMU."""
    acceleration_unknown: float = 2.0
    """m/s/sqrt(s): the same if the IMU gives no acceleration."""
    acceleration_bias: float = 0.02
    """m/s2/sqrt(s): how fast the accelerometer's bias walks."""
    turn_noise: float = 0.01
    """rad/sqrt(s): white noise of the turn by the gyroscope."""
    rest_time_s: float = 2.0
    """s: time in which the speed decays along a direction that the scans do not tell."""
    range_noise_m: float = 0.02
    """m: standard deviation of the height by the range finder."""
    climb_noise: float = 0.05
    """m/s/sqrt(s): white noise of the vertical acceleration: 0.02 to 0.03 in the simulator's flights.
    With 0.2, readings at the edge of a box pass for a climb."""
    floor_step_m: float = 0.06
    """m: if the height below differs by more than this from the expected one, the floor has a step."""

    def __post_init__(self) -> None:
        refuse_all_but_positive(self)
        if self.keyframes != int(self.keyframes):
            raise ParameterError(f"keyframes must be a whole number, not {self.keyframes:g}.")
        for name in SHARES:
            if getattr(self, name) > 1.0:
                raise ParameterError(f"{name} is a share and at most 1, not {getattr(self, name):g}.")
        if self.reach_m > 10.0 * self.cell_m:
            raise ParameterError(
                f"reach_m {self.reach_m:g} is more than ten cells of {self.cell_m:g} m; raise cell_m."
            )

    @property
    def reading_variance_m2(self) -> float:
        """Variance that a beam counts with."""
        return self.beams_per_reading * self.beam_noise_m**2
