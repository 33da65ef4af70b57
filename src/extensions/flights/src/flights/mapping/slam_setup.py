"""The experiments' set-up of gridslam: the YAML files of the launch files, without ROS."""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Callable, Mapping

from flights.errors import ScenarioError
from flights.mapping.mapping_flight import PACKAGE
from gridslam import OccupancyGrid, SlamParameters
from gridslam.loop_closure import LoopClosureParameters
from gridslam.session import SlamSession, closure_parameters
from input_schemas import read_made

CLOSURE_PREFIX = "closure_"


@dataclass(frozen=True)
class SlamSetup:
    """Parameters of the filter and of the loop closer."""

    parameters: SlamParameters
    loop_closure: LoopClosureParameters

    def session(
        self,
        seed: int,
        loop_closure: bool,
        starting_map: OccupancyGrid | None = None,
        say: Callable[[str], None] = lambda words: None,
        odometry_in_space: bool = False,
    ) -> SlamSession:
        """Return a new run of SLAM with one thread, because flights run in parallel, one on each core."""
        closure = self.loop_closure if loop_closure else None
        parameters = replace(self.parameters, seed=seed, threads=1)
        return SlamSession(parameters, closure, starting_map, say=say, odometry_in_space=odometry_in_space)


def read_setup(world: str) -> SlamSetup:
    """Return the set-up in `config/gridslam_WORLD.yaml`, without the node's own parameters.

    Raises:
        ScenarioError: there is no such file.
        SlamError: a parameter makes no sense.
    """
    path = Path(PACKAGE) / "config" / f"gridslam_{world}.yaml"
    return read_made(path, "SLAM's parameters", setup_of, ScenarioError)


def setup_of(given: Mapping) -> SlamSetup:
    """Return the set-up of a node's parameters by their names there."""
    names = {field.name for field in fields(SlamParameters)}
    own = {name: value for name, value in given.items() if name in names}
    closure = {
        name[len(CLOSURE_PREFIX) :]: value for name, value in given.items() if name.startswith(CLOSURE_PREFIX)
    }
    return SlamSetup(SlamParameters(**own), closure_parameters(closure))
