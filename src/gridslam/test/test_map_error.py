"""Map error in closed form: a square room drawn into a grid, shifted, turned, half of it missing."""

import json
import math

import numpy as np
import pytest

from gridslam.errors import EvaluationError
from gridslam.evaluation import WallPoints, Walls, draw_map_error, map_error, read_walls
from gridslam.evaluation.command import main
from gridslam.map_file import write_map
from gridslam.occupancy_grid import OccupancyGrid

ROOM = Walls.from_polygons([np.array([(0.0, 0.0), (8.0, 0.0), (8.0, 6.0), (0.0, 6.0)])])
CELL = 0.05


def grid_of(points, origin=(-1.025, -1.025), size=(240, 240)):
    """A grid with these points' cells occupied; cell centres fall on multiples of 0.05 m."""
    cells = np.full(size, -1, dtype=np.int8)
    column, row = np.floor((points - np.array(origin)) / CELL + 1e-9).astype(int).T
    cells[row, column] = 100
    return OccupancyGrid(cells, CELL, origin)


def wall_points(walls=ROOM):
    return walls.samples(0.01)[0]


def test_perfect_map_has_no_error_and_saw_everything():
    accuracy = map_error(grid_of(wall_points()), ROOM)
    assert accuracy.mean_m == pytest.approx(0.0, abs=1e-6)
    assert accuracy.seen_share == pytest.approx(1.0)
    assert [fit.cells for fit in accuracy.walls] == pytest.approx([161, 161, 121, 121], abs=2)
    assert accuracy.straightness_rms_m == pytest.approx(0.0, abs=1e-6)


def test_shift_normal_to_the_walls_is_the_error():
    # Given only the lower wall, drawn 0.2 m too high, between x = 1 and 7
    points = np.column_stack([np.arange(1.0, 7.001, CELL), np.full(121, 0.2)])
    accuracy = map_error(grid_of(points), ROOM)
    assert accuracy.mean_m == pytest.approx(0.2)
    assert accuracy.p95_m == pytest.approx(0.2)
    assert accuracy.seen_share == 0.0  # nothing within 0.15 m
    assert accuracy.walls[0].offset_m == pytest.approx(0.2)
    assert accuracy.straightness_rms_m == pytest.approx(0.0, abs=1e-9)  # straight it is


def test_share_of_wall_seen():
    seen = wall_points()[
        wall_points()[:, 1] == 0.0
    ]  # the lower wall: 8 of 28 m, and 0.1 m round both corners
    share = map_error(grid_of(seen), ROOM, seen_within_m=0.1).seen_share
    assert share == pytest.approx((8.0 + 2 * 0.1) / 28.0, abs=2 * CELL / 28.0)


def test_turned_wall_is_straight_but_turned():
    # Given the lower wall turned by 0.02 rad about its middle: cell centres spread evenly within half a cell
    along = np.arange(-4.0, 4.0, 0.01)
    points = np.column_stack([4.0 + along, 0.02 * along])
    wall = map_error(grid_of(points), ROOM).walls[0]
    assert wall.turned_rad == pytest.approx(0.02, abs=0.002)
    assert wall.straightness_rms_m == pytest.approx(CELL / math.sqrt(12.0), rel=0.15)


def test_pose_of_the_map_in_the_world_counts():
    # Given a room seen from a map frame that stands at (2, 1), turned by 90 degrees
    x, y = wall_points().T
    accuracy = map_error(
        grid_of(np.column_stack([y - 1.0, 2.0 - x]), (-7.025, -7.025), (400, 400)),
        ROOM,
        (2.0, 1.0, math.pi / 2),
    )
    assert accuracy.max_m == pytest.approx(0.0, abs=1e-6)


def test_wall_broken_by_beams_is_one_wall():
    """The pieces between the beams lie on one line; so do the beams' faces."""
    corners = [
        (0, 0),
        (2, 0),
        (2, 0.5),
        (3, 0.5),
        (3, 0),
        (5, 0),
        (5, 0.5),
        (6, 0.5),
        (6, 0),
        (8, 0),
        (8, 6),
        (0, 6),
    ]
    walls = Walls.from_polygons([np.array(corners, dtype=float)])
    assert sorted(len(wall) for wall in walls.straight_walls()) == [1, 1, 1, 1, 1, 1, 1, 2, 3]
    longest = map_error(grid_of(wall_points(walls)), walls).walls
    assert {fit.ends_m for fit in longest} >= {(0.0, 0.0, 8.0, 0.0), (2.0, 0.5, 6.0, 0.5)}


