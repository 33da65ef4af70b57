"""WGS-84 against published coordinates and closed forms."""

from __future__ import annotations

import math

import pytest

from simulation_tools.geodesy import GeodeticOrigin
from simulation_tools.mavros.earth import GeodeticPoint


def test_the_axes_and_the_poles_have_the_ellipsoids_radii():
    """Semi-major axis 6378137 m, semi-minor axis 6356752.3142 m (NIMA TR8350.2, table 3.3)."""
    assert GeodeticPoint(0.0, 0.0, 0.0).to_ecef() == pytest.approx((6378137.0, 0.0, 0.0))
    assert GeodeticPoint(0.0, 90.0, 10.0).to_ecef() == pytest.approx((0.0, 6378147.0, 0.0), abs=1e-6)
    assert GeodeticPoint(90.0, 0.0, 0.0).to_ecef() == pytest.approx((0.0, 0.0, 6356752.3142), abs=1e-4)


def test_a_millionth_of_a_degree_is_as_long_as_the_radii_of_curvature_say():
    """M = a (1 - e2) / (1 - e2 sin2)^1.5 along the meridian, N cos(latitude) along the parallel."""
    a, e2 = 6378137.0, 6.69437999014e-3
    latitude = math.radians(47.4)
    shrink = 1.0 - e2 * math.sin(latitude) ** 2
    meridian_m = a * (1.0 - e2) / shrink**1.5 * math.radians(1e-6)
    parallel_m = a / math.sqrt(shrink) * math.cos(latitude) * math.radians(1e-6)
    here = GeodeticPoint(47.4, 8.5, 0.0)
    assert here.enu_to(GeodeticPoint(47.4 + 1e-6, 8.5, 0.0)) == pytest.approx((0, meridian_m, 0), abs=1e-7)
    assert here.enu_to(GeodeticPoint(47.4, 8.5 + 1e-6, 0.0)) == pytest.approx((parallel_m, 0, 0), abs=1e-7)
    assert here.enu_to(GeodeticPoint(47.4, 8.5, 12.5)) == pytest.approx((0, 0, 12.5), abs=1e-6)


def test_px4s_sphere_differs_by_less_than_half_a_percent():
    """So a place sent on global_to_local is off by centimetres some metres away."""
    origin = GeodeticOrigin()
    here = GeodeticPoint(origin.latitude_deg, origin.longitude_deg, 0.0)
    there = GeodeticPoint(*origin.to_global(30.0, -20.0), 0.0)
    east, north, _ = here.enu_to(there)
    assert (north, east) == (pytest.approx(30.0, rel=5e-3), pytest.approx(-20.0, rel=5e-3))
