"""Compares ROS's clock with the stamps of the poses: jumps, silence, and clocks that do not agree."""

from __future__ import annotations

from simulation_tools.publisher.interface import Action, Log, PublisherParameters
from stamp_pairing.clock_steps import clock_step_s

_NS = 1e-9
_DRIFT = 0.01  # greatest difference between the clocks
_DISAGREEMENT_S = 2.0  # a smaller difference may be a late message
_WANDER_S = 10.0  # a flight controller that starts anew takes longer


class ClockWatch:
    """Tells the time.

    `newest_ns`: greatest stamp of a pose, 0: none has come. ROS's clock may be unknown (0), as in a closed
    loop without ROS. Then only the poses tell the time. The stamps may always lag behind ROS's clock, if the
    flight controller's clock began later. So a pose's delay is its lag less the least lag so far. After
    MAVROS has hung, its poses arrive together and are old.

    A clock that is set ahead tells of no silence: the poses before it are as old as they were.

    Stamps that jump twice within a few seconds, while ROS's clock goes on, tell nothing. From then on a pose
    counts by its arrival, until ROS's clock jumps back.
    """

    def __init__(self) -> None:
        self._clock_ns = 0
        self.set_ahead_ns = 0
        """By how much ROS's clock was set ahead with the last `on_clock`; 0: it was not."""
        self._jumped_ns: int | None = None
        self._by_arrival = False
        self.restart()

    def restart(self) -> None:
        """Forget the poses."""
        self.newest_ns = 0
        self._arrived_ns = 0
        self._lag_ns = 0.0
        self._agreed_ns = 0
        self._told_disagreement = False
        self._complain_at_s = 0.0

    def on_clock(self, now_ns: int, p: PublisherParameters) -> bool:
        """Take in ROS's time. Return True if it has jumped back."""
        jumped = (self._clock_ns - now_ns) * _NS > p.jump_back_s
        step_s = clock_step_s(self._clock_ns * _NS, now_ns * _NS) if self._clock_ns else 0.0
        self.set_ahead_ns = now_ns - self._clock_ns if step_s > 0.0 else 0
        self._clock_ns = now_ns
        if self.set_ahead_ns and self.newest_ns:
            self._lag_ns += self.set_ahead_ns
            self._arrived_ns += self.set_ahead_ns
            self._agreed_ns += self.set_ahead_ns
        if jumped:
            self._jumped_ns, self._by_arrival = None, False
        return jumped

    def jump(self, stamp_ns: int, p: PublisherParameters) -> str:
        """Return why the next pose needs a `restart` before it; empty: it needs none. Call it first."""
        back = (self.newest_ns - stamp_ns) * _NS > p.jump_back_s
        if self._by_arrival or not (back or self._jumped_ahead(stamp_ns, p)):
            return ""
        before_ns, self._jumped_ns = self._jumped_ns, self._clock_ns
        if not self._clock_ns or before_ns is None or (self._clock_ns - before_ns) * _NS > _WANDER_S:
            return "the clock jumped back: starting again." if back else ""
        self._by_arrival = True
        remedy = (
            "In simulated time MAVROS needs the parameter time/timesync_mode PASSTHROUGH."
            if p.time_is_simulated
            else "mavros/timesync_status shows how MAVROS and the flight controller compare their clocks."
        )
        return (
            "the stamps of MAVROS's poses wander: they jumped twice, and ROS's clock went on. From here on a "
            f"pose counts by its arrival. {remedy}"
        )

    def time_of(self, stamp_ns: int) -> int:
        """Return the time of a pose: its stamp, unless the stamps wander."""
        return self._clock_ns if self._by_arrival else stamp_ns

    def on_pose(self, stamp_ns: int, p: PublisherParameters) -> None:
        """Take in the time of a pose."""
        now_ns = self._clock_ns or stamp_ns
        lag_ns = now_ns - max(self.newest_ns, stamp_ns)
        may_be_ns = self._lag_ns + _DRIFT * (now_ns - self._arrived_ns)
        self._lag_ns = min(lag_ns, may_be_ns) if self.newest_ns else lag_ns
        self.newest_ns = max(self.newest_ns, stamp_ns)
        self._arrived_ns = now_ns
        if not self._agreed_ns or abs(self._lag_ns) * _NS <= p.command_timeout_s:
            self._agreed_ns = now_ns

    def latest_ns(self, now_ns: int) -> int:
        """Return ROS's time, or that of a message if that is later or ROS's is unknown."""
        return max(now_ns, self._clock_ns)

    def answered_at_ns(self, stamp_ns: int, p: PublisherParameters) -> int:
        """Return the time for a command: its stamp, unless that is far from the present time."""
        if not self.newest_ns:
            return stamp_ns
        time_ns = max(self.newest_ns, self._clock_ns)
        slack_ns = round(p.command_timeout_s / _NS)
        return min(max(stamp_ns, time_ns - slack_ns), time_ns + slack_ns)

    def has_poses_until(self, stamp_ns: int, p: PublisherParameters) -> bool:
        """Whether the poses of a time have come: the newest is at most `pose_age_s` older.

        A lag of the flight controller's clock behind ROS's does not count.
        """
        age_ns = stamp_ns - self.newest_ns - max(self._lag_ns, 0.0)
        return self.newest_ns != 0 and age_ns * _NS <= p.pose_age_s

    def poses_missing(self, p: PublisherParameters) -> bool:
        """Whether poses came, and have stopped."""
        return self._silence_s > p.pose_timeout_s

    def complaints(self, p: PublisherParameters) -> list[Action]:
        """Return the warnings: once a second while poses are missing, once when the clocks disagree."""
        if self.poses_missing(p):
            return self._at_most_every_second(f"MAVROS has sent no pose for {self._silence_s:.1f} s.")
        self._complain_at_s = 0.0
        if (self._arrived_ns - self._agreed_ns) * _NS < _DISAGREEMENT_S:
            self._told_disagreement = False
            return []
        if self._told_disagreement:
            return []
        self._told_disagreement = True
        text = (
            f"MAVROS's poses are stamped {abs(self._lag_ns) * _NS:.1f} s "
            f"{'behind' if self._lag_ns > 0 else 'ahead of'} ROS's clock. "
            "Start simulator, flight controller and MAVROS again, or synchronise their clocks."
        )
        return [Log(text)]

    def _jumped_ahead(self, stamp_ns: int, p: PublisherParameters) -> bool:
        """Whether a stamp lags behind ROS's clock by much less than any before. No delay does that."""
        lag_ns = self._clock_ns - stamp_ns
        return bool(self.newest_ns and self._clock_ns) and (self._lag_ns - lag_ns) * _NS > p.jump_back_s

    @property
    def _silence_s(self) -> float:
        return (self._clock_ns - self.newest_ns - self._lag_ns) * _NS if self.newest_ns else 0.0

    def _at_most_every_second(self, text: str) -> list[Action]:
        if self._silence_s < self._complain_at_s:
            return []
        self._complain_at_s = self._silence_s + 1.0
        return [Log(text)]
