"""A pallet that comes into a known place reaches the map, although scans there add no nodes."""

import numpy as np
import planar_world
from sessions_in_the_hold import LIDAR, PARAMETERS

from gridslam.evaluation import Walls
from gridslam.session import SlamSession, closure_parameters

CLOSURE = closure_parameters(
    {"separation_m": 15.0, "stretch_m": 7.0, "support_m": 5.0, "search_agreed_m": 4.0}
)
LAP = [(-8.0, -5.0), (-2.0, -5.0), (-2.0, -1.0), (-8.0, -1.0)]
LAPS, BEFORE = 10, 6
PALLET_M = np.array([(-5.5, -3.5), (-4.5, -3.5), (-4.5, -2.5), (-5.5, -2.5)])


def test_what_comes_into_a_known_place_is_seen_in_the_map():
    # given a place that six laps have mapped, and a pallet of 1 m that comes then
    hold, rng = planar_world.hold(), np.random.default_rng(9)
    with_pallet = Walls(np.vstack([hold.ends_m, Walls.from_polygons([PALLET_M]).ends_m]))
    truth = planar_world.along(np.array(LAP * LAPS), 0.4)
    log, change = planar_world.drive(hold, truth, LIDAR, seed=4), len(truth) * BEFORE // LAPS
    session, is_node = SlamSession(PARAMETERS, CLOSURE), []
    # when it drives four laps more
    for index, (scan, base) in enumerate(zip(log.scans, log.odometry)):
        if index >= change:
            scan = planar_world.scan_at(with_pallet, truth[index], LIDAR, rng, scan.stamp_s)
        update = session.process(scan, base)
        if index >= change and update is not None:
            is_node.append(update.is_node)
    # then few scans are kept, and the map shows the pallet where it is
    assert np.mean(is_node) < 0.1
    occupied = session.grid().occupied_xy()
    cells = occupied[(np.abs(occupied - PALLET_M.mean(axis=0)).max(axis=1) < 0.7)]
    assert len(cells) > 10
    assert (np.abs(np.abs(cells - PALLET_M.mean(axis=0)).max(axis=1) - 0.5) < 0.15).all()
