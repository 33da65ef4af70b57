"""Places drawn at random: the same for the same seed, clear at start and goal, and with a way through."""

from __future__ import annotations

from xml.etree import ElementTree as ET

import numpy as np
import pytest

from cepa import KeepOut, KeepOutBox
from flights.campaign.places import place_of
from flights.campaign.reading import campaign_of
from flights.campaign.trial import ExactMap, entered
from flights.worlds.drawn.barriers import WIRES_M
from flights.worlds.drawn.dead_ends import DEPTHS_M, dead_ends_sdf
from flights.worlds.drawn.forests import (
    MIXED_SPACINGS_M,
    SPACING_M,
    THICK_DENSITY_PER_M2,
    THICK_HALF_WIDTH_M,
    plant,
    plant_thick,
)
from flights.worlds.drawn.free_way import distance_m, way_exists
from flights.worlds.drawn.hallway import hallway_sdf
from flights.worlds.drawn.materials import CLEAR_M
from flights.worlds.drawn.office import DOOR_M, office_sdf
from flights.worlds.drawn.overhead import OBSTACLES
from flights.worlds.drawn.traps import GAPS_M, TRAPS
from flights.worlds.floor_plan import Outline, outlines_of_file
from flights.worlds.scenario import FLIGHT_HEIGHT_M
from simulation_tools.geometry import Pose, quaternion_from_rpy, rotation_matrix
from simulation_tools.sdf.parser import load_world

FLAT = (FLIGHT_HEIGHT_M,)
HEIGHTS = np.arange(0.6, 3.5, 0.1)
"""At which a UAV may fly over and under things; FLIGHT_HEIGHT_M is the middle."""
MEET = ("abreast", "sinking", "small_uav", "keep_out")
"""What is drawn with its speed, and boxes."""
HALF_WIDTHS_M = {
    "spaced_forest": 10.0,
    "thick_forest": THICK_HALF_WIDTH_M,
    "dead_ends": 8.0,
    "office": 7.5,
    "deep_dead_end": 8.0,
    "fence": 10.0,
    "glass": 10.0,
    **dict.fromkeys(OBSTACLES, 4.0),
}
"""How far to the side the UAV stays between its way and the world's end."""


def settings_of(world):
    return campaign_of({"trials": {"world": world}}, "x").combinations[0]


def shapes_in(place, folder):
    return outlines_of_file(place.world_file(folder))


# -- each kind of place -------------------------------------------------------------------------------------


@pytest.mark.table(
    "world",
    [
        "random_forest",
        "mixed_forest",
        "random_hallway",
        "crossing",
        "head_on",
        "doors",
        "bug_trap",
        *MEET,
        *HALF_WIDTHS_M,
    ],
)
def test_the_same_seed_gives_the_same_place(world):
    settings = settings_of(world)
    assert place_of(settings, 7) == place_of(settings, 7) != place_of(settings, 8)


@pytest.mark.table("seed", [1, 2])
@pytest.mark.table("world", HALF_WIDTHS_M)
def test_a_place_is_clear_at_start_and_goal_and_has_a_way(world, seed, tmp_path):
    place = place_of(settings_of(world), seed)
    shapes = shapes_in(place, tmp_path)
    ends = np.array([(0.0, 0.0), (place.distance_m, 0.0)])
    clear_m = 1.5 if world in ("office", "deep_dead_end") else 2.0
    assert min(distance_m(ends, shape.outline_xy).min() for shape in shapes) >= clear_m
    heights = HEIGHTS if world in OBSTACLES else FLAT
    beyond_m = 2.5 if world == "office" else 0.0
    assert way_exists(shapes, place.distance_m, HALF_WIDTHS_M[world], heights, beyond_m=beyond_m)


@pytest.mark.table("world", ["beams", "overhangs", "low_walls", "cables"])
def test_the_way_past_an_obstacle_from_wall_to_wall_leads_over_or_under_it(world, tmp_path):
    place = place_of(settings_of(world), 3)
    shapes = shapes_in(place, tmp_path)
    assert sum("obstacle" in shape.name for shape in shapes) >= 3
    assert not way_exists(shapes, place.distance_m, 4.0, FLAT)


@pytest.mark.table("seed", range(4))
def test_dead_ends_lie_on_the_straight_way_and_are_as_deep_as_they_say(seed, tmp_path):
    path = tmp_path / "dead_ends.world"
    path.write_text(dead_ends_sdf(np.random.default_rng(seed), 34.0))
    shapes = outlines_of_file(path)
    backs = [shape.outline_xy for shape in shapes if shape.name.endswith("back")]
    sides = [shape.outline_xy for shape in shapes if shape.name.endswith("left")]
    assert 2 <= len(backs) == len(sides)
    for back, side in zip(backs, sides):
        assert back[:, 1].min() < -0.3 < 0.3 < back[:, 1].max()
        longest = np.linalg.norm(side - np.roll(side, 1, axis=0), axis=1).max()
        assert DEPTHS_M[0] <= longest <= DEPTHS_M[1]
        assert side[:, 0].min() < back[:, 0].min()


