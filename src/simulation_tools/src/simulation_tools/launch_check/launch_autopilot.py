"""Checks before the start what a launch says of its flight controller."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Mapping

from simulation_tools import values
from simulation_tools.launch_check.launch_files import LaunchError

ARDUPILOT, STAND_IN = "ardupilot", "standin"
PROGRAM, PARAMETERS = "ardupilot", "ardupilot_parameters"
OWN_BATTERY = {
    "px4": "PX4 simulates one itself (set its SIM_BAT_DRAIN and SIM_BAT_MIN_PCT)",
    ARDUPILOT: "ArduPilot simulates one itself",
}
"""Why a simulated battery of ours is of no use to a flight controller."""


def check_autopilot(asked: Mapping[str, Any]) -> None:
    """Check a simulator's flight controller. An argument that is missing is not checked.

    asked: values of a launch file's arguments by their names: autopilot, ardupilot, ardupilot_parameters,
    lockstep, battery.

    Raises:
        SimulationToolsError: one sentence.
    """
    autopilot = values.choice("autopilot", str(asked["autopilot"]), values.AUTOPILOTS)
    if autopilot == ARDUPILOT:
        _check_ardupilot(str(asked[PROGRAM]).strip(), str(asked.get(PARAMETERS, "")).split())
    if autopilot == STAND_IN:
        return
    if str(asked.get("lockstep", False)).lower() == "true":
        raise LaunchError(
            f"lockstep:=true needs autopilot:=standin; with {autopilot} leave it out: physics and flight "
            "controller are in step with each other anyway."
        )
    battery = str(asked.get("battery", "")).strip()
    if battery not in ("", "endless"):
        raise LaunchError(
            f"battery:={battery} is of no use with autopilot:={autopilot}: {OWN_BATTERY[autopilot]}. Leave "
            "battery out, or give battery:=endless."
        )


def check_program_is_used(autopilot: str, given: Mapping[str, str]) -> None:
    """Check that a program of ArduPilot is not named for another flight controller, which would then fly.

    given: arguments of the command line. Raises LaunchError.
    """
    if given.get(PROGRAM, "").strip() and autopilot != ARDUPILOT:
        raise LaunchError(
            f"{PROGRAM}:={given[PROGRAM]} is of no use with autopilot:={autopilot}; add "
            f"autopilot:={ARDUPILOT}, or leave {PROGRAM} out."
        )


def _check_ardupilot(program: str, files: list[str]) -> None:
    from simulation_tools.ardupilot_sitl.program import check_parameter_file, check_program  # loads numpy

    if program:
        _check_is_absolute(PROGRAM, program)
    check_program(program)
    for file in files:
        _check_is_absolute(PARAMETERS, file)
        check_parameter_file(file)


def _check_is_absolute(name: str, given: str) -> None:
    """Check that a node, which runs in another folder, finds a file; raises LaunchError."""
    if not Path(given).is_absolute():
        example = f"$HOME{given[1:]}" if given.startswith("~/") else f"$PWD/{given}"
        raise LaunchError(
            f"{name}:={given} is not an absolute path; give one, for example {name}:={example}."
        )
