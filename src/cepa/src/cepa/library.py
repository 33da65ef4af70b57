"""The names that `from cepa import ...` knows."""

from cepa.algorithm import Algorithm
from cepa.decision import Decision, Reason
from cepa.dynamic.dynamic import Dynamic
from cepa.errors import (
    AttitudeError,
    CepaError,
    MotionError,
    MountError,
    ParameterError,
    ScanError,
    VelocityError,
)
from cepa.keep_out import KeepOut, KeepOutBox
from cepa.levelling import LidarAttitude, levelled
from cepa.motion import Cloud, Motion, Ranging
from cepa.parameters import SLOW_DETOURS, STEADY_SIDE, CepaParameters
from cepa.scan import LaserScan2D
from cepa.steering.loop import SteeringLoop
from cepa.thesis.improved import Improved
from cepa.thesis.original import Original

ALGORITHMS: dict[str, type[Algorithm]] = {"improved": Improved, "original": Original, "dynamic": Dynamic}
"""The algorithms by the names that launch files use."""

__all__ = [
    "ALGORITHMS",
    "SLOW_DETOURS",
    "STEADY_SIDE",
    "AttitudeError",
    "CepaError",
    "CepaParameters",
    "Cloud",
    "Decision",
    "Dynamic",
    "Improved",
    "KeepOut",
    "KeepOutBox",
    "LaserScan2D",
    "LidarAttitude",
    "Motion",
    "MotionError",
    "MountError",
    "Original",
    "ParameterError",
    "Ranging",
    "Reason",
    "ScanError",
    "SteeringLoop",
    "VelocityError",
    "levelled",
]
