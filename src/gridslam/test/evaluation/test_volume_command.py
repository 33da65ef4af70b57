"""The command `gridslam_evaluate volume`, on a room whose figures are known in closed form."""

import json

import numpy as np
import pytest
import trimesh

from gridslam.evaluation.command import main
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.volume import Board, VolumeParameters, VoxelMap, stream_of, write_octree

R = 0.1
SIZE_M = np.array([4.0, 3.0, 2.0])
SEEN_FROM = SIZE_M / 2 + 0.01


@pytest.fixture
def files(tmp_path):
    """Write a room, its perfect map, and a path of one place; return the folder."""
    room = trimesh.creation.box(SIZE_M, trimesh.transformations.translation_matrix(SIZE_M / 2))
    for ending in ("glb", "stl", "obj", "ply"):
        room.export(str(tmp_path / f"room.{ending}"))
    write_map(tmp_path / "map.bt", SIZE_M)
    (tmp_path / "path.tum").write_text("1.0 {} {} {} 0 0 0 1\n".format(*SEEN_FROM))
    return tmp_path


def write_map(path, size_m):
    """The voxels just inside a room's walls occupied, those between free."""
    axes = [np.arange(R / 2, side, R) for side in size_m]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    shell = centres[(np.minimum(centres, size_m - centres) < R).any(axis=1)]
    voxels = VoxelMap(VolumeParameters(resolution_m=R))
    voxels.insert(voxels.rays(size_m / 2 + 0.01, shell), Board())
    write_octree(path, stream_of(voxels, path.suffix == ".bt"), R)


def judged(folder, *words):
    """Return the exit code and the figures."""
    code = main(["volume", *map(str, words), "--json", str(folder / "figures.json")])
    return code, json.loads((folder / "figures.json").read_text()) if code == 0 else {}


@pytest.mark.parametrize("ending", ["glb", "stl", "obj", "ply"])
def test_a_perfect_map_is_half_a_voxel_off_in_any_kind_of_mesh(files, ending, capsys):
    code, figures = judged(files, files / "map.bt", files / f"room.{ending}")
    assert code == 0
    assert figures["volume_error_p95_m"] == pytest.approx(R / 2, abs=1e-6)
    assert figures["occupied_within_a_voxel_share"] == 1.0
    assert "visible_surface_mapped_share" not in figures
    assert "volume_error_mean_m" in capsys.readouterr().out


def test_from_a_path_all_that_a_lidar_saw_is_mapped(files):
    write_map(files / "map.ot", SIZE_M)
    picture = files / "errors.png"
    asked = ("--path", files / "path.tum", "--elevation", -90, 90, "--picture", picture)
    code, figures = judged(files, files / "map.ot", files / "room.glb", *asked)
    assert code == 0
    assert figures["visible_surface_mapped_share"] == 1.0
    assert figures["free_right_share"] == 1.0
    x, y, z = SIZE_M
    assert figures["visible_surface_m2"] == pytest.approx(2 * (x * y + y * z + z * x), rel=0.01)
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_a_level_puck_sees_a_band_of_the_walls(files):
    """A plane at the distance d shows the band of height 2 tan(15 deg) sqrt(d^2 + s^2) along its length s."""
    code, figures = judged(
        files, files / "map.bt", files / "room.glb", "--path", files / "path.tum", "--lidar", "puck"
    )
    assert code == 0
    along = [(apart, np.linspace(-side / 2, side / 2, 10_001)) for apart, side in ((1.5, 4.0), (2.0, 3.0))]
    bands = [2 * np.tan(np.radians(15)) * np.hypot(apart, s).mean() * np.ptp(s) for apart, s in along]
    assert figures["visible_surface_m2"] == pytest.approx(2 * sum(bands), rel=0.03)
    assert figures["visible_surface_mapped_share"] == 1.0


