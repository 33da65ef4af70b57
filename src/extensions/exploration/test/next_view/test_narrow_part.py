"""Narrow parts of a way: where their middle is, and how a UAV keeps to it."""

import math

import numpy as np
import pytest
from drawn_legs import of_legs
from drawn_voxels import tiles_of
from hypothesis import given
from hypothesis import strategies as st

from exploration.next_view import ExplorationParameters
from exploration.next_view.guide import Guide
from exploration.next_view.narrow_part import ASIDE_M, LEAD_M, NarrowPart, middle_of
from exploration.planning import FREE, OCCUPIED, PathPlanner, PlannerParameters

SIDE_M = 0.1


@of_legs
def through_a_hole(a_m, b_m):
    """A map of voxels with a hole from y = 0.4 to 1.0 and z = 1.0 to 1.6: nearer to its rim is dearer."""
    shares = np.linspace(0.0, 1.0, 10)[:, None]
    _, y, z = np.floor((a_m + shares * (b_m - a_m)) / SIDE_M + 1e-9).T
    wide = np.minimum(np.minimum(y - 3, 10 - y), np.minimum(z - 9, 16 - z))
    return math.inf if (wide < 1).any() else math.dist(a_m, b_m) * float(5.0 - wide.min())


@pytest.mark.table("y_m", [0.55, 0.61, 0.7, 0.79, 0.83])
@pytest.mark.table("z_m", [1.21, 1.3, 1.38])
def test_the_middle_of_a_hole_is_amid_its_rim_and_not_the_middle_of_a_voxel(y_m, z_m):
    places_m = [np.array((x, y_m, z_m)) for x in (-0.25, 0.0, 0.25)]
    shifted_m = places_m[0] + middle_of(places_m, through_a_hole)
    np.testing.assert_allclose(shifted_m, (-0.25, 0.7, 1.3), atol=0.011)


@pytest.mark.table("z_m", [0.97, 1.05, 1.19, 1.35, 1.43])
def test_a_way_at_the_rim_of_a_high_manhole_is_shifted_to_its_middle(z_m):
    @of_legs
    def through_a_manhole(a_m, b_m):
        """A manhole of 0.6 x 0.8 m, from z = 0.8 on: from 1.0 to 1.4 m its sides are nearer than its ends."""
        shares = np.linspace(0.0, 1.0, 10)[:, None]
        _, y, z = np.floor((a_m + shares * (b_m - a_m)) / SIDE_M + 1e-9).T
        wide = np.minimum(np.minimum(y - 3, 10 - y), np.minimum(z - 7, 16 - z))
        return math.inf if (wide < 1).any() else math.dist(a_m, b_m) * float(5.0 - wide.min())

    places_m = [np.array((x, 0.65, z_m)) for x in (-0.25, 0.0, 0.25)]
    shifted_m = places_m[0] + middle_of(places_m, through_a_manhole)
    np.testing.assert_allclose(shifted_m, (-0.25, 0.7, 1.2), atol=0.011)


def test_a_way_along_a_wall_is_no_passage_nor_is_one_that_nobody_can_fly():
    @of_legs
    def beside_a_wall(a_m, b_m):
        return math.dist(a_m, b_m) * (1.0 + 1.0 / max(math.floor(min(a_m[1], b_m[1]) / SIDE_M), 0.1))

    for y_m, cost_m in ((0.35, beside_a_wall), (5.0, through_a_hole)):
        assert middle_of([np.array((x, y_m, 1.3)) for x in (-0.25, 0.0, 0.25)], cost_m) is None


def test_a_hole_in_a_deck_is_flown_through_amid_its_rim_too():
    @of_legs
    def upwards(a_m, b_m):
        return through_a_hole(a_m[[2, 1, 0]] + (0.0, 0.0, 1.0), b_m[[2, 1, 0]] + (0.0, 0.0, 1.0))

    places_m = [np.array((0.22, 0.62, z)) for z in (2.0, 2.25, 2.5)]
    np.testing.assert_allclose(places_m[0] + middle_of(places_m, upwards), (0.3, 0.7, 2.0), atol=0.011)


