"""The best direction of a photograph: sums by frame beside plain geometry, and no better one is left."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from inspection.survey import optical_axes
from inspection.survey.kernels.gains import (
    TILTS,
    YAWS,
    best_view,
    bins_of,
    drawn_from,
    frames,
    likely_gains,
    worth_of_directions,
)
from inspection.survey.kernels.sight import drawn_straight

YAWS_RAD = 2.0 * math.pi / YAWS * np.arange(YAWS)
TILTS_RAD = math.pi * (np.arange(TILTS) / (TILTS - 1) - 0.5)
EDGES = st.floats(0.1, 1.5)


def ways_of(tilts, yaws):
    level = np.cos(TILTS_RAD[tilts])
    return np.stack(
        (level * np.cos(YAWS_RAD[yaws]), level * np.sin(YAWS_RAD[yaws]), np.sin(TILTS_RAD[tilts])), -1
    )


def plain_worth(tilts, yaws, worth, lens):
    """Of each direction: what lies within its picture's edges."""
    totals = np.zeros((TILTS, YAWS))
    for t, tilt in enumerate(TILTS_RAD):
        for y, yaw in enumerate(YAWS_RAD):
            x, down, z = (ways_of(tilts, yaws) @ optical_axes(yaw, tilt)).T
            ahead = np.where(z > 1e-6, z, np.inf)
            inside = (np.abs(x / ahead) <= lens[0]) & (np.abs(down / ahead) <= lens[1]) & (z > 1e-6)
            totals[t, y] = worth[inside].sum()
    return totals


def lens_of(across, down):
    """So sharp that all in the frame is drawn. Off round angles, where two ways to compute may differ."""
    return np.array((across + 1.234e-4, down + 1.234e-4, 1e6, 0.0))


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), EDGES, EDGES)
def test_the_worth_in_each_frame_is_that_of_plain_geometry(seed, across, down):
    rng = np.random.default_rng(seed)
    tilts, yaws = rng.integers(0, TILTS, 30), rng.integers(0, YAWS, 30)
    worth, lens = rng.uniform(0.0, 2.0, 30), lens_of(across, down)
    half = 0.5 * math.pi
    found = worth_of_directions(
        (tilts * YAWS + yaws).astype(np.int16), worth, *frames(lens, np.array((-half, half)))
    )
    np.testing.assert_allclose(found, plain_worth(tilts, yaws, worth, lens), atol=1e-9)


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.5))
def test_what_a_straight_look_draws_is_near_and_steep_enough(seed, blur):
    rng = np.random.default_rng(seed)
    places, points = rng.uniform(-3.0, 3.0, (3, 3)), rng.uniform(-3.0, 3.0, (20, 3))
    normals = rng.normal(size=(20, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    begins, seen = np.array((0, 6, 6, 15)), rng.integers(0, 20, 15)
    way = np.repeat(places, np.diff(begins), axis=0) - points[seen]
    apart_m = np.linalg.norm(way, axis=1)
    cosine = (way * normals[seen]).sum(axis=1) / apart_m
    found = drawn_straight(places, begins, seen, points, normals, np.array((0.5, 0.4, 4.0, blur)))
    np.testing.assert_array_equal(found, np.hypot(apart_m, blur) <= 4.0 * cosine)


def test_a_gimbal_that_does_not_look_up_has_no_direction_there():
    lens, tilts = lens_of(0.5, 0.4), np.radians((-90.0, 10.0))
    begins, runs = frames(lens, tilts)
    assert begins[-1] == len(runs) > 0
    np.testing.assert_array_equal(np.unique(runs[:, 0]), np.flatnonzero(tilts[1] > TILTS_RAD))


@settings(max_examples=20)
@given(st.integers(0, 2**32 - 1), st.floats(-80.0, 0.0), st.floats(0.0, 80.0))
def test_the_best_photograph_draws_its_gain_and_more_than_others(seed, least_deg, most_deg):
    rng = np.random.default_rng(seed)
    points = np.column_stack((np.full(2000, 2.5), *rng.uniform(-3.0, 3.0, (2, 2000))))
    normals = np.tile((-1.0, 0.0, 0.0), (2000, 1))
    worth = np.where(rng.random(2000) < 0.7, rng.uniform(0.01, 1.0, 2000), 0.0)
    lens, tilts = lens_of(0.57, 0.43), np.radians((least_deg, most_deg))
    seen, place = np.arange(2000), np.zeros(3)
    bins = bins_of(place[None], np.array((0, 2000)), seen, points)
    gain, yaw, tilt = best_view(place, seen, bins, points, normals, worth, lens, tilts, *frames(lens, tilts))

    def shown(yaw, tilt):
        return worth[drawn_from(place, optical_axes(yaw, tilt), lens, seen, points, normals)].sum()

    assert math.isclose(gain, shown(yaw, tilt))
    likely, *nothing = likely_gains(
        np.array((0, 1)), np.array((0, 2000, 2000)), seen, bins, worth, *frames(lens, tilts)
    )
    assert nothing == [0.0]
    assert gain == pytest.approx(likely, rel=0.1)  # the raster's steps; all in the frame is drawn
    assert tilts[0] - 1e-6 <= tilt <= tilts[1] + 1e-6
    others = [t for t in TILTS_RAD.tolist() if tilts[0] <= t <= tilts[1]]
    assert gain >= 0.93 * max(shown(y, t) for y in YAWS_RAD for t in others)
