"""Laps in known corridors: what is kept stops growing, and the path stays right and whole."""

import numpy as np
import planar_world
import pytest
from sessions_in_the_hold import LIDAR, PARAMETERS, base_in_map, error_m, run

from gridslam.saved_sessions import load_session, save_session
from gridslam.session import SlamSession, closure_parameters

CLOSURE = closure_parameters(
    {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 4.0}
)
LAP = [(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0)]
LAPS = 12


@pytest.fixture(scope="module")
def log():
    route = planar_world.along(np.array(LAP * LAPS), 0.4)
    return planar_world.drive(planar_world.hold(), route, LIDAR, seed=4)


@pytest.fixture(scope="module")
def driven(log):
    """The session after all laps, its updates, and the error at each scan, m."""
    session, updates, errors_m = SlamSession(PARAMETERS, CLOSURE), [], []
    for scan, base, true in zip(log.scans, log.odometry, log.truth.poses_in_map):
        updates.append(session.process(scan, base))
        errors_m.append(error_m(base_in_map(session, base), true))
    return session, updates, errors_m


def test_known_places_add_nothing(driven, log):
    session, updates, errors_m = driven
    nodes = [update.is_node for update in updates if update is not None]
    half = len(nodes) // 2
    assert len(session.slam.processed_scans()) == sum(nodes)
    assert sum(nodes[half:]) < 0.1 * half
    # and where the vehicle is, is known as well as before
    assert max(errors_m) < 0.15
    assert max(errors_m[len(errors_m) // 2 :]) < 0.1


def test_the_path_is_whole(driven, log):
    session, updates, _ = driven
    path = session.trajectory()
    stamps = [update.stamp_s for update in updates if update is not None]
    np.testing.assert_array_equal(path.stamps_s, stamps)
    true = log.truth.poses_in_map[np.searchsorted(log.truth.stamps_s, stamps)]
    assert np.hypot(*(path.poses_in_map - true)[:, :2].T).max() < 0.15


@pytest.mark.long
def test_a_run_saved_in_a_known_place_goes_on_as_if_never_interrupted(driven, log, tmp_path):
    whole, updates, _ = driven
    last = next(
        i for i in range(len(updates) - 40, 0, -1) if updates[i] is not None and not updates[i].is_node
    )
    begun = SlamSession(PARAMETERS, CLOSURE)
    run(begun, log, last=last + 1)
    save_session(begun, tmp_path / "state")
    continued = load_session(tmp_path / "state")
    run(continued, log, first=last + 1)
    assert continued.map_to_odom == whole.map_to_odom
    np.testing.assert_array_equal(continued.trajectory().stamps_s, whole.trajectory().stamps_s)
    np.testing.assert_array_equal(continued.trajectory().poses_in_map, whole.trajectory().poses_in_map)