PLACE = st.tuples(*[st.floats(-3.0, 3.0)] * 3).map(np.array)
CORNERS_M = [np.array(place) for place in ((0.0, 0.0, 1.0), (0.5, 0.0, 1.0), (1.0, 0.3, 1.2))]


@given(PLACE, PLACE)
def test_its_aim_lies_on_the_way_and_is_never_far_ahead(here_m, velocity_m_s):
    part = NarrowPart(0, 2, CORNERS_M)
    aim_m = part.aim_m(here_m, velocity_m_s)
    track_m = np.concatenate([np.linspace(a, b, 400) for a, b in zip(CORNERS_M, CORNERS_M[1:])])
    assert np.linalg.norm(track_m - aim_m, axis=1).min() < 2e-3
    least_m = np.linalg.norm(track_m - here_m, axis=1).min()
    assert math.dist(aim_m, here_m) <= least_m + LEAD_M + 0.02
    if least_m > ASIDE_M + 0.01 and 0.0 < here_m[0] < 1.0:
        assert math.dist(aim_m, here_m) <= least_m + 0.15  # abeam; near the corner the two legs differ


@pytest.mark.table(("aim", "holds"), [(-1, False), (0, False), (1, True), (2, True), (3, False)])
def test_it_begins_behind_its_entry_and_ends_with_its_exit(aim, holds):
    assert NarrowPart(0, 2, CORNERS_M).holds(aim) == holds


BELOW, ABOVE = (1.46, 1.88, 1.35), (1.74, 2.38, 1.95)


@pytest.mark.table("lag_s", [0.25, 0.5])
@pytest.mark.table(
    ("start_m", "goal_m"),
    [
        (BELOW, (2.97, 1.75, 2.78)),
        (ABOVE, (2.25, 2.71, 0.83)),
        ((1.74, 2.7, 1.08), (3.3, 0.84, 2.86)),
        ((2.04, 0.57, 0.56), (3.15, 2.87, 2.65)),
        ((2.3, 2.3, 2.0), (0.7, 3.2, 0.6)),
    ],
)
def test_through_a_manhole_of_a_deck_the_uav_is_in_the_middle_while_its_body_is_in_the_rim(
    start_m, goal_m, lag_s
):
    """A deck from z = 1.6 to 1.7 m; its manhole is 0.6 x 0.8 m about (1.9, 2.0). The UAV has 0.2 m."""
    kinds = np.full((36, 40, 40), FREE, np.uint8)
    kinds[16] = OCCUPIED
    kinds[16, 16:24, 16:22] = FREE
    sizes = {"radius": 0.2, "margin": 0.0, "comfort": 0.2, "preference": 3.0}
    planner = PathPlanner(PlannerParameters(**sizes))
    planner.update_map(0.1, 4, *tiles_of(kinds))
    guide = Guide(planner, ExplorationParameters(arrived=0.15, steep=True), (-0.8, 1.2))
    here_m, velocity, spare_m = np.array(start_m), np.zeros(3), []
    assert guide.plan(here_m, np.array(goal_m), 0.0)
    for stamp_s in np.arange(0.0, 30.0, 0.05):
        guide.follow(float(stamp_s), here_m)
        if not guide.way.is_left:
            break
        wanted = 1.2 * (guide.way.setpoint_m - here_m)
        wanted *= min(1.0, 0.8 / max(float(np.linalg.norm(wanted)), 1e-9))
        velocity = velocity + (wanted - velocity) * 0.05 / lag_s
        here_m = here_m + 0.05 * velocity
        if 1.6 - 0.05 < here_m[2] < 1.7 + 0.17:  # so far the body reaches above and below its middle
            spare_m.append(min(0.3 - abs(here_m[0] - 1.9), 0.4 - abs(here_m[1] - 2.0)) - 0.2)
    assert not guide.way.is_left
    assert min(spare_m) > 0.01
