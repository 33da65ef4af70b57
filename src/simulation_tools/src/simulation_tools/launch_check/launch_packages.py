"""Checks before the start that the real MAVROS is there, with the plugins that a launch needs."""

from __future__ import annotations

from typing import Callable

from simulation_tools.launch_check.launch_files import LaunchError

HOW = "Build it as src/extensions/flights/doc/from_source.md says, or leave out"
REAL = "mavros:=real"


def check_mavros_is_there(mavros: str, gnss: bool, find: Callable[[str], object], word: str = REAL) -> None:
    """Check that a launch finds the real MAVROS if it is to start it.

    mavros: sim, real or none. gnss: False: the flight controller needs external poses. find: raises
    LookupError for a package that is not there. word: of the command line, that asks for it.

    Raises:
        LaunchError: a package is missing.
    """
    if mavros != "real":
        return
    needs = {"mavros": f"{word} needs"}
    if not gnss:
        needs["mavros_extras"] = f"{word} with gnss:=false needs, for external poses,"
    for package, what in needs.items():
        try:
            find(package)
        except LookupError:
            raise LaunchError(
                f"{what} the package {package}, and ROS does not find it. {HOW} {word}."
            ) from None
