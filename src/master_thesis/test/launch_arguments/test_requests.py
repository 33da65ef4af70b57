"""What the experiments' nodes cannot fly is refused in one sentence."""

from __future__ import annotations

import math
import re
import shutil
from pathlib import Path

import pytest

from cepa import CepaParameters
from flights.errors import FlightsError
from flights.goal_flight import request as goal_flight
from master_thesis.experiment_2 import request as trial
from master_thesis.experiments_3_4 import request as mission_flight

KEEP_M = 0.5


@pytest.mark.table(
    ("asked", "sentence"),
    [
        ({"scenario": "jungle"}, "There is no scenario 'jungle'; choose scenario:=empty|"),
        ({"algorithm": "best"}, "There is no algorithm 'best'; choose algorithm:=improved|original"),
        ({"world": "/no.world"}, "There is no world file /no.world; give the path of an SDF world"),
        ({"world": "my.world"}, "for example world:=$PWD/my.world."),
        ({"goal": "far away"}, "'far away' is no goal; give 3 numbers in metres and radians: x y z."),
        ({"goal": "0 0 2"}, "The goal lies 0.00 m from the start; it must be 1 m to 10 km away."),
        (
            {"lidar": "sonar"},
            "There is no lidar 'sonar'; choose lidar:=urg|ust|utm|puck|tim|m8, or NAME of a model lidar_NAME "
            "in a folder of GAZEBO_MODEL_PATH.",
        ),
        ({"speed": "abc"}, "'abc' is no speed; give a number from 0.05 to 15."),
        (
            {"pose_source": "slam"},
            "There is no pose_source 'slam'; choose pose_source:=ground_truth|odometry.",
        ),
        ({"seed": "abc"}, "'abc' is no seed; give a whole number from 0 to 2147483647."),
        ({"hover_s": "two"}, "hover_s must be a finite number, not 'two'."),
        ({"hover_s": -1}, "hover_s must be greater than 0, not -1."),
    ],
)
def test_a_flight_to_a_goal(worlds_folder, asked, sentence):
    with pytest.raises(FlightsError, match=re.escape(sentence)):
        goal_flight.read({"world": str(worlds_folder / "empty.world"), **asked}, KEEP_M)


@pytest.mark.table(
    ("asked", "sentence"),
    [
        ({"scenario": "maze"}, "There is no scenario 'maze'; choose scenario:=columns|wall_one_column|"),
        ({"mavros": "fake"}, "There is no mavros 'fake'; choose mavros:=sim|real."),
        ({"look_s": "long"}, "'long' is no look; give a number from 0 to 8."),
    ],
)
def test_a_trial_among_obstacles(worlds_folder, asked, sentence):
    with pytest.raises(FlightsError, match=re.escape(sentence)):
        trial.read({"world": str(worlds_folder / "empty.world"), **asked}, CepaParameters())


def test_a_mission_may_hold_for_longer_than_the_flights_limit(worlds_folder, tmp_path):
    mission = tmp_path / "inspection.yaml"
    mission.write_text("waypoints: ['10 0 2', '10 20 2']\nhold: 100\nlaps: 2\n")
    asked = {"world": str(worlds_folder / "empty.world"), "mission": str(mission), "speed": 2.0}
    flight = mission_flight.read(asked, KEEP_M)
    legs_m = math.hypot(10.0, 2.0) + 20.0 + 20.0 + 20.0
    assert flight.limits.flight_timeout_s == 3.0 * legs_m / 2.0 + 4 * 100.0


@pytest.mark.table(
    ("given", "returns"), [(True, True), ("true", True), ("True", True), (False, False), ("yes", None)]
)
def test_a_mission_ends_at_its_start_if_one_says_so(worlds_folder, tmp_path, given, returns):
    mission = tmp_path / "inspection.yaml"
    mission.write_text("waypoints: ['10 0 2', '10 20 2']\n")
    asked = {"world": str(worlds_folder / "empty.world"), "mission": str(mission), "return_to_start": given}
    if returns is None:
        with pytest.raises(FlightsError, match=r"'yes' is no return_to_start; give true or false\."):
            mission_flight.read(asked, KEEP_M)
        return
    assert mission_flight.read(asked, KEEP_M).time.returns is returns


MODELS = Path(__file__).resolve().parents[4] / "src/simulation_tools/models"


@pytest.mark.table(
    ("beams", "half_deg", "sentence"),
    [
        (3, 135.0, None),  # 2.67 beams a turn
        (100_000, 135.0, "angle_increment must be between 0.01 degrees and half a turn"),
        (1, 0.0, "angle_increment is 0.0; it must be finite, not zero"),
        (721, 180.0, None),  # half a degree, with the first beam repeated at the end
    ],
)
def test_a_lidar_whose_scans_every_node_would_drop(
    worlds_folder, tmp_path, monkeypatch, beams, half_deg, sentence
):
    text = (MODELS / "lidar_ust/model.sdf").read_text()
    text = re.sub(r"<samples>\d+", f"<samples>{beams}", text)
    text = re.sub(r"(-?)2\.35619\d+", rf"\g<1>{math.radians(half_deg)}", text)
    shutil.copytree(MODELS / "lidar_ust", tmp_path / "lidar_own")
    (tmp_path / "lidar_own/model.sdf").write_text(text)
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"{tmp_path}:{MODELS}")
    asked = {"world": str(worlds_folder / "empty.world"), "lidar": "own"}
    if sentence is None:
        assert goal_flight.read(asked, KEEP_M).description.lidar == "own"
        return
    with pytest.raises(FlightsError, match=re.escape(sentence)) as error:
        goal_flight.read(asked, KEEP_M)
    assert str(error.value).startswith("The lidar own cannot steer a flight: ")
