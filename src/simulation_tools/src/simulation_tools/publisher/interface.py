"""The state machine's interface: parameters, messages and actions."""

from __future__ import annotations

from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Vector3
from simulation_tools.publisher.families import PX4, Family

_CRITICAL = 5  # MAV_STATE of a failsafe


class PublisherError(SimulationToolsError):
    """A parameter of the publisher cannot be used."""


@dataclass(frozen=True)
class PublisherParameters:
    """The parameters of the publisher.

    Raises:
        PublisherError: a value makes no sense.
    """

    hover_height_m: float = limited(2.0, above=0.0, live=(0.3, 20.0))
    """Height over the place of take-off at which the UAV waits for commands, m. It counts at the next
    take-off.
    """
    ground_clearance_m: float = limited(0.12, 0.0)
    """Height of the pose's origin while the UAV stands, m."""
    command_timeout_s: float = limited(0.5, above=0.0, live=(0.1, 5.0))
    """Age at which a command is replaced by hovering on the spot, s."""
    use_position_setpoint: bool = False
    """Fly to position setpoints instead of velocity setpoints, never both."""
    base_frame: str = "base_frame"
    """The only frame, besides none, in which velocities are taken."""
    ready_distance_m: float = limited(0.05, above=0.0)
    """The UAV hovers if it is this close to the hover point, m, slow, and for `ready_time_s`."""
    ready_speed_m_s: float = limited(0.15, above=0.0)
    """The UAV hovers if it is this slow, m/s, near the hover point, and for `ready_time_s`."""
    ready_time_s: float = limited(0.5, above=0.0)
    """The UAV hovers if it is near the hover point, and slow, for this time, s."""
    settled_distance_m: float = limited(0.25, above=0.0)
    """The UAV also hovers if it is within this greater distance, m, for `settled_time_s`: a drifting estimate
    may keep it away from its point for ever.
    """
    settled_time_s: float = limited(3.0, above=0.0)
    """The longer time for `settled_distance_m`, s."""
    hold_speed_m_s: float = limited(0.15, above=0.0)
    """A command of zero brakes a UAV that is faster than this, m/s. A slower UAV holds its position instead:
    with a velocity of zero it would sink when the hover thrust is wrong.
    """
    retry_period_s: float = limited(0.5, above=0.0)
    """Least time between two requests to the flight controller, s. A request is repeated only if a later
    state shows that it had no effect, or if no state came for `state_patience_s`.
    """
    state_patience_s: float = limited(2.0, above=0.0)
    """Time without a state after which a request is repeated, s. PX4 sends its state once a second."""
    stream_gap_s: float = limited(0.15, above=0.0)
    """If no command came for this time, s, each pose triggers a setpoint, so that the stream never breaks."""
    min_stream_s: float = limited(0.1, above=0.0)
    """Setpoints stream for this time before the request for OFFBOARD, s."""
    climb_gain: float = limited(2.0, 0.0)
    """During a take-off the setpoint is higher than the hover point by this much for each metre that is
    missing. PX4 starts with a guess of the hover thrust, and would else climb the last half metre very
    slowly.
    """
    decision_delay_s: float = limited(0.1, above=0.0)
    """Decisions are made by the state and the pose of so long ago, s, which have surely arrived."""
    pose_age_s: float = limited(0.07, above=0.0)
    """If the newest pose is older than a command by more than this, s, the command waits, see
    `SetpointPublisher.patience_s`.
    """
    pose_timeout_s: float = limited(0.5, above=0.0)
    """After this time without a pose MAVROS counts as lost, s."""
    jump_back_s: float = limited(1.0, above=0.0)
    """If a pose is older than the last one by this much, s, the clock was reset."""
    wait_report_s: float = limited(10.0, above=0.0)
    """Period of the log message that says what the node waits for, s."""
    needs_home: bool = True
    """Do not arm before the flight controller knows its home position. PX4 knows it as soon as it trusts its
    position. A vehicle that is armed earlier starts in a failsafe. Without satellites there may never be a
    home position.
    """
    needs_vision: bool = False
    """The flight controller flies by external poses. If none has gone to it for the usual gap between the
    last poses, 1.5 times the lateness of the latest but one, and `vision_spare_s` more, the UAV stops,
    because it then knows its own speed for a few seconds only.
    """
    vision_timeout_s: float = limited(0.11, above=0.0)
    """It waits for an external pose for this time, or for 1.4 usual gaps, at most, s."""
    vision_timeout_least_s: float = limited(0.07, above=0.0)
    """It waits for an external pose for this time at least, s."""
    vision_spare_s: float = limited(0.015, above=0.0)
    """It waits so much longer than the usual gap and lateness of external poses tell, s."""
    in_lockstep: bool = False
    """The simulator itself waits for each external pose, but a pose may be heard some gaps later."""
    vision_landing_s: float = limited(3.0, above=0.0)
    """After this time without external poses it lands, s: before PX4 gives up its position, after 5 s
    (EKF2_NOAID_TOUT).
    """
    brake_time_s: float = limited(0.385, above=0.0)
    """Without external poses it stops within this time, s, see `Brake`."""
    brake_acceleration_m_s2: float = limited(6.0, above=0.0)
    """A fast UAV takes longer to stop, so that the plan needs at most this, m/s2."""
    brake_pose_age_s: float = limited(0.04, above=0.0)
    """A pose of this age has come, s: the stop cannot wait for `decision_delay_s`."""
    brake_speed_m_s: float = limited(4.0, above=0.0)
    """The command that stops is at most this, m/s, because PX4's tilt limit allows no more."""
    time_is_simulated: bool = False
    """Commands may wait for their poses, see `SetpointPublisher.patience_s`."""
    awaits_order: bool = False
    """Stay on the ground until `SetpointPublisher.restart`: somebody tells the height first."""
    family: Family = PX4
    """Of the flight controller."""

    def __post_init__(self) -> None:
        check_limits(self, PublisherError)


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
