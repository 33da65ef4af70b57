"""The times of points, as the drivers of several makers tell them."""

import numpy as np
import pytest

from input_checks.point_times import SweptClouds, point_times

STAMP_S = 1_700_000_000.25
SWEEP_S = np.linspace(0.0, 0.1, 1001)
TO_THE_STAMP_S = SWEEP_S - 0.1
MAKERS = {
    "velodyne_driver, first point": ("time", SWEEP_S.astype(np.float32), SWEEP_S),
    "velodyne_driver, last point": ("time", TO_THE_STAMP_S.astype(np.float32), TO_THE_STAMP_S),
    "Ouster": ("t", np.round(SWEEP_S * 1e9).astype(np.uint32), SWEEP_S),
    "Livox": ("offset_time", np.round(SWEEP_S * 1e9).astype(np.uint32), SWEEP_S),
    "Livox, driver 2": ("timestamp", (STAMP_S + SWEEP_S) * 1e9, SWEEP_S),
    "Hesai, first point": ("timestamp", STAMP_S + SWEEP_S, SWEEP_S),
    "Hesai, last point": ("timestamp", STAMP_S + TO_THE_STAMP_S, TO_THE_STAMP_S),
    "in us": ("time", np.round(SWEEP_S * 1e6).astype(np.uint32), SWEEP_S),
    "in ms": ("t", (SWEEP_S * 1e3).astype(np.float32), SWEEP_S),
}


@pytest.mark.table("maker", MAKERS)
def test_each_makers_times_are_understood(maker):
    field, values, since_s = MAKERS[maker]
    times = point_times(field, values, STAMP_S)
    assert not times.why_not
    np.testing.assert_allclose(times.since_s, since_s, atol=1e-6)
    assert times.span_s == pytest.approx(0.1, abs=1e-6)


@pytest.mark.table("values", [np.zeros(9), np.full(9, STAMP_S), np.array([0.0, np.nan]), np.array([])])
def test_points_of_one_instant_have_no_times(values):
    assert point_times("time", values, STAMP_S) is None


def test_times_of_another_clock_tell_how_long_a_cloud_lasts_and_no_more():
    times = point_times("timestamp", 5000.0 + SWEEP_S, STAMP_S)
    assert times.span_s == pytest.approx(0.1)
    assert "timestamp" in times.why_not


@pytest.mark.table(
    ("speed", "rate", "words"), [(0.0, 0.5, "0.5 m off"), (2.0, 0.0, "0.2 m off"), (0.5, 0.02, "")]
)
def test_a_cloud_that_is_bent_is_told_once_and_what_it_costs(speed, rate, words):
    """In 0.1 s: 0.5 rad/s at 10 m is 0.5 m, 2 m/s is 0.2 m, and both others are 0.07 m together."""
    said = []
    swept = SweptClouds(said.append)
    for _ in range(3):
        swept.watch("velodyne", point_times("time", SWEEP_S, STAMP_S), speed, rate)
    assert len(said) == bool(words)
    assert not words or (words in said[0] and "0.1 s" in said[0] and "field time" in said[0])
