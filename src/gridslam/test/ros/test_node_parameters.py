"""The node's parameters: slam_gmapping's names and defaults, in every file the same, checked once."""

import dataclasses
import math
import re
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

from gridslam import ParameterError, SlamParameters

parameters = pytest.importorskip(
    "gridslam_ros.parameters", reason="the workspace is not built, or not sourced"
)
PACKAGE = Path(__file__).resolve().parents[2]
YAML = PACKAGE / "config/gridslam.yaml"
GMAPPING = {  # wiki.ros.org/gmapping and slam_gmapping.cpp; test_slam_parameters.py has the filter's
    "throttle_scans": 1,
    "base_frame": "base_link",
    "map_frame": "map",
    "odom_frame": "odom",
    "map_update_interval": 5.0,
    "transform_publish_period": 0.05,
    "tf_delay": 0.05,
}


NODE_IN_YAML = {
    "throttle_scans",
    "levelling",
    "odometry_covariance",
    "odometry_in_space",
    "clouds",
    "floor_z",
    "map_update_interval",
    "transform_publish_period",
    "tf_delay",
}


def defaults():
    node, slam, _, _ = parameters.sort_parameters({})
    return {**dataclasses.asdict(slam), **dataclasses.asdict(node), "tf_delay": node.ahead_s}


def test_names_and_defaults_are_slam_gmappings():
    assert {name: defaults()[name] for name in GMAPPING} == GMAPPING


def test_a_launch_file_for_slam_gmapping_sets_what_it_means():
    given = {
        "maxUrange": 16,
        "particles": 80,
        "xmin": -50.0,
        "ymin": -50,
        "xmax": 50,
        "ymax": 50,
        "delta": 0.1,
    }
    node, slam, closure, unknown = parameters.sort_parameters({**given, "transform_publish_period": 0.02})
    assert (slam.maxUrange, slam.particles, slam.xmin, slam.delta) == (16.0, 80, -50.0, 0.1)
    assert node.ahead_s == node.transform_publish_period == 0.02
    assert (closure, unknown) == ({}, [])


def test_names_are_sorted_and_unknown_ones_told():
    _, _, closure, unknown = parameters.sort_parameters({"closure_radius": 3, "partcles": 3, "seed": 4})
    assert (closure, unknown) == ({"radius": 3}, ["partcles"])


@pytest.mark.parametrize("pose", ["1 2 0.5", "1, 2, 0.5", [1, 2, 0.5]])
def test_a_starting_pose(pose):
    assert parameters.NodeParameters(starting_pose=pose).starting_pose == (1.0, 2.0, 0.5)


def test_parameters_without_effect_are_told():
    told = parameters.without_effect({"llsamplestep": 0.02, "sigma": 0.1, "lasamplerange": 0.01})
    assert told.startswith("llsamplestep, lasamplerange will change nothing")
    assert parameters.without_effect({"sigma": 0.1}) == ""


def test_what_counts_less_than_it_says_is_told():
    told = parameters.clamped(SlamParameters(maxUrange=10.0, maxRange=8.0))
    assert told == "maxUrange 10 is more than maxRange; it is taken as 8."
    assert parameters.clamped(SlamParameters(maxUrange=8.0, maxRange=8.0)) == ""
    assert parameters.clamped(SlamParameters(maxUrange=8.0)) == ""


def test_whole_numbers_may_come_as_others():
    throttle_scans = parameters.NodeParameters(throttle_scans=2.0).throttle_scans
    assert (throttle_scans, type(throttle_scans)) == (2, int)


def test_a_floor_that_is_not_known():
    assert parameters.NodeParameters(floor_z=math.nan).floor_z_m is None
    assert parameters.NodeParameters(floor_z=-1).floor_z_m == -1.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"particles": 0}, "particles must be at least 1"),
        ({"throttle_scans": 0}, "throttle_scans must be at least 1, not 0"),
        ({"throttle_scans": 1.5}, "throttle_scans must be a whole number, not 1.5"),
        ({"throttle_scans": math.nan}, "throttle_scans must be a finite number"),
        ({"throttle_scans": math.inf}, "throttle_scans must be a finite number"),
        ({"throttle_scans": "x"}, "throttle_scans must be a finite number"),
        ({"map_update_interval": -1.0}, "map_update_interval must be at least 0"),
        ({"tf_delay": math.inf}, "tf_delay must be a finite number"),
        ({"transform_publish_period": True}, "transform_publish_period must be a finite number"),
        ({"odom_frame": "/map"}, "three different names"),
        ({"base_frame": ""}, "base_frame must be a frame's name"),
        ({"base_frame": 3}, "base_frame must be a frame's name"),
        ({"levelling": "yes"}, "levelling must be true or false"),
        ({"localisation_only": True}, "localisation_only needs a map"),
        ({"localisation_only": True, "starting_map": "m.yaml", "loop_closure": True}, "choose one"),
        ({"continue_from_state": True}, "needs state_file"),
        ({"starting_pose": "1 2"}, "starting_pose must be"),
        ({"starting_pose": "1 2 nan"}, "starting_pose must be"),
    ],
)
def test_what_makes_no_sense_is_one_sentence(given, words):
    with pytest.raises(ParameterError, match=words):
        parameters.sort_parameters(given)


def test_the_yaml_file_holds_every_default_and_says_what_it_does():
    config = yaml.safe_load(YAML.read_text())
    assert {name: defaults()[name] for name in config} == config
    lines = [line for line in YAML.read_text().splitlines() if re.match(r"(# )?\w+: \S", line)]
    told = {re.match(r"(?:# )?(\w+):", line)[1]: line.partition("  #")[2] for line in lines}
    assert set(told) == {field.name for field in dataclasses.fields(SlamParameters)} | NODE_IN_YAML
    assert all("efault" in sentence for sentence in told.values()), told


def test_the_yaml_file_sets_nothing_that_the_start_would_remark_on():
    config = yaml.safe_load(YAML.read_text())
    slam, unknown = parameters.sort_parameters(config)[1::2]
    assert (parameters.without_effect(config), parameters.clamped(slam), unknown) == ("", "", [])


def test_the_launch_file_sets_the_other_parameters():
    launch = ElementTree.parse(PACKAGE / "launch/gridslam.launch").getroot()
    names = {param.get("name") for param in launch.iter("param")}
    told = {line.split(":")[0].lstrip("# ") for line in YAML.read_text().splitlines()}
    assert set(defaults()) - names <= told
    assert names <= set(defaults())


def test_every_parameter_is_in_the_reference():
    reference = (PACKAGE / "doc/reference.md").read_text()
    assert [name for name in defaults() if f"`{name}`" not in reference] == []
