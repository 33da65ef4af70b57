"""Given photographs whose poses nobody knows, what they show is marked on the pictures, and placed later."""

import json

import numpy as np
import pytest
import trimesh
from drawn_wall import AWAY_M, CAMERA, wall_picture
from page_words import words
from PIL import Image

from inspection.findings.command import main
from inspection.photograph_poses.command import main as place
from inspection.report.command import main as report


def test_photographs_without_poses_are_searched_and_placed_later(tmp_path, capsys):
    path = tmp_path / "IMG_0007.JPG"
    Image.fromarray(mottled(wall_picture())).save(path, quality=95, exif=equivalent_focal_length())
    assert main([str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "searched: 1 of 1" in said.out
    assert "Photographs without a pose: 1." in said.err
    content = json.loads((tmp_path / "findings.json").read_text())
    assert content["findings"] == content["left_out"] == []
    (marked,) = content["without_pose"]
    boxes = {each["kind"]: each["box_px"] for each in marked["marks"]}
    assert sorted(boxes) == ["crack", "rust"]
    for kind, (x, y) in (("crack", (500.5, 299.5)), ("rust", (199.5, 299.5))):
        left, top, right, bottom = boxes[kind]
        assert left - 1 <= x <= right + 1
        assert top - 1 <= y <= bottom + 1
    assert report([str(tmp_path)]) == 0
    page = (tmp_path / "report.html").read_text()
    assert "Photographs without a pose" in page
    assert 'href="./IMG_0007.JPG"' in page
    assert "1 x possible crack, 1 x rust" in page
    wall = trimesh.creation.box((1.0, 4.0, 4.0))
    wall.apply_translation((0.5, 0.0, 0.0))
    wall.export(tmp_path / "wall.stl")
    (tmp_path / "poses.csv").write_text(f"name,x,y,z,yaw_deg,tilt_deg\nIMG_0007,{-AWAY_M},0,0,0,0\n")
    assert place([str(tmp_path), "--table", str(tmp_path / "poses.csv")], None) == 0
    assert main([str(tmp_path), "--mesh", str(tmp_path / "wall.stl")]) == 0
    content = json.loads((tmp_path / "findings.json").read_text())
    assert sorted(each["kind"] for each in content["findings"]) == ["crack", "rust"]
    assert "without_pose" not in content
    assert report([str(tmp_path), "--mesh", str(tmp_path / "wall.stl")]) == 0
    text = words(tmp_path / "report.html")
    assert "Photographs 1 with position" in text
    assert "Light in the middle of a photograph not given Blur by motion, greatest not given" in text


def test_what_cannot_be_read_is_named_also_without_poses(tmp_path, capsys):
    Image.fromarray(wall_picture()).save(tmp_path / "1.jpg")
    (tmp_path / "IMG_2.HEIC").write_bytes(b"\0\0\0\x18ftypheic")
    (tmp_path / "3.gif").write_bytes(b"GIF89a")
    (tmp_path / "4.json").write_text(json.dumps({"position_m": [0, 0, 0]}))
    assert main([str(tmp_path)]) == 0
    said = capsys.readouterr()
    assert "searched: 1 of 4" in said.out
    assert all(f"left out: {name}: " in said.err for name in ("IMG_2.HEIC", "3.gif", "4.json"))


def test_a_phones_picture_is_searched_upright(tmp_path):
    upright, turned = (tmp_path / name for name in ("1.png", "2.png"))
    picture = mottled(wall_picture())
    Image.fromarray(picture).save(upright)
    exif = Image.Exif()
    exif[0x0112] = 6  # to be turned clockwise, as it is stored turned counter-clockwise
    Image.fromarray(np.ascontiguousarray(np.rot90(picture))).save(turned, exif=exif)
    assert main([str(tmp_path)]) == 0
    one, other = json.loads((tmp_path / "findings.json").read_text())["without_pose"]
    assert one["marks"]
    assert one["marks"] == other["marks"]


def test_a_photograph_of_any_name_is_linked(tmp_path):
    name = "Süd #1 50%.jpg"
    Image.fromarray(mottled(wall_picture())).save(tmp_path / name)
    assert main([str(tmp_path)]) == 0
    assert report([str(tmp_path)]) == 0
    assert 'href="./S%C3%BCd%20%231%2050%25.jpg"' in (tmp_path / "report.html").read_text()


@pytest.mark.table("encoding", ["utf-8-sig", "utf-16", "cp1252"])
def test_findings_that_an_editor_has_stored_otherwise_are_in_the_report(tmp_path, capsys, encoding):
    Image.fromarray(mottled(wall_picture())).save(tmp_path / "1.jpg")
    assert main([str(tmp_path)]) == 0
    found = tmp_path / "findings.json"
    found.write_bytes(found.read_text().replace("1.jpg", "Süd.jpg").encode(encoding))
    capsys.readouterr()
    assert report([str(tmp_path)]) == 0
    assert "Süd.jpg" in words(tmp_path / "report.html")
    assert not capsys.readouterr().err


def test_findings_that_cannot_be_read_are_named_by_the_command(tmp_path, capsys):
    Image.fromarray(mottled(wall_picture())).save(tmp_path / "1.jpg")
    (tmp_path / "1.json").write_text(json.dumps({"position_m": [0, 0, 0], "orientation_xyzw": [0, 0, 0, 1]}))
    (tmp_path / "findings.json").write_text('{"findings": [')
    assert report([str(tmp_path)]) == 0
    assert "findings.json cannot be read" in capsys.readouterr().err
    assert "is not JSON" in words(tmp_path / "report.html")


def mottled(picture):
    """The same picture, with dark and light pixels in its rust, which is brown."""
    light = np.exp(np.random.default_rng(2).normal(0.0, 0.2, picture.shape[:2]))
    brown = picture[..., 0] > 1.6 * picture[..., 2]
    return np.where(brown[..., None], np.clip(picture * light[..., None], 0, 255), picture).astype(np.uint8)


def equivalent_focal_length():
    """For a field of view of the drawn camera, as phones tell it."""
    exif = Image.Exif()
    diagonal_px = (CAMERA.width**2 + CAMERA.height**2) ** 0.5
    exif.get_ifd(0x8769)[0xA405] = round(CAMERA.focal_px * 43.2666 / diagonal_px)
    return exif


def test_photographs_with_poses_still_need_the_surface(tmp_path, capsys):
    Image.fromarray(wall_picture()).save(tmp_path / "a.jpg")
    (tmp_path / "poses.csv").write_text("name,x,y,z,yaw_deg,tilt_deg\na,0,0,0,0,0\n")
    Image.fromarray(wall_picture()).save(tmp_path / "a.jpg", exif=equivalent_focal_length())
    assert place([str(tmp_path), "--table", str(tmp_path / "poses.csv")], None) == 0
    assert main([str(tmp_path)]) == 1
    assert "Give the surface: --mesh FILE" in capsys.readouterr().err
