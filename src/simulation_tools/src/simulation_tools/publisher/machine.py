"""The state machine of `mavros_publisher` (thesis, 5.2.1): hovers, then passes setpoints on.

There is no ROS here. Messages come in through `on_...`. Each call returns the actions to carry out, in
order. The node carries them out through MAVROS, the closed loop without ROS directly. Frames are ENU and
FLU. Times are stamps in nanoseconds of ROS time.

Lockstep makes two demands. Every velocity command stamped t gets a setpoint stamped t, from the first
command on. And a decision must not depend on the order in which two messages arrive. So decisions use the
state and pose of `decision_delay_s` ago, which have surely arrived.
"""

from __future__ import annotations

import math
from dataclasses import replace

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.brake import STANDSTILL
from simulation_tools.publisher.clock_watch import ClockWatch
from simulation_tools.publisher.commands import Command, Commands
from simulation_tools.publisher.heard import Heard
from simulation_tools.publisher.hover import Hover
from simulation_tools.publisher.interface import (
    Action,
    AnnounceReady,
    FcuState,
    Log,
    PublisherParameters,
    SendLevel,
    SendVelocity,
)
from simulation_tools.publisher.phases import Phase, Phases
from simulation_tools.publisher.vision_watch import Blindness, VisionWatch
from simulation_tools.publisher.waiting import WaitingReason

_NS = 1e-9
_BEFORE_NS = 1_000_000
_SEVERE = 4  # MAV_SEVERITY_WARNING
_POSE_PATIENCE_S = 0.2
_SINKS_WITH = 1.0 / 3.0
"""Thrust of a UAV that comes down level: 0.5 m/s with ArduPilot's own WPNAV_SPEED_DN of 1.5 m/s."""
_FIRST_POSE_PATIENCE_S = 0.01  # the first one may come at any time


