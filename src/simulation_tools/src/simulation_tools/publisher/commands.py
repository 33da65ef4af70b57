"""Accepts or refuses velocity and position commands, and makes setpoints of the newest ones."""

from __future__ import annotations

from dataclasses import dataclass

from simulation_tools.bounds import are_sane
from simulation_tools.geometry import Vector3, wrap_angle
from simulation_tools.publisher.history import History
from simulation_tools.publisher.hover import Hover
from simulation_tools.publisher.interface import Action, Log, PublisherParameters, SendPosition, SendVelocity

_NS = 1e-9


@dataclass(frozen=True)
class Command:
    """A command. `yaw` is a velocity command's yaw rate or a position command's heading."""

    stamp_ns: int
    vector: Vector3
    yaw: float

    @property
    def is_zero(self) -> bool:
        """Whether it asks for a stop."""
        return not (any(self.vector) or self.yaw)


class Commands:
    """Holds the newest command of each kind. Without a fresh command the UAV holds the hover point."""

    def __init__(self, hover: Hover, poses: History) -> None:
        self._hover = hover
        self._poses = poses
        self.forget()

    def forget(self) -> None:
        """Forget all commands."""
        self._velocity: Command | None = None
        self._position: Command | None = None

    def take_velocity(
        self, command: Command, frame_id: str, now_ns: int | None, p: PublisherParameters
    ) -> list[Action]:
        """Take in a velocity command (FLU, levelled), or return why it is refused.

        now_ns: None if unknown.
        """
        if frame_id not in ("", p.base_frame):
            text = f"a velocity command in the unknown frame {frame_id!r} is refused; it must be in"
            return [Log(f"{text} {p.base_frame!r}.", repeated=True)]
        if not are_sane((*command.vector, command.yaw)):
            text = "a velocity command with NaN, infinity or an absurd number is refused."
            return [Log(text, repeated=True)]
        if now_ns is None:
            return []
        if now_ns < command.stamp_ns:
            return [Log("a velocity command stamped in the future is refused.", repeated=True)]
        self._velocity = command
        return []

    def take_position(self, stamp_ns: int, position: Vector3, heading: float) -> list[Action]:
        """Take in a position command (ENU, heading from east), or return why it is refused."""
        if not are_sane((*position, heading)):
            text = "a position command with NaN, infinity or an absurd number is refused."
            return [Log(text, repeated=True)]
        self._position = Command(stamp_ns, position, wrap_angle(heading))
        return []

    def setpoint(self, now_ns: int, newest_ns: int, stamp_ns: int, p: PublisherParameters) -> Action | None:
        """Return the setpoint of the command in use; None to hover. newest_ns: stamp of the newest pose.

        The command may set or release the hover point.
        """
        hover = self._hover
        command = self._position if p.use_position_setpoint else self._velocity
        if command is None or (max(now_ns, newest_ns) - command.stamp_ns) * _NS > p.command_timeout_s:
            if hover.point is None:
                hover.hold(self._poses.newest())
            return None
        if p.use_position_setpoint:
            hover.release()
            return SendPosition(stamp_ns, command.vector, command.yaw)
        if not command.is_zero:
            hover.release()
        elif hover.point is None and hover.speed_m_s(now_ns, p) <= p.hold_speed_m_s:
            hover.hold(self._poses.at_or_oldest(now_ns - p.decision_delay_s / _NS))
        if hover.point is not None:
            return None
        return SendVelocity(stamp_ns, command.vector, command.yaw)
