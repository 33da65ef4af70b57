"""A vehicle that flies at two heights, where level scans see two slices of a hold: each gets its own map.

Below there are beams 0.5 m deep on the hold's sides, above there are none.
"""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import planar_world
import pytest
from sessions_in_the_hold import LIDAR, PARAMETERS, base_in_map, error_m

from gridslam import se2
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession, closure_parameters

LOW_M, HIGH_M = 2.0, 4.0
ROUND = np.array([(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0), (-8.0, -5.0)])
APART_M = 0.25
BEAMS_X_M = (-7.5, -4.5, -1.5)
"""Middles of beams on the starboard side, y = -10 m."""
CLOSURE = closure_parameters(
    {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 0.5}
)


@pytest.fixture(scope="module")
def log():
    """Rounds at 2, 4 and 2 m: scans, odometry and truth, and where a round begins."""
    truth = planar_world.along(np.concatenate([ROUND, ROUND[1:], ROUND[1:]]), 0.4)
    once = len(truth) // 3
    driven = planar_world.drive(planar_world.hold(), truth, LIDAR, seed=4)
    rng, high = np.random.default_rng(5), planar_world.hold(beams=False)
    scans = []
    for number, scan in enumerate(driven.scans):
        is_high = number // once == 1
        if is_high:
            scan = planar_world.scan_at(high, truth[number], LIDAR, rng, scan.stamp_s)
        scans.append(dataclasses.replace(scan, height_m=HIGH_M if is_high else LOW_M))
    return dataclasses.replace(driven, scans=scans), once


def has_wall(session, x_m, y_m):
    """Whether a cell is occupied within 0.15 m of a place."""
    grid = session.grid()
    near = np.hypot(*(grid.centres(grid.cells > 50) - (x_m, y_m)).T)
    return bool(len(near) and near.min() < 0.15)


def go(session, log, first, last):
    for scan, odometry in list(zip(log.scans, log.odometry))[first:last]:
        session.process(scan, odometry)


def slices(session):
    """Which slice the map has: beams below, and the bare side above."""
    below = [has_wall(session, x, -9.5) for x in BEAMS_X_M]
    above = [has_wall(session, x, -10.0) for x in BEAMS_X_M]
    return below, above


YES, NO = [True] * 3, [False] * 3


@dataclasses.dataclass(frozen=True)
class Mapped:
    """One session over all three rounds, saved after two.

    slices: after each round, and at the end, which corrects the path. said, poses, cells, off_m: before it.
    """

    state: Path
    said: list[str]
    slices: list
    poses: np.ndarray
    cells: np.ndarray
    off_m: float
    closures: list


@pytest.fixture(scope="module")
def mapped(log, tmp_path_factory):
    log, once = log
    state, said, seen = tmp_path_factory.mktemp("saved") / "state", [], []
    session = SlamSession(PARAMETERS, CLOSURE, say=said.append)
    for number in range(3):
        go(session, log, number * once, (number + 1) * once)
        seen.append(slices(session))
        if number == 1:
            save_session(session, state)
    poses, cells = session.particle_poses.copy(), session.grid().cells.copy()
    off_m = error_m(base_in_map(session, log.odometry[-1]), log.truth.poses_in_map[-1])
    said = list(said)
    session.finish()
    seen.append(slices(session))
    return Mapped(state, said, seen, poses, cells, off_m, list(session.closures))


def test_each_height_has_its_map_and_the_first_one_comes_back(mapped):
    assert mapped.slices == [(YES, NO), (NO, YES), (YES, NO), (YES, NO)]
    # that is said once: a UAV that climbs and sinks changes its map often
    (said,) = mapped.said
    assert "at 4.0 m" in said
    assert "Each height has its own map" in said
    assert mapped.off_m < 0.1


def test_loops_are_closed_within_a_height(log, mapped):
    heights_m = {scan.stamp_s: scan.height_m for scan in log[0].scans}
    pairs = [(heights_m[each.stamp_from_s], heights_m[each.stamp_to_s]) for each in mapped.closures]
    assert pairs
    assert all(one == other for one, other in pairs)


