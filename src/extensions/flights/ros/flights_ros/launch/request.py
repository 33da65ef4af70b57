"""Checks the arguments of this package's launch files, and compiles what the launch needs.

usage: python -m flights_ros.launch.request LAUNCH_FILE [ARG:=VALUE ...]

The checks are those that the experiments' nodes make of their parameters.
Exit code 0: the launch is possible. 1: it is not, and one sentence says why.
"""

from __future__ import annotations

import signal
import sys

if __name__ == "__main__":
    signal.signal(
        signal.SIGINT, signal.SIG_DFL
    )  # until main: the imports take a second, and say nothing then

from dataclasses import dataclass
from pathlib import Path
from typing import Callable, Iterator, Mapping, Sequence
from xml.etree import ElementTree

from flights.errors import FlightError, FlightsError
from flights.goal_flight import request as goal_flight
from flights.launch_arguments import machine_pace, nodding, real_uav, simulator, teleop
from flights.launch_arguments.results_folder import check_results
from flights.worlds import scenario
from flights_ros.launch import (
    cepa_arguments,
    exploration_settings,
    inspection_settings,
    machine_code,
    slam_arguments,
)
from simulation_tools.errors import SimulationToolsError
from simulation_tools.launch_check.launch_autopilot import check_program_is_used
from simulation_tools.launch_check.launch_files import LaunchError, arguments_of
from simulation_tools_ros import launch_check


@dataclass(frozen=True)
class LaunchFiles:
    """Launch files of one package that can be flown.

    folder: where they lie. checks: by a file's name, what checks the values of its arguments.
    """

    folder: Path
    checks: Mapping[str, Callable[[Mapping[str, str]], None]]

    def flown_by(self, launch: launch_check.Launch) -> Iterator[tuple[Path, dict[str, str]]]:
        """Give those of the files that the launch starts, each with its arguments."""
        for file in launch.files:
            if file.name in self.checks and file.parent == self.folder and launch.starts:
                yield file, values_of(file, launch.given)


def main(words: Sequence[str], files: LaunchFiles) -> int:
    """Check a launch file and its arguments, and that it would end no running node; return an exit code.

    words: of the command line. files: of the package that the launch file belongs to.
    """
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        given = dict(_name_and_value(word) for word in words[1:])
        prepare(launch_check.Launch((Path(words[0]).resolve(),), given), files)
    except KeyboardInterrupt:
        print("Interrupted. The next call goes on from here.", file=sys.stderr)
        return 130
    except (FlightsError, SimulationToolsError) as error:
        print(error, file=sys.stderr)
        return 1
    return 0


def _name_and_value(word: str) -> tuple[str, str]:
    name, is_argument, value = word.partition(":=")
    if not is_argument:
        raise LaunchError(f"'{word}' is not an argument; write NAME:=VALUE, for example scenario:=forest.")
    return name, value


def prepare(launch: launch_check.Launch, files: LaunchFiles) -> None:
    """Check a launch, and compile the kernels that its flight would else wait for; raises as `check`."""
    check(launch, files)
    for file, asked in files.flown_by(launch):
        machine_code.compile_missing(machine_code.needed_by(asked))
        late = machine_pace.warning(file.name, asked)
        if late:
            print(late, file=sys.stderr, flush=True)


def check(launch: launch_check.Launch, files: LaunchFiles) -> None:
    """Check a launch as `launch_check` does, and the values and ports if it starts one of these files.

    Raises:
        FlightsError, SimulationToolsError: one sentence.
    """
    launch_check.check(launch)
    for file, asked in files.flown_by(launch):
        check_program_is_used(asked.get("autopilot", ""), launch.given)
        simulator.check(asked)
        files.checks[file.name](asked)
        simulator.check_packages(asked, launch_check.find_package)
        if "results" in asked:
            check_results(asked["results"])
        simulator.check_ports(asked)


