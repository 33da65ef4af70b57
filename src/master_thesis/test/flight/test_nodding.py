"""A closed loop whose planar lidar nods, and the map of voxels that its sweeps make."""

from dataclasses import replace

import numpy as np
import pytest

from flights.flight.closed_loop import ClosedLoop
from flights.flight.flight_recording import FlightRecorder
from flights.mapping.mapping_flight import parameters_of
from flights.mapping.slam_run import true_path
from inspection_tools import Waypoint
from master_thesis.experiments_3_4.volume.nodding import NoddingFlight, map_swept
from simulation_tools.vehicle.nod import Nod

pytestmark = pytest.mark.flight

NOD = Nod(amplitude_rad=0.7, period_s=2.0, sweeps=2)


@pytest.fixture(scope="module")
def flown():
    """A UAV that hovers at one place of the hold for two sweeps, about pitch and about roll."""
    parameters = parameters_of("hold", "ust", seed=3)
    stop = Waypoint((0.0, -7.0, 2.0), tolerance_m=0.3, hold_s=6.0)
    with ClosedLoop(replace(parameters, mission=(stop,), nod=NOD)) as loop:
        recorder = FlightRecorder("nod", loop.lidar)
        loop.listeners.append(recorder)
        outcome = loop.run()
        odometry = np.array(loop.log.odometry.rows)
        return NoddingFlight(outcome, recorder.recording(), loop.nodding.swept, odometry), loop.log


def tilt_rad(scan):
    return np.arccos(np.clip((scan.truth @ scan.lidar_in_base).rotation[2, 2], -1.0, 1.0))


def test_the_lidar_nods_at_the_stop_and_the_flight_goes_on(flown):
    flight, _ = flown
    assert flight.outcome.reached_goal
    assert not flight.outcome.collision
    assert max(map(tilt_rad, flight.swept)) == pytest.approx(0.7, abs=0.02)


def test_slam_gets_level_scans_only(flown):
    flight, _ = flown
    level = set(flight.recording.times_s.tolist())
    tilts = {scan.t_s: tilt_rad(scan) for scan in flight.swept}
    in_sweep = [t_s for t_s, tilt in tilts.items() if tilt > 0.1]
    assert len(in_sweep) > 2.0 * 40  # most of four seconds of 40 Hz
    assert not level.intersection(in_sweep)


def test_the_sweeps_make_a_map_of_floor_and_walls(flown):
    flight, _ = flown
    recording = flight.recording
    truth = true_path(recording.times_s, recording.truth)
    corrected, clouds = map_swept(recording, flight.swept, flight.odometry, truth)
    assert clouds > 4
    from gridslam.volume.drawing.centres import occupied_centres

    centres = occupied_centres(corrected.voxels)
    floor = centres[np.abs(centres[:, 2]) <= 0.1 + 1e-9]
    near = floor[np.hypot(floor[:, 0], floor[:, 1] + 7.0) < 4.0]
    columns = np.unique(near[:, :2].round(2), axis=0)
    assert len(columns) > 500  # of 5000 voxels; a level lidar has none
    wall = centres[(centres[:, 1] < -9.5) & (np.abs(centres[:, 0]) < 2.0)]
    assert wall[:, 2].max() - wall[:, 2].min() > 2.0
