"""Map error in closed form: a square room drawn into a grid, shifted, turned, half of it missing."""

import json
import math

import numpy as np
import pytest

from gridslam import se2
from gridslam.errors import EvaluationError
from gridslam.evaluation import WallPoints, Walls, map_error, read_walls
from gridslam.evaluation.command import main
from gridslam.evaluation.map_picture import shades
from gridslam.files.map_file import write_map
from gridslam.occupancy_grid import OccupancyGrid

BEAMS = [(2, 0), (2, 0.5), (3, 0.5), (3, 0), (5, 0), (5, 0.5), (6, 0.5), (6, 0)]
ROOM_WITH_BEAMS = Walls.from_polygons([np.array([(0, 0), *BEAMS, (8, 0), (8, 6), (0, 6)], dtype=float)])
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
    assert sorted(len(wall) for wall in ROOM_WITH_BEAMS.straight_walls()) == [1, 1, 1, 1, 1, 1, 1, 2, 3]
    longest = map_error(grid_of(wall_points(ROOM_WITH_BEAMS)), ROOM_WITH_BEAMS).walls
    assert {fit.ends_m for fit in longest} >= {(0.0, 0.0, 8.0, 0.0), (2.0, 0.5, 6.0, 0.5)}


def test_walls_on_one_line_on_opposite_sides_of_a_room_are_two():
    walls = Walls(np.array([(0.0, 0.0, 1.0, 0.0), (4.0, 0.0, 3.9, 0.0), (7.5, 0.0, 7.0, 0.0)]))
    # Gaps of 2.9 and 3 m; then one of 3.1 m
    assert [wall.tolist() for wall in walls.straight_walls()] == [[0, 1, 2]]
    apart = Walls(np.vstack([walls.ends_m, [(11.0, 0.0, 10.6, 0.0)]]))
    assert [wall.tolist() for wall in apart.straight_walls()] == [[0, 1, 2], [3]]


@pytest.mark.table("walls", [ROOM, ROOM_WITH_BEAMS])
@pytest.mark.table("shift", [(0.1, 0.1), (0.2, -0.1), (-0.2, 0.2)])
def test_displaced_map_has_straight_walls_that_are_not_turned(walls, shift):
    """Straightness is the wall's own: cells at its displaced ends are not taken for those of another."""
    accuracy = map_error(grid_of(wall_points(walls) + np.array(shift)), walls)
    assert accuracy.straightness_rms_m == pytest.approx(0.0, abs=1e-6)
    assert accuracy.as_dict()["wall_turned_max_rad"] == pytest.approx(0.0, abs=1e-6)
    assert {round(fit.offset_m, 6) for fit in accuracy.walls} <= {abs(part) for part in shift}


def test_turned_map_has_straight_walls_as_far_as_cells_allow():
    # Given a room turned by 0.02 rad: cells spread evenly over one cell's width about their line
    turned = se2.transform((0.0, 0.0, 0.02), wall_points())
    accuracy = map_error(grid_of(turned), ROOM)
    assert accuracy.straightness_rms_m == pytest.approx(CELL / math.sqrt(12.0), rel=0.1)
    assert [fit.turned_rad for fit in accuracy.walls] == pytest.approx([0.02] * 4, abs=0.002)


def test_bent_wall_deviates_as_its_bow_does():
    # Given the lower wall as a parabola, 0.3 m high in its middle: its RMS deviation is 2 / sqrt(45) of that
    x = np.arange(0.0, 8.0, 0.01)
    bow = np.column_stack([x, 0.3 * (1.0 - (x / 4.0 - 1.0) ** 2)])
    wall = map_error(grid_of(bow), Walls(np.array([(0.0, 0.0, 8.0, 0.0)]))).walls[0]
    assert wall.straightness_rms_m == pytest.approx(
        math.hypot(0.3 * 2.0 / math.sqrt(45.0), CELL / math.sqrt(12.0)), rel=0.03
    )
    assert wall.turned_rad == pytest.approx(0.0, abs=0.002)
    assert wall.offset_m == pytest.approx(0.2, abs=0.01)  # two thirds of the bow's height


