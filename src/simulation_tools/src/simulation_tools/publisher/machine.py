"""The state machine of `mavros_publisher` (thesis, 5.2.1): gets the UAV to hover, then hands setpoints on.

ROS-free: messages come in through `on_...`, and each call returns what is to be done, in order. The node does
it through MAVROS, the closed loop without ROS directly. Frames ENU and FLU; times are stamps in nanoseconds
of ROS time.

Lockstep asks for two things. Every velocity command stamped t is answered by a setpoint stamped t, from the
very first; and what is decided then must not depend on which of two messages happened to arrive first, so
decisions look at the state and pose of `decision_delay_s` ago, which have surely arrived.
"""

from __future__ import annotations

import enum
import math
from typing import Sequence

from simulation_tools.geometry import Pose, Vector3
from simulation_tools.publisher.clock_watch import ClockWatch
from simulation_tools.publisher.commands import Command, Commands
from simulation_tools.publisher.heard import Heard
from simulation_tools.publisher.hover import Hover
from simulation_tools.publisher.interface import (
    OFFBOARD,
    Action,
    AnnounceReady,
    FcuState,
    Log,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendVelocity,
)
from simulation_tools.publisher.waiting import Waiting

LANDING = "AUTO.LAND"
_ON_GROUND = 1  # MAV_LANDED_STATE
_NS = 1e-9
_BEFORE_NS = 1_000_000
_ZERO: Vector3 = (0.0, 0.0, 0.0)


class Phase(enum.Enum):
    """What the publisher is doing."""

    WAITING = "waiting for the flight controller"
    TAKING_OFF = "taking off"
    RETURNING = "getting back to hover after the flight controller or MAVROS was away"
    FLYING = "flying by commands"
    YIELDED = "leaving the UAV to whoever changed its mode"
    IDLE = "on the ground, done"


