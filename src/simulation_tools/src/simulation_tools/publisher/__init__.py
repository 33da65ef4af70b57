"""`mavros_publisher` without ROS: the state machine, its inputs and its actions."""

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
    RequestTakeoff,
    SendLevel,
    SendPosition,
    SendVelocity,
    SetOrigin,
)
from simulation_tools.publisher.machine import SetpointPublisher
from simulation_tools.publisher.phases import Phase

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
    "RequestTakeoff",
    "SendLevel",
    "SendPosition",
    "SendVelocity",
    "SetOrigin",
    "SetpointPublisher",
]
