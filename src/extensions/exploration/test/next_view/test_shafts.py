"""Holes and shafts, into which a level lidar does not look."""

import math

import numpy as np
import pytest

from exploration.next_view import Explorer, ExplorerParameters
from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner, PlannerParameters

VOXEL_M, SIDE, FLOOR = 0.2, 40, 15
"""The floor's surface is at z = 3 m, and the room above it is 4 m high."""
SLOPE = math.tan(math.radians(15.0))
HERE_M = np.array((1.7, 4.1, 4.9))
HOLE = slice(15, 25)
"""Voxels of a hole of 2 x 2 m along x and y, from 3 to 5 m."""


def drawn(upside_down=False, hole=UNKNOWN):
    """A room of 7.6 x 7.6 m, all known; its floor, with a hole; nothing is known below but by level beams."""
    kinds = np.full((SIDE, SIDE, SIDE), UNKNOWN, np.uint8)
    inside = slice(1, SIDE - 1)
    kinds[FLOOR - 1 : FLOOR + 21] = OCCUPIED
    kinds[FLOOR : FLOOR + 20, inside, inside] = FREE
    kinds[FLOOR - 1, HOLE, HOLE] = hole
    if hole == UNKNOWN:
        # The lowest beam over the far rim ends where it has sunk by its slope
        centres = (np.arange(SIDE) + 0.5)[HOLE] * VOXEL_M - 3.0
        far_m = np.maximum(centres, 2.0 - centres)
        sunk = (SLOPE * np.maximum(far_m[:, None], far_m) / VOXEL_M).astype(int)
        for (y, x), deep in np.ndenumerate(sunk):
            kinds[FLOOR - deep : FLOOR, 15 + y, 15 + x] = FREE
    return kinds[::-1].copy() if upside_down else kinds


def planner_of(kinds):
    planner = PathPlanner(PlannerParameters(radius=0.3, margin=0.1))
    planner.update_map(VOXEL_M, SIDE, np.zeros((1, 3), np.int64), kinds.reshape(1, -1))
    return planner


ASKED = ExplorerParameters(spacing=0.4, worth_min=1e3, shafts=True)


def decided(kinds, here_m, is_steep=True):
    explorer = Explorer(ASKED, is_steep)
    return explorer.decide(planner_of(kinds).space(0.0, here_m), here_m)


@pytest.mark.table("upside_down", [False, True])
def test_a_hole_is_entered_straight_before_any_view_of_its_border(upside_down):
    here_m = HERE_M * (1.0, 1.0, -1.0) + (0.0, 0.0, SIDE * VOXEL_M) if upside_down else HERE_M
    decision = decided(drawn(upside_down), here_m)
    # Then the way ends in the shaft, a metre beyond where the UAV may be; half its width is within the rim
    assert decision.column_m is not None
    x, y, z = decision.goal_m
    assert min(x, y) >= 3.4
    assert max(x, y) <= 4.6
    begin_z, end_z = decision.column_m[0][2], decision.column_m[-1][2]
    assert end_z == z
    assert end_z - begin_z == pytest.approx(1.0 if upside_down else -1.0)
    assert z > 5.0 if upside_down else z < 3.0
    np.testing.assert_allclose(decision.column_m[:, :2] - (x, y), 0.0, atol=1e-9)


@pytest.mark.table("upside_down", [False, True])
def test_a_shaft_is_entered_as_far_as_a_range_finder_has_seen_it(upside_down):
    """Given a thread of free voxels in the hole's middle, down to 0.6 m. The UAV keeps two voxels."""
    kinds = drawn()
    kinds[3:FLOOR, 19:21, 19:21] = FREE
    kinds[1:3] = OCCUPIED  # the floor of the room below
    kinds = kinds[::-1].copy() if upside_down else kinds
    here_m = HERE_M * (1.0, 1.0, -1.0) + (0.0, 0.0, SIDE * VOXEL_M) if upside_down else HERE_M
    z = decided(kinds, here_m).goal_m[2]
    z = SIDE * VOXEL_M - z if upside_down else z
    assert z == pytest.approx(0.6 + 1.5 * VOXEL_M)


def test_no_shaft_is_entered_without_range_finders_or_through_a_floor():
    assert decided(drawn(), HERE_M, is_steep=False).column_m is None
    assert decided(drawn(hole=OCCUPIED), HERE_M).goal_m is None


def test_a_pit_that_level_beams_would_show_is_not_entered_first():
    # Given a pit as wide as half the room: from its other side the lidar looks down far enough
    kinds = drawn()
    kinds[2:FLOOR, 1:-1, 15:-1] = UNKNOWN
    assert decided(kinds, HERE_M).column_m is None


def test_a_shaft_into_which_nothing_comes_of_looks_is_given_up():
    kinds = drawn()
    explorer = Explorer(ASKED, True)
    space = planner_of(kinds).space(0.0, HERE_M)
    looks = 0
    while (decision := explorer.decide(space, HERE_M)).column_m is not None and looks < 50:
        explorer.give_up_goal()
        looks += 1
    assert 0 < looks <= 3 * 4  # three around each corner of the 1.2 m in which its middle fits
    assert decision.column_m is None
