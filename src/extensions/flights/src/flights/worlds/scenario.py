"""Scenarios: a world, a start and a goal; and checks of a launch file's values."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Sequence

from flights.errors import ScenarioError
from simulation_tools.vehicle.uav import is_lidar

WORLDS = Path(__file__).resolve().parents[3] / "worlds"
"""The folder of the worlds that this package brings."""
THESIS_ALGORITHMS = ("improved", "original")
ALGORITHMS = (*THESIS_ALGORITHMS, "dynamic")
CEPA = "cepa"
LIDARS = ("urg", "ust", "utm", "puck", "tim", "m8")
CLOUD_LIDARS = ("puck", "near_puck", "qt64", "m8")  # their models have clouds; without GNSS these are matched
POSE_SOURCES = ("ground_truth", "odometry")
MAPPING_POSE_SOURCES = (*POSE_SOURCES, "slam")  # of experiments that run SLAM
MAVROS = ("sim", "real")
SPEEDS_M_S = (0.05, 15.0)  # the position controller's greatest speed; the least one, so that a flight ends
LOOKAHEADS_S = (0.0, 10.0)  # the position controller's
SEEDS = (0, 2**31 - 1)  # roslaunch reads greater numbers as real ones
SCENARIOS = ("empty", "sparse", "forest", "hallway")
NAMED_WORLDS = ("hold_3d", "hold_3d_cargo", "ballast_tank")  # of explore.launch and inspection.launch
FLIGHT_HEIGHT_M = 2.0


@dataclass(frozen=True)
class Scenario:
    """A world file, the UAV's start (x, y, z, yaw) and its goal, in `world`.

    mission_path: file of waypoints. The goal is the last of them and may be anywhere. comes_home: the goal is
    the start.
    """

    name: str
    world_path: Path
    start_xyz_yaw: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    goal_xyz_m: tuple[float, float, float] = (40.0, 0.0, FLIGHT_HEIGHT_M)
    mission_path: Path | None = None
    comes_home: bool = False

    def __post_init__(self) -> None:
        if not Path(self.world_path).is_file():
            raise ScenarioError(
                f"There is no world file {self.world_path}; give the path of an SDF world with world:=FILE."
            )
        straight = math.dist(self.start_xyz_yaw[:2], self.goal_xyz_m[:2])
        if self.mission_path is None and not self.comes_home and not 1.0 <= straight <= 10_000.0:
            raise ScenarioError(
                f"The goal lies {straight:.2f} m from the start; it must be 1 m to 10 km away."
            )


def scenario(name: str, worlds_folder: Path) -> Scenario:
    """Return one of Experiment 1's scenarios (thesis, figures 8.1 and 8.2).

    Raises:
        ScenarioError: there is none of this name.
    """
    choose("scenario", name, SCENARIOS)
    return Scenario(name, Path(worlds_folder) / f"{name}.world")


def named_world(given: str) -> Path:
    """Return the path of a world's file. In place of one of `NAMED_WORLDS` the launch file gives its path.

    Raises:
        ScenarioError: there is no such file, and the sentence lists the names; or its path is relative.
    """
    path = Path(given)
    if not path.is_file() and (path.is_absolute() or not path.suffix):
        names = "|".join(NAMED_WORLDS)
        raise ScenarioError(
            f"There is no world '{given}'; choose world:={names}, or the path of an SDF world file."
        )
    return absolute("world", given)


def lidar(given: str) -> str:
    """Return a lidar's name: one of `LIDARS`, or a model in GAZEBO_MODEL_PATH; raises ScenarioError."""
    if not is_lidar(given):
        raise ScenarioError(
            f"There is no lidar '{given}'; choose lidar:={'|'.join(LIDARS)}, or NAME of a model lidar_NAME "
            "in a folder of GAZEBO_MODEL_PATH."
        )
    return given


def choose(what: str, given: str, choices: Sequence[str]) -> str:
    """Return `given` if it is one of the choices.

    Raises:
        ScenarioError: a sentence that lists the choices.
    """
    if given not in choices:
        raise ScenarioError(f"There is no {what} '{given}'; choose {what}:={'|'.join(choices)}.")
    return given


def number(what: str, given: Any, least: float, greatest: float) -> float:
    """Return the given value as a number within the bounds.

    Raises:
        ScenarioError: a sentence that says what is expected.
    """
    value = _as_float(given)
    if not least <= value <= greatest:
        raise ScenarioError(f"'{given}' is no {what}; give a number from {least:g} to {greatest:g}.")
    return value


def whole_number(what: str, given: Any, least: int, greatest: int) -> int:
    """Return the given value as a whole number within the bounds.

    Raises:
        ScenarioError: a sentence that says what is expected.
    """
    value = _as_float(given)
    if not least <= value <= greatest or value != int(value):
        raise ScenarioError(f"'{given}' is no {what}; give a whole number from {least} to {greatest}.")
    return int(value)


def flag(what: str, given: Any) -> bool:
    """Return whether the given value is true: as roslaunch sets it, or as one writes it.

    Raises:
        ScenarioError: a sentence that says what is expected.
    """
    text = str(given).lower()
    if text not in ("true", "false"):
        raise ScenarioError(f"'{given}' is no {what}; give true or false.")
    return text == "true"


def absolute(what: str, given: str) -> Path:
    """Return an absolute path, because roslaunch starts nodes in another folder.

    The shell leaves a ~ after := as it is, and so do most nodes.

    Raises:
        ScenarioError: the path is relative, or begins with ~.
    """
    path = Path(given)
    if not path.is_absolute():
        example = f"$HOME{given[1:]}" if given.startswith("~/") else f"$PWD/{given}"
        raise ScenarioError(
            f"{what}:={given} is not an absolute path; give one, for example {what}:={example}."
        )
    return path


def _as_float(given: Any) -> float:
    """Return a number, or NaN, which fails every bound."""
    try:
        return math.nan if isinstance(given, bool) else float(given)
    except (TypeError, ValueError):
        return math.nan


def place(what: str, text: str) -> tuple[float, float, float]:
    """Read "x y z"; raises ScenarioError with a sentence that says what is expected."""
    x, y, z = _numbers(what, text, ("x", "y", "z"))
    return x, y, z


def place_and_yaw(what: str, text: str) -> tuple[float, float, float, float]:
    """Read "x y z yaw"; raises ScenarioError with a sentence that says what is expected."""
    x, y, z, yaw = _numbers(what, text, ("x", "y", "z", "yaw"))
    if abs(yaw) > 2.0 * math.pi:
        raise ScenarioError(
            f"The yaw of {what} '{text}' is {yaw:g}, and yaw is in radians, from -6.28 to 6.28; "
            f"{yaw:g} degrees are {math.radians(yaw):.4g}."
        )
    return x, y, z, yaw


def _numbers(what: str, text: str, names: Sequence[str]) -> tuple[float, ...]:
    """Read "1 2 0.5", "1,2,0.5" or "(1, 2, 0.5)" as that many finite numbers as there are names.

    Raises:
        ScenarioError: a sentence that says what is expected.
    """
    try:
        values = tuple(map(float, str(text).translate(dict.fromkeys(map(ord, ",()[]"), " ")).split()))
    except ValueError:
        values = ()
    if len(values) != len(names) or not all(math.isfinite(value) for value in values):
        form = " ".join(names)
        raise ScenarioError(
            f"'{text}' is no {what}; give {len(names)} numbers in metres and radians: {form}."
        )
    return values
