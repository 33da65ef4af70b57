"""Checks the arguments of a launch file that go to gridslam, as its node does."""

from __future__ import annotations

import difflib
from dataclasses import fields
from pathlib import Path
from typing import Any, Mapping

from master_thesis.errors import FlightError
from master_thesis.worlds import scenario
from node_tools.parameters import exponents_as_text

EVERY_NTH = (1, 1_000_000)


def check(asked: Mapping[str, str]) -> None:
    """Check `throttle_scans`, `slam_config` and `starting_map`; raises FlightError or ScenarioError."""
    from gridslam_ros.sessions import Sessions  # takes a third of a second

    from gridslam import SlamError

    throttle_scans = scenario.whole_number("throttle_scans", asked["throttle_scans"], *EVERY_NTH)
    starting_map = asked["starting_map"].strip()
    starting_map = starting_map and str(scenario.absolute("starting_map", starting_map))
    path = Path(asked["slam_config"])
    written = _parameters_in(path)
    given = {**written, "throttle_scans": throttle_scans, "starting_map": ""}
    try:
        _check_names(written)
        Sessions(given, say=lambda words: None)
    except SlamError as error:
        words = f"{error} {exponents_as_text(written)}".strip()
        raise FlightError(f"gridslam cannot fly with slam_config:={path}: {words}") from None
    try:
        Sessions({"starting_map": starting_map}, say=lambda words: None)
    except SlamError as error:
        what = str(error).rstrip(".")
        raise FlightError(f"{what}; give a map's YAML file with starting_map:=FILE.") from None


def _check_names(given: Mapping[str, Any]) -> None:
    """Raise SlamError for a name that is no parameter, because a misspelt one would have no effect."""
    from gridslam_ros.parameters import NodeParameters, sort_parameters

    from gridslam import ParameterError, SlamParameters

    unknown = sort_parameters(dict(given))[3]
    if unknown:
        known = [field.name for kind in (NodeParameters, SlamParameters) for field in fields(kind)]
        close = difflib.get_close_matches(unknown[0], known, n=1)
        meant = f"did you mean {close[0]}?" if close else "leave it out."
        raise ParameterError(f"There is no parameter {unknown[0]}; {meant}")


def _parameters_in(path: Path) -> dict[str, Any]:
    import rosparam  # noqa: F401  gives YAML its angles, as for roslaunch
    import yaml

    how = "give a YAML file of gridslam's parameters with slam_config:=FILE."
    try:
        found = yaml.safe_load(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise FlightError(f"SLAM's parameters {path} cannot be read: {error.strerror}; {how}") from None
    except (yaml.YAMLError, ValueError) as error:
        mark = getattr(error, "problem_mark", None)
        where = f" in line {mark.line + 1}" if mark else ""
        raise FlightError(f"SLAM's parameters {path} are no valid YAML{where}; {how}") from None
    if found is None:
        return {}
    if not isinstance(found, dict):
        raise FlightError(f"{path} holds no names with values; {how}")
    return found
