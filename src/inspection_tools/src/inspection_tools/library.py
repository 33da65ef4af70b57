"""The names that `from inspection_tools import ...` knows."""

from flight_basics.correction import CorrectionParameters, SlowCorrection
from flight_basics.errors import (
    ContradictionError,
    FlightBasicsError,
    MapError,
    MissionError,
    NoPathError,
    ParameterError,
    PoseError,
    ScanError,
    VelocityError,
)
from inspection_tools.level_beams import LevelBeamsParameters, LevelFrame, is_whole, level_part
from inspection_tools.median_filter import LidarMedianFilter, MedianFilterParameters
from inspection_tools.mission.file import parse_mission, read_mission
from inspection_tools.mission.waypoints import Mission, Waypoint, hold_s, way_home, way_m
from inspection_tools.padding import LidarPadding, PaddingParameters
from inspection_tools.position_controller import PositionController, PositionControllerParameters
from inspection_tools.scan import ScanGeometry
from inspection_tools.vision_pose import VisionPose, VisionPoseParameters, VisionState
from inspection_tools.yaw.regulator import YawRegulator, YawRegulatorParameters
from inspection_tools.yaw.steering import YawSteering

__all__ = [
    "ContradictionError",
    "CorrectionParameters",
    "FlightBasicsError",
    "LevelBeamsParameters",
    "LevelFrame",
    "LidarMedianFilter",
    "LidarPadding",
    "MapError",
    "MedianFilterParameters",
    "Mission",
    "MissionError",
    "NoPathError",
    "PaddingParameters",
    "ParameterError",
    "PoseError",
    "PositionController",
    "PositionControllerParameters",
    "ScanError",
    "ScanGeometry",
    "SlowCorrection",
    "VelocityError",
    "VisionPose",
    "VisionPoseParameters",
    "VisionState",
    "Waypoint",
    "YawRegulator",
    "YawRegulatorParameters",
    "YawSteering",
    "hold_s",
    "is_whole",
    "level_part",
    "parse_mission",
    "read_mission",
    "way_home",
    "way_m",
]