def test_smeared_wall_deviates_as_its_width_does():
    # Given the lower wall drawn five cells wide: offsets -2..2 cells, whose mean square is 2
    x, offset = np.meshgrid(np.arange(0.0, 8.001, CELL), CELL * np.arange(-2, 3))
    smear = np.column_stack([x.ravel(), offset.ravel()])
    accuracy = map_error(grid_of(smear), Walls(np.array([(0.0, 0.0, 8.0, 0.0)])))
    assert accuracy.straightness_rms_m == pytest.approx(CELL * math.sqrt(2.0), rel=0.01)
    assert accuracy.mean_m == pytest.approx(CELL * 6.0 / 5.0)
    assert accuracy.p95_m == pytest.approx(2.0 * CELL)


def test_mean_and_95_percent_of_errors_that_grow_evenly():
    # Given a wall drawn with a slope of 0.05 over 8 m: errors spread evenly from 0 to 0.4 m
    x = np.arange(0.0, 8.0, 0.01)
    accuracy = map_error(
        grid_of(np.column_stack([x, 0.05 * x])), Walls(np.array([(0.0, 0.0, 8.0, 0.0)])), seen_within_m=0.17
    )
    assert accuracy.mean_m == pytest.approx(0.2, abs=0.005)
    assert accuracy.p95_m == pytest.approx(0.38, abs=CELL / 2)
    assert accuracy.max_m == pytest.approx(0.4, abs=1e-6)
    assert accuracy.seen_share == pytest.approx(3.5 / 8.0, abs=0.015)  # there cells rise from 0.15 to 0.2 m


def test_a_wall_of_which_the_map_has_a_corner_only_is_not_judged():
    stub = np.column_stack([np.arange(0.0, 0.601, CELL), np.zeros(13)])
    accuracy = map_error(grid_of(stub), ROOM)
    assert accuracy.walls == ()
    assert math.isnan(accuracy.straightness_rms_m)


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


@pytest.mark.table(
    ("text", "sentence"),
    [
        ("", "is empty"),
        ('<?xml version="1.0"?>\n<sdf version="1.6"/>\n', "'<\\?xml' is not a finite number"),
        ("0 0 8 0\n1 1\n", "line 2: has 2 numbers"),
        ("0 0 8 inf\n", "'inf' is not a finite number"),
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


def test_no_wall_vanishes_between_the_pixels_of_a_picture():
    # Given a map of 0.05 m cells, 10 m high, with a wall one cell wide in some row, and pixels of 0.12 m
    for row in range(100, 110):
        cells = np.zeros((200, 31), dtype=np.int8)
        cells[row] = 100
        shade, shade_m = shades(OccupancyGrid(cells, CELL, (0.0, 0.0)), 0.12)
        assert shade_m == pytest.approx(0.15)
        assert np.flatnonzero((shade == 0.0).all(axis=1)).tolist() == [row // 3]
        assert np.unique(shade).tolist() == [0.0, 1.0]
    assert shades(OccupancyGrid(cells, CELL, (0.0, 0.0)), 0.04)[0].shape == cells.shape


def test_command_judges_a_map_from_files(tmp_path, capsys):
    write_map(tmp_path / "room", grid_of(wall_points()))
    np.savetxt(tmp_path / "walls.txt", ROOM.ends_m)
    figures, picture = tmp_path / "figures.json", tmp_path / "map.error"  # a PNG whatever its name
    files = [str(tmp_path / "room.yaml"), str(tmp_path / "walls.txt")]
    assert main(["map", *files, "--json", str(figures), "--picture", str(picture)]) == 0
    assert "map_error_mean_m" in capsys.readouterr().out
    assert json.loads(figures.read_text())["wall_seen_share"] == pytest.approx(1.0)
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.table(
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


@pytest.mark.table("command", [["ate", "no.tum", "no.tum"], ["relations", "no.tum", "no.gz"]])
def test_command_says_what_is_missing_in_one_sentence(command, capsys):
    assert main(command) == 1
    said = capsys.readouterr().err
    assert "no.tum" in said
    assert said.count("\n") == 1
