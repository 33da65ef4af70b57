"""Conversions between the local frame and latitude and longitude, by PX4's projection.

Azimuthal equidistant on a sphere about the origin (Snyder, "Map projections", 1987, section 25): distances
and bearings from the origin are true.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.autopilot import Px4Error
from simulation_tools.geometry import Vector3

EARTH_RADIUS_M = 6371000.0
_ALTITUDE_MAX_M = 1e4


@dataclass(frozen=True)
class GeodeticOrigin:
    """Where the world's origin lies on earth; altitude above mean sea level. Default: PX4 SITL's, Zurich."""

    latitude_deg: float = limited(47.397742, above=-90.0, below=90.0)
    longitude_deg: float = limited(8.545594, -180.0, 180.0)
    altitude_m: float = limited(488.0, -_ALTITUDE_MAX_M, _ALTITUDE_MAX_M)

    def __post_init__(self) -> None:
        check_limits(self, Px4Error, "the world's origin: {}")

    def moved(self, position_enu_m: Vector3) -> GeodeticOrigin:
        """Return the origin of a frame whose zero is a place in this frame. Its altitude is at most 10 km."""
        east_m, north_m, up_m = position_enu_m
        altitude_m = min(max(self.altitude_m + up_m, -_ALTITUDE_MAX_M), _ALTITUDE_MAX_M)
        return GeodeticOrigin(*self.to_global(north_m, east_m), altitude_m)

    def to_global(self, north_m: float, east_m: float) -> tuple[float, float]:
        """Return latitude and longitude, degrees, of a place given from the origin."""
        c = math.hypot(north_m, east_m) / EARTH_RADIUS_M
        k = math.sin(c) / c if c > 0.0 else 1.0
        x, y = north_m / EARTH_RADIUS_M, east_m / EARTH_RADIUS_M
        latitude, longitude = math.radians(self.latitude_deg), math.radians(self.longitude_deg)
        sine = math.cos(c) * math.sin(latitude) + k * x * math.cos(latitude)
        turned = math.atan2(k * y, math.cos(c) * math.cos(latitude) - k * x * math.sin(latitude))
        wrapped = math.remainder(longitude + turned, 2.0 * math.pi)
        return math.degrees(math.asin(min(1.0, max(-1.0, sine)))), math.degrees(wrapped)

    def to_local(self, latitude_deg: float, longitude_deg: float) -> tuple[float, float]:
        """Return north and east, metres from the origin, of a place on earth."""
        here, there = math.radians(self.latitude_deg), math.radians(latitude_deg)
        turned = math.radians(longitude_deg - self.longitude_deg)
        cosine = math.sin(here) * math.sin(there) + math.cos(here) * math.cos(there) * math.cos(turned)
        north = math.cos(here) * math.sin(there) - math.sin(here) * math.cos(there) * math.cos(turned)
        east = math.cos(there) * math.sin(turned)
        # Compute the angle from both sine and cosine, because each alone is ill-conditioned somewhere.
        sine = math.hypot(north, east)
        k = math.atan2(sine, cosine) / sine if sine > 0.0 else 1.0
        return k * north * EARTH_RADIUS_M, k * east * EARTH_RADIUS_M
