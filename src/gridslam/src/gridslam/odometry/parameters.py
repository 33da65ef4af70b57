"""Every parameter of the lidar odometry, checked once."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError


@dataclass(frozen=True)
class LidarOdometryParameters:
    """How scans are matched, and how far each sensor is trusted.

    Raises ParameterError, in one sentence, for values that make no sense.
    """

    range_m: float = limited(30.0, above=0.0)
    """m: beams are used up to here."""
    cell_m: float = limited(0.1, above=0.0)
    """m: cells of the local map; beams that end closer together are averaged."""
    reach_m: float = limited(0.2, above=0.0)
    """m: a beam's end is compared with surfaces within this distance."""
    keyframe_m: float = limited(0.4, above=0.0)
    """m: a scan is added to the local map after this much travel."""
    keyframe_rad: float = limited(0.3, above=0.0)
    """rad: a scan is added to the local map after this much turning, too."""
    overlap_min: float = limited(0.75, above=0.0, most=1.0)
    """A scan is added to the local map, too, if a smaller share of its beams finds the map."""
    keyframes: int = limited(60, 1)
    """Number of scans in the local map."""
    match_min: float = limited(0.3, above=0.0, most=1.0)
    """If a smaller share of the beams finds the local map, the scan does not count."""
    beam_noise_m: float = limited(0.03, above=0.0)
    """m: standard deviation of a beam's end across the surface that it hit."""
    beams_per_reading: float = limited(10.0, above=0.0)
    """So many beams err together and count as one reading."""
    told_m: float = limited(0.05, above=0.0)
    """m: a scan tells a direction if it alone gives the place along it to this standard deviation."""
    acceleration_noise: float = limited(0.25, above=0.0)
    """m/s2 in one second (m/s/sqrt(s)): white noise of the horizontal acceleration by the IMU."""
    acceleration_unknown: float = limited(2.0, above=0.0)
    """m/s/sqrt(s): the same if the IMU gives no acceleration."""
    acceleration_bias: float = limited(0.02, above=0.0)
    """m/s2/sqrt(s): how fast the accelerometer's bias walks."""
    turn_noise: float = limited(0.01, above=0.0)
    """rad/sqrt(s): white noise of the turn by the gyroscope."""
    rest_time_s: float = limited(2.0, above=0.0)
    """s: time in which the speed decays along a direction that the scans do not tell."""
    range_noise_m: float = limited(0.02, above=0.0)
    """m: standard deviation of the height by the range finder."""
    climb_noise: float = limited(0.05, above=0.0)
    """m/s/sqrt(s): white noise of the vertical acceleration: 0.02 to 0.03 in the simulator's flights.
    With 0.2, readings at the edge of a box pass for a climb."""
    floor_step_m: float = limited(0.06, above=0.0)
    """m: if the height below differs by more than this from the expected one, the floor has a step."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError)
        if self.reach_m > 10.0 * self.cell_m:
            raise ParameterError(
                f"reach_m {self.reach_m:g} is more than ten cells of {self.cell_m:g} m; raise cell_m."
            )

    @property
    def reading_variance_m2(self) -> float:
        """Variance that a beam counts with."""
        return self.beams_per_reading * self.beam_noise_m**2
