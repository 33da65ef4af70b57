"""Checks the arguments of this package's launch files, and compiles what the launch needs.

usage: python -m master_thesis_ros.launch.request LAUNCH_FILE [ARG:=VALUE ...]

As `flights_ros.launch.request`, with the checks of Experiments 1 to 4.
"""

from __future__ import annotations

import signal
import sys

if __name__ == "__main__":
    signal.signal(
        signal.SIGINT, signal.SIG_DFL
    )  # until main: the imports take a second, and say nothing then

from pathlib import Path
from typing import Mapping

from flights.launch_arguments import nodding
from flights_ros.launch import slam_arguments
from flights_ros.launch.request import LaunchFiles, check_goal_flight, main
from master_thesis.experiments_3_4 import request as mission_flight


def _mission_flight(asked: Mapping[str, str]) -> None:
    from flights.launch_arguments.cepa_parameters import cepa_keeps_m, cepa_of

    cepa_of(asked, {"r_ub": "r_ub"})
    mission_flight.read(asked, cepa_keeps_m({}))
    nodding.check(asked)
    slam_arguments.check(asked)


def _trial(asked: Mapping[str, str]) -> None:
    from flights.launch_arguments.cepa_parameters import cepa_of
    from master_thesis.experiment_2 import request as trial

    cepa = cepa_of(asked, {"k_filter": "K", "r_lb": "r_lb"})
    trial.read({**asked, "look_s": asked["look"]}, cepa)


FILES = LaunchFiles(
    Path(__file__).resolve().parents[3] / "launch",
    {
        "experiment_1.launch": check_goal_flight,
        "experiment_2.launch": _trial,
        "experiment_3.launch": _mission_flight,
        "experiment_4.launch": _mission_flight,
    },
)
"""The launch files of this package."""

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:], FILES))
