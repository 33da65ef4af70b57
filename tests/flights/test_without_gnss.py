"""Without GNSS nobody that flies the UAV listens to the truth: read from the running graph."""

from __future__ import annotations

import xmlrpc.client

import pytest
from launched_flight import READY_PATIENCE_S, Flight

pytestmark = [pytest.mark.ros, pytest.mark.timeout(240)]

MADE_OF_TRUTH = ("/UAV/ground_truth", "/gazebo/odometry", "/imu", "/gazebo/model_states")
JUDGE, WORLD_EDGE = "/experiment", "/tf_publisher"


def subscribers(processes) -> dict[str, set[str]]:
    master = xmlrpc.client.ServerProxy(processes.environment["ROS_MASTER_URI"])
    _, _, (_, subscribed, _) = master.getSystemState("/test")
    return {topic: set(nodes) for topic, nodes in subscribed}


def test_the_truth_reaches_nobody_but_the_judge_and_the_world_edge(processes, tmp_path):
    # Given a flight of Experiment 4 without GNSS
    flight = Flight(
        processes, tmp_path, "experiment_4.launch", gnss="false", lockstep="true", real_time_factor="0"
    )
    # When the UAV has taken off and is on its mission, so that every node is connected
    flight.wait_until_said("begins its mission", READY_PATIENCE_S)
    # Then nobody but the judge and TF's edge `world` subscribes to what is made of the truth
    heard = subscribers(processes)
    assert heard["/UAV/ground_truth"] == {JUDGE, WORLD_EDGE}
    for topic in MADE_OF_TRUTH[1:]:
        assert heard.get(topic, set()) <= {JUDGE, WORLD_EDGE}, topic
    # And odometry is the lidar's
    master = xmlrpc.client.ServerProxy(processes.environment["ROS_MASTER_URI"])
    published = dict(master.getSystemState("/test")[2][0])
    assert published["/UAV/odometry"] == ["/lidar_odometry"]
    assert "/vision_pose_publisher" in published["/mavros/vision_pose/pose_cov"]
