"""Given pictures of a wall whose marks are known, rust and cracks are found in their places."""

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from drawn_wall import AWAY_M, CAMERA, wall_picture
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

from inspection.camera.survey_camera import SurveyCamera, optical_axes
from inspection.findings.command import main
from inspection.findings.findings_file import read_findings
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import Candidate, candidates_in
from inspection.findings.remembered import write_marks
from inspection.findings.search import find
from inspection.photographs.folder import PhotographFolder
from inspection.photographs.record import PhotographRecord
from inspection.report.grades import RUST_M
from inspection.survey.parameters import FlightParameters, SurveyParameters
from inspection.survey.plan import Flight, PlannedView, SurveyPlan
from inspection.survey.plan_file import read_plan, write_plan
from inspection.survey.views.candidates import View


def stored(folder, *shifts_px):
    """Photographs of the wall x = 0 from x = -AWAY_M, each from further to the right."""
    store = PhotographFolder(folder, CAMERA)
    turn = tuple(Rotation.from_matrix(optical_axes(0.0, 0.0)).as_quat())
    for stamp_s, shift_px in enumerate(shifts_px):
        place = (-AWAY_M, -shift_px * AWAY_M / CAMERA.focal_px, 0.0)  # a view along x: -y is to the right
        store.save(wall_picture(shift_px), PhotographRecord(float(stamp_s), place, turn, 0.002, 100.0, 100.0))


def wall(path, corner_at_m=None):
    box = trimesh.creation.box((1.0, 4.0, 4.0))
    box.apply_translation((0.5, 0.0, 0.0))
    if corner_at_m is not None:  # a rib of 2 cm, whose edge lies in the picture
        rib = trimesh.creation.box((0.02, 1.0, 4.0))
        rib.apply_translation((-0.01, corner_at_m - 0.5, 0.0))
        box = trimesh.util.concatenate([box, rib])
    box.export(path)
    return str(path)


def test_two_views_give_one_finding_each_where_it_is(tmp_path):
    stored(tmp_path, 0, 60)
    assert main([str(tmp_path), "--mesh", wall(tmp_path / "wall.stl")]) == 0
    findings = json.loads((tmp_path / "findings.json").read_text())["findings"]
    assert [each["kind"] for each in findings] == ["crack", "rust"]
    pixel_m = AWAY_M / CAMERA.focal_px
    for each, middle_px in zip(findings, ((500.5, 299.5), (199.5, 299.5))):
        aside, down = (np.array(middle_px) - CAMERA.centre_px) * pixel_m
        assert np.allclose(each["position_m"], (0.0, -aside, -down), atol=4 * pixel_m)
        assert np.allclose(each["normal"], (-1.0, 0.0, 0.0))
        assert len(each["photographs"]) == 2
    assert abs(findings[0]["length_m"] - 200 * pixel_m) < 12 * pixel_m
    assert abs(findings[1]["area_m2"] / (40 * pixel_m) ** 2 - 1) < 0.25


def test_a_line_along_an_edge_of_the_mesh_is_no_crack(tmp_path):
    stored(tmp_path, 0)
    edge_m = -(500.5 - CAMERA.centre_px[0]) * AWAY_M / CAMERA.focal_px
    assert main([str(tmp_path), "--mesh", wall(tmp_path / "wall.stl", edge_m)]) == 0
    findings = json.loads((tmp_path / "findings.json").read_text())["findings"]
    assert [each["kind"] for each in findings] == ["rust"]


def test_a_line_along_an_edge_is_no_crack_even_if_the_pose_is_off(tmp_path):
    stored(tmp_path, 0)
    edge_m = -(500.5 + 20.0 - CAMERA.centre_px[0]) * AWAY_M / CAMERA.focal_px  # 20 px: 1.6 deg
    mesh = wall(tmp_path / "wall.stl", edge_m)

    def kinds(**limits):
        return [each.kind for each in find([tmp_path], Path(mesh), FindingParameters(**limits))]

    assert kinds(pose_turned=0.0, pose_off=0.0) == ["crack", "rust"]
    assert kinds(pose_turned=1.6, pose_off=0.0) == ["rust"]


