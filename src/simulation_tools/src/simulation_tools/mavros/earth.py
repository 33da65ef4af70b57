"""From latitude, longitude and height over WGS-84's ellipsoid to ENU metres about a place, as MAVROS does.

PX4's own projection (`geodesy.py`) differs: it is on a sphere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.geometry import Vector3

_SEMI_MAJOR_M = 6378137.0
_FLATTENING = 1.0 / 298.257223563
_ECCENTRICITY_SQUARED = _FLATTENING * (2.0 - _FLATTENING)


@dataclass(frozen=True)
class GeodeticPoint:
    """A place on earth: degrees, and metres above the ellipsoid."""

    latitude_deg: float
    longitude_deg: float
    height_m: float

    def to_ecef(self) -> Vector3:
        """Return earth-centred, earth-fixed coordinates, m."""
        latitude, longitude = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        sine, cosine = math.sin(latitude), math.cos(latitude)
        normal_m = _SEMI_MAJOR_M / math.sqrt(1.0 - _ECCENTRICITY_SQUARED * sine * sine)
        return (
            (normal_m + self.height_m) * cosine * math.cos(longitude),
            (normal_m + self.height_m) * cosine * math.sin(longitude),
            (normal_m * (1.0 - _ECCENTRICITY_SQUARED) + self.height_m) * sine,
        )

    def enu_to(self, other: GeodeticPoint) -> Vector3:
        """Return the vector from here to another place: east, north and up at this place, m."""
        x, y, z = (there - here for there, here in zip(other.to_ecef(), self.to_ecef()))
        latitude, longitude = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        outwards = math.cos(longitude) * x + math.sin(longitude) * y
        return (
            -math.sin(longitude) * x + math.cos(longitude) * y,
            -math.sin(latitude) * outwards + math.cos(latitude) * z,
            math.cos(latitude) * outwards + math.sin(latitude) * z,
        )