def test_an_office_has_doors_that_a_uav_passes_and_walls_that_it_does_not(tmp_path):
    path = tmp_path / "office.world"
    path.write_text(office_sdf(np.random.default_rng(2), 26.0))
    shapes = outlines_of_file(path)
    assert way_exists(shapes, 26.0, 7.5, FLAT, DOOR_M / 2 - 0.06, 2.5)
    assert not way_exists(shapes, 26.0, 7.5, FLAT, DOOR_M / 2 + 0.01, 2.5)


@pytest.mark.table("trap", TRAPS)
def test_a_trap_stands_on_the_straight_way_and_can_be_gone_around(trap, tmp_path):
    settings = campaign_of({"trials": {"world": "bug_trap", "trap": trap}}, "x").combinations[0]
    for seed in range(3):
        place = place_of(settings, seed)
        shapes = shapes_in(place, tmp_path)
        corners = np.concatenate([shape.outline_xy for shape in shapes])
        assert CLEAR_M - 1.5 < corners[:, 0].min() < corners[:, 0].max() < place.distance_m - 1.5
        assert corners[:, 1].min() < 0.0 < corners[:, 1].max()
        assert way_exists(shapes, place.distance_m, 20.0, FLAT)


def test_a_gap_is_as_wide_as_it_says():
    for seed in range(20):
        (_, low), (high, _) = TRAPS["gap"](np.random.default_rng(seed))
        assert GAPS_M[0] <= high[1] - low[1] <= GAPS_M[1]


def test_a_deep_dead_end_holds_the_straight_way_and_is_as_deep_as_asked_for(tmp_path):
    settings = campaign_of({"trials": {"world": "deep_dead_end", "depth_m": 20}}, "x").combinations[0]
    for seed in range(4):
        shapes = {s.name.split("::")[-1]: s.outline_xy for s in shapes_in(place_of(settings, seed), tmp_path)}
        for name, outside in (("left", 1.0), ("right", -1.0)):
            longest = np.linalg.norm(shapes[name] - np.roll(shapes[name], 1, axis=0), axis=1).max()
            assert longest == pytest.approx(20.0, abs=0.01)
            assert (outside * shapes[name][:, 1] > 0.0).all()
        assert shapes["back"][:, 1].min() < -0.3 < 0.3 < shapes["back"][:, 1].max()


@pytest.mark.table("door_m", [0.9, 1.0, 1.2])
def test_doors_are_as_wide_as_asked_for_and_the_only_way(door_m, tmp_path):
    settings = campaign_of({"trials": {"world": "doors", "door_m": door_m}}, "x").combinations[0]
    shapes = shapes_in(place_of(settings, 5), tmp_path)
    assert sum("left_of_door" in shape.name for shape in shapes) >= 3
    assert way_exists(shapes, 26.0, 2.94, FLAT, door_m / 2 - 0.06)
    assert not way_exists(shapes, 26.0, 2.94, FLAT, door_m / 2 + 0.01)


@pytest.mark.table("behind", ["nothing", "person", "hose"])
def test_each_manhole_is_near_the_straight_way_and_what_is_behind_one_leaves_it(behind, tmp_path):
    settings = campaign_of({"trials": {"world": "manholes", "behind": behind}}, "x").combinations[0]
    for seed in range(4):
        path = place_of(settings, seed).world_file(tmp_path)
        beside = [s.outline_xy for s in outlines_of_file(path) if "_beside" in s.name or "_end" in s.name]
        assert len(beside) >= 4  # two of each bulkhead
        for x in {round(float(outline[:, 0].min()), 3) for outline in beside}:
            edges = [outline[:, 1] for outline in beside if abs(outline[:, 0].min() - x) < 1e-3]
            low, high = (
                max(e.max() for e in edges if e.max() < 0.0),
                min(e.min() for e in edges if e.min() > 0.0),
            )
            assert 0.6 <= high - low <= 0.66
            assert abs(low + high) / 2 <= 0.05
        walk = ET.parse(path).findall(".//waypoint/pose")
        assert bool(walk) == (behind != "nothing")
        assert not walk or float(walk[-1].text.split()[1]) >= 1.1


