"""Paths in drawn rooms: lengths and sentences worked out by hand."""

import dataclasses
import math

import numpy as np
import pytest
from drawn_voxels import SIDE, block, kinds_of, planner_on, tiles_of, voxels_on

from exploration.planning import KeepOutBox, Limits, PathPlanner, PlannerParameters
from flight_basics.errors import MapError, NoPathError, PoseError

SLIM = PlannerParameters(radius=1.4, margin=0.0, comfort=0.0, preference=0.0)
"""Keeps 2 squared voxels of 1 m: no voxel beside a wall's face."""


def in_shell(kinds):
    """Kinds within a shell of unknown voxels, so that the first of them has the index 1."""
    return np.pad(kinds, 1)


def walled(width, doors):
    """A room of 9 x 13 x width m with a wall in the middle that is open at the doors (z, y slices)."""
    kinds = block(9, 13, width)
    kinds[:, :, width // 2] = 2
    for z, y in doors:
        kinds[z, y, width // 2] = 1
    return kinds


def test_in_the_open_the_path_is_the_straight_line():
    planner = planner_on(block(12, 12, 12), SLIM)
    start, goal = np.array((2.2, 3.3, 2.4)), np.array((9.1, 7.9, 8.6))
    plan = planner.plan(start, goal)
    assert plan.points_m == pytest.approx(np.array((start, goal)))
    assert plan.length_m == pytest.approx(math.dist(start, goal))
    assert plan.length_m <= plan.searched_m


def test_it_goes_through_the_door():
    planner = planner_on(walled(17, [(slice(2, 7), slice(8, 12))]), SLIM)
    plan = planner.plan((3.5, 3.5, 4.5), (13.5, 3.5, 4.5))
    crossed = voxels_on(plan.points_m)
    in_wall = crossed[crossed[:, 2] == 8]
    assert set(in_wall[:, 1]) <= {9, 10}  # a voxel beside the door's frame is too near
    assert len(in_wall)
    # The cheapest legs bend at the corners (9.5 m to the side) of the wall and its two neighbours
    corner = 2.0 * math.hypot(4.5, 6.0) + 1.0
    assert corner - 0.5 < plan.length_m < corner + 1.5


def test_in_three_dimensions_it_goes_over_the_wall():
    kinds = block(12, 9, 17)
    kinds[:6, :, 8] = 2
    plan = planner_on(kinds, SLIM).plan((3.5, 4.5, 2.5), (13.5, 4.5, 2.5))
    assert plan.points_m[:, 2].max() == pytest.approx(7.5)  # 6.5 is beside the wall's upper face


def test_a_leg_that_sinks_behind_a_wall_is_not_clear_for_a_uav_that_sinks_before_it():
    kinds = block(12, 9, 17)
    kinds[:6, :, 8] = 2
    low, high = np.array((3.5, 4.5, 5.5)), np.array((13.5, 4.5, 10.5))
    space = planner_on(kinds, SLIM).space(0.0, low)
    assert space.is_clear(low, high)
    assert space.cost_whatever_climb_m(low, high) == space.cost_m(low, high) < math.inf  # above first
    before, behind = np.array((3.5, 4.5, 10.5)), np.array((13.5, 4.5, 5.5))
    assert space.is_clear(before, behind)
    assert space.cost_whatever_climb_m(before, behind) == math.inf
    beyond = np.array((99.0, 4.5, 5.5))
    assert not space.is_clear(low, beyond)  # beyond the map
    # And many legs at once cost as each alone
    begins, ends = np.array([[low, before], [low, low]]), np.array([[high, behind], [beyond, low]])
    costs = [[space.cost_whatever_climb_m(*leg) for leg in zip(*row)] for row in zip(begins, ends)]
    np.testing.assert_array_equal(space.cost_whatever_climb_m(begins, ends), costs)


def test_comfort_keeps_away_from_a_wall():
    kinds = block(11, 11, 30)
    straight = planner_on(kinds, SLIM).plan((2.5, 2.5, 5.5), (27.5, 2.5, 5.5))
    comfortable = dataclasses.replace(SLIM, comfort=3.0, preference=3.0)
    plan = planner_on(kinds, comfortable).plan((2.5, 2.5, 5.5), (27.5, 2.5, 5.5))
    assert straight.points_m[:, 1].max() == 2.5
    assert plan.points_m[:, 1].max() > 4.0


@pytest.mark.table(
    ("start", "goal", "sentence"),
    [
        ((40.0, 5.0, 5.0), (3.5, 5.5, 4.5), "start .* is in unknown space"),
        ((8.5, 5.5, 4.5), (3.5, 5.5, 4.5), "start .* is in an obstacle"),
        ((3.5, 5.5, 4.5), (8.5, 5.5, 4.5), "goal .* is in an obstacle"),
        ((3.5, 5.5, 4.5), (3.5, 5.5, 40.0), "goal .* is in unknown space"),
        ((3.5, 5.5, 4.5), (7.5, 5.5, 4.5), "goal .* is 1.00 m from an obstacle, but the UAV needs 1.41 m"),
        ((3.5, 5.5, 4.5), (3.5, 5.5, 0.5), "goal .* is 1.00 m from unknown space"),
    ],
)
def test_an_end_where_the_uav_cannot_be_is_named(start, goal, sentence):
    planner = planner_on(in_shell(walled(17, [])), SLIM)
    shift = 1.0
    with pytest.raises(NoPathError, match=sentence):
        planner.plan(np.add(start, shift), np.add(goal, shift))


def test_without_a_way_it_names_the_closest_place():
    planner = planner_on(walled(17, []), SLIM)
    with pytest.raises(NoPathError) as told:
        planner.plan((3.5, 6.5, 4.5), (13.5, 6.5, 4.5))
    assert "comes closest at (6.5, 6.5, 4.5), 7.0 m before it, and then meets an obstacle" in str(told.value)


def test_a_narrow_way_is_named_with_its_width():
    narrow = walled(17, [(slice(4, 5), slice(0, 13))])  # a slot, one voxel high
    with pytest.raises(NoPathError) as told:
        planner_on(narrow, SLIM).plan((3.5, 6.5, 4.5), (13.5, 6.5, 4.5))
    assert "too narrow at (8.5," in str(told.value)
    assert "1.00 m to each side there, but this one needs 1.41 m" in str(told.value)


def test_of_two_narrow_slots_the_first_is_named_and_unknown_space_beside_a_way_is_told():
    kinds = walled(17, [(slice(4, 5), slice(0, 13))])
    kinds[:, :, 12] = 2
    kinds[4, :, 12] = 1  # a second slot, as narrow
    with pytest.raises(NoPathError, match=r"too narrow at \(8\.5,"):
        planner_on(kinds, SLIM).plan((3.5, 6.5, 4.5), (15.5, 6.5, 4.5))
    kinds = block(9, 13, 17)
    kinds[:, :, 8] = 0
    kinds[4, :, 8] = 1  # the same, but what is beside it was never seen
    with pytest.raises(NoPathError, match=r"too narrow at \(8\.5, .* 1\.00 m .* beside what is unknown, but"):
        planner_on(kinds, SLIM).plan((3.5, 6.5, 4.5), (13.5, 6.5, 4.5))


def test_a_uav_beside_a_wall_leaves_it_and_comes_no_nearer():
    planner = planner_on(block(12, 12, 12), SLIM)
    plan = planner.plan((0.5, 6.5, 6.5), (8.5, 6.5, 6.5))
    assert plan.length_m == pytest.approx(8.0)
    with pytest.raises(NoPathError, match="goal"):  # the rule is for the start alone
        planner.plan((8.5, 6.5, 6.5), (0.5, 6.5, 6.5))


def test_a_keep_out_box_is_flown_around_with_clearance():
    box = KeepOutBox((5.0, 0.0, 0.0), (7.0, 8.0, 12.0), "tank")
    planner = planner_on(block(12, 12, 12), SLIM, limits=Limits((box,)))
    plan = planner.plan((2.5, 3.5, 6.5), (9.5, 3.5, 6.5))
    crossed = voxels_on(plan.points_m)
    beside = crossed[(crossed[:, 2] >= 4) & (crossed[:, 2] <= 7)]
    assert beside[:, 1].min() >= 8
    assert not ((crossed[:, 2] >= 5) & (crossed[:, 2] < 7) & (crossed[:, 1] < 9)).any()
    with pytest.raises(NoPathError, match=r"start .* is in the keep-out box tank"):
        planner.plan((6.0, 3.5, 6.5), (9.5, 3.5, 6.5))
    with pytest.raises(NoPathError, match=r"goal .* is in the keep-out box tank"):
        planner.plan((2.5, 3.5, 6.5), (6.0, 3.5, 6.5))


def test_the_ceiling_bounds_the_height_but_lets_a_uav_above_it_come_down():
    kinds = block(12, 9, 17)
    kinds[:6, :, 8] = 2  # the way over it is at 7.5 m
    low, high = (3.5, 4.5, 2.5), (13.5, 4.5, 2.5)
    assert planner_on(kinds, SLIM, limits=Limits(ceiling_m=7.5)).plan(low, high).length_m > 10.0
    lower = planner_on(kinds, SLIM, limits=Limits(ceiling_m=7.4))
    with pytest.raises(NoPathError, match=r"No known free way|too narrow"):
        lower.plan(low, high)
    with pytest.raises(NoPathError, match=r"goal .* is above the ceiling of 7\.4 m"):
        lower.plan(low, (3.5, 4.5, 8.5))
    with pytest.raises(NoPathError, match=r"goal .* is in a voxel that reaches above the ceiling"):
        lower.plan(low, (3.5, 4.5, 7.3))
    assert lower.plan((3.5, 4.5, 9.5), high).points_m[:, 2].max() <= 9.5


def test_a_closed_way_is_avoided_for_its_time():
    doors = [(slice(2, 7), slice(1, 5)), (slice(2, 7), slice(8, 12))]
    parameters = dataclasses.replace(SLIM, closed_radius=2.0, closed_time=10.0)
    planner = planner_on(walled(17, doors), parameters)
    ends = (3.5, 3.5, 4.5), (13.5, 3.5, 4.5)
    near = planner.plan(*ends, stamp_s=100.0)
    planner.close((8.5, 3.0, 4.5), stamp_s=100.0)
    assert not planner.is_clear(near.points_m, stamp_s=101.0)
    far = planner.plan(*ends, stamp_s=101.0)
    assert far.length_m > near.length_m + 3.0
    planner.close((8.5, 10.0, 4.5), stamp_s=101.0)
    with pytest.raises(NoPathError, match="Every way is closed, because CEPA did not fly it"):
        planner.plan(*ends, stamp_s=102.0)
    assert planner.plan(*ends, stamp_s=110.5).length_m == pytest.approx(near.length_m)
    assert planner.plan(*ends, stamp_s=50.0).length_m == pytest.approx(
        near.length_m
    )  # a clock that jumps back


def test_a_place_that_is_refused_again_stays_closed_for_longer_and_opens_at_last_when_asked():
    planner = planner_on(block(12, 12, 30), dataclasses.replace(SLIM, closed_radius=1.0, closed_time=10.0))
    here_m, refused_m, other_m = np.array(((3.0, 5.5, 5.5), (8.5, 5.5, 5.5), (8.5, 8.5, 5.5)))

    def closed_at(stamp_s):
        return len(planner.space(stamp_s, here_m).closed)

    # When CEPA refuses it once, then it is closed for its time; the second time for twice as long
    planner.close(refused_m, stamp_s=100.0)
    assert (closed_at(109.9), closed_at(110.1)) == (1, 0)
    planner.close(refused_m + 0.5, stamp_s=120.0)
    assert (closed_at(139.9), closed_at(140.1)) == (1, 0)
    # And another place is closed for its own time
    planner.close(other_m, stamp_s=150.0)
    assert (closed_at(159.9), closed_at(160.1)) == (1, 0)
    # When all is to be tried again, then only what was refused too often stays closed
    planner.close(refused_m, stamp_s=200.0)
    planner.close(other_m, stamp_s=200.0)
    assert planner.reopen(201.0, times_max=2)
    assert closed_at(201.0) == 1
    assert not planner.reopen(201.0, times_max=2)


def test_a_closed_place_around_the_uav_does_not_hold_it():
    planner = planner_on(block(12, 12, 30), dataclasses.replace(SLIM, closed_radius=3.0))
    planner.close((8.5, 5.5, 5.5), stamp_s=0.0)
    plan = planner.plan((6.5, 5.5, 5.5), (2.5, 5.5, 5.5), stamp_s=1.0)
    assert plan.length_m == pytest.approx(4.0)


def test_a_path_is_judged_again_when_the_map_changes():
    kinds = block(12, 12, 20)
    planner = planner_on(kinds, SLIM)
    points_m = planner.plan((2.5, 5.5, 5.5), (17.5, 5.5, 5.5)).points_m
    assert planner.is_clear(points_m)
    kinds[5, 7, 10] = 2  # two voxels to the side: 4 squared voxels away
    planner.update_map(1.0, SIDE, *tiles_of(kinds))
    assert planner.is_clear(points_m)
    kinds[5, 6, 10] = 2
    planner.update_map(1.0, SIDE, *tiles_of(kinds))
    assert not planner.is_clear(points_m)
    assert planner.is_clear(planner.plan(points_m[0], points_m[-1]).points_m)


def test_new_parameters_count_at_once():
    planner = planner_on(walled(17, [(slice(2, 7), slice(8, 12))]), SLIM)
    ends = (3.5, 3.5, 4.5), (13.5, 3.5, 4.5)
    assert planner.plan(*ends)
    planner.parameters = dataclasses.replace(SLIM, radius=3.0)
    with pytest.raises(NoPathError, match="too narrow"):
        planner.plan(*ends)


def test_without_a_map_or_with_bad_numbers_it_says_so():
    planner = PathPlanner(SLIM)
    with pytest.raises(NoPathError, match="There is no map yet"):
        planner.plan((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    planner.update_map(1.0, SIDE, *tiles_of(block(8, 8, 8)))
    with pytest.raises(PoseError, match="goal"):
        planner.plan((0.0, 0.0, 0.0), (math.nan, 0.0, 0.0))
    with pytest.raises(PoseError):
        planner.close((math.inf, 0.0, 0.0), 0.0)
    planner.clear_map()
    with pytest.raises(NoPathError, match="There is no map yet"):
        planner.plan((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def test_bad_tiles_leave_the_map_as_it_was():
    planner = planner_on(block(8, 8, 8), SLIM)
    tiles, voxels = tiles_of(block(8, 8, 8))
    for wrong in (
        (tiles, voxels[:, :-1]),
        (tiles, voxels + 2),
        (tiles[:-1], voxels),
        (tiles + 10**7, voxels),
        (tiles * 50_000, voxels),
    ):
        with pytest.raises(MapError):
            planner.update_map(1.0, SIDE, *wrong)
    with pytest.raises(MapError):
        planner.update_map(math.nan, SIDE, tiles, voxels)
    assert planner.plan((2.5, 2.5, 2.5), (5.5, 5.5, 5.5)).length_m == pytest.approx(math.sqrt(27.0))


def test_the_map_grows_to_all_sides_and_another_resolution_begins_anew():
    planner = PathPlanner(SLIM)
    for at in ((0, 0, 0), (-2, 0, 0), (2, 0, 0)):
        planner.update_map(1.0, SIDE, *tiles_of(block(8, 8, 8), at=at))
    assert planner.plan((-5.5, 3.5, 3.5), (13.5, 3.5, 3.5)).length_m == pytest.approx(19.0)
    planner.update_map(0.5, SIDE, *tiles_of(block(8, 8, 8)))
    with pytest.raises(NoPathError, match=r"start .* unknown"):
        planner.plan((-5.5, 3.5, 3.5), (13.5, 3.5, 3.5))


def test_letters_draw_what_they_say():
    assert kinds_of("?.# ...").tolist() == [[[0, 1, 2], [1, 1, 1]]]


def test_what_is_assumed_free_opens_the_unknown_but_no_obstacle():
    kinds = block(12, 12, 24)
    kinds[:, :, :8] = 0
    kinds[6, 6, 5] = 2
    planner = planner_on(kinds, SLIM)
    ends = (3.5, 3.5, 6.5), (15.5, 3.5, 6.5)
    with pytest.raises(NoPathError, match=r"start .* is in unknown space"):
        planner.plan(*ends)
    planner.assume_free((3.5, 3.5, 6.5), 3.4)
    planner.assume_free((6.5, 3.5, 6.5), 3.4)
    assert planner.plan(*ends).length_m == pytest.approx(12.0)
    with pytest.raises(NoPathError, match=r"goal .* is in an obstacle"):
        planner.plan(ends[0], (5.5, 6.5, 6.5))
    planner.update_map(1.0, SIDE, *tiles_of(np.where(kinds == 0, 2, kinds)))  # then the map knows better
    with pytest.raises(NoPathError, match=r"start .* is in an obstacle"):
        planner.plan(*ends)


def test_a_venture_is_free_only_where_the_uav_has_been():
    planner = planner_on(np.pad(block(8, 8, 8), ((0, 8), (0, 8), (0, 8))), SLIM)
    start, above, beside = (3.5, 3.5, 3.5), np.array((3.5, 3.5, 10.5)), np.array((10.5, 3.5, 3.5))
    # Given two ways into what is unknown, of which the first was flown
    planner.venture(np.array([(3.5, 3.5, 8.5), above, (8.5, 3.5, 3.5), beside]), 3.0)
    assert planner.plan(start, above).length_m == pytest.approx(7.0)
    assert planner.plan(start, beside).length_m == pytest.approx(7.0)
    planner.settle([True, True, False, False])
    assert planner.plan(start, above).length_m == pytest.approx(7.0)
    with pytest.raises(NoPathError):
        planner.plan(start, beside)
    # And what is settled stays so
    planner.settle([])
    assert planner.plan(start, above).length_m == pytest.approx(7.0)


def test_a_ball_that_is_assumed_free_may_lie_beyond_the_map():
    planner = planner_on(block(8, 8, 8), SLIM)
    planner.assume_free((-6.0, 4.0, 4.0), 4.0)
    planner.assume_free((-2.0, 4.0, 4.0), 4.0)
    assert planner.plan((-6.5, 3.5, 3.5), (5.5, 3.5, 3.5)).length_m == pytest.approx(12.0)


def test_towards_a_goal_that_is_not_known_it_flies_as_far_as_the_door_that_the_map_shows():
    """The room behind the wall is unknown, but for some voxels behind its door, which is aside of the way."""
    kinds = walled(17, [(slice(2, 7), slice(8, 12))])
    kinds[:, :, 9:] = 0
    kinds[2:7, 8:12, 9:12] = 1
    start, goal = np.array((3.5, 3.5, 4.5)), np.array((13.5, 3.5, 4.5))
    planner = planner_on(kinds, SLIM)
    with pytest.raises(NoPathError):
        planner.plan(start, goal)
    plan = planner.onward(start, goal)
    assert planner.is_clear(plan.points_m)
    end = plan.points_m[-1]
    assert 8.0 < end[0] < 12.0  # through the door, no farther than what is seen behind it
    assert 8.0 < end[1] < 12.0
    assert plan.beyond_m[-1] == pytest.approx(goal)


def test_over_a_wall_of_unknown_height_it_does_not_look_for_a_way_first():
    kinds = walled(17, [(slice(2, 7), slice(8, 12))])
    kinds[:, :, 9:] = 0
    kinds[2:7, 8:12, 9:12] = 1
    kinds[7:, :, :] = 0  # all above is unknown
    kinds[7:, :, 8] = 0
    end = planner_on(kinds, SLIM).onward((3.5, 3.5, 4.5), (13.5, 3.5, 4.5)).points_m[-1]
    assert end[0] > 8.0


def test_without_a_door_even_the_unknown_has_no_way():
    kinds = block(12, 16, 16)  # whole tiles: nothing unknown is beside the wall
    kinds[:, :, 8] = 2
    kinds[:, :, 9:] = 0
    with pytest.raises(NoPathError, match="No known free way"):
        planner_on(kinds, SLIM).onward((3.5, 3.5, 4.5), (13.5, 3.5, 4.5))