def values_of(file: Path, given: Mapping[str, str]) -> dict[str, str]:
    """Return a launch file's arguments with their values, and those that it sets for a pass_all_args include.

    Raises:
        LaunchError: a default cannot be resolved with the given arguments.
    """
    from roslaunch.substitution_args import SubstitutionException  # takes a third of a second

    values: dict[str, str] = {}
    root = ElementTree.parse(file).getroot()
    try:
        for argument in arguments_of(file):
            if argument.name in given and not argument.fixed:
                values[argument.name] = given[argument.name]
            elif argument.text is not None:
                values[argument.name] = launch_check.resolved(argument.text, values, file)
        for include in root.findall("include[@pass_all_args='true']"):
            for handed in include.findall("arg"):
                values[handed.get("name", "")] = launch_check.resolved(handed.get("value", ""), values, file)
    except SubstitutionException as error:
        raise LaunchError(f"{file.name}: {error}") from None
    return values


def check_avoidance(avoidance: str) -> None:
    """Check that the avoidance exists: cepa, or "PACKAGE NODE"; raises FlightError."""
    if avoidance == scenario.CEPA:
        return
    import roslib.packages
    import rospkg

    words = avoidance.split()
    how = 'give avoidance:=cepa or avoidance:="PACKAGE NODE"'
    if len(words) != 2:
        raise FlightError(f"'{avoidance}' is not an avoidance; {how}.")
    try:
        found = roslib.packages.find_node(*words)
    except (roslib.packages.ROSPkgException, rospkg.ResourceNotFound):
        raise FlightError(f"There is no package '{words[0]}' for the avoidance; {how}.") from None
    if not found:
        raise FlightError(f"The package {words[0]} has no node '{words[1]}' for the avoidance; {how}.")


def check_goal_flight(asked: Mapping[str, str]) -> None:
    """Check the arguments of a flight to one goal; raises FlightsError, SimulationToolsError."""
    from flights.launch_arguments.cepa_parameters import cepa_keeps_m  # cepa takes a quarter of a second

    check_avoidance(asked["avoidance"])
    if "scenario" in asked:
        scenario.choose("scenario", asked["scenario"], scenario.SCENARIOS)
    goal_flight.read(asked, cepa_keeps_m({}))


def _exploration(asked: Mapping[str, str]) -> None:
    from flights.exploring import request as exploration  # numba takes half a second
    from flights.launch_arguments.cepa_parameters import cepa_keeps_m, led_r_lb_m

    settings = exploration_settings.read_file(Path(asked["settings"]))
    exploration.read({**asked, **settings}, cepa_keeps_m({"r_lb": led_r_lb_m(asked)}))
    if nodding.is_true(asked, "nod"):
        nodding.check_lidar(asked)
    slam_arguments.check_file(Path(asked["slam_config"]))


def _inspection(asked: Mapping[str, str]) -> None:
    from flights.inspecting import request as inspection
    from flights.launch_arguments.cepa_parameters import cepa_keeps_m, led_r_lb_m

    settings = inspection_settings.read_file(Path(asked["settings"]))
    inspection.read({**asked, **settings}, cepa_keeps_m({"r_lb": led_r_lb_m(asked)}))
    slam_arguments.check_file(Path(asked["slam_config"]))


def _real_flight(asked: Mapping[str, str]) -> None:
    real_uav.check(asked)
    cepa_arguments.check_file(Path(asked["cepa_config"]))
    if any(scenario.flag(name, asked[name]) for name in ("slam", "explore", "inspection")):
        slam_arguments.check_file(Path(asked["slam_config"]))


FILES = LaunchFiles(
    Path(__file__).resolve().parents[3] / "launch",
    {
        "fly_to_goal.launch": check_goal_flight,
        "explore.launch": _exploration,
        "inspection.launch": _inspection,
        "teleop.launch": teleop.check,
        "real.launch": _real_flight,
    },
)
"""The launch files of this package."""

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], FILES))
