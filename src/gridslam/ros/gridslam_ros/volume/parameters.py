"""The parameters of slam_octomap: those of octomap_server, and new ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Sequence

from gridslam import ParameterError
from gridslam.volume import NodeSpacing, VolumeParameters

RANGES = tuple(f"pointcloud_{end}_{axis}" for axis in "xyz" for end in ("min", "max"))
NUMBERS = {
    "resolution": VolumeParameters.resolution_m,
    "sensor_model/max_range": VolumeParameters.max_range_m,
    "sensor_model/min_range": -1.0,
    "sensor_model/hit": VolumeParameters.hit,
    "sensor_model/miss": VolumeParameters.miss,
    "sensor_model/min": VolumeParameters.least,
    "sensor_model/max": VolumeParameters.greatest,
    "occupancy_min_z": -math.inf,
    "occupancy_max_z": math.inf,
    "publish_period": 1.0,
    "updates_period": 0.2,
    "cloud_period": 0.0,
    "keep_period": 0.0,
    "node_distance": NodeSpacing.distance_m,
    "node_angle": NodeSpacing.angle_rad,
    "node_period": NodeSpacing.period_s,
    "greatest_distance": 3.0,
    **{name: -math.inf if "_min_" in name else math.inf for name in RANGES},
}
"""m, s, rad and probabilities."""
TEXTS = {
    "frame_id": "map",
    "base_frame_id": "base_link",
    "odom_frame": "odom",
    "map_file": "",
    "state_file": "",
}
FLAGS = {"publish_free_space": False, "continue_from_state": False}
WITHOUT_EFFECT = {
    "latch": "topics are always latched, and made only while somebody listens",
    "compress_map": "the map is always pruned",
    "height_map": "occupied voxels always have the colour of their height",
    "incremental_2D_projection": "projected_map is made whole each time",
    "filter_ground": "all points count",
    "filter_ground_plane": "all points count",
    "filter_speckles": "single voxels count",
    "colored_map": "voxels have no colour of their own",
}
"""Parameters of octomap_server, and what happens instead."""


@dataclass(frozen=True)
class OctomapParameters:
    """What the node is started with.

    Raises:
        ParameterError: a value makes no sense.
    """

    numbers: dict[str, float]
    texts: dict[str, str]
    flags: dict[str, bool]
    volume: VolumeParameters = field(init=False)
    spacing: NodeSpacing = field(init=False)

    def __post_init__(self) -> None:
        given = self.numbers
        for name, value in given.items():
            if not isinstance(value, (int, float)) or isinstance(value, bool) or math.isnan(value):
                raise ParameterError(f"{name} must be a number, not {value}.")
        for name in ("publish_period", "updates_period"):
            if given[name] <= 0.0:
                raise ParameterError(f"{name} must be above 0 s, not {given[name]}.")
        for name in ("cloud_period", "keep_period"):
            if not 0.0 <= given[name] < math.inf:
                raise ParameterError(f"{name} must be 0 s or more, not {given[name]}.")
        for name in ("frame_id", "base_frame_id", "odom_frame"):
            if not self.texts[name].strip("/ "):
                raise ParameterError(f"{name} must be a frame's name, and not empty.")
        if self.flags["continue_from_state"] and not self.texts["state_file"].strip():
            raise ParameterError("continue_from_state needs state_file, the path of a saved state.")
        volume = VolumeParameters(
            given["resolution"],
            given["sensor_model/max_range"],
            given["sensor_model/hit"],
            given["sensor_model/miss"],
            given["sensor_model/min"],
            given["sensor_model/max"],
        )
        spacing = NodeSpacing(given["node_distance"], given["node_angle"], given["node_period"])
        object.__setattr__(self, "volume", volume)
        object.__setattr__(self, "spacing", spacing)

    def frame(self, name: str) -> str:
        """Return a frame's name without the slash of tf's first version."""
        return self.texts[name].strip().lstrip("/")


def with_map_argument(texts: dict[str, str], arguments: Sequence[str]) -> dict[str, str]:
    """Return the texts with the map that the command line names, as octomap_server's does.

    arguments: of the command line, without ROS's.

    Raises:
        ParameterError: there is more than one, or the parameter `map_file` names another one.
    """
    if not arguments:
        return texts
    if len(arguments) > 1:
        raise ParameterError(
            f"slam_octomap takes one map file, not {len(arguments)}: {', '.join(arguments)}."
        )
    if texts["map_file"].strip() not in ("", arguments[0]):
        raise ParameterError(
            f"The command line names the map {arguments[0]}, and map_file names {texts['map_file']}; "
            "give one of them."
        )
    return {**texts, "map_file": arguments[0]}


def without_effect(given: dict) -> list[str]:
    """Return a sentence for each parameter of octomap_server that is set and has no effect here."""
    return [f"{name} has no effect: {why}." for name, why in WITHOUT_EFFECT.items() if given.get(name)]
