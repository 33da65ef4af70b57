"""Measurements and statements of the thesis's chapters 8 and 9, transcribed, to compare with ours.

"The path to Autonomous Inspection using an Unmanned Aerial Vehicle", master's thesis, NTNU.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import Mapping, NamedTuple

TITLE = "The path to Autonomous Inspection using an Unmanned Aerial Vehicle"
UNIVERSITY = "Norwegian University of Science and Technology"


class Figure(NamedTuple):
    """A figure of the thesis: its number and the words below it."""

    number: str
    caption: str


class MapWords(NamedTuple):
    """The thesis's words on one map: the figure, and its verdict, quoted or nearly quoted."""

    figure: str
    words: str


TABLE_8_1_MS: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "original": {"empty": 14.3, "sparse": 16.9, "forest": 17.0, "hallway": 16.9},
        "improved": {"empty": 0.0, "sparse": 3.2, "forest": 5.1, "hallway": 1.1},
    }
)
"""Mean computation time in ms by algorithm and scenario; 0 where the table says "~ 0"."""

SCENARIO_FIGURES = MappingProxyType({"empty": "8.1", "sparse": "8.1", "forest": "8.2", "hallway": "8.2"})


class Lidar(NamedTuple):
    """A column of table 8.2; short: the thesis's shorthand."""

    short: str
    name: str
    fov_deg: float
    range_m: float
    resolution_deg: float
    frequency_hz: float


LIDARS: Mapping[str, Lidar] = MappingProxyType(
    {
        "urg": Lidar("URG", "Hokuyo URG-04LX-UG01", 240, 5.6, 0.35, 10),
        "ust": Lidar("UST", "Hokuyo UST-10LX", 270, 10, 0.25, 40),
        "utm": Lidar("UTM", "Hokuyo UTM-30LX-EW", 270, 30, 0.25, 40),
        "puck": Lidar("Puck", "Velodyne Puck LITE", 360, 100, 0.2, 20),
        "tim": Lidar("TiM", "SICK TiM", 270, 25, 0.33, 15),
        "m8": Lidar("M8", "Quanergy M8-1", 360, 150, 0.2, 30),
    }
)
"""Table 8.2. The text (9.1.2) gives the TiM 15 m, and its type as TiM571 for the table's TiM-751."""

TIM_RANGE_IN_TEXT_M = 15.0

FIGURES: Mapping[str, Figure] = MappingProxyType(
    {
        figure.number: figure
        for figure in (
            Figure(
                "8.1",
                "Two different scenarios: a completely empty field and a field with obstacles sparsely "
                "spread around. Two start and goal posts are placed at the top and bottom.",
            ),
            Figure(
                "8.2", "Two different scenarios: a forest like environment and a indoor area with a hallway."
            ),
            Figure(
                "8.3",
                "Here we can see the emergency avoidance setup, with the Gazebo world to the left and "
                "the visualisation to the right.",
            ),
            Figure(
                "8.4",
                "To check that our algorithm works we test the emergency avoidance with different Ks.",
            ),
            Figure(
                "8.5",
                "Here we see the same set up but with lower Ks. With low enough Ks the figure starts to "
                "loose its shape.",
            ),
            Figure(
                "8.6",
                "Here we see the difference between the original and the improved emergency avoidance. "
                "As the original does not cause a collision in this scenario the arrows are identical.",
            ),
            Figure(
                "8.7",
                "Here we see the difference between the original and the improved emergency avoidance. "
                "The original emergency avoidance would have caused the UAV to crash into the columns, "
                "but the improved emergency avoidance finds a safe escape.",
            ),
            Figure(
                "8.8",
                "Environment created to test SLAM. Note the brown “box” is a bookshelf and shows up on "
                "the maps as more of a [-shape than a box.",
            ),
            Figure(
                "8.9",
                "The simulation world and the map created by SLAM side by side. Lidar: Hokuyo UST-10LX.",
            ),
            Figure("8.10", "The maps created by URG-04LX-UG01 and UTM-30LX-EW side by side."),
            Figure(
                "8.11",
                "Figure showing how fast odometry can drift, even after some seconds around a corner. "
                "Lidar: SICK TiM571. (a) Note the wall on the bottom left, where the odometry has "
                "drifted. (b) Map fully created. Note how the wall down to the left has been corrected "
                "due to loop-closure.",
            ),
            Figure("8.12", "The maps created by the Velodyne Puck LITE and Quanergy M8-1 side by side."),
            Figure(
                "8.13",
                "Cargo hold environment. The dimensions are 20x30 meters. The “beams” on the sides are "
                "1 meter wide.",
            ),
            Figure(
                "8.14",
                "Map of the cargo hold. This misalignment was to great for the loop closure to fix. "
                "Lidar: Hokuyo URG-04LX-UG01.",
            ),
            Figure(
                "8.15",
                "Map of the cargo hold. The misalignment was fixed by the loop closure. Lidar: Hokuyo "
                "UST-10LX.",
            ),
            Figure(
                "8.16",
                "The maps created by UTM-30LX-EW and TiM571 side by side. (b) Note the slight bend in "
                "the side walls.",
            ),
            Figure(
                "8.17",
                "The maps created by Velodyne Puck LITE and Quarnegy M8-1 side by side. The maps are "
                "virtually indistinguishable.",
            ),
        )
    }
)
"""The captions of chapter 8, quoted."""

MAPS: Mapping[str, Mapping[str, MapWords]] = MappingProxyType(
    {
        "room": {
            "urg": MapWords("8.10a", "slightly less complete"),
            "ust": MapWords("8.9", "pretty good"),
            "utm": MapWords("8.10b", "pretty good"),
            "puck": MapWords("8.12a", "pretty good"),
            "tim": MapWords("8.11", "a wall drifted, corrected when seen again"),
            "m8": MapWords("8.12b", "pretty good"),
        },
        "hold": {
            "urg": MapWords("8.14", "drifted too far for the loop closure"),
            "ust": MapWords("8.15", "misaligned, corrected by the loop closure"),
            "utm": MapWords("8.16a", "equal to the world"),
            "puck": MapWords("8.17a", "equal to the world"),
            "tim": MapWords("8.16b", "good, the long wall bulges inwards a bit"),
            "m8": MapWords("8.17b", "equal to the world"),
        },
    }
)
"""By world and lidar, from 8.2 and 9.1.2."""

TABLE_8_3_S: Mapping[str, float | None] = MappingProxyType(
    {"full, one file": 5.0, "full, many files": 15.0, "single package": None}
)
"""Compilation time, s; all "~"; None where the table says "scales with files"."""


class LaunchTime(NamedTuple):
    """A column of table 8.4, s."""

    startup_s: float
    shutdown_s: float


TABLE_8_4: Mapping[str, LaunchTime] = MappingProxyType(
    {
        "Gazebo": LaunchTime(5.0, 10.0),
        "Gazebo with PX4": LaunchTime(7.0, 15.0),
        "Gazebo with Rviz": LaunchTime(10.0, 10.0),
    }
)