def test_a_map_whose_frame_is_turned_is_placed_by_its_pose(files):
    """The room turned by 90 degrees and moved: what was at (x, y) is at (5 - y, x) and 1 m higher."""
    room = trimesh.load_mesh(files / "room.stl")
    x, y, yaw = 5.0, 0.0, np.pi / 2
    room.apply_transform(trimesh.transformations.euler_matrix(0, 0, yaw))
    room.apply_translation((x, y, 1.0))
    room.export(str(files / "turned.stl"))
    code, figures = judged(files, files / "map.bt", files / "turned.stl", "--map-in-world", x, y, 1.0, yaw)
    assert code == 0
    assert figures["volume_error_max_m"] < R
    _, figures = judged(files, files / "map.bt", files / "turned.stl")
    assert figures["volume_error_max_m"] > 0.5


def test_a_path_of_the_base_is_moved_to_the_lidar(files):
    (files / "base.tum").write_text("1.0 {} {} 0 0 0 0 1\n".format(*SEEN_FROM))
    asked = ("--lidar", "puck", "--path", files / "base.tum")
    code, moved = judged(
        files, files / "map.bt", files / "room.glb", *asked, "--lidar-at", 0, 0, SEEN_FROM[2]
    )
    assert code == 0
    _, direct = judged(
        files, files / "map.bt", files / "room.glb", "--lidar", "puck", "--path", files / "path.tum"
    )
    assert moved == direct


@pytest.mark.parametrize(
    ("words", "told"),
    [
        (("cut.bt", "room.glb"), "cut.bt"),
        (("none.bt", "room.glb"), "none.bt"),
        (("empty.bt", "room.glb"), "no voxel of the map is occupied"),
        (("map.bt", "cut.glb"), "cut.glb"),
        (("map.bt", "none.sdf"), "no such file"),
        (("map.bt", "room.glb", "--path", "empty.tum"), "is empty"),
        (("map.bt", "room.glb", "--path", "planar.tum"), "planar path"),
        (("map.bt", "room.glb", "--path", "away.tum"), "reaches no surface"),
        (("map.bt", "room.glb", "--lidar", "puck"), "needs --path"),
        (("map.bt", "room.glb", "--path", "path.tum", "--elevation", "20", "10"), "LOW < HIGH"),
        (
            ("map.bt", "room.glb", "--path", "path.tum", "--lidar", "puck", "--elevation", "1", "2"),
            "leave out",
        ),
        (("map.bt", "room.glb", "--picture", "none/errors.png"), "no folder"),
    ],
)
def test_bad_input_gets_one_sentence(files, words, told, capsys, monkeypatch):
    monkeypatch.chdir(files)
    whole = (files / "map.bt").read_bytes()
    (files / "cut.bt").write_bytes(whole[: len(whole) // 2])
    voxels = VoxelMap(VolumeParameters(resolution_m=R))
    write_octree(files / "empty.bt", stream_of(voxels, is_binary=True), R)
    (files / "cut.glb").write_bytes((files / "room.glb").read_bytes()[:100])
    (files / "empty.tum").write_text("# stamp x y z qx qy qz qw\n")
    (files / "planar.tum").write_text("1 2 1.5 0 0 0 0 1\n2 2 1.6 0 0 0 0 1\n")
    (files / "away.tum").write_text("1 90 90 90 0 0 0 1\n")
    assert main(["volume", *words]) == 1
    said = capsys.readouterr().err
    assert said.startswith("gridslam_evaluate: ")
    assert told in said
    assert said.count("\n") == 1


@pytest.mark.parametrize("lidar", sorted(VIEWS))
def test_the_beams_are_those_of_the_models(lidar):
    uav = pytest.importorskip("simulation_tools.vehicle.uav", reason="the models are simulation_tools'")
    elements = pytest.importorskip("simulation_tools.sdf.elements")
    sensors = [ray for _, ray in uav.load_uav("iris", lidar).model.sensors(elements.RaySensor)]
    sensor = max(sensors, key=lambda each: each.vertical.samples)
    view = VIEWS[lidar]
    assert view.range_max_m == sensor.range_max_m
    flat, tall = sensor.horizontal, sensor.vertical
    spans = flat.samples * flat.increment_rad, (flat.samples - 1) * flat.increment_rad
    assert any(view.field_of_view_deg == pytest.approx(np.degrees(span), abs=0.02) for span in spans)
    if tall.samples > 1:
        assert view.elevation_deg == pytest.approx(np.degrees((tall.min_angle_rad, tall.max_angle_rad)))
    else:
        assert view.elevation_deg == (-0.5, 0.5)
