"""gridslam fed by a simulated flight: what it hears, and that its map is true."""

from dataclasses import fields, replace

import numpy as np
import pytest
import yaml

from flights.errors import ScenarioError
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.flight.flight_recording import FlightRecorder, LidarGeometry
from flights.mapping.mapping_flight import SCENARIOS, parameters_of
from flights.mapping.slam_metrics import slam_metrics_of
from flights.mapping.slam_run import SlamParticipant, replay, true_path, true_walls
from flights.mapping.slam_setup import read_setup, setup_of
from gridslam import SlamParameters
from gridslam.errors import ParameterError
from inspection_tools import Waypoint

pytestmark = pytest.mark.flight

ALONG_THE_WALL = (Waypoint((6.0, -7.0, 2.0)),)


@pytest.fixture(scope="module")
def flown():
    """Six metres along the hold's wall with the URG; SLAM beside the flight, and its recording."""
    setup = read_setup("hold")
    with ClosedLoop(replace(parameters_of("hold", "urg", seed=1), mission=ALONG_THE_WALL)) as loop:
        recorder = FlightRecorder("short", loop.simulation.lidar)
        beside = SlamParticipant(
            setup.session(1, loop_closure=False), LidarGeometry.of(loop.simulation.lidar), half_time_s=12.0
        )
        loop.listeners += [recorder, beside]
        loop.run_to(Phase.HOVERING)
    return recorder.recording(), beside.run()


def test_the_map_of_a_short_flight_is_true(flown):
    """Tolerances: twice the worst of seeds 1 to 10, which is said beside each."""
    recording, run = flown
    scenario = SCENARIOS["hold"]
    walls = true_walls(scenario.world_path, 2.0, scenario.start_xyz_yaw[:2])
    figures, _, _ = slam_metrics_of(run, true_path(recording.times_s, recording.truth), walls)
    assert figures["ate_rmse_m"] < 0.07  # 0.036
    assert figures["map_error_p95_m"] < 0.05  # 0.025, half a cell
    assert figures["closures"] == 0


def test_slam_in_flight_and_on_its_recording_are_the_same_bit_for_bit(flown):
    recording, beside = flown
    again = replay(recording, read_setup("hold").session(1, loop_closure=False))
    assert np.array_equal(again.final.poses_in_map, beside.final.poses_in_map)
    assert np.array_equal(again.online.poses_in_map, beside.online.poses_in_map)
    assert np.array_equal(again.grid.cells, beside.grid.cells)
    assert beside.scans == len(recording)


class Session:
    """Stands for a session whose path is corrected when it is finished."""

    closures, is_finished = (), False

    def finish(self):
        self.is_finished = True

    def grid(self):
        return "corrected map" if self.is_finished else "map"

    def trajectory(self):
        return "corrected path" if self.is_finished else "path"


def test_the_final_path_and_map_are_corrected_by_all_closures():
    geometry = LidarGeometry(0.0, 0.1, 0.1, 5.0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    run = SlamParticipant(Session(), geometry).run()
    assert (run.final, run.grid) == ("corrected path", "corrected map")


def test_the_map_at_half_time_knows_less(flown):
    _, run = flown
    assert 0 < (run.half_way.cells >= 0).sum() < (run.grid.cells >= 0).sum()


@pytest.mark.table("world", ["room", "hold"])
def test_the_shipped_parameters_are_those_of_gridslam(world):
    setup = read_setup(world)
    assert setup.parameters.delta == 0.05
    assert setup.parameters.seed == 0


def test_parameters_of_the_node_alone_are_left_out_and_wrong_ones_refused():
    setup = setup_of({"particles": 7, "closure_score_min": 0.8, "map_update_interval": 1.0})
    assert setup.parameters == SlamParameters(particles=7)
    assert setup.loop_closure.score_min == 0.8
    with pytest.raises(ParameterError, match="particles"):
        setup_of({"particles": 0})
    with pytest.raises(ParameterError, match="no parameter magic"):
        setup_of({"closure_magic": 1})
    with pytest.raises(ScenarioError, match="gridslam_attic"):
        read_setup("attic")


@pytest.mark.table("world", ["room", "hold"])
def test_every_line_of_the_shipped_files_says_its_effect(world, worlds_folder):
    text = (worlds_folder.parent / f"config/gridslam_{world}.yaml").read_text()
    known = {field.name for field in fields(SlamParameters)}
    for name in yaml.safe_load(text):
        assert name in known or name.startswith("closure_") or name == "map_update_interval"
    assert all("#" in line for line in text.splitlines() if ":" in line)
