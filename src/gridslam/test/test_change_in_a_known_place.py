"""A pallet that comes into a known place reaches the map, although scans there add no nodes, and stays."""

import numpy as np
import planar_world
import pytest
from sessions_in_the_hold import LIDAR, PARAMETERS

from gridslam.evaluation import Walls
from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession, closure_parameters

CLOSURE = closure_parameters(
    {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 4.0}
)
LAP = [(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0)]
LAPS, BEFORE = 10, 6
PALLET_M = np.array([(-5.5, -3.5), (-4.5, -3.5), (-4.5, -2.5), (-5.5, -2.5)])


def cells_of_pallet(session):
    """Return the occupied cells (n, 2) around the pallet's place, from its middle."""
    occupied = session.grid().occupied_xy() - PALLET_M.mean(axis=0)
    return occupied[np.abs(occupied).max(axis=1) < 0.7]


def assert_is_pallet(cells):
    assert len(cells) > 10
    assert (np.abs(np.abs(cells).max(axis=1) - 0.5) < 0.15).all()


@pytest.fixture(scope="module")
def changed():
    """A session in a place that six laps have mapped, and four laps more with a pallet of 1 m in it."""
    hold, rng = planar_world.hold(), np.random.default_rng(9)
    with_pallet = Walls(np.vstack([hold.ends_m, Walls.from_polygons([PALLET_M]).ends_m]))
    truth = planar_world.along(np.array(LAP * LAPS), 0.4)
    log, change = planar_world.drive(hold, truth, LIDAR, seed=4), len(truth) * BEFORE // LAPS
    session, is_node = SlamSession(PARAMETERS, CLOSURE), []
    for index, (scan, base) in enumerate(zip(log.scans, log.odometry)):
        if index >= change:
            scan = planar_world.scan_at(with_pallet, truth[index], LIDAR, rng, scan.stamp_s)
        update = session.process(scan, base)
        if index >= change and update is not None:
            is_node.append(update.is_node)
    assert np.mean(is_node) < 0.1
    return session


def test_what_comes_into_a_known_place_is_seen_in_the_map(changed):
    assert_is_pallet(cells_of_pallet(changed))


def test_what_came_into_a_known_place_stays_when_the_map_is_drawn_anew(changed, tmp_path):
    # given the session, and the same one from its state
    save_session(changed, tmp_path / "state")
    saved = load_session(tmp_path / "state")
    # when a correction draws the map anew
    saved.finish()
    poses = changed.slam.node_poses()
    changed.slam.adopt(poses)
    # then the pallet is in it
    assert_is_pallet(cells_of_pallet(changed))
    assert_is_pallet(cells_of_pallet(saved))
