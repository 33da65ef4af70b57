"""`mavros_publisher` without ROS: the state machine, what it is told and what it wants done."""

from simulation_tools.publisher.interface import (
    Action,
    AnnounceReady,
    AnnounceStatus,
    FcuState,
    Log,
    PublisherError,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendPosition,
    SendVelocity,
)
from simulation_tools.publisher.machine import Phase, SetpointPublisher

__all__ = [
    "Action",
    "AnnounceReady",
    "AnnounceStatus",
    "FcuState",
    "Log",
    "Phase",
    "PublisherError",
    "PublisherParameters",
    "RequestArm",
    "RequestMode",
    "SendPosition",
    "SendVelocity",
    "SetpointPublisher",
]
