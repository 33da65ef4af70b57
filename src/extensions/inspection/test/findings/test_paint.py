"""Given coatings as red as rust: intact they are none, rust on them is found, and what is unsure is said."""

import json
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from inspection.findings.command import main
from inspection.findings.findings_file import read_search
from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.paint import RED

PAINTS = {"3009": (109, 52, 45), "3016": (161, 35, 18), "8012": (102, 51, 43), "2004": (231, 91, 18)}
RUST, GREY = (150, 70, 35), (150, 152, 150)
FOCAL_PX, AWAY_M = 300.0, 0.5
"""A pixel covers 1.67 mm; a picture of 400 x 300 px 0.333 m2."""


def painted(colour, spots=(), spot=RUST, seed=1, noise=4.0):
    """A picture of 400 x 300 px of a coating with round spots (x, y, radius in px)."""
    rng = np.random.default_rng(seed)
    picture = (
        np.array(colour, float) + rng.normal(0.0, noise, (300, 400, 1)) + rng.normal(0.0, 1.0, (300, 400, 3))
    )
    y, x = np.mgrid[0:300, 0:400]
    for middle_x, middle_y, radius in spots:
        inside = np.hypot(x - middle_x, y - middle_y) < radius
        picture[inside] = np.array(spot) + rng.normal(0.0, 6.0, (int(inside.sum()), 3))
    return np.clip(picture, 0, 255).astype(np.uint8)


def rust_px(found):
    return sum(each.size_px for each in found if each.kind == "rust")


@pytest.mark.table("paint", PAINTS.values())
def test_an_intact_red_coating_is_no_rust_and_rust_on_it_is(paint):
    assert rust_px(candidates_in(painted(paint), FindingParameters(), detail_mm=1.67)) == 0
    found = candidates_in(painted(paint, [(200, 150, 30)]), FindingParameters(), detail_mm=1.67)
    assert rust_px(found) == pytest.approx(np.pi * 30**2, rel=0.2)


@pytest.mark.table("paint", PAINTS.values())
def test_a_coating_that_is_given_is_no_rust_wherever_it_is(paint):
    """A red band beside grey, with rust on the grey."""
    picture = painted(GREY, [(300, 150, 30)])
    picture[:, :150] = painted(paint)[:, :150]
    found = candidates_in(picture, FindingParameters(coatings=(paint,)), detail_mm=1.67)
    assert rust_px(found) == pytest.approx(np.pi * 30**2, rel=0.1)


def test_a_wall_that_is_rust_in_most_places_stays_rust():
    spots = [(x, y, 26) for x in range(0, 420, 50) for y in range(0, 320, 50)]
    found = candidates_in(painted(GREY, spots), FindingParameters(), detail_mm=1.67)
    assert {each.kind for each in found} == {"rust"}
    assert rust_px(found) > 0.7 * 400 * 300


def folder_of(folder, *pictures):
    """Photographs of a wall."""
    folder.mkdir()
    for number, picture in enumerate(pictures):
        Image.fromarray(picture).save(folder / f"{number}.png")
        pose = {"position_m": [0.0, 1.0 * number, 0.0], "orientation_xyzw": [-0.5, 0.5, -0.5, 0.5]}
        (folder / f"{number}.json").write_text(json.dumps(pose))
    matrix = {"data": [FOCAL_PX, 0.0, 199.5, 0.0, FOCAL_PX, 149.5, 0.0, 0.0, 1.0]}
    calibration = {"image_width": 400, "image_height": 300, "camera_matrix": matrix}
    (folder / "calibration.yaml").write_text(json.dumps(calibration))
    corners = np.array(((AWAY_M, -9.0, -9.0), (AWAY_M, 9.0, -9.0), (AWAY_M, 0.0, 19.0)))
    trimesh.Trimesh(corners, [[0, 1, 2]]).export(folder / "wall.stl")
    return [str(folder), "--mesh", str(folder / "wall.stl")]


def rust_m2(given):
    return sum(
        each.area_m2 for each in read_search(Path(given[0]) / "findings.json").findings if each.kind == "rust"
    )


def test_a_space_that_is_all_red_has_a_red_coating_and_the_command_says_what_it_cannot_tell(tmp_path, capsys):
    given = folder_of(tmp_path / "a", painted(PAINTS["3009"]), painted(PAINTS["3009"], [(200, 150, 30)]))
    assert main(given) == 0
    assert rust_m2(given) == pytest.approx(np.pi * (30 * AWAY_M / FOCAL_PX) ** 2, rel=0.2)
    assert read_search(tmp_path / "a/findings.json").red == ("0.png", "1.png")
    assert "cannot be told from the coating" in capsys.readouterr().err
    # With its colour given nothing is unsure
    assert main([*given, "--coating", "109,52,45"]) == 0
    assert read_search(tmp_path / "a/findings.json").red == ()
    assert "coating" not in capsys.readouterr().err


def test_one_red_wall_in_a_grey_space_is_rust(tmp_path, capsys):
    given = folder_of(tmp_path / "a", painted(RUST, noise=6.0), painted(GREY), painted(GREY, seed=2))
    assert main(given) == 0
    assert rust_m2(given) == pytest.approx(400 * 300 * (AWAY_M / FOCAL_PX) ** 2, rel=0.05)
    assert capsys.readouterr().err == ""


@pytest.mark.table("colour", ["red", "1,2", "1,2,3,4", "1,2,256", "-1,2,3"])
def test_a_colour_that_makes_no_sense_is_refused(tmp_path, colour, capsys):
    given = folder_of(tmp_path / "a", painted(GREY))
    try:
        code = main([*given, f"--coating={colour}"])
    except SystemExit as ended:
        code = ended.code
    assert code
    assert "oating" in capsys.readouterr().err


def test_what_one_photograph_cannot_tell_is_marked_so():
    kinds = {
        each.kind for each in candidates_in(painted(PAINTS["3009"]), FindingParameters(), detail_mm=1.67)
    }
    assert kinds == {RED}
