"""A flight without GNSS: nobody that flies the UAV listens to the truth, and it comes back to its start."""

from __future__ import annotations

import xmlrpc.client

import numpy as np
import pytest
from launched_flight import READY_PATIENCE_S, Flight

pytestmark = [pytest.mark.ros, pytest.mark.long, pytest.mark.timeout(600)]

MADE_OF_TRUTH = ("/UAV/ground_truth", "/gazebo/odometry", "/imu", "/gazebo/model_states")
ERROR_MAX_M = 0.1
"""What the experiment asks for over four minutes."""
JUDGE, WORLD_EDGE = "/experiment", "/tf_publisher"


def subscribers(processes) -> dict[str, set[str]]:
    master = xmlrpc.client.ServerProxy(processes.environment["ROS_MASTER_URI"])
    _, _, (_, subscribed, _) = master.getSystemState("/test")
    return {topic: set(nodes) for topic, nodes in subscribed}


def test_it_flies_without_the_truth_and_lands_where_it_started(processes, tmp_path):
    # Given Experiment 3 without GNSS, whose mission ends after a few seconds
    args = {"gnss": "false", "lockstep": "true", "real_time_factor": "0", "headless": "true", "duration": "4"}
    flight = Flight(processes, tmp_path, "experiment_3.launch", **args)
    # When the UAV has taken off and is on its mission, so that every node is connected
    flight.wait_until_said("begins its mission", READY_PATIENCE_S)
    # Then nothing was told as a fault that the start itself mends
    assert "[WARN]" not in flight.said
    # And nobody but the judge and TF's edge `world` subscribes to what is made of the truth
    heard = subscribers(processes)
    assert heard["/UAV/ground_truth"] == {JUDGE, WORLD_EDGE}
    for topic in MADE_OF_TRUTH[1:]:
        assert heard.get(topic, set()) <= {JUDGE, WORLD_EDGE}, topic
    # And odometry is the lidar's
    master = xmlrpc.client.ServerProxy(processes.environment["ROS_MASTER_URI"])
    published = dict(master.getSystemState("/test")[2][0])
    assert published["/UAV/odometry"] == ["/lidar_odometry"]
    assert "/vision_pose_publisher" in published["/mavros/vision_pose/pose_cov"]
    # When the time is over
    flight.wait_until_said("The UAV flies back to its start", READY_PATIENCE_S)
    flight.wait_until_said("Measuring the clearance", READY_PATIENCE_S)  # SLAM's files and numbers are there
    flight.interrupt()
    flight.wait(200.0)
    # Then it has landed where it started, and has been elsewhere
    assert flight.result["success"], flight.result["failure"]
    truth = flight.series("truth")
    off_m = np.hypot(truth["x_m"] - truth["x_m"][0], truth["y_m"] - truth["y_m"][0])
    assert off_m.max() > 1.5
    assert off_m[-1] < 0.3
    # And the map is that of the room
    assert flight.result["slam"]["ate_rmse_m"] < ERROR_MAX_M
    assert flight.result["slam"]["map_error_mean_m"] < ERROR_MAX_M
    assert {"map.pgm", "map.yaml", "map.png"} <= {path.name for path in flight.results.iterdir()}