def test_no_uav_passes_between_the_wires_of_a_fence(tmp_path):
    shapes = shapes_in(place_of(settings_of("fence"), 5), tmp_path)
    middles = {}
    for shape in shapes:
        middles.setdefault(shape.name.split("::")[0], []).append(shape.outline_xy.mean(axis=0))
        assert np.ptp(shape.outline_xy, axis=0).max() < 0.0125
    assert len(middles) >= 2
    for wires in middles.values():
        gaps_m = np.linalg.norm(np.diff(wires, axis=0), axis=1)
        assert gaps_m == pytest.approx(WIRES_M, abs=1e-3)


def test_a_thick_forest_is_as_dense_as_the_issue_says():
    trunks = plant_thick(np.random.default_rng(1), 54.0)
    assert len(trunks) / (48.0 * 30.0) == pytest.approx(THICK_DENSITY_PER_M2, abs=1e-3)
    assert 0.25 <= trunks[:, 2].min() < 0.35
    assert 0.9 < trunks[:, 2].max() <= 1.0
    gaps = np.hypot(*(trunks[:, None, :2] - trunks[None, :, :2]).transpose(2, 0, 1))
    assert np.any(gaps + 9.0 * np.eye(len(trunks)) < trunks[:, 2] + trunks[:, None, 2])


@pytest.mark.table("seed", range(3))
@pytest.mark.table("mover_speed_m_s", [1.0, 2.0])
@pytest.mark.table("world", ["crossing", "head_on"])
def test_a_mover_meets_a_uav_that_flies_straight(world, mover_speed_m_s, seed, tmp_path):
    """A UAV at 4 m/s that is 0.6 s behind one which has its speed at once, as PX4's rise time makes it."""
    trials = {"world": world, "speed_m_s": 4, "mover_speed_m_s": mover_speed_m_s}
    place = place_of(campaign_of({"trials": trials}, "x").combinations[0], seed)
    mover = next(m for m in load_world(place.world_file(tmp_path)).models if m.script is not None)
    (way,) = mover.script.trajectories
    assert not mover.script.loop
    times = np.array([w.time_s for w in way.waypoints])
    x, y, _ = np.array([w.pose.position_m for w in way.waypoints]).T
    speeds = np.hypot(np.diff(x), np.diff(y)) / np.diff(times)
    assert speeds == pytest.approx(mover_speed_m_s, abs=1e-3)
    uav_x = 4.0 * (times - 8.7)
    fine = np.linspace(8.7, 8.7 + 6.5, 2000)
    gap = np.hypot(*(np.interp(fine, times, a) for a in (x - uav_x, y)))
    assert gap.min() < 0.6  # of the middles: less than the radii of a person and a UAV
    before = times < 8.7
    assert np.hypot(x[before], y[before]).min() > 4.0


@pytest.mark.table("seed", range(3))
@pytest.mark.table("world", ["abreast", "sinking", "small_uav"])
def test_what_is_drawn_meets_a_uav_at_its_height_or_comes_down_to_the_floor(world, seed, tmp_path):
    trials = {"world": world, "speed_m_s": 2}
    place = place_of(campaign_of({"trials": trials}, "x").combinations[0], seed)
    things = [m for m in load_world(place.world_file(tmp_path)).models if m.script is not None]
    gaps, fine = [], np.linspace(8.7, 8.7 + 13.0, 4000)
    for thing in things:
        (way,) = thing.script.trajectories
        times = np.array([w.time_s for w in way.waypoints])
        x, y, z = np.array([w.pose.position_m for w in way.waypoints]).T
        assert z.min() >= 0.0
        if world == "sinking":
            assert z[0] > FLIGHT_HEIGHT_M
            assert z[-1] == 0.0
        gaps.append(np.hypot(np.interp(fine, times, x) - 2.0 * (fine - 8.7), np.interp(fine, times, y)).min())
    assert len(things) >= (2 if world == "abreast" else 1)
    assert min(gaps) < 1.6  # half the greatest gap between two people, and what a UAV keeps


def test_keep_out_boxes_stand_beside_the_way_and_a_body_in_one_is_found():
    place = place_of(settings_of("keep_out"), 3)
    assert len(place.keep_out) == 3
    for box in place.keep_out:
        assert min(abs(box.low_m[1]), abs(box.high_m[1])) >= 0.3
        assert 0.0 < box.low_m[0] < box.high_m[0] < place.distance_m
    box = place.keep_out[0]
    beside = np.zeros((1, 8))
    beside[0, 1:3] = box.high_m[0] + 0.3, box.low_m[1]
    assert entered(beside, place.keep_out, 0.35)
    assert not entered(beside, place.keep_out, 0.25)


