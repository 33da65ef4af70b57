"""The state machine's interface: parameters, messages and actions."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Vector3
from simulation_tools.publisher.families import PX4, Family

_CRITICAL = 5  # MAV_STATE of a failsafe


class PublisherError(SimulationToolsError):
    """A parameter of the publisher cannot be used."""


@dataclass(frozen=True)
class PublisherParameters:
    """The parameters of the publisher.

    hover_height_m: over the ground at the place of take-off. ground_clearance_m: height of the pose's origin
    while the UAV stands. command_timeout_s: instead of an older command the UAV hovers.
    use_position_setpoint: send positions instead of velocities. base_frame: the only frame, besides none, in
    which velocities are taken.

    ready_distance_m, ready_speed_m_s, ready_time_s: the UAV hovers if it is this close to the hover point
    and this slow for this time. settled_distance_m, settled_time_s: it also hovers if it is within this
    greater distance for this longer time, because a drifting estimate may keep it away from its point for
    ever. climb_gain: during a take-off the setpoint is higher than the hover point by this much for each
    metre that is missing. PX4 starts with a guess of the hover thrust, so without this gain it would climb
    the last half metre very slowly.

    hold_speed_m_s: a command of zero brakes a UAV that is faster than this. A slower UAV holds its position
    instead, because with a velocity of zero it would sink when the hover thrust is wrong.

    retry_period_s: least time between two requests to the flight controller. A request is repeated only if a
    later state shows that it had no effect, or if no state came for state_patience_s (PX4 sends its state
    once a second). min_stream_s: setpoints stream for this time before the request for OFFBOARD.
    stream_gap_s: if no command came for this time, each pose triggers a setpoint, so that the stream never
    breaks. pose_age_s: if the newest pose is older than a command by more than this, the command waits, see
    `SetpointPublisher.patience_s`. pose_timeout_s: after this time without a pose MAVROS counts as lost.
    jump_back_s: if a pose is older than the last one by this much, the clock was reset. wait_report_s:
    period of the log message that says what the node waits for.

    needs_home: do not arm before the flight controller knows its home position. PX4 knows it as soon as it
    trusts its position. A vehicle that is armed earlier starts in a failsafe. Without satellites there may
    never be a home position. needs_vision: the flight controller flies by external poses. If none has gone
    to it for the usual gap between the last poses, 1.5 times the lateness of the latest but one, and
    vision_spare_s more, the UAV stops, because it then knows its own speed for a few seconds only. It waits
    for vision_timeout_least_s at least, and for vision_timeout_s or 1.4 usual gaps at most.
    in_lockstep: the simulator itself waits for each external pose, but a pose may be heard some gaps later.
    It stops within brake_time_s, see `Brake`. A fast one takes longer, so that the plan needs at most
    brake_acceleration_m_s2. The command is brake_speed_m_s at most, because PX4's tilt limit allows no more.
    A pose that is brake_pose_age_s old has come; the stop cannot wait for decision_delay_s.
    After vision_landing_s it lands: before PX4 gives up its position, after 5 s (EKF2_NOAID_TOUT).
    time_is_simulated: commands may wait for their poses, see `SetpointPublisher.patience_s`.
    awaits_order: stay on the ground until `SetpointPublisher.restart`: somebody tells the height first.
    family: of the flight controller.
    """

    hover_height_m: float = 2.0
    ground_clearance_m: float = 0.12
    command_timeout_s: float = 0.5
    use_position_setpoint: bool = False
    base_frame: str = "base_frame"
    ready_distance_m: float = 0.05
    ready_speed_m_s: float = 0.15
    ready_time_s: float = 0.5
    settled_distance_m: float = 0.25
    settled_time_s: float = 3.0
    hold_speed_m_s: float = 0.15
    retry_period_s: float = 0.5
    state_patience_s: float = 2.0
    stream_gap_s: float = 0.15
    min_stream_s: float = 0.1
    climb_gain: float = 2.0
    decision_delay_s: float = 0.1
    pose_age_s: float = 0.07
    pose_timeout_s: float = 0.5
    jump_back_s: float = 1.0
    wait_report_s: float = 10.0
    needs_home: bool = True
    needs_vision: bool = False
    vision_timeout_s: float = 0.11
    vision_timeout_least_s: float = 0.07
    vision_spare_s: float = 0.015
    in_lockstep: bool = False
    vision_landing_s: float = 3.0
    brake_time_s: float = 0.385
    brake_acceleration_m_s2: float = 6.0
    brake_pose_age_s: float = 0.04
    brake_speed_m_s: float = 4.0
    time_is_simulated: bool = False
    awaits_order: bool = False
    family: Family = PX4

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            least = 0.0 if name in ("ground_clearance_m", "climb_gain") else 1e-9
            if isinstance(value, float) and not least <= value < math.inf:
                raise PublisherError(f"{name} must be a positive number, got {value}.")


@dataclass(frozen=True)
class SendVelocity:
    """Send a velocity setpoint in the levelled body frame (FLU) and a yaw rate, rad/s."""

    stamp_ns: int
    linear: Vector3
    yaw_rate: float


@dataclass(frozen=True)
class SendPosition:
    """Send a position setpoint in the local frame (ENU) with a heading, rad from east."""

    stamp_ns: int
    position: Vector3
    yaw: float


@dataclass(frozen=True)
class SendLevel:
    """Send a level attitude with a heading, rad from east, and a thrust: 0.5 holds the height, less sinks."""

    stamp_ns: int
    yaw: float
    thrust: float


@dataclass(frozen=True)
class RequestMode:
    """Ask the flight controller for a mode."""

    mode: str


@dataclass(frozen=True)
class RequestArm:
    """Ask the flight controller to arm."""


@dataclass(frozen=True)
class RequestTakeoff:
    """Ask the flight controller to climb to a height over the place where it armed, m."""

    height_m: float


@dataclass(frozen=True)
class SetOrigin:
    """Tell the flight controller a place on earth for the origin of its local frame. Any place will do."""


@dataclass(frozen=True)
class AnnounceReady:
    """Publish whether the UAV takes commands."""

    ready: bool


@dataclass(frozen=True)
class AnnounceStatus:
    """Publish in words what the node waits for; empty: for nothing."""

    text: str


@dataclass(frozen=True)
class Log:
    """Log a sentence. repeated: it may come with every message, so it must be throttled."""

    text: str
    is_warning: bool = True
    repeated: bool = False


Action = (
    SendVelocity
    | SendPosition
    | SendLevel
    | RequestMode
    | RequestArm
    | RequestTakeoff
    | SetOrigin
    | AnnounceReady
    | AnnounceStatus
    | Log
)


@dataclass(frozen=True)
class FcuState:
    """MAVROS's State; system_status is MAV_STATE."""

    connected: bool
    armed: bool
    mode: str
    system_status: int

    def is_guided(self, family: Family) -> bool:
        """Whether it flies by setpoints."""
        return self.armed and self.mode == family.guided

    def failsafe(self, family: Family) -> bool:
        """Whether a failsafe flies the UAV, from which the publisher may take it back.

        In OFFBOARD the flight controller obeys setpoints, whatever its status is.
        """
        is_failsafe = self.system_status == _CRITICAL and self.mode != family.guided
        return self.armed and is_failsafe and family.comes_back
