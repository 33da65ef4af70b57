"""Coverage in a closed room: areas in closed form; poses from files, whole or damaged."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
import yaml
from PIL import Image

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.findings.placing import MeshSurface
from inspection.photographs.record import PhotographRecord
from inspection.survey import SurveyCamera, SurveyParameters
from inspection.survey.command import main
from inspection.survey.coverage import coverage_of_file
from inspection.survey.poses import read_photograph_poses
from inspection.survey.surface.mesh_file import read_mesh
from inspection.survey.views.candidates import View

CAMERA = SurveyCamera(width=648, height=486)
ASKED = SurveyParameters(resolution=8.0, spacing=1.0, voxel=0.2)
AHEAD = "x,y,z,yaw_deg,tilt_deg,blur_px\n"


@pytest.fixture(scope="module")
def room_file(tmp_path_factory):
    """A room of 6 x 4 x 3 m; the wall ahead is at x = 3."""
    path = tmp_path_factory.mktemp("room") / "room.stl"
    trimesh.creation.box((6.0, 4.0, 3.0)).export(path)
    return path


@pytest.mark.table(("blur_px", "low_m2", "high_m2"), [(0.0, 3.9, 4.6), (2.5, 0.0, 0.0)])
def test_a_photograph_from_2_m_shows_its_frame_and_a_blurred_one_nothing(
    room_file, tmp_path, blur_px, low_m2, high_m2
):
    """2 m away 60 degrees span 2.31 x 1.73 m = 4 m2; pixels of 3.6 mm, with 2.5 px of blur 9.6 mm."""
    (tmp_path / "poses.csv").write_text(AHEAD + f"1,0,0,0,0,{blur_px}\n")
    taken, camera = read_photograph_poses(tmp_path / "poses.csv", CAMERA)
    coverage = coverage_of_file(room_file, taken, camera, ASKED)
    assert low_m2 <= coverage.shown_m2 <= high_m2
    assert (coverage.points.points_m[coverage.shown, 0] > 2.99).all()


@pytest.mark.table(
    ("shift_m", "turn_rad", "is_shown"),
    [(0.0, 0.0, True), (0.006, 0.0, True), (0.009, 0.0, False), (0.0, 0.003, True), (0.0, 0.0045, False)],
)
def test_the_motion_of_a_record_counts_on_the_surface_in_place_of_its_longest_blur(
    room_file, shift_m, turn_rad, is_shown
):
    """2 m away in the middle: pixels of 3.6 mm, and a blur of the shift, or of 2 m times the turn."""
    record = PhotographRecord(
        1.0,
        (1.0, 0.0, 0.0),
        (-0.5, 0.5, -0.5, 0.5),
        0.01,
        100.0,
        90.0,
        9.0,
        shift_m=shift_m,
        turn_rad=turn_rad,
    )
    coverage = coverage_of_file(room_file, [record.pose], CAMERA, ASKED)
    middle = np.linalg.norm(coverage.points.points_m - (3.0, 0.0, 0.0), axis=1) < 0.2
    assert (coverage.shown[middle] == is_shown).all()


def test_the_command_judges_a_folder_of_photographs(room_file, tmp_path):
    """The optical frame of a camera that looks along x: its z axis is the map's x, its x the map's -y."""
    record = {"position_m": [1, 0, 0], "orientation_xyzw": [-0.5, 0.5, -0.5, 0.5], "blur_px": 0.0}
    (tmp_path / "1.json").write_text(json.dumps(record))
    Image.new("RGB", (648, 486), (128, 128, 128)).save(tmp_path / "1.jpg")
    focal = CAMERA.focal_px
    (tmp_path / "calibration.yaml").write_text(
        "{image_width: 648, image_height: 486, camera_matrix: "
        f"{{data: [{focal}, 0, 323.5, 0, {focal}, 242.5, 0, 0, 1]}}}}"
    )
    asked = [
        "--resolution",
        "8",
        "--spacing",
        "1",
        "--voxel",
        "0.2",
        "--out",
        str(tmp_path / "coverage.json"),
    ]
    assert main(["coverage", "--mesh", str(room_file), "--poses", str(tmp_path), *asked]) == 0
    found = json.loads((tmp_path / "coverage.json").read_text())
    assert 3.9 <= found["shown_m2"] <= 4.6
    assert found["reachable_m2"] == pytest.approx(108.0, rel=0.02)
    assert found["share_of_reachable"] == pytest.approx(found["shown_m2"] / found["reachable_m2"], abs=1e-3)
    opened_m2 = np.array(found["open"])[:, 3].sum()
    assert opened_m2 == pytest.approx(found["reachable_m2"] - found["shown_m2"], rel=0.02)


def test_a_plan_is_judged_by_what_it_was_made_for(room_file, tmp_path, monkeypatch):
    """Pixels of 8 mm everywhere, and nothing of 1 mm: for that, its camera must be 0.56 m away."""
    monkeypatch.chdir(tmp_path)
    asked = ["--resolution", "8", "--spacing", "1", "--voxel", "0.2", "--width", "648", "--height", "486"]
    assert main(["plan", "--mesh", str(room_file), *asked, "--search", "0", "--no-bound"]) == 0
    planned = yaml.safe_load(Path("plan.yaml").read_text())["figures"]["share"]
    shares = []
    for options in ([], ["--resolution", "1"]):
        assert main(["coverage", "--poses", "plan.yaml", *options]) == 0
        shares.append(json.loads(Path("coverage.json").read_text())["share_of_reachable"])
    assert shares[0] == pytest.approx(planned, abs=0.05)  # a patch counts by its middle
    assert not shares[1]


def room_with_fins(path, places_y, deep_m, thick_m=0.02):
    """The room of 6 x 4 x 3 m; fins stand on the wall ahead, x = 3, from floor to deck."""
    room = trimesh.creation.box((6.0, 4.0, 3.0))
    room.invert()
    fins = [trimesh.creation.box((deep_m, thick_m, 3.0)) for _ in places_y]
    for fin, y in zip(fins, places_y):
        fin.apply_translation((3.0 - 0.5 * deep_m, y, 0.0))
    trimesh.util.concatenate([room, *fins]).export(path)
    return path


def test_the_foot_of_a_stiffener_that_hides_it_is_not_shown(tmp_path):
    """From (1, 0, 0) the far edge of a fin's tip, (2.8, 0.51), hides the wall up to y = 0.567.

    The frame is 4.0 m2. Of it the fin takes 0.02 m x 1.732 m, and it hides 0.057 m x 1.732 m.
    """
    mesh = room_with_fins(tmp_path / "room.stl", [0.5], 0.2)
    (tmp_path / "poses.csv").write_text(AHEAD + "1,0,0,0,0,0\n")
    taken, camera = read_photograph_poses(tmp_path / "poses.csv", CAMERA)
    coverage = coverage_of_file(mesh, taken, camera, replace(ASKED, voxel=0.05, patch=0.25))
    points = coverage.points
    wall = points.points_m[:, 0] > 2.995
    hidden = wall & (points.points_m[:, 1] > 0.511) & (points.points_m[:, 1] < 0.566)
    assert hidden.any()
    assert not coverage.shown[hidden].any()
    frame_m2 = 4.0 * 647 / 648 * 485 / 486  # between the middles of the outer pixels
    true_m2 = frame_m2 - (0.02 + 0.51 * 2.0 / 1.8 - 0.51) * 1.732
    assert points.areas_m2[wall & coverage.shown].sum() == pytest.approx(true_m2, rel=0.005)
    # And it is told as open, near its foot
    record = coverage.record()
    foot = (np.abs(record.points_m - (3.0, 0.55, 0.0)) < (0.01, 0.1, 0.5)).all(axis=1)
    assert record.open_m2[foot].sum() > 0.8 * 0.057 * 0.9


@pytest.mark.parametrize("seed", [0, *(pytest.param(n, marks=pytest.mark.long) for n in (1, 2))])
def test_the_area_shown_is_that_of_the_pixels_that_show_it(tmp_path, seed):
    """A slow reference: each pixel shows its solid angle, on a surface that is near and steep enough."""
    rng = np.random.default_rng(seed)
    mesh = room_with_fins(tmp_path / "room.stl", rng.uniform(-1.6, 1.6, 6), rng.uniform(0.05, 0.4))
    place_m, yaw, tilt = (*rng.uniform(-1.0, 1.0, 2), 0.2), rng.uniform(-0.6, 0.6), rng.uniform(-0.3, 0.3)
    taken = PhotographPose.of_view(View(place_m, yaw, tilt))
    coverage = coverage_of_file(mesh, [taken], CAMERA, replace(ASKED, voxel=0.05))
    across, down = np.meshgrid(np.arange(CAMERA.width), np.arange(CAMERA.height))
    pixels = np.column_stack((across.ravel(), down.ravel()))

    def rays_of(pixels):
        aside = (pixels - CAMERA.centre_px) / CAMERA.focal_px
        return np.column_stack((aside, np.ones(len(aside)))) @ taken.axes.T

    rays = rays_of(pixels)
    lengths = np.linalg.norm(rays, axis=1)
    points_m, normals = MeshSurface(read_mesh(mesh).triangles_m).hits(taken.place_m, rays / lengths[:, None])
    reach_m = ((points_m - taken.place_m) * normals).sum(axis=1)
    right_m, below_m = (
        taken.place_m + (reach_m / (beside * normals).sum(axis=1))[:, None] * beside - points_m
        for beside in (rays_of(pixels + step) for step in ((1.0, 0.0), (0.0, 1.0)))
    )
    area_m2 = np.linalg.norm(np.cross(right_m, below_m), axis=1)
    widest_m = np.linalg.svd(np.stack((right_m, below_m), axis=2), compute_uv=False)[:, 0]
    shown = (-(normals * rays).sum(axis=1) >= 0.5 * lengths) & (1e3 * widest_m <= 8.0)
    told_m2 = coverage.shown_m2
    assert told_m2 == pytest.approx(area_m2[shown].sum(), rel=0.02)
    assert told_m2 <= 1.005 * area_m2[shown].sum()


@pytest.mark.table(
    ("content", "told"),
    [("x,y\n1,2\n", "no column z"), (AHEAD + "1,0,nan,0,0,0\n", "finite"), (AHEAD, "no photograph")],
)
def test_poses_that_make_no_sense_are_refused_with_a_sentence(tmp_path, content, told):
    (tmp_path / "poses.csv").write_text(content)
    with pytest.raises(SurveyError, match=told):
        read_photograph_poses(tmp_path / "poses.csv", CAMERA)


def test_a_map_s_coverage_is_told_as_one_and_the_drawing_has_what_the_map_lacks(
    tmp_path, capsys, monkeypatch
):
    """A room of 6 x 4 x 3 m with two webs of 0.3 m from floor to deck, which the map of the flight lacks.

    The map has all walls, 108 m2. A photograph from (1, 0, 0) shows 4.0 m2 of the wall ahead; of the drawing
    the webs at y = 0.5 and -0.5 hide some of that.
    """
    monkeypatch.chdir(tmp_path)
    plate = trimesh.creation.box((6.0, 4.0, 3.0))
    plate.invert()
    scene = trimesh.Scene()
    scene.add_geometry(plate, node_name="mapped_plating")
    scene.export("map.glb")
    drawn = trimesh.creation.box((0.3, 0.02, 3.0)), trimesh.creation.box((0.3, 0.02, 3.0))
    for web, y in zip(drawn, (-0.5, 0.5)):
        web.apply_translation((2.85, y, 0.0))
    scene = trimesh.Scene()
    scene.add_geometry(plate, node_name="shell")
    scene.add_geometry(trimesh.util.concatenate(drawn), node_name="webs")
    scene.export("drawing.glb")
    (tmp_path / "poses.csv").write_text(AHEAD + "1,0,0,0,0,0\n")
    asked = [
        "--poses",
        "poses.csv",
        "--resolution",
        "8",
        "--spacing",
        "1",
        "--voxel",
        "0.05",
        "--incidence",
        "80",
    ]
    camera = ["--width", "648", "--height", "486"]
    assert main(["coverage", "--mesh", "map.glb", "--drawing", "drawing.glb", *asked, *camera]) == 0
    words, told = capsys.readouterr().out, json.loads(Path("coverage.json").read_text())
    assert told["of"] == "map"
    assert told["reachable_m2"] == pytest.approx(108.0, rel=0.02)
    drawing = told["drawing"]
    webs = drawing["classes"]["webs"]
    assert 2.0 < webs["reachable_m2"] < 2 * (2 * 0.3 + 0.02) * 3.0
    assert webs["not_mapped_m2"] == pytest.approx(webs["reachable_m2"], abs=0.05)
    assert drawing["classes"]["shell"]["not_mapped_m2"] == pytest.approx(0.0, abs=0.1)
    assert drawing["not_mapped_m2"] <= drawing["reachable_m2"] <= drawing["surface_m2"]
    assert "on the map of the flight (map.glb)" in words
    assert "webs" in words
    # What is told of the drawing is what its own coverage tells
    assert main(["coverage", "--mesh", "drawing.glb", *asked, *camera, "--out", "true.json"]) == 0
    true = json.loads(Path("true.json").read_text())
    assert (true["of"], true["drawing"]) == ("drawing", None)
    assert drawing["share_of_reachable"] == pytest.approx(true["share_of_reachable"], abs=0.005)
    # Without a drawing it is said that what the map lacks does not count
    capsys.readouterr()
    assert main(["coverage", "--mesh", "map.glb", *asked, *camera]) == 0
    assert "no drawing was given" in capsys.readouterr().out