class SetpointPublisher:
    """See the module. Not thread-safe."""

    def __init__(self, parameters: PublisherParameters) -> None:
        self.parameters = parameters
        self._heard = Heard()
        self._hover = Hover(self._heard.poses)
        self._phases = Phases(self._heard, self._hover)
        self._commands = Commands(self._hover, self._heard.poses)
        self._clock = ClockWatch()
        self._waiting = WaitingReason()
        self._begin()

    @property
    def phase(self) -> Phase:
        """The present phase."""
        return self._phases.phase

    def restart(self) -> None:
        """Begin again: take off if the UAV stands on the ground, else take over in flight."""
        self.parameters = replace(self.parameters, awaits_order=False)
        self._begin()

    def _begin(self) -> None:
        self._phases.restart(self.parameters)
        self._heard.forget()
        self._clock.restart()
        self._sent_ns: int | None = None
        self._stream_began_ns: int | None = None
        self._commands.forget()
        self._answers_poses = True
        self._vision = VisionWatch()
        self._is_blind = False

    # Messages

    def on_clock(self, now_ns: int) -> list[Action]:
        """Take in ROS's time.

        It shows a reset long before the first pose does, and it shows missing poses. Without external poses
        every call gives a setpoint, because a UAV that does not know its place must stop at once.
        """
        if self._clock.on_clock(now_ns, self.parameters):
            return self._start_again("the clock jumped back: starting again.")
        self._vision.set_ahead(self._clock.set_ahead_ns)
        return [*self._watch_poses(), *self._watch_vision(now_ns), *self._report_waiting(now_ns)]

    def on_state(self, stamp_ns: int, state: FcuState) -> list[Action]:
        """Take in MAVROS's state."""
        self._heard.states.add(stamp_ns, state)
        return []

    def on_landed_state(self, stamp_ns: int, landed_state: int) -> list[Action]:
        """Take in MAVROS's extended state."""
        self._heard.landed.add(stamp_ns, landed_state)
        return []

    def on_text(self, stamp_ns: int, severity: int, text: str) -> list[Action]:
        """Take in what the flight controller says to people: it may explain a change of its mode."""
        if severity <= _SEVERE:
            self._phases.on_text(stamp_ns, text.strip())
        return []

    def on_home(self, stamp_ns: int) -> list[Action]:
        """Take in that the flight controller knows its home position."""
        self._heard.homes.add(stamp_ns, True)
        return []

    def on_vision(self, now_ns: int) -> list[Action]:
        """Take in that an external pose has gone to the flight controller."""
        self._vision.on_pose(now_ns)
        return []

    def on_local_pose(self, stamp_ns: int, pose: Pose) -> list[Action]:
        """Take in the pose in the local frame. It gives the time and keeps the stream of setpoints alive."""
        jump = self._clock.jump(stamp_ns, self.parameters)
        actions = self._start_again(jump) if jump else []
        stamp_ns = self._clock.time_of(stamp_ns)
        self._clock.on_pose(stamp_ns, self.parameters)
        self._heard.poses.add(stamp_ns, pose)
        self._vision.expect_pose(stamp_ns, self.parameters)
        gap_s = math.inf if self._sent_ns is None else (stamp_ns - self._sent_ns) * _NS
        if self._answers_poses or gap_s >= self.parameters.stream_gap_s:
            # The stamp differs from the pose's, because lockstep may wait for the answer to a scan of that
            # stamp.
            actions += self._answer(stamp_ns, stamp_ns - _BEFORE_NS, by_pose=True)
        return actions

    def patience_s(self, stamp_ns: int) -> float:
        """Return the wall time for which a command of this stamp should wait for the next pose.

        A simulation in lockstep may be faster than MAVROS's messages. Then a command waits for its pose, so
        that no decision depends on the order of messages. On a real UAV commands never wait: another
        computer may have stamped them, and poses may come over a slow link.
        """
        if not self.parameters.time_is_simulated or self._poses_missing:
            return 0.0
        if self._clock.has_poses_until(stamp_ns, self.parameters):
            return 0.0
        return _POSE_PATIENCE_S if self._clock.newest_ns else _FIRST_POSE_PATIENCE_S

    def on_velocity(self, stamp_ns: int, frame_id: str, linear: Vector3, yaw_rate: float) -> list[Action]:
        """Take in a velocity command (FLU, levelled). Every command gets an answer."""
        now_ns = self._clock.answered_at_ns(stamp_ns, self.parameters)
        command = Command(stamp_ns, linear, yaw_rate)
        # Without poses the time is not known, so a stamp in the future cannot be recognised
        unknown = self._poses_missing and now_ns < stamp_ns
        actions = self._commands.take_velocity(
            command, frame_id, None if unknown else now_ns, self.parameters
        )
        return actions + self._answer(now_ns, stamp_ns, by_pose=False)

    def on_position(self, stamp_ns: int, position: Vector3, yaw: float) -> list[Action]:
        """Take in a position command (ENU, heading from east). The next pose triggers its setpoint."""
        return self._commands.take_position(stamp_ns, position, yaw)

    # Decisions

    @property
    def _poses_missing(self) -> bool:
        return self._clock.poses_missing(self.parameters)

    def _blindness(self, now_ns: int) -> Blindness:
        return self._vision.blindness(self._clock.latest_ns(now_ns), self.parameters)

    def _watch_poses(self) -> list[Action]:
        """Take no commands while poses are missing, and warn every second."""
        if self.phase in (Phase.WAITING, Phase.IDLE):
            return []
        actions = self._clock.complaints(self.parameters)
        if self.phase is Phase.FLYING and self._poses_missing:
            actions += self._phases.return_to(self._heard.poses.newest())
        return actions

    def _watch_vision(self, now_ns: int) -> list[Action]:
        if self.phase is Phase.SINKING:  # the flight controller may send no poses then
            return self._answer(now_ns, now_ns - _BEFORE_NS, self._answers_poses)
        may_stop = self.phase in (Phase.FLYING, Phase.BLIND) and not self._poses_missing
        if not may_stop or not self._blindness(now_ns).is_too_long:
            return []
        return self._answer(now_ns, now_ns - _BEFORE_NS, self._answers_poses)

    def _report_waiting(self, now_ns: int) -> list[Action]:
        """Publish the reason for waiting when it changes. Log it if it lasts."""
        period_s = math.inf if self.phase is Phase.YIELDED else self.parameters.wait_report_s
        return self._waiting.report(now_ns, self.phase.value, self.waiting_for, period_s)

    @property
    def waiting_for(self) -> str:
        """The reason for waiting, in words; empty: commands are taken, or the flight is over."""
        if self.phase in (Phase.FLYING, Phase.IDLE):
            return ""
        if self._poses_missing:
            return "MAVROS sends no poses any more"
        if self._is_blind:
            return "the flight controller gets no external pose"
        return (
            self._heard.lacking(self._vision.has_come, self.parameters)
            or "the UAV is not at its hover point yet"
        )

    def _start_again(self, why: str) -> list[Action]:
        self._begin()
        return [Log(why), AnnounceReady(False)]

    def _answer(self, now_ns: int, stamp_ns: int, by_pose: bool) -> list[Action]:
        """Return the present actions. The last one is a setpoint with the given stamp, if one may go out."""
        self._answers_poses = by_pose
        p = self.parameters
        began_ns = now_ns if self._stream_began_ns is None else self._stream_began_ns
        known = self._heard.known(now_ns, p)
        blindness = self._blindness(now_ns)
        self._is_blind = blindness.is_too_long
        actions = self._phases.advance(now_ns, known, began_ns, self._poses_missing, blindness, p)
        self._sent_ns = min(now_ns, self._clock.newest_ns) if self._clock.newest_ns else now_ns
        self._stream_began_ns = began_ns
        return [*actions, *self._setpoint(now_ns, stamp_ns)]

    def _setpoint(self, now_ns: int, stamp_ns: int) -> list[Action]:
        """Return the setpoint to send; none if it would end the flight controller's own take-off."""
        stamp_ns = max(stamp_ns, 0)
        if self.phase is Phase.TAKING_OFF and self.parameters.family.takes_off_by_command:
            return []
        if self.phase is Phase.FLYING:
            commanded = self._commands.setpoint(now_ns, self._clock.newest_ns, stamp_ns, self.parameters)
            if commanded is not None:
                return [commanded]
        if self.phase in (Phase.TAKING_OFF, Phase.RETURNING, Phase.FLYING):
            return [self._hover.setpoint(now_ns, stamp_ns, self.parameters)]
        if self.phase is Phase.SINKING:
            return [SendLevel(stamp_ns, self._phases.sinking_yaw_rad, _SINKS_WITH)]
        brake = self._phases.brake if self.phase is Phase.BLIND else None
        return [SendVelocity(stamp_ns, brake.velocity(now_ns) if brake else STANDSTILL, 0.0)]