def test_a_saved_session_goes_on_with_the_map_of_its_height(log, mapped):
    log, once = log
    continued = load_session(mapped.state, say=lambda words: None)
    assert slices(continued) == (NO, YES)
    go(continued, log, 2 * once, 3 * once)
    np.testing.assert_array_equal(continued.particle_poses, mapped.poses)
    np.testing.assert_array_equal(continued.grid().cells, mapped.cells)


def test_without_kept_scans_the_map_stays_one_and_that_is_said(log):
    log, once = log
    said = []
    session = SlamSession(PARAMETERS, False, say=said.append)
    go(session, log, 0, 2 * once)
    assert "may be wrong" in " ".join(said)


def test_good_odometry_counts_where_a_height_has_no_map_yet(log):
    """Nothing tells a place on a map that is empty. So the pose stays what a sure odometry says."""
    log, once = log
    session = SlamSession(PARAMETERS, CLOSURE, say=lambda words: None)
    sure = np.diag((1e-3, 1e-3, 1e-4)) ** 2
    for scan, base in list(zip(log.scans, log.truth.poses_in_map))[: once + 8]:
        session.process(scan, base, sure)
        off = np.abs(se2.between(base, base_in_map(session, base)))
        assert np.hypot(*off[:2]) < 0.05
        assert off[2] < 0.01


@pytest.mark.table(("in_space", "moves"), [(False, True), (True, False)])
def test_a_slice_that_looks_displaced_moves_no_pose_that_was_found_in_space(log, in_space, moves):
    """Back at 2 m all that a level scan sees is 0.25 m farther to port than on the first round."""
    log, once = log
    session = SlamSession(PARAMETERS, CLOSURE, say=lambda words: None, odometry_in_space=in_space)
    sure = np.diag((1e-3, 1e-3, 1e-4)) ** 2
    rng, off_m = np.random.default_rng(6), []
    for number, (scan, base) in enumerate(list(zip(log.scans, log.truth.poses_in_map))[: 2 * once + 8]):
        if number >= 2 * once:
            there = base - (0.0, APART_M, 0.0)
            seen = planar_world.scan_at(planar_world.hold(), there, LIDAR, rng, scan.stamp_s)
            scan = dataclasses.replace(seen, height_m=LOW_M)
        session.process(scan, base, sure)
        off_m.append(float(np.hypot(*se2.between(base, base_in_map(session, base))[:2])))
    assert max(off_m[: 2 * once]) < 0.05
    assert (max(off_m[2 * once :]) > 0.5 * APART_M) == moves


@pytest.mark.table(
    ("in_space", "walk_m", "is_witness"), [(True, 0.01, False), (True, 1.0, True), (False, 0.01, True)]
)
def test_another_slice_within_a_height_is_no_witness_against_clouds(log, in_space, walk_m, is_witness):
    """On a second round, 0.4 m higher, all walls are half as far, as over the holes of plates.

    It is one where clouds do not know the way: they tell that a step is off by 1 m.
    """
    log, once = log
    said, states = [], []
    session = SlamSession(PARAMETERS, CLOSURE, say=said.append, odometry_in_space=in_space)
    for number, (scan, base) in enumerate(list(zip(log.scans, log.truth.poses_in_map))[: once + 20]):
        walked_m2 = 1e-6 + 1e-4 * number
        if number >= once:
            walked_m2 += walk_m**2 * (number - once)
            scan = dataclasses.replace(scan, ranges_m=0.5 * scan.ranges_m, height_m=LOW_M + 0.4)
        session.process(scan, base, np.diag((walked_m2, walked_m2, 1e-6)))
        states.append(session.tracking.state)
    assert set(states[:once]) == {"tracking"}
    assert ("lost" in states) == is_witness
    if not is_witness:
        assert set(states) == {"tracking"}
        assert np.hypot(*se2.between(base, base_in_map(session, base))[:2]) < 0.05
        assert not said
