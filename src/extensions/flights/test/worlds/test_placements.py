"""Obstacles of Experiment 2: where they are, against plain geometry; what their SDF says; how they vary."""

import numpy as np
import pytest

from flights.errors import ScenarioError
from flights.worlds.floor_plan import outlines
from flights.worlds.placements import R_LB_M, SCENARIOS, VARIATION_M, freeze_frame, placement, varied
from simulation_tools.geometry import Pose
from simulation_tools.sdf.elements import DEFAULT_INERTIAL, Collision, Link, Model, Polyline, World

SEEN_RAD = np.radians(135.0)  # UST-10LX: 270 degrees about straight ahead
FITS_M = 2 * 0.35  # the body radius that CEPA's sanity check uses


def surface(obstacle, points=20_000):
    """Points (n, 2) along the outline of an obstacle, densely, from its SDF."""
    (outline,) = outlines(World("w", models=(obstacle.model(),)))
    corners = np.vstack((outline.outline_xy, outline.outline_xy[:1]))
    share = np.linspace(0.0, len(corners) - 1.0, points)
    return np.column_stack([np.interp(share, np.arange(len(corners)), corners[:, k]) for k in (0, 1)])


def distance(obstacle):
    return np.linalg.norm(surface(obstacle), axis=1).min()


def by_name(scenario):
    return {obstacle.name: obstacle for obstacle in placement(scenario)}


@pytest.mark.table("scenario", SCENARIOS)
def test_what_is_within_r_lb_is_where_the_lidar_sees_it(scenario):
    near = [obstacle for obstacle in placement(scenario) if distance(obstacle) < R_LB_M]
    assert len(near) == {"columns": 4, "wall_one_column": 2, "wall_three_columns": 2}[scenario]
    for obstacle in near:
        points = surface(obstacle)
        nearest = points[np.linalg.norm(points, axis=1).argmin()]
        assert abs(np.arctan2(nearest[1], nearest[0])) < SEEN_RAD
        assert np.linalg.norm(nearest) > 0.39  # the tips of the rotors are 0.384 m from the middle


def test_the_columns_behind_are_nearer_and_there_is_room_ahead():
    columns = by_name("columns")
    assert distance(columns["column_front_left"]) == pytest.approx(0.65, abs=1e-3)
    assert distance(columns["column_rear_right"]) == pytest.approx(0.52, abs=1e-3)
    # 0.75 sin 52 = 0.591 m to the side, less the radius, on both sides
    ahead = 2 * (columns["column_front_left"].y_m - 0.1)
    assert ahead == pytest.approx(0.982, abs=1e-3)
    assert ahead > FITS_M


def test_there_is_room_beside_the_wall_but_not_between_the_columns():
    placed = by_name("wall_three_columns")
    wall, columns = placed.pop("wall"), list(placed.values())
    assert distance(wall) == pytest.approx(0.5, abs=1e-3)
    assert len(columns) == 3
    assert all(0.5 - (c.y_m + 0.1) > FITS_M + 2 * VARIATION_M for c in columns)
    places = sorted(column.x_m for column in columns)
    assert max(np.diff(places)) - 0.2 + 2 * VARIATION_M < FITS_M


@pytest.mark.table("scenario", SCENARIOS)
def test_the_obstacles_stand_on_the_floor_and_reach_beyond_the_hover(scenario):
    for obstacle in placement(scenario):
        (outline,) = outlines(World("w", models=(obstacle.model(),)))
        assert outline.bottom_m == pytest.approx(0.0, abs=1e-9)
        assert outline.blocks(2.0)
        assert obstacle.model().static


def test_a_variation_is_small_repeatable_and_leaves_shapes_alone():
    nominal = placement("columns")
    one, again, other = (varied(nominal, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert one == again
    assert one != other
    shifts = np.array([(v.x_m - n.x_m, v.y_m - n.y_m) for v, n in zip(one + other, nominal * 2)])
    assert 0.5 * VARIATION_M < np.abs(shifts).max() <= VARIATION_M
    assert [v.shape for v in one] == [n.shape for n in nominal]


def test_obstacles_turn_with_the_uav_that_leans():
    uav = Pose.from_xyz_rpy(3.0, -1.0, 2.0, roll=0.1, pitch=-0.05, yaw=np.pi / 2)
    wall = by_name("wall_one_column")["wall"]  # 0.6 m to the left: at yaw 90 degrees that is -x
    pose = wall.pose(freeze_frame(uav))
    assert pose.position_m == pytest.approx((3.0 - 0.6, -1.0, 0.0), abs=1e-9)
    roll, pitch, yaw = pose.rpy_rad
    assert (roll, pitch) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert yaw == pytest.approx(np.pi / 2)


def test_an_unknown_scenario_is_refused_with_the_choices():
    with pytest.raises(ScenarioError, match=r"scenario:=columns\|wall_one_column\|wall_three_columns"):
        placement("maze")


def test_an_extruded_polyline_is_outlined_in_convex_pieces_and_its_hole_stays_open():
    square, hole = ((0, 0), (4, 0), (4, 4), (0, 4)), ((1, 1), (3, 1), (3, 3), (1, 3))
    collision = Collision("c", Pose(), Polyline((square, hole), 2.0))
    model = Model("m", Pose((0.0, 0.0, 1.0)), True, (Link("l", Pose(), DEFAULT_INERTIAL, (collision,)),))
    found = outlines(World("w", models=(model,)))
    sides = [np.ptp(each.outline_xy, axis=0) for each in found]
    assert sum(x * y for x, y in sides) == pytest.approx(12.0)
    assert {(each.bottom_m, each.top_m) for each in found} == {(1.0, 3.0)}
