"""The node's parameters: the filter's, the loop closure's, and the node's own."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

from flight_basics.checks import check_limits, limited
from gridslam import ParameterError, SlamParameters

NAMES = ("base_frame", "map_frame", "odom_frame")
PATHS = ("starting_map", "state_file")
SAMPLED_LIKELIHOOD = ("llsamplerange", "llsamplestep", "lasamplerange", "lasamplestep")
CLOSURE_PREFIX = "closure_"


@dataclass(frozen=True)
class NodeParameters:
    """The parameters of slam_gmapping's node, with the same names, and new ones.

    Raises ParameterError, in one sentence, for values that make no sense.
    """

    base_frame: str = "base_link"
    """Frame of the vehicle."""
    map_frame: str = "map"
    """Frame of the map."""
    odom_frame: str = "odom"
    """Frame of the odometry."""
    throttle_scans: int = limited(1, 1)
    """SLAM uses one of so many scans."""
    map_update_interval: float = limited(5.0, 0.0)
    """Least time between two maps, by the stamps of the scans, s."""
    transform_publish_period: float = limited(0.05, 0.0)
    """Least time between two transforms map -> odom, s. 0: none is published."""
    tf_delay: float | None = limited(None, 0.0)
    """The stamp of map -> odom is later than its scan by this, s. None: by transform_publish_period."""
    levelling: bool = True
    """Undo the lean of the base frame in the scans."""
    odometry_covariance: bool = False
    """How uncertain a motion is comes from the topic odometry, not from srr, srt, str and stt."""
    odometry_in_space: bool = False
    """Odometry is matched in space, as by clouds: another height does not lead it astray."""
    clouds: bool = False
    """Loops are closed by the topic cloud, too: in space, and from any height."""
    floor_z: float = 0.0
    """Height of the floor in odom_frame, m. Beams that end on it are left out. NaN means unknown."""
    starting_map: str = ""
    """Path of the YAML file of a starting map; empty: none."""
    starting_pose: tuple = ()
    """x, y in m and yaw in rad of the base in the map at the first scan; empty: as odometry has it."""
    localisation_only: bool = False
    """SLAM only localises: the starting map, or the saved state's, stays as it is."""
    loop_closure: bool | None = None
    """Find places again and correct the map. None: yes, unless localisation_only."""
    state_file: str = ""
    """Path of the file for ~save_state and ~load_state."""
    continue_from_state: bool = False
    """Begin with the state in state_file."""

    def __post_init__(self) -> None:
        if self.loop_closure is None:
            object.__setattr__(self, "loop_closure", not self.localisation_only)
        true_or_false(self)
        check_limits(self, ParameterError)
        self._check_types()
        object.__setattr__(self, "throttle_scans", int(self.throttle_scans))
        if len({getattr(self, name).lstrip("/") for name in NAMES}) < len(NAMES):
            raise ParameterError("base_frame, map_frame and odom_frame must be three different names.")
        if self.localisation_only and not self.starting_map and not self.continue_from_state:
            raise ParameterError("localisation_only needs a map: give starting_map, or continue_from_state.")
        if self.localisation_only and self.loop_closure:
            raise ParameterError("loop_closure changes the map, which localisation_only forbids; choose one.")
        if self.continue_from_state and not self.state_file:
            raise ParameterError("continue_from_state needs state_file.")
        object.__setattr__(self, "starting_pose", _pose(self.starting_pose))

    def _check_types(self) -> None:
        for name in NAMES:
            value = getattr(self, name)
            if not isinstance(value, str) or not value.strip("/"):
                raise ParameterError(f"{name} must be a frame's name, not {value!r}.")
        for name in PATHS:
            object.__setattr__(self, name, str(getattr(self, name)).strip())
        if isinstance(self.floor_z, bool) or not isinstance(self.floor_z, (int, float)):
            raise ParameterError(f"floor_z must be a number, not {self.floor_z!r}.")

    @property
    def ahead_s(self) -> float:
        """The stamp of map -> odom is ahead of the triggering message's by this."""
        return self.transform_publish_period if self.tf_delay is None else self.tf_delay

    @property
    def floor_z_m(self) -> float | None:
        """Height of the floor in odom_frame, or None."""
        return None if math.isnan(self.floor_z) else float(self.floor_z)


def true_or_false(parameters: Any) -> None:
    """Turn 1 and 0 in a dataclass's fields that are flags into True and False.

    Raises:
        ParameterError: a flag is something else.
    """
    for each in dataclasses.fields(parameters):
        if each.type not in ("bool", "bool | None"):
            continue
        value = getattr(parameters, each.name)
        if not isinstance(value, (bool, int)):
            raise ParameterError(f"{each.name} must be true or false, not {value!r}.")
        object.__setattr__(parameters, each.name, bool(value))


def sort_parameters(given: dict) -> tuple[NodeParameters, SlamParameters, dict, list[str]]:
    """Return (the node's, the filter's, the loop closure's, unknown names) of parameters by name.

    Raises:
        ParameterError: a value makes no sense.
    """
    node_names = {field.name for field in dataclasses.fields(NodeParameters)}
    slam_names = {field.name for field in dataclasses.fields(SlamParameters)}
    node = {name: value for name, value in given.items() if name in node_names}
    slam = {name: value for name, value in given.items() if name in slam_names}
    closure = {
        name[len(CLOSURE_PREFIX) :]: value for name, value in given.items() if name.startswith(CLOSURE_PREFIX)
    }
    known = node_names | slam_names | {CLOSURE_PREFIX + name for name in closure}
    return NodeParameters(**node), SlamParameters(**slam), closure, sorted(set(given) - known)


def without_effect(given: dict) -> str:
    """Return a sentence about given parameters without effect; empty if there are none."""
    names = [name for name in SAMPLED_LIKELIHOOD if name in given]
    if not names:
        return ""
    return (
        f"{', '.join(names)} will change nothing, here as in slam_gmapping: they are of a sampled likelihood "
        "that its scan matcher has, and its filter never calls."
    )


def clamped(slam: SlamParameters) -> str:
    """Return a sentence about parameters that are clipped; empty if there are none."""
    if slam.maxUrange is None or slam.maxRange is None or slam.maxUrange <= slam.maxRange:
        return ""
    return f"maxUrange {slam.maxUrange:g} is more than maxRange; it is taken as {slam.maxRange:g}."


def _pose(value: Any) -> tuple:
    """Read (x, y, yaw) from "x y yaw", a list, or nothing."""
    if isinstance(value, str):
        value = value.replace(",", " ").split()
    try:
        numbers = tuple(float(number) for number in value)
    except (TypeError, ValueError):
        numbers = (math.nan,)
    if len(numbers) not in (0, 3) or not all(math.isfinite(number) for number in numbers):
        raise ParameterError(f'starting_pose must be "x y yaw" in m and rad, not {value!r}.')
    return numbers
