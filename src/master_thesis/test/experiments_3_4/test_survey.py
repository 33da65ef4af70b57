"""From a map and a path that are known in closed form to the figures and files of a survey."""

from dataclasses import replace
from datetime import datetime

import numpy as np
import pytest

from flights.mapping.slam_metrics import slam_metrics_of, verdict
from flights.mapping.slam_run import FoundAgain, SlamRun, true_path
from flights.results.run_folder import RunFolder
from flights.worlds.floor_plan import Outline
from gridslam import OccupancyGrid
from gridslam.evaluation import Walls, read_tum
from gridslam.files.map_file import read_map
from gridslam.trajectory import Trajectory
from master_thesis.experiments_3_4.slam_summary import headline
from master_thesis.experiments_3_4.survey_files import Surveyed, closure_pairs, write_survey

CELL_M = 0.1
OFF_M = 0.25


def square_room(offset_m=0.0):
    """Map of a room of 4 x 4 m around the origin; its walls' cells lie outside of them, moved along x."""
    cells = np.zeros((42, 42), dtype=np.int8)
    cells[[0, -1], :] = cells[:, [0, -1]] = 100
    return OccupancyGrid(cells, CELL_M, (-2.1 + offset_m, -2.1))


WALLS = Walls(np.array([(-2, -2, 2, -2), (2, -2, 2, 2), (2, 2, -2, 2), (-2, 2, -2, -2)], dtype=float))
BOX = np.array(((-0.1, -2.1), (0.1, -2.1), (0.1, -2.0), (-0.1, -2.0)))


def path(offset_m=0.0, count=41):
    """10 s of a half circle of 1 m radius about the origin."""
    times = np.linspace(0.0, 10.0, count)
    angles = 0.1 * np.pi * times
    poses = np.column_stack((np.cos(angles) + offset_m, np.sin(angles), angles - np.pi / 2))
    return Trajectory(times, poses)


@pytest.fixture
def run():
    return SlamRun(
        online=path(2 * OFF_M),
        final=path(OFF_M),
        grid=square_room(),
        half_way=square_room(),
        closures=(FoundAgain(1.0, 9.0),),
        cpu_ms=np.array([4.0, 6.0]),
        scans=100,
    )


def test_a_path_that_is_off_by_a_quarter_of_a_metre(run):
    figures, errors, _ = slam_metrics_of(run, path(count=1001), WALLS)
    assert figures["ate_rmse_m"] == pytest.approx(OFF_M)
    assert figures["ate_online_rmse_m"] == pytest.approx(2 * OFF_M)
    assert figures["ate_aligned_rmse_m"] == pytest.approx(0.0, abs=1e-6)
    assert figures["end_error_m"] == pytest.approx(OFF_M)
    assert (figures["scans"], figures["scans_processed"], figures["closures"]) == (100, 41, 1)
    assert figures["cpu_ms_per_scan"]["mean"] == 5.0
    assert np.allclose(errors.errors_m, OFF_M)


def test_a_straight_path_cannot_be_aligned(run):
    straight = Trajectory(np.arange(3.0), np.column_stack((np.arange(3.0), np.zeros(3), np.zeros(3))))
    figures, _, _ = slam_metrics_of(replace(run, final=straight, online=straight), straight, WALLS)
    assert figures["ate_rmse_m"] == 0.0
    assert figures["ate_aligned_rmse_m"] is None


def test_a_true_map_has_no_error_but_its_cells(run):
    figures, _, _ = slam_metrics_of(run, path(), WALLS)
    assert figures["map_error_mean_m"] == pytest.approx(CELL_M / 2, abs=0.001)  # the corners' a little more
    assert figures["wall_seen_share"] == 1.0


def test_loops_are_drawn_between_the_places_of_their_scans(run):
    first, again = np.radians(18.0), np.radians(162.0)
    places = [(np.cos(angle) + OFF_M, np.sin(angle)) for angle in (first, again)]
    assert np.allclose(closure_pairs(run), [places], atol=0.001)


@pytest.mark.usefixtures("png_only")
def test_the_files_of_a_survey(run, tmp_path):
    folder = RunFolder(tmp_path, "experiment_3", datetime(2026, 1, 1))
    outlines = [Outline("box", BOX, 0.0, 3.0)]
    survey = Surveyed("a room, ust, seed 1", run, path(), path(4 * OFF_M), WALLS, outlines, 2.0)
    figures = write_survey(folder, survey)
    assert figures["odometry_ate_rmse_m"] == pytest.approx(4 * OFF_M)
    assert np.array_equal(read_map(folder.path / "map.yaml").cells, run.grid.cells)
    assert (folder.path / "map_half_way.yaml").is_file()
    final = read_tum(folder.path / "slam_final.tum")
    assert np.allclose(final.poses_in_map, run.final.poses_in_map)
    for name in ("truth", "odometry", "slam_online"):
        assert len(read_tum(folder.path / f"{name}.tum").stamps_s) == 41
    assert len((folder.path / "walls.csv").read_text().splitlines()) == 5
    for name in ("map", "map_error", "error"):
        assert (folder.path / f"{name}.png").read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_the_truth_as_a_planar_path_turns_the_uav_s_quaternions():
    half = np.radians(45.0) / 2
    poses = np.array([(1.0, 2.0, 3.0, 0.0, 0.0, np.sin(half), np.cos(half))])
    assert np.allclose(true_path(np.zeros(1), poses).poses_in_map, [(1.0, 2.0, np.radians(45.0))])


@pytest.mark.table(
    ("ate", "p95", "words"),
    [(0.05, 0.1, "true to the world"), (0.2, 0.3, "bent or turned"), (0.6, 0.9, "doubled"), (2, 3, "broken")],
)
def test_the_verdict_gets_worse_with_the_error(ate, p95, words):
    figures = {
        "ate_rmse_m": ate,
        "map_error_p95_m": p95,
        "wall_turned_max_rad": 0.01,
        "wall_seen_share": 0.9,
    }
    assert words in verdict(figures)
    # and a map of a few walls says so, however exact they are
    part = verdict({**figures, "wall_seen_share": 0.02})
    assert part.startswith("only a part, 2 % of the walls")
    assert words in part


def test_a_run_without_a_map_has_a_headline_too():
    content = {
        "scenario": "room",
        "algorithm": "improved",
        "lidar": "ust",
        "seed": 1,
        "reached_goal": False,
        "collision": False,
        "flight_time_s": None,
        "path_length_m": 0.0,
        "min_clearance_m": None,
        "cepa_computation_ms": None,
        "latency_ms": None,
        "real_time_factor": None,
        "failure": "SLAM gave no map.",
    }
    assert "SLAM gave no map." in headline(content)
