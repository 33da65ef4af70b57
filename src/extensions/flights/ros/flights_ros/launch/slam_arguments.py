"""Checks the arguments of a launch file that go to gridslam, as its node does."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Any, Mapping

from flights.errors import FlightError
from flights.worlds import scenario
from flights_ros.launch.parameter_file import no_such_parameter, parameters_in

EVERY_NTH = (1, 1_000_000)


def check(asked: Mapping[str, str]) -> None:
    """Check `throttle_scans`, `slam_config` and `starting_map`; raises FlightError or ScenarioError."""
    from gridslam_ros.sessions import Sessions  # takes a third of a second

    from gridslam import SlamError

    throttle_scans = scenario.whole_number("throttle_scans", asked["throttle_scans"], *EVERY_NTH)
    starting_map = asked["starting_map"].strip()
    starting_map = starting_map and str(scenario.absolute("starting_map", starting_map))
    check_file(Path(asked["slam_config"]), throttle_scans)
    try:
        Sessions({"starting_map": starting_map}, say=lambda words: None)
    except SlamError as error:
        what = str(error).rstrip(".")
        raise FlightError(f"{what}; give a map's YAML file with starting_map:=FILE.") from None


def check_file(path: Path, throttle_scans: int = 1) -> None:
    """Check gridslam's parameters in a YAML file; raises FlightError."""
    from gridslam_ros.sessions import Sessions

    from gridslam import SlamError
    from node_tools.parameters import exponents_as_text  # loads rospy

    how = "give a YAML file of gridslam's parameters with slam_config:=FILE."
    written = parameters_in(path, "SLAM's parameters", how)
    given = {**written, "throttle_scans": throttle_scans, "starting_map": ""}
    try:
        _check_names(written)
        Sessions(given, say=lambda words: None)
    except SlamError as error:
        words = f"{error} {exponents_as_text(written)}".strip()
        raise FlightError(f"gridslam cannot fly with slam_config:={path}: {words}") from None


def _check_names(given: Mapping[str, Any]) -> None:
    """Raise SlamError for a name that is no parameter, because a misspelt one would have no effect."""
    from gridslam_ros.parameters import NodeParameters, sort_parameters

    from gridslam import ParameterError, SlamParameters

    unknown = sort_parameters(dict(given))[3]
    if unknown:
        known = [field.name for kind in (NodeParameters, SlamParameters) for field in fields(kind)]
        raise ParameterError(no_such_parameter(unknown[0], known))
