"""The plan of an inspection is made from a world, a mesh, or the map of an exploration."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from flights.errors import ScenarioError
from flights.inspecting.planning import provide_plan
from flights.inspecting.request import read
from gridslam.volume import Board, VolumeParameters, VoxelMap
from gridslam.volume.octree.files import write_octree
from gridslam.volume.octree.stream import stream_of
from simulation_tools.camera.errors import PhotographError

WORLDS = Path(__file__).resolve().parents[2] / "worlds"
SIZE_M, VOXEL_M = np.array((5.0, 4.0, 4.0)), 0.1
ASKED = {
    "experiment": "inspection", "world": str(WORLDS / "empty.world"), "start": "2.5 2 0 0", "lidar": "puck",
    "algorithm": "dynamic", "pose_source": "slam", "gnss": False, "photographs": 2, "detail": 2.0,
}  # fmt: skip


def box_map(path):
    """A map of a box whose corner is the origin, seen from its middle."""
    axes = [np.arange(VOXEL_M / 2, side, VOXEL_M) for side in SIZE_M]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shell = centres[(np.minimum(centres, SIZE_M - centres) < VOXEL_M).any(axis=1)]
    voxels = VoxelMap(VolumeParameters(resolution_m=VOXEL_M))
    voxels.insert(voxels.rays(SIZE_M / 2 + 0.01, shell), Board())
    write_octree(path, stream_of(voxels, is_binary=True), VOXEL_M)
    return path


def box_mesh(path):
    box = trimesh.creation.box(SIZE_M)
    box.apply_translation(SIZE_M / 2)
    box.export(path)
    return path


@pytest.mark.table(("name", "drawn"), [("map.bt", box_map), ("box.stl", box_mesh)])
def test_a_plan_is_made_from_a_map_or_a_mesh_with_a_page_beside_it(tmp_path, name, drawn):
    out, said = tmp_path / "run" / "plan.yaml", []
    out.parent.mkdir()
    request = read({**ASKED, "drawing": str(drawn(tmp_path / name)), "second_look": True}, 0.5)
    plan = provide_plan(request, out, 1, said.append)
    assert request.second_look
    assert name in said[0]
    inner = SIZE_M - 2 * VOXEL_M if name == "map.bt" else SIZE_M
    area_m2 = 2 * (inner[0] * inner[1] + inner[1] * inner[2] + inner[0] * inner[2])
    assert plan.figures["area_m2"] == pytest.approx(area_m2, rel=0.05)
    assert Path(plan.source).is_file()
    places = np.array([view.place_m for view in plan.views])
    assert len(places)
    assert (places > 0.5).all()
    assert (places < SIZE_M - 0.5).all()
    assert "Survey plan, before the flight" in out.with_suffix(".html").read_text()


@pytest.mark.table(("model", "radius_m", "passes"), [("small_quad", 0.2, True), ("iris", 0.35, False)])
def test_a_plan_for_the_small_uav_leads_through_manholes(tmp_path, model, radius_m, passes):
    # Given two rooms with a manhole of 0.6 x 0.8 m between them
    beside = [
        ((2.5, 0.0, 0.0), (2.7, 1.2, 4.0)),
        ((2.5, 1.8, 0.0), (2.7, 3.0, 4.0)),
        ((2.5, 1.2, 0.0), (2.7, 1.8, 1.6)),
        ((2.5, 1.2, 2.4), (2.7, 1.8, 4.0)),
    ]
    wall = [trimesh.creation.box(bounds=bounds) for bounds in beside]
    shell = trimesh.creation.box(bounds=((0.0, 0.0, 0.0), (5.2, 3.0, 4.0)))
    shell.invert()
    path = tmp_path / "rooms.stl"
    trimesh.util.concatenate([shell, *wall]).export(path)
    asked = {**ASKED, "drawing": str(path), "start": "1.2 1.5 0 0", "model": model, "radius": radius_m}
    plan = provide_plan(read(asked, 0.5), tmp_path / "plan.yaml", 1, lambda _: None)
    places_m = np.array([each.view.place_m for flight in plan.flights for each in flight.views])
    assert (places_m[:, 0] < 2.5).any()
    assert (places_m[:, 0] > 2.7).any() == passes


def test_a_plan_on_a_map_leads_through_manholes_that_the_rims_voxels_make_narrower(tmp_path):
    # Given two rooms and a manhole of 0.6 x 0.8 m. The noise of the beams has filled all voxels at its rim
    size_m, low_m, high_m = np.array((5.2, 3.0, 4.0)), np.array((1.3, 1.7)), np.array((1.7, 2.3))
    axes = [np.arange(VOXEL_M / 4, side, VOXEL_M / 2) for side in size_m]
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    in_hole = ((places[:, 1:] > low_m) & (places[:, 1:] < high_m)).all(axis=1)
    in_wall = (np.abs(places[:, 0] - 2.6) < VOXEL_M) & ~in_hole
    at_shell = (np.minimum(places, size_m - places) < VOXEL_M).any(axis=1)
    cells = np.unique(np.floor(places[in_wall | at_shell] / VOXEL_M), axis=0)
    voxels = VoxelMap(VolumeParameters(resolution_m=VOXEL_M))
    for x_m in (1.21, 4.01):
        voxels.insert(voxels.rays((x_m, 1.51, 2.01), (cells + 0.5) * VOXEL_M), Board())
    path = tmp_path / "map.bt"
    write_octree(path, stream_of(voxels, is_binary=True), VOXEL_M)
    asked = {**ASKED, "drawing": str(path), "start": "1.2 1.5 0 0", "model": "small_quad", "radius": 0.2}
    plan = provide_plan(read(asked, 0.5), tmp_path / "plan.yaml", 1, lambda _: None)
    places_m = np.array([view.place_m for view in plan.views])
    assert (places_m[:, 0] > 2.7).any()


NAN = float("nan")
NONSENSE = {
    "drawing": (["nowhere.stl"], "no such drawing"),
    "exposure": ([0.0, -1.0, "short", NAN, 20.0], "exposure"),
    "passing": ([-0.1, 2.0, "fast", NAN], "passing"),
    "effects": (["rain", "dirt=2", "dirt=much", "seed=0.5"], "effect"),
    **{
        name: (["yes", 1, -1.0, NAN], f"is no {name}; give true or false")
        for name in ("supplement", "second_look", "explore")
    },
}


@pytest.mark.table(
    ("name", "value", "sentence"),
    [(name, value, sentence) for name, (values, sentence) in NONSENSE.items() for value in values],
)
def test_what_makes_no_sense_is_named_before_a_flight(name, value, sentence):
    with pytest.raises(PhotographError if name == "effects" else ScenarioError, match=sentence):
        read({**ASKED, name: value}, 0.5)


def test_a_file_of_defects_that_makes_no_sense_is_refused_before_a_flight(tmp_path):
    path = tmp_path / "my.defects.yaml"
    path.write_text("defects: []\neffects: {rain: 1}\n")
    with pytest.raises(PhotographError, match=r"my[.]defects[.]yaml, line 2: .*'rain'"):
        read({**ASKED, "defects": str(path)}, 0.5)
    with pytest.raises(PhotographError, match=r"none[.]yaml"):
        read({**ASKED, "defects": str(tmp_path / "none.yaml")}, 0.5)


def test_a_given_plan_is_flown_with_the_exposure_that_is_asked(tmp_path):
    first, again = ({**ASKED, "exposure": value} for value in (0.002, 0.0005))
    path = tmp_path / "first.yaml"
    provide_plan(
        read({**first, "drawing": str(box_mesh(tmp_path / "box.stl"))}, 0.5), path, 1, lambda _: None
    )
    plan = provide_plan(read({**again, "plan": str(path)}, 0.5), tmp_path / "plan.yaml", 1, lambda _: None)
    assert plan.camera.exposure == 0.0005


def test_a_plan_is_made_and_a_given_one_flown_in_passing_as_is_asked(tmp_path):
    drawn = {**ASKED, "drawing": str(box_mesh(tmp_path / "box.stl")), "exposure": 0.0005}
    path, again = tmp_path / "first.yaml", tmp_path / "plan.yaml"
    for passing_m_s in (0.0, 0.4):
        request = read({**drawn, "passing": passing_m_s}, 0.5)
        plan = provide_plan(request, path, 1, lambda _: None)
        assert plan.flying.shooting_speed == passing_m_s
    for passing_m_s, flown_m_s in ((0.0, 0.4), (0.3, 0.3)):
        given = read({**ASKED, "plan": str(path), "passing": passing_m_s}, 0.5)
        assert provide_plan(given, again, 1, lambda _: None).flying.shooting_speed == flown_m_s


@pytest.mark.table("value", ["True", "true", True])
def test_true_is_read_however_it_is_written(value):
    assert read({**ASKED, "supplement": value}, 0.5).supplement
