"""Given pictures of a wall whose marks are known, rust and cracks are found in their places."""

import json

import numpy as np
import trimesh
from scipy.spatial.transform import Rotation

from inspection_tools.findings.command import main
from inspection_tools.photographs.folder import PhotographFolder, PhotographRecord
from inspection_tools.survey.camera import SurveyCamera, optical_axes

CAMERA = SurveyCamera(800, 600, 60.0)
AWAY_M = 0.7  # 1 mm per pixel


def wall_picture(shift_px=0):
    """A grey wall in front: rust of 40 px, a dark line of 2 x 200 px, a step between two tones."""
    picture = np.full((600, 800, 3), 150, np.uint8)
    picture[:, 700:] = 90
    picture[280:320, 180 - shift_px : 220 - shift_px] = (110, 60, 30)
    picture[200:400, 500 - shift_px : 502 - shift_px] = 70
    noise = np.random.default_rng(1).normal(0.0, 2.0, picture.shape)
    return np.clip(picture + noise, 0, 255).astype(np.uint8)


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


def test_an_empty_folder_is_named(tmp_path, capsys):
    assert main([str(tmp_path), "--mesh", "wall.stl"]) == 1
    assert "there is no photograph" in capsys.readouterr().err