def test_distance_of_segments_equals_that_of_dense_points():
    rng = np.random.default_rng(0)
    walls = Walls(rng.uniform(-5.0, 5.0, (7, 4)))
    points = rng.uniform(-6.0, 6.0, (300, 2))
    dense = WallPoints(walls.samples(0.002)[0], 0.002)
    assert np.abs(walls.distances(points)[0] - dense.distances(points)[0]).max() < 0.0011


def test_map_without_occupied_cells_is_refused_with_a_sentence():
    with pytest.raises(EvaluationError, match="no occupied cell"):
        map_error(OccupancyGrid(np.zeros((4, 4), dtype=np.int8), CELL, (0.0, 0.0)), ROOM)


def test_walls_from_files(tmp_path):
    segments, points, bad = (tmp_path / name for name in ("segments.csv", "points.txt", "bad.txt"))
    segments.write_text("# x1, y1, x2, y2\n0, 0, 8, 0\n8, 0, 8, 6\n")
    points.write_text("0 0\n0.1 0\n0.2 0\n")
    bad.write_text("1 2 3\n")
    assert read_walls(segments).ends_m.shape == (2, 4)
    assert read_walls(points).spacing_m == pytest.approx(0.1)
    with pytest.raises(EvaluationError, match="has 3 numbers; each line must hold 4"):
        read_walls(bad)


def test_walls_of_a_results_folder_are_read_with_their_heading(tmp_path):
    (tmp_path / "walls.csv").write_text("x1_m,y1_m,x2_m,y2_m\n0,0,8,0\n8,0,8,6\n")
    assert read_walls(tmp_path / "walls.csv").lengths_m.tolist() == [8.0, 6.0]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "is empty"),
        ('<?xml version="1.0"?>\n<sdf version="1.6"/>\n', "'<\\?xml' is no finite number"),
        ("0 0 8 0\n1 1\n", "line 2: has 2 numbers"),
        ("0 0 8 inf\n", "'inf' is no finite number"),
        ("3 4 3 4\n", "walls.txt: Every wall segment has length 0"),
    ],
)
@pytest.mark.filterwarnings("error")
def test_bad_wall_files_are_refused_with_a_sentence(tmp_path, text, sentence):
    (tmp_path / "walls.txt").write_text(text)
    with pytest.raises(EvaluationError, match=sentence):
        read_walls(tmp_path / "walls.txt")


def test_a_wall_point_given_twice_counts_once(tmp_path):
    (tmp_path / "walls.txt").write_text("0 0\n0 0\n0.1 0\n0.1 0\n0.2 0\n")
    walls = read_walls(tmp_path / "walls.txt")
    assert (len(walls.points_xy_m), walls.spacing_m) == (3, pytest.approx(0.1))


def test_command_judges_a_map_from_files(tmp_path, capsys):
    write_map(tmp_path / "room", grid_of(wall_points()))
    np.savetxt(tmp_path / "walls.txt", ROOM.ends_m)
    figures, picture = tmp_path / "figures.json", tmp_path / "map.png"
    files = [str(tmp_path / "room.yaml"), str(tmp_path / "walls.txt")]
    assert main(["map", *files, "--json", str(figures), "--picture", str(picture)]) == 0
    assert "map_error_mean_m" in capsys.readouterr().out
    assert json.loads(figures.read_text())["wall_seen_share"] == pytest.approx(1.0)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize(
    ("extra", "sentence"),
    [
        (["--json", "{tmp}/none/figures.json"], "there is no folder"),
        (["--picture", "{tmp}/none/map.png"], "there is no folder"),
        (["--picture", "{tmp}"], "it is a folder"),
        (["--estimate", "{tmp}/path.tum"], "--picture"),
        (["--picture", "{tmp}/map.png", "--truth", "{tmp}/none.tum"], "none.tum: cannot be read"),
    ],
)
def test_command_refuses_before_it_begins_to_judge(tmp_path, capsys, monkeypatch, extra, sentence):
    write_map(tmp_path / "room", grid_of(wall_points()))
    np.savetxt(tmp_path / "walls.txt", ROOM.ends_m)
    monkeypatch.setattr("gridslam.evaluation.command.map_error", lambda *_: pytest.fail("it has begun"))
    files = [str(tmp_path / "room.yaml"), str(tmp_path / "walls.txt")]
    assert main(["map", *files, *(word.format(tmp=tmp_path) for word in extra)]) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1


def test_picture_is_a_png_whatever_its_name(tmp_path):
    grid = grid_of(wall_points())
    draw_map_error(tmp_path / "map.error", grid, ROOM, map_error(grid, ROOM))
    assert (tmp_path / "map.error").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("command", [["ate", "no.tum", "no.tum"], ["relations", "no.tum", "no.gz"]])
def test_command_says_what_is_missing_in_one_sentence(command, capsys):
    assert main(command) == 1
    said = capsys.readouterr().err
    assert "no.tum" in said
    assert said.count("\n") == 1
