"""Given meshes with several rooms, the UAV begins in the one that walls enclose most, and all are told."""

import numpy as np
import pytest
import trimesh

from inspection.survey.command import main
from inspection.survey.parameters import SurveyParameters
from inspection.survey.plan_file import read_plan
from inspection.survey.surface.reading import read_room, read_surface
from inspection.survey.surface.room import room_of
from inspection.survey.tour.ways import Ways
from inspection.survey.views.candidates import lattice

VOXEL_M = 0.25


def boxes(*parts):
    """Blocked voxels of 12 x 10 x 5 m: hollow boxes (x, y, z from, to, m), each without some of its sides."""
    blocked = np.zeros((20, 40, 48), bool)
    for low, high, without in parts:
        a, b = (np.rint(np.array(v)[::-1] / VOXEL_M).astype(int) for v in (low, high))
        inside = tuple(slice(i, j) for i, j in zip(a, b))
        shell = np.zeros_like(blocked)
        shell[inside] = True
        shell[tuple(slice(i + 1, j - 1) for i, j in zip(a, b))] = False
        for axis, end in without:
            cut = [slice(i + 1, j - 1) for i, j in zip(a, b)]
            cut[axis] = slice(b[axis] - 1, b[axis]) if end else slice(a[axis], a[axis] + 1)
            shell[tuple(cut)] = False
        blocked |= shell
    return blocked


TOP, SIDE = (0, 1), (2, 1)
TANK = ((1.0, 1.0, 0.5), (8.0, 8.0, 4.5))
CELL = ((9.0, 2.0, 0.5), (11.5, 6.0, 3.5))


def home_in(blocked, box):
    room = room_of(blocked, np.zeros(3), VOXEL_M, 0.5, None)
    return room, bool(((room.home_m > box[0]) & (room.home_m < box[1])).all())


@pytest.mark.table("without", [(), (TOP,), (SIDE,)])
def test_a_large_room_wins_over_a_sealed_cell_be_it_open_or_not(without):
    room, is_there = home_in(boxes((*TANK, without), (*CELL, ())), TANK)
    assert is_there
    assert room.regions[0].is_open == bool(without)
    # the cell is 2 x 3.5 x 2.5 m within its walls, and the UAV's centre keeps 0.5 m from each of them
    (cell,) = (each for each in room.regions[1:] if not each.is_open)
    assert cell.sheltered_m3 == pytest.approx(1.0 * 2.5 * 1.5)


def test_home_views_and_ways_keep_the_clearance_from_the_surfaces_themselves(tmp_path):
    """A UAV of 0.2 m in a room of 3 x 2 x 2 m with a pillar, and a bulkhead whose manhole is 0.6 x 0.8 m."""
    walls = trimesh.creation.box(bounds=((0.0, 0.0, 0.0), (3.0, 2.0, 2.0)))
    walls.invert()
    pillar_m = np.array(((0.7, 0.9, 0.0), (0.9, 1.1, 2.0)))
    solids_m = [
        pillar_m,
        *(
            np.array((low, high))
            for low, high in (
                ((2.0, 0.0, 0.0), (2.05, 0.7, 2.0)),
                ((2.0, 1.3, 0.0), (2.05, 2.0, 2.0)),
                ((2.0, 0.7, 0.0), (2.05, 1.3, 0.6)),
                ((2.0, 0.7, 1.4), (2.05, 1.3, 2.0)),
            )
        ),
    ]
    parts = [trimesh.creation.box(bounds=each) for each in solids_m]
    trimesh.util.concatenate([walls, *parts]).export(tmp_path / "room.stl")
    asked = SurveyParameters(radius=0.2, margin=0.0, voxel=0.05)
    room = read_room(tmp_path / "room.stl", asked)

    def clearances_m(places_m):
        """To walls and solids, closed form."""
        inside_m = np.minimum(places_m, np.array((3.0, 2.0, 2.0)) - places_m).min(axis=1)
        to_solids_m = [
            np.linalg.norm(np.maximum(np.maximum(low - places_m, places_m - high), 0.0), axis=1)
            for low, high in solids_m
        ]
        return np.minimum(inside_m, np.min(to_solids_m, axis=0))

    views_m = lattice(room, 0.1)
    assert clearances_m(views_m).min() >= 0.2 - 1e-6
    assert clearances_m(room.home_m[None]).min() >= 0.2 - 1e-6
    # Then the way through the manhole keeps it, too
    ends_m = np.array(
        [views_m[np.argmin(np.linalg.norm(views_m - (x, 1.6, 0.4), axis=1))] for x in (1.4, 2.6)]
    )
    way_m = np.array((ends_m[0], *Ways(room, ends_m).between(0, 1), ends_m[1]))
    along_m = np.concatenate([np.linspace(a, b, 50) for a, b in zip(way_m, way_m[1:])])
    assert clearances_m(along_m).min() >= 0.2 - 1e-6