def test_cracks_are_not_looked_for_where_a_pixel_covers_too_much(tmp_path):
    stored(tmp_path, 0)
    mesh = Path(wall(tmp_path / "wall.stl"))
    pixel_mm = 1e3 * AWAY_M / CAMERA.focal_px
    for detail, kinds in ((1.1 * pixel_mm, ["crack", "rust"]), (0.9 * pixel_mm, ["rust"])):
        found = find([tmp_path], mesh, FindingParameters(crack_detail=detail))
        assert [each.kind for each in found] == kinds


@pytest.mark.table("detail_mm", [0.5, 1.0, 2.0])
def test_the_places_of_a_rusted_wall_leave_no_gap_of_a_rusted_edge(detail_mm):
    """Each rusted pixel has a place that is as near as an edge counts as rusted."""
    picture = np.full((1200, 1600, 3), 128, np.uint8)
    picture[100:1100, 200:1400] = (120, 60, 20)
    (rust,) = candidates_in(picture, FindingParameters(), detail_mm=detail_mm)
    assert rust.kind == "rust"
    assert rust.size_px == pytest.approx(1200 * 1000, rel=0.01)
    pixels = np.stack(np.meshgrid(np.arange(200, 1400, 7), np.arange(100, 1100, 7)), -1).reshape(-1, 2)
    apart_mm = detail_mm * cKDTree(rust.pixels).query(pixels)[0]
    assert apart_mm.max() < 1e3 * RUST_M


def to_srgb(light):
    """IEC 61966-2-1, of light 0 to 1."""
    value = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return np.rint(255 * value).astype(np.uint8)


@pytest.mark.table("paint", [(0.45, 0.47, 0.44), (0.15, 0.15, 0.16), (0.5, 0.35, 0.28)])
def test_a_spot_that_fades_into_its_paint_ends_where_rust_covers_half(paint):
    y, x = np.mgrid[-300:300, -400:400]
    share = np.clip(0.5 + (150.0 - np.hypot(x, y)) / 60.0, 0.0, 1.0)[..., None]  # half at 150 px
    light = share * (0.12, 0.03, 0.01) + (1.0 - share) * paint
    (rust,) = candidates_in(to_srgb(light), FindingParameters(), detail_mm=0.5)
    assert rust.size_px == pytest.approx(np.pi * 150.0**2, rel=0.05)


def test_an_empty_folder_is_named(tmp_path, capsys):
    assert main([str(tmp_path), "--mesh", "wall.stl"]) == 1
    assert "there is no photograph" in capsys.readouterr().err


def test_the_marks_of_another_detector_count_in_place_of_ours(tmp_path, capsys):
    stored(tmp_path, 0)
    x, y = np.meshgrid(np.arange(100, 150), np.arange(400, 440))
    marks = [Candidate("blister", np.column_stack((x.ravel(), y.ravel()))[::7], x.size)]
    write_marks(tmp_path / "0.000000.jpg", marks, "/theirs")
    assert main([str(tmp_path), "--mesh", wall(tmp_path / "wall.stl")]) == 0
    assert capsys.readouterr().out.splitlines()[:3] == ["rust: 0", "crack: 0", "blister: 1"]
    (found,) = read_findings(tmp_path / "findings.json")
    pixel_m = AWAY_M / CAMERA.focal_px
    aside, down = (np.array((124.5, 419.5)) - CAMERA.centre_px) * pixel_m
    assert np.allclose(found.position_m, (0.0, -aside, -down), atol=2 * pixel_m)
    assert found.area_m2 == pytest.approx(50 * 40 * pixel_m**2, rel=0.01)  # far from the middle, too
    # When another photograph has got this name, then these are no marks of it
    kept = tmp_path / "0.000000.marks.json"
    kept.write_text(re.sub('"photograph": "[0-9a-f]*"', '"photograph": "0"', kept.read_text()))
    found = find([tmp_path], tmp_path / "wall.stl", FindingParameters())
    assert "blister" not in {each.kind for each in found}
    # When the detector marks nothing, then nothing is there; when its file is damaged, its name is told
    write_marks(tmp_path / "0.000000.jpg", [], "/theirs")
    assert find([tmp_path], tmp_path / "wall.stl", FindingParameters()) == []
    (tmp_path / "0.000000.marks.json").write_text('{"candidates": [{"kind": "rust", "size_px": 3}]}')
    capsys.readouterr()
    assert main([str(tmp_path), "--mesh", str(tmp_path / "wall.stl")]) == 1
    told = capsys.readouterr().err
    assert "0.000000.marks.json, line 1: entry 1 of candidates lacks the key 'pixels'" in told
    assert told.count("\n") == 1


