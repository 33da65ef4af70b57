"""The projection against closed forms on the sphere."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geodesy import EARTH_RADIUS_M, GeodeticOrigin

ZURICH = GeodeticOrigin()


def great_circle(latitude_1, longitude_1, latitude_2, longitude_2):
    """Distance by the haversine formula, metres."""
    a, b, turned = map(math.radians, (latitude_1, latitude_2, longitude_2 - longitude_1))
    h = math.sin((b - a) / 2) ** 2 + math.cos(a) * math.cos(b) * math.sin(turned / 2) ** 2
    return 2.0 * EARTH_RADIUS_M * math.asin(math.sqrt(h))


places = st.floats(-20_000.0, 20_000.0)


@given(places, places, st.floats(-85.0, 85.0), st.floats(-180.0, 180.0))
def test_there_and_back_and_true_distances(north, east, latitude, longitude):
    origin = GeodeticOrigin(latitude, longitude)
    there = origin.to_global(north, east)
    assert origin.to_local(*there) == pytest.approx((north, east), abs=1e-5)
    assert great_circle(latitude, longitude, *there) == pytest.approx(math.hypot(north, east), abs=1e-4)


def test_one_degree_north_is_a_degree_of_the_meridian():
    latitude, longitude = ZURICH.to_global(math.radians(1.0) * EARTH_RADIUS_M, 0.0)
    assert latitude == pytest.approx(ZURICH.latitude_deg + 1.0)
    assert longitude == pytest.approx(ZURICH.longitude_deg)


def test_east_shrinks_with_the_latitude():
    _, longitude = ZURICH.to_global(0.0, 100.0)
    expected = math.degrees(100.0 / (EARTH_RADIUS_M * math.cos(math.radians(ZURICH.latitude_deg))))
    assert longitude - ZURICH.longitude_deg == pytest.approx(expected, rel=1e-6)
    assert ZURICH.to_local(ZURICH.latitude_deg, ZURICH.longitude_deg) == (0.0, 0.0)
