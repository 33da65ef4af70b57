"""Helpers for UAV inspection software, free of ROS: see README.md for the nodes around them."""

from inspection_tools.errors import InspectionToolsError, ParameterError, PoseError, ScanError, VelocityError
from inspection_tools.median_filter import LidarMedianFilter, MedianFilterParameters
from inspection_tools.padding import UNSEEN_INTENSITY, LidarPadding, PaddedScan, PaddingParameters
from inspection_tools.pairing import ReferencePairing
from inspection_tools.position_controller import (
    PositionCommand,
    PositionController,
    PositionControllerParameters,
)
from inspection_tools.scan import ScanGeometry
from inspection_tools.yaw_regulator import YawRegulator, YawRegulatorParameters

__all__ = [
    "UNSEEN_INTENSITY",
    "InspectionToolsError",
    "LidarMedianFilter",
    "LidarPadding",
    "MedianFilterParameters",
    "PaddedScan",
    "PaddingParameters",
    "ParameterError",
    "PoseError",
    "PositionCommand",
    "PositionController",
    "PositionControllerParameters",
    "ReferencePairing",
    "ScanError",
    "ScanGeometry",
    "VelocityError",
    "YawRegulator",
    "YawRegulatorParameters",
]
