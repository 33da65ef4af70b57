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
from simulation_tools.publisher.commands import Command, Commands
from simulation_tools.publisher.history import History
from simulation_tools.publisher.hover import Hover
from simulation_tools.publisher.interface import (
    Action,
    AnnounceReady,
    FcuState,
    Log,
    PublisherParameters,
    RequestArm,
    RequestMode,
    SendVelocity,
)

OFFBOARD = "OFFBOARD"
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
        self._poses, self._states, self._landed = History(), History(), History()
        self._hover = Hover(self._poses)
        self._commands = Commands(self._hover, self._poses)
        self._clock_ns = 0
        self.restart()

    def restart(self) -> None:
        """Begin again: take off if the UAV stands on the ground, take over if it flies."""
        self.phase = Phase.WAITING
        for history in (self._poses, self._states, self._landed):
            history.clear()
        self._newest_ns = 0
        self._sent_ns: int | None = None
        self._stream_began_ns: int | None = None
        self._requested_ns: int | None = None
        self._complain_at_s = 0.0
        self._hover.release()
        # The local frame begins where the UAV stood.
        self._hover_z_m = self.parameters.hover_height_m - self.parameters.ground_clearance_m
        self._commands.forget()
        self._seen_offboard = False
        self._has_flown = False
        self._was_failsafe = False
        self._answers_poses = True

    # Messages

    def on_clock(self, now_ns: int) -> list[Action]:
        """Take in ROS's time; it tells of a reset long before the first pose does, and of missing poses."""
        jumped = (self._clock_ns - now_ns) * _NS > self.parameters.jump_back_s
        self._clock_ns = now_ns
        return self._start_again() if jumped else self._watch_poses()

    def on_state(self, stamp_ns: int, state: FcuState) -> list[Action]:
        """Take in MAVROS's state."""
        self._states.add(stamp_ns, state)
        return []

    def on_landed_state(self, stamp_ns: int, landed_state: int) -> list[Action]:
        """Take in MAVROS's extended state."""
        self._landed.add(stamp_ns, landed_state)
        return []

    def on_local_pose(self, stamp_ns: int, pose: Pose) -> list[Action]:
        """Take in the pose in the local frame; it tells the time and keeps the stream going."""
        actions = self._watch_clock(stamp_ns)
        self._poses.add(stamp_ns, pose)
        gap_s = math.inf if self._sent_ns is None else (stamp_ns - self._sent_ns) * _NS
        if self._answers_poses or gap_s >= self.parameters.stream_gap_s:
            # Not stamped as the pose: a scan may have the same stamp, and lockstep waits for its own answer.
            actions += self._answer(stamp_ns, stamp_ns - _BEFORE_NS, by_pose=True)
        return actions

    def on_velocity(
        self, stamp_ns: int, frame_id: str, linear: Sequence[float], yaw_rate: float
    ) -> list[Action]:
        """Take in a velocity command (FLU, levelled); it is always answered, whatever it holds."""
        now_ns = self._now(stamp_ns)
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

    def _now(self, stamp_ns: int) -> int:
        """Return the time at which a command is answered: its stamp, unless it is far off the poses'."""
        if not self._newest_ns:
            return stamp_ns
        slack_ns = round(self.parameters.command_timeout_s / _NS)
        return min(max(stamp_ns, self._newest_ns - slack_ns), self._newest_ns + slack_ns)

    def _watch_clock(self, stamp_ns: int) -> list[Action]:
        """Start again when the clock has jumped back."""
        if (self._newest_ns - stamp_ns) * _NS > self.parameters.jump_back_s:
            actions = self._start_again()
            self._newest_ns = stamp_ns
            return actions
        self._newest_ns = max(self._newest_ns, stamp_ns)
        return []

    @property
    def _silence_s(self) -> float:
        return (self._clock_ns - self._newest_ns) * _NS if self._newest_ns else 0.0

    @property
    def _poses_missing(self) -> bool:
        return self._silence_s > self.parameters.pose_timeout_s

    def _watch_poses(self) -> list[Action]:
        """Take no commands while MAVROS is away, and say so every second."""
        if not self._poses_missing or self.phase in (Phase.WAITING, Phase.IDLE):
            self._complain_at_s = 0.0
            return []
        actions = []
        if self._silence_s >= self._complain_at_s:
            self._complain_at_s = self._silence_s + 1.0
            actions.append(Log(f"MAVROS has sent no pose for {self._silence_s:.1f} s."))
        if self.phase is Phase.FLYING:
            actions += self._enter_returning(self._poses.newest())
        return actions

    def _start_again(self) -> list[Action]:
        self.restart()
        return [Log("the clock jumped back: starting again."), AnnounceReady(False)]

    def _answer(self, now_ns: int, stamp_ns: int, by_pose: bool) -> list[Action]:
        """Return what is to be done now; the last action is a setpoint of the given stamp."""
        self._answers_poses = by_pose
        actions = self._advance(now_ns)
        self._sent_ns = min(now_ns, self._newest_ns) if self._newest_ns else now_ns
        if self._stream_began_ns is None:
            self._stream_began_ns = now_ns
        return [*actions, self._setpoint(now_ns, stamp_ns)]

    def _advance(self, now_ns: int) -> list[Action]:
        """Take the phase forward by what was known `decision_delay_s` ago."""
        then_ns = now_ns - self.parameters.decision_delay_s / _NS
        pose, state, landed = (h.at(then_ns) for h in (self._poses, self._states, self._landed))
        if pose is None or state is None or landed is None or not state.connected:
            return []
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
        rise_m = self.parameters.hover_height_m - self.parameters.ground_clearance_m
        self._hover_z_m = pose.position_m[2] + rise_m
        self._hover.climb_over(pose, self._hover_z_m)
        self._seen_offboard = self._has_flown = False
        return []

    def _take_off(self, now_ns: int, pose: Pose, state: FcuState, flying: bool) -> list[Action]:
        in_offboard = state.armed and state.mode == OFFBOARD
        self._seen_offboard = self._seen_offboard or in_offboard
        self._has_flown = self._has_flown or flying
        if self._has_flown and not state.armed and not self._was_failsafe:
            return self._enter_idle()
        if self._seen_offboard and flying and state.mode != OFFBOARD and not state.failsafe:
            return self._enter_yielded(state)
        if in_offboard:
            return (
                self._enter_flying(None, "hovering, ready.")
                if self._hover.reached(now_ns, self.parameters)
                else []
            )
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
        """Return the requests, unless they were made just now."""
        since_ns = None if self._requested_ns is None else now_ns - self._requested_ns
        if since_ns is not None and since_ns * _NS < self.parameters.retry_period_s:
            return []
        self._requested_ns = now_ns
        return list(requests)

    # Setpoints

    def _setpoint(self, now_ns: int, stamp_ns: int) -> Action:
        """Return what to send now."""
        stamp_ns = max(stamp_ns, 0)
        if self.phase is Phase.FLYING:
            commanded = self._commands.setpoint(now_ns, self._newest_ns, stamp_ns, self.parameters)
            if commanded is not None:
                return commanded
        if self.phase in (Phase.TAKING_OFF, Phase.RETURNING, Phase.FLYING):
            return self._hover.setpoint(now_ns, stamp_ns, self.parameters)
        return SendVelocity(stamp_ns, _ZERO, 0.0)
