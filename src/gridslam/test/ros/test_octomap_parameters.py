"""The parameters of slam_octomap, and the map that its command line names, as octomap_server's does."""

from dataclasses import fields

import pytest
from gridslam_ros.volume.parameters import (
    DEFAULTS,
    OctomapParameters,
    SensorModel,
    parameters_of,
    with_map_argument,
)

from gridslam import ParameterError
from gridslam.volume import NodeSpacing, VolumeParameters

SAME = {
    "resolution": (VolumeParameters, "resolution_m"),
    "max_range": (VolumeParameters, "max_range_m"),
    "hit": (VolumeParameters, "hit"),
    "miss": (VolumeParameters, "miss"),
    "min": (VolumeParameters, "least"),
    "max": (VolumeParameters, "greatest"),
    "node_distance": (NodeSpacing, "distance_m"),
    "node_angle": (NodeSpacing, "angle_rad"),
    "node_period": (NodeSpacing, "period_s"),
}
"""Parameters that the library has by another name."""


def test_a_map_of_the_command_line_is_the_map_to_begin_with():
    assert with_map_argument(DEFAULTS, []) == DEFAULTS
    assert with_map_argument(DEFAULTS, ["hold.bt"]) == {**DEFAULTS, "map_file": "hold.bt"}
    same = {**DEFAULTS, "map_file": "hold.bt"}
    assert with_map_argument(same, ["hold.bt"]) == same


@pytest.mark.parametrize(
    ("map_file", "arguments", "saying"),
    [("", ["a.bt", "b.bt"], "one map file, not 2: a.bt, b.bt"), ("c.bt", ["a.bt"], "give one of them")],
)
def test_two_maps_are_refused(map_file, arguments, saying):
    with pytest.raises(ParameterError, match=saying):
        with_map_argument({**DEFAULTS, "map_file": map_file}, arguments)


def test_what_the_library_checks_has_the_same_default_and_limits_here():
    own = {each.name: each for kind in (OctomapParameters, SensorModel) for each in fields(kind)}
    for name, (kind, other) in SAME.items():
        there = next(each for each in fields(kind) if each.name == other)
        assert (own[name].default, own[name].metadata) == (there.default, there.metadata), name


@pytest.mark.parametrize(
    ("given", "saying"),
    [
        ({"sensor_model/hit": 0.4}, "sensor_model/hit must be greater than 0.5, not 0.4."),
        ({"resolution": 0.0}, "resolution must be between 0.001 and 100, not 0.0."),
        ({"publish_period": 0.0}, "publish_period must be greater than 0, not 0.0."),
        ({"keep_period": -1.0}, "keep_period must be at least 0, not -1.0."),
        ({"occupancy_min_z": "low"}, "occupancy_min_z must be a finite number, not 'low'."),
        ({"publish_free_space": "yes"}, "publish_free_space must be true or false, not 'yes'."),
        ({"odom_frame": "/"}, "odom_frame must be a frame's name, and not empty."),
        ({"continue_from_state": 1}, "continue_from_state needs state_file"),
    ],
)
def test_what_makes_no_sense_is_refused_by_the_name_on_the_parameter_server(given, saying):
    with pytest.raises(ParameterError, match=saying):
        parameters_of({**DEFAULTS, **given})


def test_values_reach_the_library():
    parameters = parameters_of({"sensor_model/miss": 0.46, "resolution": 0.2, "node_period": 2.0})
    assert (parameters.volume.miss, parameters.volume.resolution_m) == (0.46, 0.2)
    assert parameters.spacing == NodeSpacing(period_s=2.0)
    assert parameters_of(DEFAULTS) == OctomapParameters()
