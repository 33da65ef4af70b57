"""Given drawn light, only a long, thin, dark line with the same surface on both sides may be a crack."""

import numpy as np
import pytest

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in
from inspection.findings.picture.cracks import is_thin
from inspection.findings.picture.lines import line_through, pieces_joined
from inspection.survey.surface.mesh_file import Mesh

PARAMETERS = FindingParameters()
ROW = np.array([(x, 50) for x in range(20, 180)])


def drawn(above=1.0, line=0.6, below=1.0, rows=(50,)):
    light = np.full((100, 200), above, np.float32)
    light[50:] = below
    light[list(rows)] = line
    return light


def test_depth_and_width_are_those_drawn():
    line = line_through(ROW, drawn())
    assert line.depth == pytest.approx(0.4, abs=1e-5)
    assert (line.length_px, line.width_px, line.unlike, line.filled) == (159.0, 1.0, 0.0, 1.0)
    assert is_thin(line, PARAMETERS)


@pytest.mark.table(
    "light",
    [
        drawn(line=1.0),  # nothing
        drawn(above=1.0, line=0.5, below=0.5),  # a step
        drawn(above=1.0, line=0.4, below=0.6),  # a dark line on a step
        drawn(rows=range(46, 54)),  # a band
        np.where((np.arange(100) // 5 == 11)[:, None], 1.4, drawn(rows=range(48, 53))).astype(
            np.float32
        ),  # a weld
        np.where(np.arange(200) < 90, drawn(), 1.0).astype(np.float32),  # half of the line
    ],
)
def test_no_thin_dark_line(light):
    assert not is_thin(line_through(ROW, light), PARAMETERS)


def toe(unlike, bent_px):
    """A line of the depth 0.3 between two surfaces, one of which is brighter by a multiple of that depth."""
    y, x = np.mgrid[:100, :200]
    off = y - 50.0 - bent_px * np.sin(2.0 * np.pi * x / 200.0)
    light = np.where(off > 0.0, 1.0 + 0.3 * unlike, 1.0) - 0.3 * np.exp(-0.5 * (off / 1.5) ** 2)
    return line_through(
        np.argwhere(np.abs(off[:, 20:180]) < 1.0)[:, ::-1] + (20, 0), light.astype(np.float32)
    )


@pytest.mark.table(("unlike", "bent_px", "is_crack"), [(0.4, 0, False), (0.4, 4, True), (0.1, 0, True)])
def test_the_toe_of_a_weld_is_straight_between_two_surfaces(unlike, bent_px, is_crack):
    assert is_thin(toe(unlike, bent_px), PARAMETERS) is is_crack


def test_pieces_that_go_on_in_each_other_are_one():
    first, second, beside = ROW[:60], ROW[80:], ROW[80:] + np.array((0, 25))
    joined = pieces_joined([first, second, beside])
    assert sorted(len(each) for each in joined) == [80, 140]


def test_noise_in_the_dark_and_steps_are_none():
    rng = np.random.default_rng(5)
    picture = np.full((400, 400, 3), 120.0)
    picture[:, 200:] = 25.0
    noise = rng.normal(0.0, 1.0, picture.shape) * np.where(np.arange(400) < 200, 3.0, 9.0)[:, None]
    shot = np.clip(picture + noise, 0, 255).astype(np.uint8)
    assert candidates_in(shot, PARAMETERS) == []
    shot[100:300, 100:102] = 60
    (found,) = candidates_in(shot, PARAMETERS)
    assert found.kind == "crack"
    assert np.ptp(found.pixels[:, 1]) == pytest.approx(200.0, abs=10.0)


def test_noisy_yellow_paint_is_no_rust():
    rng = np.random.default_rng(5)
    yellow = np.full((200, 200, 3), (98.0, 82.0, 20.0))
    shot = np.clip(yellow + rng.normal(0.0, 12.0, yellow.shape), 0, 255).astype(np.uint8)
    assert candidates_in(shot, PARAMETERS) == []
    shot[80:110, 80:110] = (110, 60, 30)
    assert [each.kind for each in candidates_in(shot, PARAMETERS)] == ["rust"]


@pytest.mark.table(("width", "detail_mm", "count"), [(2, 0.3, 1), (9, 0.3, 1), (9, 1.0, 0)])
def test_a_wide_crack_is_found_in_a_fine_photograph(width, detail_mm, count):
    """9 px are 2.7 mm at 0.3 mm per pixel: a crack; at 1 mm per pixel they are a band."""
    shot = np.full((600, 400, 3), 150.0)
    shot[100:500, 200 : 200 + width] = 60.0
    shot += np.random.default_rng(2).normal(0.0, 2.0, shot.shape)
    found = candidates_in(np.clip(shot, 0, 255).astype(np.uint8), PARAMETERS, None, detail_mm)
    assert {each.kind for each in found} <= {"crack"}
    assert bool(found) == bool(count)
    for each in found:
        assert np.abs(each.pixels[:, 0] - (199.5 + 0.5 * width)).max() < 3.0


@pytest.mark.table(("bend_px", "count"), [(0.0, 0), (0.3, 0), (4.0, 1)])
def test_on_the_mesh_of_a_map_straight_lines_are_edges(bend_px, count):
    """The mesh of a map does not show every edge of the structure. 0.003 of 400 px are 1.2 px."""
    triangle = np.array([[(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)]])
    drawn, mapped = (Mesh(triangle, (name,), np.zeros(1, int)) for name in ("shell", "mapped_plating"))
    shot, rows = np.full((600, 400, 3), 150.0), np.arange(100, 500)
    columns = np.round(200.0 + bend_px * np.sin(rows / 60.0)).astype(int)
    shot[rows, columns] = shot[rows, columns + 1] = 60.0
    shot += np.random.default_rng(3).normal(0.0, 2.0, shot.shape)
    picture = np.clip(shot, 0, 255).astype(np.uint8)
    assert len(candidates_in(picture, FindingParameters().for_mesh(mapped))) == count
    assert len(candidates_in(picture, FindingParameters().for_mesh(drawn))) == 1
