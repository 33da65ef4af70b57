"""The parameters of slam_octomap: those of octomap_server, and new ones."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, Mapping, Sequence

from flight_basics.checks import check_limits, limited
from gridslam import ParameterError
from gridslam.volume import NodeSpacing, VolumeParameters
from gridslam.volume.parameters import RESOLUTIONS_M
from gridslam_ros.parameters import true_or_false

RANGES = tuple(f"pointcloud_{end}_{axis}" for axis in "xyz" for end in ("min", "max"))
FRAMES = ("frame_id", "base_frame_id", "odom_frame")
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
class SensorModel:
    """The parameters in the namespace sensor_model: what a ray tells of the voxels on its way.

    Raises:
        ParameterError: a value makes no sense.
    """

    max_range: float = limited(VolumeParameters.max_range_m, -math.inf, math.inf)
    """A longer ray counts as free up to here, m. -1 means no limit."""
    min_range: float = limited(-1.0, -math.inf, math.inf)
    """A nearer point is left out, m. -1 means no limit."""
    hit: float = limited(VolumeParameters.hit, above=0.5, below=1.0)
    """Probability by which a hit makes a voxel occupied, above 0.5."""
    miss: float = limited(VolumeParameters.miss, above=0.0, below=0.5)
    """Probability by which a ray through a voxel makes it free, below 0.5."""
    min: float = limited(VolumeParameters.least, above=0.0, below=0.5)
    """Least probability of a voxel. Further rays do not lower it."""
    max: float = limited(VolumeParameters.greatest, above=0.5, below=1.0)
    """Greatest probability of a voxel. Further hits do not raise it."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "sensor_model/{}")


@dataclass(frozen=True)
class OctomapParameters:
    """What the node is started with, beside the sensor's model.

    Raises:
        ParameterError: a value makes no sense.
    """

    resolution: float = limited(VolumeParameters.resolution_m, RESOLUTIONS_M[0], RESOLUTIONS_M[1])
    """Side of a voxel, m."""
    frame_id: str = "map"
    """Frame of the map."""
    base_frame_id: str = "base_link"
    """Frame of the UAV. Its pose at each cloud is kept, so that the map follows when a loop closes."""
    odom_frame: str = "odom"
    """Frame of the odometry. If TF does not know it, clouds are placed in `frame_id` directly."""
    sensor_frame: str = ""
    """Frame of the lidar, if its clouds come in a frame that the UAV does not carry, as `map`."""
    sensor_model: SensorModel = SensorModel()
    """What a ray tells of the voxels on its way."""
    occupancy_min_z: float = limited(-math.inf, -math.inf, math.inf)
    """Lowest height that is shown, m."""
    occupancy_max_z: float = limited(math.inf, -math.inf, math.inf)
    """Greatest height that is shown, m."""
    pointcloud_min_x: float = limited(-math.inf, -math.inf, math.inf)
    """Points with a smaller x in the map's frame are left out, m."""
    pointcloud_max_x: float = limited(math.inf, -math.inf, math.inf)
    """Points with a greater x in the map's frame are left out, m."""
    pointcloud_min_y: float = limited(-math.inf, -math.inf, math.inf)
    """Points with a smaller y in the map's frame are left out, m."""
    pointcloud_max_y: float = limited(math.inf, -math.inf, math.inf)
    """Points with a greater y in the map's frame are left out, m."""
    pointcloud_min_z: float = limited(-math.inf, -math.inf, math.inf)
    """Points with a smaller z in the map's frame are left out, m."""
    pointcloud_max_z: float = limited(math.inf, -math.inf, math.inf)
    """Points with a greater z in the map's frame are left out, m."""
    publish_period: float = limited(1.0, above=0.0, most=math.inf)
    """Least time between two whole maps, s."""
    updates_period: float = limited(0.2, above=0.0, most=math.inf)
    """Least time between two messages on `~updates`, s."""
    cloud_period: float = limited(0.0, 0.0)
    """The map takes a cloud at most so often, s. 0 means every one."""
    keep_period: float = limited(0.0, 0.0)
    """A copy of the state is kept so often for a node that dies and starts again, s. 0 means never."""
    node_distance: float = limited(NodeSpacing.distance_m, above=0.0, most=math.inf)
    """A cloud is kept for loops after this much way, m."""
    node_angle: float = limited(NodeSpacing.angle_rad, above=0.0, most=math.inf)
    """A cloud is kept for loops after this much turning, rad."""
    node_period: float = limited(NodeSpacing.period_s, above=0.0, most=math.inf)
    """A cloud is kept for loops after this time, s."""
    greatest_distance: float = limited(3.0, -math.inf, math.inf)
    """The distance field ends at this distance from what is occupied, m."""
    publish_free_space: bool = False
    """Publish the centres of free voxels too."""
    map_file: str = ""
    """File (.bt or .ot) to begin with. No loop moves it."""
    state_file: str = ""
    """Path of the file for `~save_state` and `~load_state`."""
    continue_from_state: bool = False
    """Begin with the state in `state_file`."""

    def __post_init__(self) -> None:
        true_or_false(self)
        check_limits(self, ParameterError)
        for name in FRAMES:
            if not getattr(self, name).strip("/ "):
                raise ParameterError(f"{name} must be a frame's name, and not empty.")
        if self.continue_from_state and not self.state_file.strip():
            raise ParameterError("continue_from_state needs state_file, the path of a saved state.")
        _ = self.volume, self.spacing  # which check themselves

    @cached_property
    def volume(self) -> VolumeParameters:
        """The map's."""
        model = self.sensor_model
        return VolumeParameters(self.resolution, model.max_range, model.hit, model.miss, model.min, model.max)

    @cached_property
    def spacing(self) -> NodeSpacing:
        """Which clouds are kept."""
        return NodeSpacing(self.node_distance, self.node_angle, self.node_period)

    def frame(self, name: str) -> str:
        """Return a frame's name without the slash of tf's first version."""
        return str(getattr(self, name)).strip().lstrip("/")


