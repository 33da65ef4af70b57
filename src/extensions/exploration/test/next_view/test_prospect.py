"""What views would reveal of the unknown, against slow references and closed forms."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import ndimage
from voxel_room import PLANNER, SIDE_M, TILE

from exploration.next_view.kernels.gates import mark_gates
from exploration.next_view.kernels.revealed import STEP, WALL, count_unknown, mark_walls, revealed
from exploration.next_view.views.no_gain import CellsWithoutGain
from exploration.next_view.views.prospect import Prospect
from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner

SEEDS = st.integers(0, 2**32 - 1)


def goes_on_in(row, goes_on):
    """Whether each voxel of a row is unknown and continues enough occupied ones before it."""
    marked = []
    for here in range(len(row)):
        since_free = row[:here][::-1]
        if FREE in since_free:
            since_free = since_free[: since_free.index(FREE)]
        is_wall = row[here] == UNKNOWN and since_free.count(OCCUPIED) >= WALL
        marked.append(is_wall and since_free.index(OCCUPIED) < goes_on)
    return np.array(marked)


@given(SEEDS, st.integers(1, 4))
def test_walls_go_on_along_each_axis_beyond_rows_of_occupied_voxels(seed, goes_on):
    rng = np.random.default_rng(seed)
    kinds = rng.choice(3, (7, 6, 8), p=[0.4, 0.1, 0.5]).astype(np.uint8)
    expected = np.zeros(kinds.shape, bool)
    for axis in range(3):
        rows, marked = np.moveaxis(kinds, axis, -1), np.moveaxis(expected, axis, -1)
        for at in np.ndindex(rows.shape[:2]):
            marked[at] |= goes_on_in(rows[at].tolist(), goes_on)
            marked[at] |= goes_on_in(rows[at].tolist()[::-1], goes_on)[::-1]
    is_wall = np.zeros(kinds.shape, bool)
    mark_walls(kinds, goes_on, is_wall)
    np.testing.assert_array_equal(is_wall, expected)


def cells_met(kinds, is_wall, place, direction, side, offset, reaches):
    """The cells in which a beam meets unknown voxels."""
    found, inside = set(), 0.0
    for number in range(math.ceil(reaches[1] / STEP)):
        voxel = np.floor(np.array(place) + 0.5 + number * STEP * direction).astype(int)
        is_outside = (voxel < 0).any() or (voxel >= kinds.shape).any()
        if is_outside or kinds[tuple(voxel)] == OCCUPIED or is_wall[tuple(voxel)]:
            break
        if kinds[tuple(voxel)] == UNKNOWN and number * STEP >= reaches[0]:
            inside += STEP
            if inside > reaches[2]:
                break
            found.add(tuple(((voxel + offset) // side).tolist()))
    return found


@given(SEEDS, st.floats(0.0, 1.0), st.floats(-1.2, 1.2), st.floats(0.01, 1.4))
def test_a_view_reveals_what_is_unknown_in_the_cells_that_its_beams_meet(seed, free, lowest_rad, span_rad):
    """Also where few beams can meet any, because most of the map is free."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(3, (9, 8, 10), p=[0.3, 0.65, 0.05]).astype(np.uint8)
    kinds[rng.random(kinds.shape) < free] = FREE
    is_wall = (kinds == UNKNOWN) & (rng.random(kinds.shape) < 0.1)
    side, offset = 3, rng.integers(0, 3, 3)
    counts = np.zeros((4, 4, 5), np.int64)
    count_unknown(kinds, is_wall, side, offset, counts)
    expected = np.zeros_like(counts)
    for voxel in np.argwhere((kinds == UNKNOWN) & ~is_wall):
        expected[tuple((voxel + offset) // side)] += 1
    np.testing.assert_array_equal(counts, expected)
    is_gate = np.zeros(kinds.shape, bool)
    mark_gates(kinds, is_wall, is_gate)
    touch_free = ndimage.binary_dilation(kinds == FREE, np.ones((3, 3, 3)))
    np.testing.assert_array_equal(is_gate, (kinds == UNKNOWN) & ~is_wall & touch_free)
    places, views = rng.integers(0, kinds.shape, (4, 3)), np.array([0, 0, 1, 2])
    highest_rad = min(lowest_rad + span_rad, 1.5)
    up_rad, around_rad = np.meshgrid(
        np.linspace(lowest_rad, highest_rad, 3), np.linspace(0.0, math.tau, 9, endpoint=False), indexing="ij"
    )
    level = np.cos(up_rad)
    beams = np.stack((np.sin(up_rad), level * np.sin(around_rad), level * np.cos(around_rad)), axis=-1)
    reaches = 1.0, 7.0, 3.0
    gains = revealed(
        kinds, is_wall, np.argwhere(is_gate), counts, side, offset, places, views, beams,
        (math.tan(lowest_rad), math.tan(highest_rad)), reaches, np.zeros(counts.shape, np.int32),
    )  # fmt: skip
    for view in range(3):
        met = set()
        for place in places[views == view]:
            for beam in beams.reshape(-1, 3):
                met |= cells_met(kinds, is_wall, place, beam, side, offset, reaches)
        assert gains[view] == sum(counts[cell] for cell in met)


def room_known_up_to(layers):
    """A planner's space in a room of 4.4 x 3.6 x 5.6 m whose lower layers are known."""
    kinds = np.full((TILE, TILE, TILE), UNKNOWN, np.uint8)
    kinds[:layers, :18, :22] = OCCUPIED
    kinds[1:layers, 1:17, 1:21] = FREE
    kinds[27, 8, 10] = OCCUPIED  # the deck, where a range finder looks up
    kinds[layers:27, 8, 10] = FREE
    planner = PathPlanner(PLANNER)
    planner.update_map(SIDE_M, TILE, np.zeros((1, 3), int), kinds.reshape(1, -1))
    return planner.space(0.0, np.array((2.1, 1.7, 1.1)))


def prospect_of(space, no_gain=None):
    return Prospect(space, (-0.26, 0.26), (0.1, 8.0), no_gain or CellsWithoutGain())


def test_what_lies_behind_walls_that_go_on_is_not_expected_to_be_seen():
    prospect = prospect_of(room_known_up_to(10))
    # A place 0.6 m above what is known: from there the beams meet the walls' continuation all around
    gain_m3 = prospect.gains_m3(np.array([(13, 8, 10)]), np.zeros(1, int))[0]
    # All that is unknown between the walls within the heights that beams reach, and in their cells
    inner_m3 = 3.2 * 4.0
    assert 0.4 * inner_m3 < gain_m3 < 1.6 * inner_m3
    # And behind a wall that is known, nothing
    assert prospect.gains_m3(np.array([(5, 8, 10)]), np.zeros(1, int))[0] == 0.0


def test_what_was_looked_at_without_gain_counts_no_more_until_it_has_changed():
    space, no_gain = room_known_up_to(10), CellsWithoutGain()
    prospect, view = prospect_of(space, no_gain), (np.array([(13, 8, 10)]), np.zeros(1, int))
    before_m3 = prospect.gains_m3(*view)[0]
    prospect.note(view[0][0], 0.5)
    assert prospect.gains_m3(*view)[0] == before_m3
    prospect.note(view[0][0], 0.5)
    assert prospect.gains_m3(*view)[0] == 0.0
    assert prospect_of(space, no_gain).gains_m3(*view)[0] == 0.0
    assert prospect.is_without_gain(np.array([(13, 8, 13), (5, 8, 10)])).tolist() == [True, False]
    # A map in which half of it is known by now
    space.grid.kinds[10:16, 1:17, 1:21:2] = FREE
    assert prospect_of(space, no_gain).gains_m3(*view)[0] > 0.0


@pytest.mark.table("roughly", [True, False])
def test_a_higher_view_of_a_column_counts_what_the_lower_ones_show_too(roughly):
    prospect = prospect_of(room_known_up_to(10))
    low, high = (13, 8, 10), (19, 8, 10)
    gains = prospect.gains_m3(np.array([low, low, high, high]), np.array([0, 1, 1, 2]), roughly)
    assert max(gains[0], gains[2]) < gains[1] <= gains[0] + gains[2]