class SetpointPublisher:
    """See the module. Not thread-safe."""

    def __init__(self, parameters: PublisherParameters) -> None:
        self.parameters = parameters
        self._heard = Heard()
        self._hover = Hover(self._heard.poses)
        self._commands = Commands(self._hover, self._heard.poses)
        self._clock = ClockWatch()
        self._waiting = Waiting()
        self.restart()

    def restart(self) -> None:
        """Begin again: take off if the UAV stands on the ground, take over if it flies."""
        self.phase = Phase.WAITING
        self._heard.forget()
        self._clock.restart()
        self._sent_ns: int | None = None
        self._stream_began_ns: int | None = None
        self._requested_ns: int | None = None
        self._hover.release()
        # The local frame begins where the UAV stood.
        self._hover_z_m = self.parameters.hover_height_m - self.parameters.ground_clearance_m
        self._commands.forget()
        self._seen_offboard = False
        self._has_flown = self._may_arm = False
        self._was_failsafe = False
        self._answers_poses = True

    # Messages

    def on_clock(self, now_ns: int) -> list[Action]:
        """Take in ROS's time; it tells of a reset long before the first pose does, and of missing poses."""
        if self._clock.on_clock(now_ns, self.parameters):
            return self._start_again()
        return [*self._watch_poses(), *self._report_waiting(now_ns)]

    def on_state(self, stamp_ns: int, state: FcuState) -> list[Action]:
        """Take in MAVROS's state."""
        self._heard.states.add(stamp_ns, state)
        return []

    def on_landed_state(self, stamp_ns: int, landed_state: int) -> list[Action]:
        """Take in MAVROS's extended state."""
        self._heard.landed.add(stamp_ns, landed_state)
        return []

    def on_home(self, stamp_ns: int) -> list[Action]:
        """Take in that the flight controller knows its home position."""
        self._heard.homes.add(stamp_ns, True)
        return []

    def on_local_pose(self, stamp_ns: int, pose: Pose) -> list[Action]:
        """Take in the pose in the local frame; it tells the time and keeps the stream going."""
        actions = []
        if self._clock.on_pose(stamp_ns, self.parameters):
            actions = self._start_again()
            self._clock.on_pose(stamp_ns, self.parameters)
        self._heard.poses.add(stamp_ns, pose)
        gap_s = math.inf if self._sent_ns is None else (stamp_ns - self._sent_ns) * _NS
        if self._answers_poses or gap_s >= self.parameters.stream_gap_s:
            # Not stamped as the pose: a scan may have the same stamp, and lockstep waits for its own answer.
            actions += self._answer(stamp_ns, stamp_ns - _BEFORE_NS, by_pose=True)
        return actions

    def on_velocity(
        self, stamp_ns: int, frame_id: str, linear: Sequence[float], yaw_rate: float
    ) -> list[Action]:
        """Take in a velocity command (FLU, levelled); it is always answered, whatever it holds."""
        now_ns = self._clock.answered_at_ns(stamp_ns, self.parameters)
        command = Command(stamp_ns, tuple(linear), yaw_rate)
        # Without poses nobody can tell what lies in the future, and more is wrong.
        unknown = self._poses_missing and now_ns < stamp_ns
        actions = self._commands.take_velocity(
            command, frame_id, None if unknown else now_ns, self.parameters
        )
        return actions + self._answer(now_ns, stamp_ns, by_pose=False)

    def on_position(self, stamp_ns: int, position: Sequence[float], yaw: float) -> list[Action]:
        """Take in a position command (ENU, heading from east); the next pose is answered by it."""
        return self._commands.take_position(stamp_ns, position, yaw)

    # Decisions

    @property
    def _poses_missing(self) -> bool:
        return self._clock.poses_missing(self.parameters)

    def _watch_poses(self) -> list[Action]:
        """Take no commands while MAVROS is away, and say so every second."""
        if self.phase in (Phase.WAITING, Phase.IDLE):
            return []
        actions = self._clock.complaints(self.parameters)
        if self.phase is Phase.FLYING and self._poses_missing:
            actions += self._enter_returning(self._heard.poses.newest())
        return actions

    def _report_waiting(self, now_ns: int) -> list[Action]:
        """Say what is waited for when that changes, and aloud when it lasts."""
        period_s = math.inf if self.phase is Phase.YIELDED else self.parameters.wait_report_s
        return self._waiting.report(now_ns, self.phase.value, self.waiting_for, period_s)

    @property
    def waiting_for(self) -> str:
        """What must happen before commands are taken, in words; empty: they are taken, or all is over."""
        if self.phase in (Phase.FLYING, Phase.IDLE):
            return ""
        if self._poses_missing:
            return "MAVROS sends no poses any more"
        return self._heard.lacking(self.parameters) or "the UAV is not at its hover point yet"

    def _start_again(self) -> list[Action]:
        self.restart()
        return [Log("the clock jumped back: starting again."), AnnounceReady(False)]

    def _answer(self, now_ns: int, stamp_ns: int, by_pose: bool) -> list[Action]:
        """Return what is to be done now; the last action is a setpoint of the given stamp."""
        self._answers_poses = by_pose
        actions = self._advance(now_ns)
        self._sent_ns = min(now_ns, self._clock.newest_ns) if self._clock.newest_ns else now_ns
        if self._stream_began_ns is None:
            self._stream_began_ns = now_ns
        return [*actions, self._setpoint(now_ns, stamp_ns)]

    def _advance(self, now_ns: int) -> list[Action]:
        """Take the phase forward by what was known `decision_delay_s` ago."""
        pose, state, landed, home = self._heard.known(now_ns, self.parameters)
        if pose is None or state is None or landed is None or not state.connected:
            return []
        self._may_arm = home or not self.parameters.needs_home
        flying = state.armed and landed != _ON_GROUND
        step = {
            Phase.WAITING: self._begin,
            Phase.TAKING_OFF: self._take_off,
            Phase.FLYING: self._fly,
            Phase.RETURNING: self._return,
            Phase.YIELDED: self._yield,
        }.get(self.phase)
        actions = step(now_ns, pose, state, flying) if step else []
        self._was_failsafe = state.failsafe or (self._was_failsafe and not state.armed)
        return actions

    def _begin(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        if flying and state.mode != OFFBOARD and not state.failsafe:
            return self._enter_yielded(state)
        if flying:
            if state.failsafe:
                return self._enter_returning(pose)
            return self._enter_flying(pose, "the UAV is in the air: taking over where it is.")
        self.phase = Phase.TAKING_OFF
        self._aim_over(pose)
        self._seen_offboard = self._has_flown = False
        return []

    def _aim_over(self, pose: Pose) -> None:
        """Hover over where the UAV stands on the ground."""
        rise_m = self.parameters.hover_height_m - self.parameters.ground_clearance_m
        self._hover_z_m = pose.position_m[2] + rise_m
        self._hover.climb_over(pose, self._hover_z_m)

    def _take_off(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        self._seen_offboard = self._seen_offboard or state.in_offboard
        self._has_flown = self._has_flown or flying
        if self._has_flown and not state.armed and not self._was_failsafe:
            return self._enter_idle()
        if self._seen_offboard and flying and not state.in_offboard and not state.failsafe:
            return self._enter_yielded(state)
        if state.in_offboard:
            return (
                self._enter_flying(None, "hovering, ready.")
                if self._hover.reached(now_ns, self.parameters)
                else []
            )
        if not (state.armed or self._may_arm):
            self._aim_over(pose)  # an estimate that has just begun still moves
            return []
        if (now_ns - self._stream_began_ns) * _NS < self.parameters.min_stream_s:
            return []
        return self._request(now_ns, RequestMode(OFFBOARD), RequestArm())

    def _fly(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        if not state.armed:
            return self._end_flight()
        if state.failsafe:
            return self._enter_returning(pose) + self._request(now_ns, RequestMode(OFFBOARD))
        return [] if state.mode == OFFBOARD else self._enter_yielded(state)

    def _return(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        if not state.armed:
            return self._end_flight()
        if state.failsafe:
            self._hover.climb_over(pose, self._hover_z_m)
            return self._request(now_ns, RequestMode(OFFBOARD))
        if state.mode != OFFBOARD:
            return self._enter_yielded(state)
        if self._poses_missing or not self._hover.reached(now_ns, self.parameters):
            return []
        return self._enter_flying(None, "hovering again, ready.")

    def _end_flight(self) -> list[Action]:
        """Take off again after the flight controller's own landing; anybody else's is to be the end."""
        if not self._was_failsafe:
            return self._enter_idle()
        self.phase = Phase.WAITING
        return [AnnounceReady(False), Log("the flight controller landed in a failsafe: taking off again.")]

    def _yield(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        if not state.armed:
            return self._enter_idle()
        if state.mode == OFFBOARD and not state.failsafe:
            return self._enter_flying(pose, "OFFBOARD again: taking over where the UAV is.")
        return []

    def _enter_flying(self, pose: Pose | None, text: str) -> list[Action]:
        """pose: where to hold until a command comes; None keeps the hover point."""
        self.phase = Phase.FLYING
        self._requested_ns = None
        if pose is not None:
            self._hover.hold(pose)
        return [AnnounceReady(True), Log(text, is_warning=False)]

    def _enter_returning(self, pose: Pose) -> list[Action]:
        """Hover there again before commands count: nobody has flown the UAV, and it may be low by now."""
        self.phase = Phase.RETURNING
        self._requested_ns = None
        self._hover.climb_over(pose, self._hover_z_m)
        return [AnnounceReady(False), Log("the connection to the flight controller broke: hovering first.")]

    def _enter_yielded(self, state: FcuState) -> list[Action]:
        self.phase = Phase.YIELDED
        if state.mode == LANDING and not state.failsafe:
            text = f"{LANDING} was ordered: leaving the UAV to it until it is OFFBOARD."
            return [AnnounceReady(False), Log(text, is_warning=False)]
        text = f"somebody else has set the mode {state.mode}: leaving the UAV to them until it is OFFBOARD."
        return [AnnounceReady(False), Log(text)]

    def _enter_idle(self) -> list[Action]:
        self.phase = Phase.IDLE
        text = "disarmed: the flight is over; call ~restart for another take-off."
        return [AnnounceReady(False), Log(text, is_warning=False)]

    def _request(self, now_ns: int, *requests: Action) -> list[Action]:
        """Return the requests, unless they were made just now, or nobody can tell yet what became of them."""
        p = self.parameters
        if self._requested_ns is not None:
            since_s = (now_ns - self._requested_ns) * _NS
            told = self._heard.state_newer_than(self._requested_ns, now_ns, p)
            if since_s < (p.retry_period_s if told else p.state_patience_s):
                return []
        self._requested_ns = now_ns
        return list(requests)

    # Setpoints

    def _setpoint(self, now_ns: int, stamp_ns: int) -> Action:
        """Return what to send now."""
        stamp_ns = max(stamp_ns, 0)
        if self.phase is Phase.FLYING:
            commanded = self._commands.setpoint(now_ns, self._clock.newest_ns, stamp_ns, self.parameters)
            if commanded is not None:
                return commanded
        if self.phase in (Phase.TAKING_OFF, Phase.RETURNING, Phase.FLYING):
            return self._hover.setpoint(now_ns, stamp_ns, self.parameters)
        return SendVelocity(stamp_ns, _ZERO, 0.0)