def test_the_odometrys_drift_moves_no_keep_out_box():
    # Given a box, and odometry that is off by 0.4 m and 0.1 rad
    box = KeepOutBox((6.0, -1.0, 0.0), (7.0, 1.0, 3.0), "box")
    told, true = (
        Pose.from_xyz_rpy(*pose) for pose in ((3.4, 0.2, 1.5, 0, 0, 0.3), (3.0, 0.0, 1.5, 0, 0, 0.2))
    )
    keep_out = KeepOut((box,))
    # When a SLAM without error places it
    ExactMap(keep_out).on_scan(0.0, np.empty(0), told, true)
    walls = keep_out.walls(told.position_m)
    # Then it is where it truly is from the UAV: 3 m ahead in the map, which odometry takes for 0.1 rad left
    in_map = walls @ rotation_matrix(quaternion_from_rpy(0.0, 0.0, 0.1))
    assert in_map[:, 0].min() == pytest.approx(3.0)
    assert (in_map[:, 1].min(), in_map[:, 1].max()) == pytest.approx((-1.0, 1.0))


# -- ways ---------------------------------------------------------------------------------------------------


def wall(y_low, y_high, bottom_m=0.0, top_m=4.0):
    """Return a wall across the way, 0.2 m thick, 5 m ahead."""
    corners = np.array([(5.0, y_low), (5.2, y_low), (5.2, y_high), (5.0, y_high)])
    return Outline("wall", corners, bottom_m, top_m)


@pytest.mark.table(("gap_m", "found"), [(0.95, False), (1.05, True)])
def test_a_gap_is_a_way_when_it_leaves_half_a_metre_to_both_sides(gap_m, found):
    walls = [wall(-3.0, 1.0 - gap_m / 2), wall(1.0 + gap_m / 2, 3.0)]
    assert way_exists(walls, 10.0, 3.0, FLAT) is found


@pytest.mark.table(("bottom_m", "found"), [(1.55, False), (1.65, True)])
def test_a_way_may_lead_below(bottom_m, found):
    hanging = wall(-3.0, 3.0, bottom_m, 6.0)  # the lowest height is 1.1 m
    assert way_exists([hanging], 10.0, 3.0, np.arange(1.1, 2.95, 0.1)) is found


def test_the_distance_from_a_polygon():
    square = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    points = np.array([(0.5, 0.5), (2.0, 0.5), (0.5, -3.0), (4.0, 5.0)])
    assert distance_m(points, square) == pytest.approx([0.0, 1.0, 3.0, 5.0])


# -- forests and hallways -----------------------------------------------------------------------------------


def test_a_denser_forest_is_the_sparser_one_with_more_trunks():
    sparse, dense = (plant(np.random.default_rng(3), SPACING_M, 26.0, trees) for trees in (20, 64))
    assert (len(sparse), len(dense)) == (20, 64)  # 0.16 per m2 of 20 x 20 m
    assert np.array_equal(dense[:20], sparse)
    gaps = np.hypot(*(dense[:, None, :2] - dense[None, :, :2]).transpose(2, 0, 1))
    assert gaps[~np.eye(64, dtype=bool)].min() >= SPACING_M
    assert np.abs(dense[:, 0] - 13.0).max() <= 13.0 - CLEAR_M


@pytest.mark.table("width_m", [1.6, 3.0])
def test_a_hallway_is_passable_and_as_wide_as_it_says(width_m, tmp_path):
    path = tmp_path / "hallway.world"
    path.write_text(hallway_sdf(np.random.default_rng(5), width_m, 26.0))
    shapes = {outline.name.split("::")[0]: outline.outline_xy for outline in outlines_of_file(path)}
    assert shapes["left"][:, 1].min() == pytest.approx(width_m / 2)
    assert shapes["right"][:, 1].max() == pytest.approx(-width_m / 2)
    cabinets = [corners for name, corners in shapes.items() if name.startswith("cabinet")]
    assert len(cabinets) >= 3
    for cabinet in cabinets:
        assert width_m / 2 - np.abs(cabinet[:, 1]).min() == pytest.approx(0.4)
    edges = sorted((cabinet[:, 0].min(), cabinet[:, 0].max()) for cabinet in cabinets)
    assert min(b[0] - a[1] for a, b in zip(edges, edges[1:])) > 2.0  # no two stand opposite each other


@pytest.mark.table("seed", range(8))
def test_a_mixed_forest_has_room_at_start_and_goal_and_between_its_trunks(seed):
    rng = np.random.default_rng(seed)
    trunks = plant(rng, rng.uniform(*MIXED_SPACINGS_M), 26.0)
    gaps = np.hypot(*(trunks[:, None, :2] - trunks[None, :, :2]).transpose(2, 0, 1))
    assert np.min(gaps[~np.eye(len(trunks), dtype=bool)]) >= MIXED_SPACINGS_M[0]
    for end_x in (0.0, 26.0):
        assert np.min(np.hypot(trunks[:, 0] - end_x, trunks[:, 1])) >= CLEAR_M
    assert len(trunks) > 15
