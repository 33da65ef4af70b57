"""Every parameter of the cloud odometry, checked once."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError


@dataclass(frozen=True)
class CloudOdometryParameters:
    """How clouds are matched, and how far each sensor is trusted.

    Raises ParameterError, in one sentence, for values that make no sense.
    """

    range_m: float = limited(100.0, above=0.0)
    """m: points are used up to here."""
    voxel_m: float = limited(0.25, above=0.0)
    """m: the finest voxels of the map. Those of the three coarser levels are 2, 4 and 8 times as wide."""
    thinned_m: float = limited(0.25, above=0.0)
    """m: of the points in a cube of this side one is matched."""
    kept_m: float = limited(0.08, above=0.0)
    """m: of the points in a cube of this side one enters the map."""
    keyframe_m: float = limited(0.25, above=0.0)
    """m: a cloud enters the map after this much travel."""
    keyframe_rad: float = limited(0.087, above=0.0)
    """rad: a cloud enters the map after this much turning, too."""
    known_min: float = limited(0.5, above=0.0, most=1.0)
    """After kept_m a cloud enters the map, too, if the map has a plane for a smaller share of its points."""
    flatness_m: float = limited(0.03, above=0.0)
    """m: the points of a voxel are a plane if they scatter less than this about it."""
    points_max: int = limited(2000, 1)
    """A voxel with so many points takes no more. So a surface stays where it was seen first."""
    first_reach_m: float = limited(0.3, above=0.0)
    """m: in the first step of a match, points that lie this far from their plane count a quarter."""
    last_reach_m: float = limited(0.05, above=0.0)
    """m: in the last steps of a match, points that lie this far from their plane count a quarter."""
    point_noise_m: float = limited(0.03, above=0.0)
    """m: standard deviation of a point across its plane."""
    points_per_reading: float = limited(20.0, above=0.0)
    """So many points err together and count as one reading."""
    agreement_min: float = limited(0.5, above=0.0, most=1.0)
    """If a smaller share of the points in voxels with planes lies on these, the cloud does not count."""
    told_m: float = limited(0.05, above=0.0)
    """m: a cloud tells a direction if it alone gives the place along it to this standard deviation."""
    speed_noise: float = limited(1.6, above=0.0)
    """m/s in one second (m/s/sqrt(s)): how fast the velocity walks."""
    turn_noise: float = limited(0.01, above=0.0)
    """rad/sqrt(s): white noise of the turn by the gyroscope."""
    lean_noise_rad: float = limited(0.005, above=0.0)
    """rad: standard deviation of the IMU's roll and pitch."""
    level_time_s: float = limited(5.0, above=0.0)
    """s: the map is levelled by the mean of the IMU's roll and pitch over so long."""
    rest_time_s: float = limited(2.0, above=0.0)
    """s: time in which the speed decays along a direction that the clouds do not tell."""
    drift: float = limited(0.003, above=0.0)
    """Growth of the place's standard deviation in `odom`, m per root metre of way."""
    voxels_max: int = limited(4_000_000, 1)
    """Of all levels. A full map takes no more, and says so."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError)
        if self.last_reach_m > self.first_reach_m:
            raise ParameterError(
                f"last_reach_m {self.last_reach_m:g} is more than first_reach_m {self.first_reach_m:g}."
            )

    @property
    def levels_m(self) -> tuple[float, float, float, float]:
        """Sides of the voxels, finest first."""
        return self.voxel_m, 2 * self.voxel_m, 4 * self.voxel_m, 8 * self.voxel_m
