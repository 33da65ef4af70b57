"""Drawn rooms and bug traps: closed, with room for the UAV at its start, and a way for it to each end."""

import re

import numpy as np
import pytest

from flights.exploring.judge import SIDE_M, room_of
from flights.worlds.drawn.rooms import SMALL, TRAPS, rooms_world, trap_world
from gridslam.evaluation.volume.surface import read_surface

CLEARANCE_M = 0.5
BEYOND_M = {"u_shape": (4.3, 0.0, 1.5), "snake": (4.6, 0.0, 1.5), "cells": (2.7, 2.0, 1.5)}
BEYOND_M |= {"shaft": (0.0, 0.0, 4.2), "under": (4.0, 0.0, 2.0)}
"""A place behind what makes the trap."""


def room_for_the_uav(drawn, folder):
    """Return where the UAV's centre can come to, as a function of a place (x, y, z), and all of it (n, 3)."""
    path, low = folder / "drawn.world", np.array(drawn.low_m)
    path.write_text(drawn.sdf)
    box = drawn.low_m, drawn.high_m
    rng = np.random.default_rng(0)
    room = room_of(read_surface(path), box, np.array((0.0, 0.0, 1.5)), CLEARANCE_M, rng)
    places = low + (np.argwhere(room)[:, ::-1] + 0.5) * SIDE_M
    return lambda place: room[tuple(np.floor((np.array(place) - low) / SIDE_M).astype(int)[::-1])], places


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.long)])
def test_rooms_are_closed_and_the_uav_reaches_the_last_one(seed, tmp_path):
    drawn = rooms_world(np.random.default_rng(seed))
    assert drawn == rooms_world(np.random.default_rng(seed))
    _, places = room_for_the_uav(drawn, tmp_path)
    walls = np.array((0.3, 0.3, 0.3)) + CLEARANCE_M - 0.1
    assert (places > drawn.low_m + walls).all()
    assert (places < drawn.high_m - walls).all()
    assert places[:, 0].max() > drawn.high_m[0] - 1.5


BEAM_0 = r'<collision name="beam_0">\s*<pose>(.*?)</pose>.*?<size>(.*?)</size>'


@pytest.mark.table("sizes", [None, SMALL])
def test_no_beam_hangs_low_over_the_start(sizes):
    apart_m, bottoms_m = [], []
    for seed in range(300):
        sdf = rooms_world(np.random.default_rng(seed), sizes).sdf
        inside_m = re.search(r'<model name="inside">.*?<pose>(\S+) ', sdf, re.DOTALL)
        for place, size in re.findall(BEAM_0, sdf, re.DOTALL):
            (x, _, z, *_), (length, _, height) = map(float, place.split()), map(float, size.split())
            apart_m.append(abs(float(inside_m[1]) + x) - length / 2)
            bottoms_m.append(z - height / 2)
    low = np.array(bottoms_m) < 2.3
    assert 10 < low.sum() < len(low)
    assert np.array(apart_m)[low].min() >= 0.6


@pytest.mark.long
@pytest.mark.table("kind", TRAPS)
def test_the_uav_fits_behind_each_trap(kind, tmp_path):
    is_reached, _ = room_for_the_uav(trap_world(np.random.default_rng(1), kind), tmp_path)
    assert is_reached(BEYOND_M[kind])
