"""Maps in closed form: planes drawn once, twice, from both sides, aslant; and a slow reference."""

import numpy as np
import pytest

from gridslam.evaluation.volume.doubled_surfaces import DOUBLED_MAX, disagreement, doubled_share
from gridslam.volume import Board, VolumeParameters, VoxelMap
from gridslam.volume.kernels.doubling import APART_MAX, APART_MIN, MARGIN, PATCH_MIN, count_doubled
from gridslam.volume.kernels.shown import FREE, OCCUPIED, UNKNOWN

SIDE = 28
INNER = slice(MARGIN, SIDE - MARGIN)


def block(kind=UNKNOWN):
    return np.full((SIDE, SIDE, SIDE), kind, np.uint8)


def share(kinds):
    surface, doubled = count_doubled(kinds)
    return doubled / surface


def planes(*layers, between=UNKNOWN):
    """Floors at layers, rising, each with two free layers above, and something else between."""
    kinds = block(between)
    for z in layers:
        kinds[z + 1 : z + 3] = FREE
    for z in layers:
        kinds[z] = OCCUPIED
    return kinds


@pytest.mark.table("way", [1, -1])
@pytest.mark.table(("apart", "expected"), [(2, 1.0), (3, 1.0), (5, 1.0), (6, 0.0)])
def test_a_plane_that_is_drawn_twice_is_doubled_floor_or_ceiling(way, apart, expected):
    assert share(np.ascontiguousarray(planes(9, 9 + apart)[::way])) == expected


@pytest.mark.table("axis", [1, 2])
def test_walls_do_not_count(axis):
    """Pipes, frames and stiffeners stand before the walls of a ship."""
    assert count_doubled(np.ascontiguousarray(np.moveaxis(planes(9, 12), 0, axis))) == (0, 0)


def test_a_plane_once_and_a_thick_plane_are_not_doubled():
    assert share(planes(10)) == 0.0
    thick = planes(10)
    thick[9] = OCCUPIED
    assert share(thick) == 0.0


@pytest.mark.table("thickness", [1, 2, 3])
@pytest.mark.table("inside", [UNKNOWN, FREE])
def test_a_slab_that_was_seen_from_both_sides_is_not_doubled(thickness, inside):
    """Free room is below and above. Only one that was seen from inside, too, has two that face alike."""
    kinds = block(FREE)
    kinds[10 : 10 + thickness + 1] = inside
    kinds[10] = kinds[10 + thickness] = OCCUPIED
    if inside == FREE and thickness > 1:
        assert share(kinds) == 1.0
    else:
        assert share(kinds) == 0.0


def test_slopes_and_corners_are_not_doubled():
    z, _, x = np.indices((SIDE, SIDE, SIDE))
    for rise in (0.15, 0.5, 1.0):
        height = 8.0 + rise * (x - 12.0)
        kinds = np.where(z > height + 0.5, FREE, UNKNOWN).astype(np.uint8)
        kinds[np.abs(z - height) <= 0.5] = OCCUPIED
        assert share(kinds) == 0.0
    corner = block(FREE)
    corner[:10], corner[:, :, :10] = UNKNOWN, UNKNOWN
    corner[9, :, 9:], corner[9:, :, 9] = OCCUPIED, OCCUPIED
    assert share(corner) == 0.0


def test_a_narrow_rib_before_a_wall_is_no_surface():
    kinds = planes(10)
    kinds[12, :, 12:14] = OCCUPIED  # 2 voxels wide
    assert share(kinds) == 0.0


def test_half_a_plane_doubled_counts_as_its_half():
    kinds = planes(10)
    kinds[11:13, :, 14:], kinds[13, :, 14:], kinds[14:16, :, 14:] = FREE, OCCUPIED, FREE
    # 14 x 14 columns, from MARGIN on. Half of them have two floors; at their edge a patch ends
    surface, doubled = count_doubled(kinds)
    assert surface == pytest.approx(14 * (7 + 2 * 7), abs=2 * 14)
    assert doubled == pytest.approx(2 * 14 * 7, abs=2 * 14)


def test_kernel_equals_the_definition_written_slowly():
    rng = np.random.default_rng(5)
    for _ in range(3):
        kinds = rng.choice(np.array([UNKNOWN, FREE, OCCUPIED], np.uint8), (SIDE,) * 3, p=[0.1, 0.3, 0.6])
        kinds[8::3] = FREE  # so many voxels face up or down
        assert count_doubled(kinds) == slowly(kinds)


def slowly(kinds):
    surface, doubled = np.zeros((2, SIDE, SIDE, SIDE), bool)
    for side in (-1, 1):
        faces = (kinds == OCCUPIED) & (np.roll(kinds, -side, 0) == FREE)
        thick = faces | np.roll(faces, 1, 0) | np.roll(faces, -1, 0)
        around = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
        found = sum(np.roll(thick, step, (1, 2)).astype(int) for step in around)
        patch = faces & (found >= PATCH_MIN)
        surface |= patch
        for apart in range(APART_MIN, APART_MAX + 1):
            doubled |= patch & (np.roll(patch, apart, 0) | np.roll(patch, -apart, 0))
    inner = (INNER, INNER, INNER)
    return surface[inner].sum(), doubled[inner].sum()


def scanned(*floors_m):
    """A map of a floor of 1.6 x 1.6 m, seen straight from above, at one height after the other."""
    voxels, board = VoxelMap(VolumeParameters(resolution_m=0.1)), Board()
    ticks = np.arange(-0.75, 0.8, 0.1)
    x, y = (axis.ravel() for axis in np.meshgrid(ticks, ticks))
    for floor_m in floors_m:
        for begin in zip(x, y):
            voxels.insert(voxels.rays((*begin, 1.05), np.array([(*begin, floor_m)], np.float32)), board)
    return voxels


def test_a_map_whose_height_leapt_lies_doubled_and_a_steady_one_does_not():
    """The UAV was 0.2 m lower than it believed: the floor came a second time, above the first."""
    steady, leapt = scanned(-0.95), scanned(-0.95, -0.75)
    assert doubled_share(steady) == 0.0
    assert doubled_share(leapt) == 1.0
    assert disagreement(doubled_share(steady)) == ""
    assert "does not agree with itself: 100 %" in disagreement(doubled_share(leapt))


def test_a_map_without_a_surface_has_no_share_and_the_limit_itself_passes():
    assert np.isnan(doubled_share(VoxelMap(VolumeParameters())))
    assert disagreement(float("nan")) == disagreement(DOUBLED_MAX) == ""