def test_the_room_around_a_closed_one_does_not_win():
    room, is_there = home_in(boxes((*CELL, ())), CELL)
    assert is_there
    assert [each.is_open for each in room.regions] == [False, True]
    assert room.regions[1].flyable_m3 > 10 * room.regions[0].flyable_m3


def test_where_nothing_is_enclosed_the_uav_begins_outside():
    blocked = np.zeros((20, 40, 48), bool)
    blocked[:16, 18:22, 22:26] = True
    room = room_of(blocked, np.zeros(3), VOXEL_M, 0.5, None)
    assert room.regions[0].is_open
    assert room.regions[0].sheltered_m3 == 0.0


def test_the_command_says_first_which_room_it_plans_and_how_much_of_the_mesh_it_is(tmp_path, capsys):
    """An open-topped tank of 7 x 7 x 4 m, and a sealed cell beside it."""
    tank, cell = trimesh.creation.box((7.0, 7.0, 4.0)), trimesh.creation.box((2.5, 4.0, 3.0))
    tank.update_faces(tank.face_normals[:, 2] < 0.5)
    cell.apply_translation((6.0, 0.0, 0.0))
    trimesh.util.concatenate([tank, cell]).export(tmp_path / "both.stl")
    given = [
        "--mesh",
        tmp_path / "both.stl",
        "--out",
        tmp_path / "plan.yaml",
        "--resolution",
        "10",
        "--voxel",
        "0.2",
    ]
    assert main(["plan", *map(str, given), "--search", "0", "--no-bound", "--patch", "1.0"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("room: the one that surfaces enclose most")
    assert "this room: open to the outside" in lines[2]
    assert "another room: closed" in lines[3]
    # The open tank is a sheet with two sides, the sealed cell has one: its walls are a part of the mesh
    sides_m2 = 2 * (49.0 + 4 * 28.0) + 2 * (2.5 * 4.0 + 2.5 * 3.0 + 4.0 * 3.0)
    walls_m2, mesh_m2 = (float(each.split()[0]) for each in lines[4].split(": ")[1:])
    assert mesh_m2 == pytest.approx(sides_m2, abs=0.5)
    assert walls_m2 <= mesh_m2


def tower(path, has_door):
    """A hollow tower of 4 x 4 x 12 m with walls of 0.2 m, and a door of 1.6 x 2.4 m towards x."""
    outer, inner = trimesh.creation.box((4.0, 4.0, 12.0)), trimesh.creation.box((3.6, 3.6, 11.6))
    inner.invert()
    solid = trimesh.util.concatenate([outer, inner])
    solid.apply_translation((0.0, 0.0, 6.0))
    if has_door:
        solid = solid.subdivide_to_size(0.4)
        middles = solid.triangles_center
        is_door = (middles[:, 0] > 1.5) & (np.abs(middles[:, 1]) < 0.8) & (middles[:, 2] < 2.4)
        solid.update_faces(~is_door)
    solid.export(path)
    return path


@pytest.mark.table("has_door", [False, True])
def test_from_outside_nothing_in_a_tower_is_flown_or_photographed(tmp_path, has_door):
    asked = SurveyParameters(outside=True, voxel=0.2, patch=1.0)
    surface = read_surface(tower(tmp_path / "tower.stl", has_door), asked)
    room, points = surface.room, surface.patches.points_m
    places_m = room.outer(np.argwhere(room.flyable) + 0.5)
    is_within = (np.abs(places_m[:, :2]) < 2.0).all(axis=1) & (places_m[:, 2] < 12.0)
    assert len(places_m)
    assert not is_within.any()
    assert (np.abs(places_m).max(axis=0)[:2] > 6.0).all()  # all around it
    assert places_m[:, 2].min() > 0.0  # not below its base
    assert room.home_m[2] < 1.0
    # Its faces are those outside: no inner wall, and no underside
    outside = (np.abs(np.abs(points[:, :2]) - 2.0) < 0.05).any(axis=1) | (points[:, 2] > 11.9)
    assert outside.mean() > 0.94  # through the door, its jambs are outside, too
    patches = surface.patches
    leads_out = (points[:, :2] * patches.normals[:, :2]).sum(axis=1) > 1.0
    walls_m2 = patches.areas_m2[leads_out & (np.abs(patches.normals[:, 2]) < 0.5)].sum()
    assert walls_m2 == pytest.approx(4 * 48.0 - has_door * 1.6 * 2.4, rel=0.02)


def test_from_outside_the_uav_takes_off_beside_a_tower_on_legs_and_not_below_it(tmp_path):
    boxes = [trimesh.creation.box((8.0, 8.0, 4.0))]
    boxes[0].apply_translation((0.0, 0.0, 14.0))
    for x in (-3.5, 3.5):
        for y in (-3.5, 3.5):
            leg = trimesh.creation.box((0.6, 0.6, 12.0))
            leg.apply_translation((x, y, 6.0))
            boxes.append(leg)
    trimesh.util.concatenate(boxes).export(tmp_path / "legs.stl")
    room = read_room(tmp_path / "legs.stl", SurveyParameters(outside=True, voxel=0.4, patch=1.0))
    x, y, z = room.home_m
    assert max(abs(x), abs(y)) == pytest.approx(4.0 + 2.0, abs=0.4)  # a voxel
    assert 0.0 < z < 1.2


def lattice_mast(path, width_m=8.0, height_m=12.0, apart_m=2.0):
    """Bars of 0.1 m along the four sides of a mast, upright and level: a UAV fits between them."""
    bars, half = [], 0.5 * width_m
    for along, size in ((0, (width_m, 0.1, 0.1)), (1, (0.1, width_m, 0.1))):
        for side in (-half, half):
            for z in np.arange(0.0, height_m + 0.1, apart_m):
                bars.append(trimesh.creation.box(size))
                bars[-1].apply_translation((0.0, side, z) if along == 0 else (side, 0.0, z))
            for at in np.arange(-half, half + 0.1, apart_m):
                bars.append(trimesh.creation.box((0.1, 0.1, height_m)))
                middle = (at, side, 0.5 * height_m) if along == 0 else (side, at, 0.5 * height_m)
                bars[-1].apply_translation(middle)
    trimesh.util.concatenate(bars).export(path)
    return path


def test_from_outside_the_uav_does_not_fly_in_a_lattice_whose_inner_sides_it_photographs(tmp_path):
    asked = SurveyParameters(outside=True, voxel=0.25, patch=1.0)
    surface = read_surface(lattice_mast(tmp_path / "mast.stl"), asked)
    room = surface.room
    places_m = room.outer(np.argwhere(room.flyable) + 0.5)
    low = places_m[:, 2] < 8.0  # below its open top, which one sees out of
    assert not ((np.abs(places_m[:, :2]) < 2.0).all(axis=1) & low).any()
    beside = (np.abs(places_m[:, :2]).max(axis=1) < 6.0) & low
    assert beside.sum() > 1000
    points, normals = surface.patches.points_m, surface.patches.normals
    faces_in = (np.abs(points[:, 0] + 3.95) < 0.02) & (normals[:, 0] > 0.9)
    assert faces_in.any()


def test_from_outside_the_uav_flies_between_two_buildings(tmp_path):
    blocks = [trimesh.creation.box((30.0, 4.0, 8.0)) for _ in range(2)]
    for block, y in zip(blocks, (-5.0, 5.0)):
        block.apply_translation((0.0, y, 4.0))
    trimesh.util.concatenate(blocks).export(tmp_path / "street.stl")
    room = read_room(tmp_path / "street.stl", SurveyParameters(outside=True, voxel=0.4, patch=1.0))
    middle_m = np.column_stack((np.linspace(-12.0, 12.0, 7), np.zeros(7), np.full(7, 4.0)))
    assert room.at(room.flyable, middle_m).all()


def test_without_the_flag_the_inside_of_a_closed_tower_is_planned(tmp_path):
    surface = read_surface(tower(tmp_path / "tower.stl", False), SurveyParameters(voxel=0.2, patch=1.0))
    assert (np.abs(surface.room.home_m[:2]) < 1.8).all()


def test_a_plan_from_outside_comes_back_and_its_views_lie_outside(tmp_path):
    given = [
        "--mesh",
        str(tower(tmp_path / "tower.stl", True)),
        "--out",
        str(tmp_path / "plan.yaml"),
        "--outside",
    ]
    given += ["--resolution", "10", "--voxel", "0.2", "--search", "0", "--no-bound", "--patch", "1.0"]
    assert main(["plan", *given, "--spacing", "2"]) == 0
    plan = read_plan(tmp_path / "plan.yaml")
    assert plan.asked.outside
    stops_m = [
        place_m
        for flight in plan.flights
        for each in flight.views
        for place_m in (*each.way_m, each.view.place_m)
    ]
    assert all(max(abs(x), abs(y)) > 2.4 or z > 12.4 for x, y, z in stops_m)
    assert main(["check", str(tmp_path / "plan.yaml")]) == 0
