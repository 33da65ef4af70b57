"""Padding: a full turn on the source's own grid, its beams unchanged, the rest marked."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flight_basics.errors import ParameterError, ScanError
from inspection_tools import LidarPadding, PaddingParameters, ScanGeometry

INF, NAN = math.inf, math.nan
DEGREE = math.pi / 180.0

# Field of view, step, least and greatest range of the six lidars (thesis, table D.1)
LIDARS = {
    "urg": (240.0, 360.0 / 1024.0, 0.02, 5.6),
    "ust": (270.0, 0.25, 0.06, 10.0),
    "utm": (270.0, 0.25, 0.1, 30.0),
    "puck": (360.0, 0.2, 0.5, 100.0),
    "tim": (270.0, 1.0 / 3.0, 0.05, 25.0),
    "m8": (360.0, 0.2, 0.5, 150.0),
}


def lidar_geometry(name, sign=1):
    """As the lidar's message says it: float32, symmetric to straight ahead, a full turn open at its end."""
    fov_deg, step_deg, _, _ = LIDARS[name]
    turn = round(360.0 / step_deg)
    beams = min(math.floor(fov_deg / step_deg + 1e-6) + 1, turn)
    start = np.float32(-sign * (turn // 2 if beams == turn else (beams - 1) / 2.0) * step_deg * DEGREE)
    return ScanGeometry(beams, float(start), float(np.float32(sign * step_deg * DEGREE)))


def angles(geometry):
    return geometry.angle_min_rad + np.arange(geometry.beams) * geometry.angle_increment_rad


def wrapped(angle):
    return (angle + math.pi) % (2.0 * math.pi) - math.pi


@pytest.mark.table("sign", [1, -1])
@pytest.mark.table("name", LIDARS)
def test_all_six_lidars(name, sign):
    """Every direction of the turn once, the lidar's own at their places and unchanged."""
    _, step_deg, range_min, range_max = LIDARS[name]
    geometry = lidar_geometry(name, sign)
    ranges = np.random.default_rng(1).uniform(range_min, range_max, geometry.beams).astype(np.float32)
    padded = LidarPadding().pad(ranges, geometry, range_min, range_max)

    assert len(padded.ranges) == len(padded.seen) == padded.geometry.beams == round(360.0 / step_deg)
    assert padded.geometry.angle_increment_rad == geometry.angle_increment_rad
    assert padded.seen.sum() == geometry.beams
    np.testing.assert_array_equal(padded.ranges[padded.seen], ranges)
    assert np.isnan(padded.ranges[~padded.seen]).all()
    np.testing.assert_allclose(angles(padded.geometry)[padded.seen], angles(geometry), atol=1e-9)
    assert padded.geometry.closes_circle
    # starts at the rear, and goes round from there
    step = abs(geometry.angle_increment_rad)
    assert -math.pi - 1e-3 * step <= sign * padded.geometry.angle_min_rad < -math.pi + step
    assert sign * padded.angle_max_rad < math.pi + 1e-3 * step


@given(
    turn=st.integers(4, 400),
    beams=st.integers(1, 400),
    start=st.floats(-7.0, 7.0),
    sign=st.sampled_from([1, -1]),
)
def test_any_field_of_view(turn, beams, start, sign):
    """A slow reference: look every padded beam's direction up among the source's."""
    beams = min(beams, turn)
    geometry = ScanGeometry(beams, start, sign * 2.0 * math.pi / turn)
    ranges = np.arange(beams, dtype=np.float32) + 1.0
    padded = LidarPadding(PaddingParameters("inf")).pad(ranges, geometry, 0.0, 1000.0)
    assert padded.geometry.beams == turn
    source = angles(geometry)
    for index, angle in enumerate(angles(padded.geometry)):
        off = np.abs(wrapped(source - angle))
        nearest = int(np.argmin(off))
        assert padded.seen[index] == (off[nearest] < 1e-6)
        assert padded.ranges[index] == (ranges[nearest] if padded.seen[index] else INF)


@pytest.mark.table(
    ("beams", "start_rad", "increment_rad", "turn"),
    [
        (897, -math.pi, 0.007, 898),  # velodyne_laserscan
        (1454, math.pi, -0.004319689702242613, 1455),  # SICK NAV310
        (361, -1.5708, 0.0087, 722),  # pointcloud_to_laserscan
    ],
)
def test_an_increment_that_does_not_divide_the_turn_is_kept(beams, start_rad, increment_rad, turn):
    geometry = ScanGeometry(beams, start_rad, increment_rad)
    ranges = np.arange(beams, dtype=np.float32) + 1.0
    padded = LidarPadding().pad(ranges, geometry, 0.0, 2000.0)
    assert (padded.geometry.beams, padded.geometry.angle_increment_rad) == (turn, increment_rad)
    np.testing.assert_array_equal(padded.ranges[padded.seen], ranges)
    np.testing.assert_allclose(angles(padded.geometry)[padded.seen], angles(geometry), atol=1e-9)
    across_the_seam = 2.0 * math.pi - (turn - 1) * abs(increment_rad)
    assert 0.5 <= across_the_seam / abs(increment_rad) <= 1.5


@pytest.mark.table(
    ("value", "expected"),
    [("range_max", 10.0), ("inf", INF), ("nan", NAN), (3.5, 3.5), ("3.5", 3.5), (0, 0.0)],
)
def test_value_of_the_added_beams(value, expected):
    padded = LidarPadding(PaddingParameters(value)).pad(
        np.ones(3), ScanGeometry(3, 0.0, math.pi / 4), 0.1, 10.0
    )
    np.testing.assert_array_equal(padded.ranges[~padded.seen], np.full(5, expected, np.float32))


@pytest.mark.table("value", ["far", "", "-1", -1.0, "-inf", 2000.0, None])
def test_refuses_other_values(value):
    with pytest.raises(ParameterError, match="value is"):
        PaddingParameters(value)


@pytest.mark.table(
    ("first", "last", "merged"),
    [(2.0, 3.0, 2.0), (3.0, 2.0, 2.0), (NAN, 3.0, 3.0), (3.0, NAN, 3.0), (INF, 3.0, 3.0)],
)
def test_a_repeated_seam_beam_is_merged_to_the_nearer(first, last, merged):
    ranges = np.array([first, 5, 6, 7, 8, last], np.float32)  # 5 beams a turn, and the first again
    padded = LidarPadding().pad(ranges, ScanGeometry(6, -math.pi, 2.0 * math.pi / 5), 0.1, 10.0)
    np.testing.assert_array_equal(padded.ranges, np.array([merged, 5, 6, 7, 8], np.float32))
    assert padded.seen.all()


def test_the_added_beams_are_unseen():
    padded = LidarPadding().pad(np.ones(3), ScanGeometry(3, -math.pi / 4, math.pi / 4), 0.1, 10.0)
    #                                           -180 -135 -90 -45 0 45 90 135
    np.testing.assert_array_equal(padded.seen, [False, False, False, True, True, True, False, False])


def test_padding_twice_changes_nothing():
    geometry = lidar_geometry("ust")
    once = LidarPadding().pad(np.ones(geometry.beams, np.float32), geometry, 0.1, 10.0)
    twice = LidarPadding().pad(once.ranges, once.geometry, 0.1, 10.0)
    np.testing.assert_array_equal(twice.ranges, once.ranges)
    assert twice.geometry == once.geometry


@pytest.mark.table(
    ("geometry", "limits", "complaint"),
    [
        (ScanGeometry(5, 0.0, math.pi), (0.1, 10.0), "more than twice"),
        (ScanGeometry(4, 0.0, math.pi), (0.1, 10.0), "has 5 ranges, but its geometry says 4"),
        (ScanGeometry(5, 0.0, 0.25 * DEGREE), (0.1, -10.0), "range_max -10"),
        (ScanGeometry(5, 0.0, 0.25 * DEGREE), (0.1, NAN), "range_max nan"),
    ],
)
def test_refuses_what_it_cannot_pad(geometry, limits, complaint):
    with pytest.raises(ScanError, match=complaint):
        LidarPadding().pad(np.ones(5), geometry, *limits)


def test_each_scan_is_padded_by_its_own_geometry_limits_and_parameters():
    quarter, half = ScanGeometry(90, 0.0, DEGREE), ScanGeometry(180, 0.0, DEGREE)
    padding = LidarPadding(PaddingParameters("range_max"))
    for geometry, range_max_m in ((quarter, 10.0), (half, 10.0), (half, 20.0), (quarter, 10.0)):
        ones = np.ones(geometry.beams, np.float32)
        padded = padding.pad(ones, geometry, 0.1, range_max_m)
        assert padded.seen.sum() == geometry.beams
        assert (padded.ranges[~padded.seen] == range_max_m).all()
        padded.ranges[:], padded.seen[:] = 0.0, True  # the next scan must not show what a caller does to this
    padding.parameters = PaddingParameters(3.0)
    padded = padding.pad(ones, quarter, 0.1, 10.0)
    assert (padded.ranges[~padded.seen] == 3.0).all()
