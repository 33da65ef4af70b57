"""From latitude, longitude, height and compass angles into the map."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass

import numpy as np

from flight_basics.checks import check_parameters, limited
from inspection.camera.survey_camera import optical_axes, rolled

AXIS_M, FLATTENING = 6_378_137.0, 1.0 / 298.257223563
"""Of the ellipsoid of WGS 84."""


@dataclass(frozen=True)
class WorldFrame:
    """Where the map lies on earth: the place of its origin, and its x axis, clockwise from north.

    height_m: None: heights are those above the take-off, and the map's z is 0 there.

    Raises:
        ParameterError: a value out of range.
    """

    latitude_deg: float = limited(MISSING, -90.0, 90.0, named="latitude")
    longitude_deg: float = limited(MISSING, -180.0, 180.0, named="longitude")
    height_m: float | None = limited(None, -12_000.0, 100_000.0, named="height")
    heading_deg: float = limited(90.0, -360.0, 360.0, named="heading")

    def __post_init__(self) -> None:
        check_parameters(self)

    @property
    def _turn(self) -> np.ndarray:
        """(3, 3) from east, north, up into the map."""
        angle = math.radians(self.heading_deg - 90.0)
        cos, sin = math.cos(angle), math.sin(angle)
        return np.array(((cos, -sin, 0.0), (sin, cos, 0.0), (0.0, 0.0, 1.0)))

    def place_m(self, latitude_deg: float, longitude_deg: float, height_m: float) -> np.ndarray:
        """Return a place (3,) in the map. height_m: see the class."""
        at = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        base_m = 0.0 if self.height_m is None else self.height_m
        there_m = _earth_m(math.radians(latitude_deg), math.radians(longitude_deg), height_m)
        off_m = there_m - _earth_m(*at, base_m)
        (sin_lat, cos_lat), (sin_lon, cos_lon) = ((math.sin(each), math.cos(each)) for each in at)
        east_north_up = np.array(
            (
                (-sin_lon, cos_lon, 0.0),
                (-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
                (cos_lat * cos_lon, cos_lat * sin_lon, sin_lat),
            )
        )
        place: np.ndarray = self._turn @ east_north_up @ off_m
        return place

    def axes(self, yaw_deg: float, pitch_deg: float, roll_deg: float) -> np.ndarray:
        """Return the optical frame's axes in the map, (3, 3) in the columns, for angles as DJI tells them."""
        axes = optical_axes(math.radians(90.0 - yaw_deg), math.radians(pitch_deg))
        turned: np.ndarray = rolled(self._turn @ axes, math.radians(roll_deg))
        return turned


def _earth_m(latitude: float, longitude: float, height_m: float) -> np.ndarray:
    """Return a place (3,) in the frame that turns with the earth."""
    squeezed = FLATTENING * (2.0 - FLATTENING)
    normal_m = AXIS_M / math.sqrt(1.0 - squeezed * math.sin(latitude) ** 2)
    level_m = (normal_m + height_m) * math.cos(latitude)
    return np.array(
        (
            level_m * math.cos(longitude),
            level_m * math.sin(longitude),
            (normal_m * (1.0 - squeezed) + height_m) * math.sin(latitude),
        )
    )
