"""Experiment 2 through the whole graph, started as a user starts it: with roslaunch."""

from __future__ import annotations

import pytest
from launched_flight import Flight

pytestmark = [pytest.mark.ros, pytest.mark.flight, pytest.mark.long]


def test_obstacles_appear_in_stopped_time_and_the_original_hits_one(processes, tmp_path):
    """As fast as the machine can, in lockstep: the flight is the same on every machine."""
    lockstep = {"lockstep": "true", "lockstep_timeout": 30, "real_time_factor": "0", "headless": "true"}
    asked = {"scenario": "wall_three_columns", "algorithm": "original", "K": "20"}
    flight = Flight(processes, tmp_path, "experiment_2.launch", **asked, **lockstep)
    flight.wait(200.0)
    result = flight.result
    assert result["success"], result["failure"]
    assert "Traceback" not in flight.said
    # Given four obstacles around a UAV that hovers at 2 m
    freeze = result["freeze"]
    assert freeze["uav_xyz_m"] == pytest.approx((0.0, 0.0, 2.0), abs=0.05)
    assert len(freeze["obstacles"]) == 4
    assert 0.0 < freeze["first_scan_after_s"] <= 0.029
    assert freeze["moved_until_first_scan_m"] < 0.002
    # When CEPA's node answers the first scan, it says what is reported as its proposal
    proposed = result["proposals"][0]
    assert proposed["k_filter"] == result["parameters"]["cepa"]["k_filter"] == 20.0
    assert result["node_answer_xy"] == pytest.approx(proposed["original_xy"], abs=1e-6)
    assert proposed["original_xy"][1] < -0.9  # to the right, where the middle column is
    assert proposed["improved_xy"][0] > 0.9  # ahead, along the wall
    # Then the UAV flies into the column, and the simulator saw it
    assert next(iter(result["touched"])) == "column_middle::link::body"
    assert result["min_clearance_m"] < 0.005
    assert flight.series("contacts")["t_s"].min() > freeze["t_s"]
    assert {"proposals.png", "k_sweep.png", "path.png"} <= {path.name for path in flight.results.iterdir()}