_IN_MODEL = {f"sensor_model/{each.name}": each.name for each in fields(SensorModel)}
DEFAULTS: dict[str, Any] = {
    **{each.name: each.default for each in fields(OctomapParameters) if each.name != "sensor_model"},
    **{name: getattr(SensorModel(), field) for name, field in _IN_MODEL.items()},
}
"""By the names on the parameter server."""


def parameters_of(given: Mapping[str, Any]) -> OctomapParameters:
    """Return the parameters of values by their names on the parameter server.

    Raises:
        ParameterError: a value makes no sense.
    """
    model = {field: given[name] for name, field in _IN_MODEL.items() if name in given}
    others = {name: value for name, value in given.items() if name not in _IN_MODEL}
    return OctomapParameters(**others, sensor_model=SensorModel(**model))


def with_map_argument(values: Mapping[str, Any], arguments: Sequence[str]) -> dict[str, Any]:
    """Return the values with the map that the command line names, as octomap_server's does.

    arguments: of the command line, without ROS's.

    Raises:
        ParameterError: there is more than one, or the parameter `map_file` names another one.
    """
    if not arguments:
        return {**values}
    if len(arguments) > 1:
        raise ParameterError(
            f"slam_octomap takes one map file, not {len(arguments)}: {', '.join(arguments)}."
        )
    if values["map_file"].strip() not in ("", arguments[0]):
        raise ParameterError(
            f"The command line names the map {arguments[0]}, and map_file names {values['map_file']}; "
            "give one of them."
        )
    return {**values, "map_file": arguments[0]}


def without_effect(given: dict) -> list[str]:
    """Return a sentence for each parameter of octomap_server that is set and has no effect here."""
    return [f"{name} has no effect: {why}." for name, why in WITHOUT_EFFECT.items() if given.get(name)]