def test_a_nearer_photograph_decides_whether_a_crack_is_one(tmp_path):
    """The far photograph shows two lines, the near one only the right one."""
    mesh = Path(wall(tmp_path / "wall.stl"))
    turn = tuple(Rotation.from_matrix(optical_axes(0.0, 0.0)).as_quat())
    rows, scale = slice(250, 350), 4
    for name, place_m, columns in (("far", AWAY_M, (360, 440)), ("near", AWAY_M / scale, (None, 440))):
        picture = np.full((600, 800, 3), 150, np.uint8)
        for column in columns:
            if column is not None and name == "far":
                picture[rows, column : column + 2] = 70
            elif column is not None:
                at = scale * (column - 400) + 400
                picture[100:500, at : at + 5] = 70
        record = PhotographRecord(0.0, (-place_m, 0.0, 0.0), turn, 0.002, 100.0, 100.0)
        PhotographFolder(tmp_path / name, CAMERA).save(picture, record)
    parameters = FindingParameters(pose_turned=0.1, pose_off=0.0)
    both = find([tmp_path / "far"], mesh, parameters)
    assert sorted(each.position_m[1] > 0.0 for each in both) == [False, True]
    (kept,) = find([tmp_path / "far", tmp_path / "near"], mesh, parameters)
    assert kept.position_m[1] < 0.0  # to the right, seen along x
    assert kept.photographs == ("../near/0.000000.jpg", "0.000000.jpg")
    ahead_mm = 1e3 * AWAY_M / scale / CAMERA.focal_px
    assert ahead_mm < kept.detail_mm < 1.1 * ahead_mm  # aside it is farther, and flat


def test_a_plan_of_nearer_photographs_is_written(tmp_path, capsys):
    store = PhotographFolder(tmp_path / "shots", CAMERA)
    turn = tuple(Rotation.from_matrix(optical_axes(0.0, 0.0)).as_quat())
    place_m = (0.8, 0.0, 1.5)
    store.save(wall_picture(), PhotographRecord(0.0, place_m, turn, 0.002, 100.0, 100.0))
    room = trimesh.creation.box((3.0, 4.0, 3.0))
    room.apply_translation((0.0, 0.0, 1.5))  # the wall is x = 1.5, 0.7 m away
    room.export(tmp_path / "room.stl")
    view = PlannedView(View(place_m, 0.0, 0.0))
    asked = SurveyParameters(voxel=0.2, radius=0.2)
    plan = SurveyPlan("", (0.0, 0.0, 1.5), CAMERA, asked, FlightParameters(), (Flight((view,), 9.0, 1.0),))
    write_plan(tmp_path / "plan.yaml", plan)
    given = [str(tmp_path / "shots"), "--mesh", str(tmp_path / "room.stl")]
    assert main([*given, "--plan", str(tmp_path / "plan.yaml")]) == 1  # it would touch the wall
    assert "None of 1 places" in capsys.readouterr().err
    finer = replace(plan, camera=SurveyCamera(4000, 3000, 60.0))
    write_plan(tmp_path / "plan.yaml", finer)
    assert main([*given, "--plan", str(tmp_path / "plan.yaml")]) == 0
    (near,) = read_plan(tmp_path / "shots" / "closer.yaml").views
    aside_m = (500.5 - CAMERA.centre_px[0]) * 0.7 / CAMERA.focal_px
    assert abs(near.place_m[1] + aside_m) < 0.2
    steep_m = 3e-4 * finer.camera.focal_px  # the distance, seen squarely
    assert 0.5 * steep_m < 1.5 - near.place_m[0] <= steep_m + 0.01
