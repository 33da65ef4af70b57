"""The judge in a room whose volume and surface are known in closed form."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from flights.exploring.judge import judge_map
from gridslam.evaluation.volume.surface import Surface
from gridslam.evaluation.volume.visibility import LidarView

SIZE_M, CLEARANCE_M = np.array((3.0, 2.0, 2.0)), 0.4
BEGIN_M = np.array((1.0, 1.0, 1.0))


def room():
    box = trimesh.creation.box(bounds=((0.0, 0.0, 0.0), SIZE_M))
    return Surface(np.array(box.triangles), ("room",), np.zeros(len(box.triangles), int))


def shown(share=1.0, side_m=0.2):
    """A map of the room that knows what is left of this share of its length."""
    shape = np.round(SIZE_M / side_m).astype(int)[::-1] + 2  # its walls begin at the map's voxel -1
    kinds = np.full(shape, 2, np.uint8)
    kinds[1:-1, 1:-1, 1:-1] = 1
    kinds[:, :, 1 + round(share * SIZE_M[0] / side_m) :] = 0 if share < 1.0 else kinds[:, :, -1:]

    def dense(box):
        low, high = np.array(box.low) + 1, np.array(box.high) + 1
        found = np.zeros((high - low)[::-1], np.uint8)
        for place in np.ndindex(kinds.shape):
            inner = np.array(place) - low[::-1]
            if (inner >= 0).all() and (inner < found.shape).all():
                found[tuple(inner)] = kinds[place]
        return found

    def centres(kind):
        return (np.argwhere(kinds == kind)[:, ::-1] - 0.5) * side_m

    return SimpleNamespace(resolution_m=side_m, dense=dense, centres=centres)


def judged(known, **how):
    box_m = (-0.3, -0.3, -0.3), tuple(SIZE_M + 0.3)
    given = {
        "box_m": box_m,
        "begin_m": BEGIN_M,
        "clearance_m": CLEARANCE_M,
        "view": LidarView(range_max_m=20.0),
    }
    return judge_map(known, room(), rng=np.random.default_rng(1), **{**given, **how})


def test_all_that_a_ball_fills_of_a_known_room_is_known():
    found = judged(shown())
    r, inner = CLEARANCE_M, SIZE_M - 2 * CLEARANCE_M
    volume = np.prod(inner) + 2 * r * (inner[0] * inner[1] + inner[1] * inner[2] + inner[2] * inner[0])
    volume += math.pi * r**2 * inner.sum() + 4.0 / 3.0 * math.pi * r**3  # Steiner's formula
    assert found.reachable_m3 == pytest.approx(volume, rel=0.05)
    assert found.known_share == 1.0
    assert found.visible_m2 == pytest.approx(32.0, rel=0.03)
    assert found.mapped_share == 1.0


def test_what_the_map_lacks_is_missing():
    found = judged(shown(share=1.0 / 3.0))
    assert 0.2 < found.known_share < 0.4
    assert found.mapped_share < 0.6


def test_a_uav_that_does_not_fit_is_told():
    with pytest.raises(ValueError, match=r"does not have 1\.2 m"):
        judged(shown(), clearance_m=1.2)
