"""Every parameter of the cloud odometry, checked once."""

from __future__ import annotations

from dataclasses import dataclass

from gridslam.errors import ParameterError
from gridslam.odometry.parameters import refuse_all_but_positive


@dataclass(frozen=True)
class CloudOdometryParameters:
    """How clouds are matched, and how far each sensor is trusted.

    Raises ParameterError, in one sentence, for values that make no sense.
    """

    range_m: float = 100.0
    """m: points are used up to here."""
    voxel_m: float = 0.25
    """m: the finest voxels of the map. Those of the three coarser levels are 2, 4 and 8 times as wide."""
    thinned_m: float = 0.25
    """m: of the points in a cube of this side one is matched."""
    kept_m: float = 0.08
    """m: of the points in a cube of this side one enters the map."""
    keyframe_m: float = 0.25
    """m: a cloud enters the map after this much travel ..."""
    keyframe_rad: float = 0.087
    """rad: ... or this much turning ..."""
    known_min: float = 0.5
    """... or, after kept_m, if the map has a plane for a smaller share of the points."""
    flatness_m: float = 0.03
    """m: the points of a voxel are a plane if they scatter less than this about it."""
    points_max: int = 2000
    """A voxel with so many points takes no more. So a surface stays where it was seen first."""
    first_reach_m: float = 0.3
    """m: points that lie this far from their plane count a quarter, in the first step of a match ..."""
    last_reach_m: float = 0.05
    """m: ... and in the last ones."""
    point_noise_m: float = 0.03
    """m: standard deviation of a point across its plane."""
    points_per_reading: float = 20.0
    """So many points err together and count as one reading."""
    agreement_min: float = 0.5
    """If a smaller share of the points in voxels with planes lies on these, the cloud does not count."""
    told_m: float = 0.05
    """m: a cloud tells a direction if it alone gives the place along it to this standard deviation."""
    speed_noise: float = 1.6
    """m/s in one second (m/s/sqrt(s)): how fast the velocity walks."""
    turn_noise: float = 0.01
    """rad/sqrt(s): white noise of the turn by the gyroscope."""
    lean_noise_rad: float = 0.005
    """rad: standard deviation of the IMU's roll and pitch."""
    level_time_s: float = 5.0
    """s: the map is levelled by the mean of the IMU's roll and pitch over so long."""
    rest_time_s: float = 2.0
    """s: time in which the speed decays along a direction that the clouds do not tell."""
    drift: float = 0.003
    """Growth of the place's standard deviation in `odom`, m per root metre of way."""
    voxels_max: int = 4_000_000
    """Of all levels. A full map takes no more, and says so."""

    def __post_init__(self) -> None:
        refuse_all_but_positive(self)
        for name in ("points_max", "voxels_max"):
            if getattr(self, name) != int(getattr(self, name)):
                raise ParameterError(f"{name} must be a whole number, not {getattr(self, name):g}.")
        for name in ("agreement_min", "known_min"):
            if getattr(self, name) > 1.0:
                raise ParameterError(f"{name} is a share and at most 1, not {getattr(self, name):g}.")
        if self.last_reach_m > self.first_reach_m:
            raise ParameterError(
                f"last_reach_m {self.last_reach_m:g} is more than first_reach_m {self.first_reach_m:g}."
            )

    @property
    def levels_m(self) -> tuple[float, float, float, float]:
        """Sides of the voxels, finest first."""
        return self.voxel_m, 2 * self.voxel_m, 4 * self.voxel_m, 8 * self.voxel_m
