"""Poses whose stamps wander, as MAVROS's do when it takes a small negative offset for a huge one."""

from __future__ import annotations

import numpy as np
import pytest

from simulation_tools.geometry import Pose
from simulation_tools.publisher import AnnounceReady, FcuState, Log, Phase, PublisherParameters, SendVelocity

from .conftest import AIR, MS, Bench


class MavrosClock:
    """MAVROS 1.21's stamps after 500 exchanges, if both clocks begin at 0.

    It computes the offset of the flight controller's clock by (sent + received - 2 remote) / 2 in unsigned
    integers of 64 bits: a negative one becomes 2^63 ns. It smooths this by 0.003 ten times a second, and
    adds it to each stamp. ROS keeps 32 bits of the seconds.
    """

    def __init__(self, begins_ns, seed=1):
        self.begins_ns, self.offset_ns = begins_ns, 0.0
        self.rng = np.random.default_rng(seed)

    def __call__(self, now_ns):
        if now_ns < self.begins_ns:
            return now_ns
        if self.rng.random() < 0.3:  # exchanges a pose
            observed_ns = 2.0**63 if self.rng.random() < 0.5 else 0.0
            self.offset_ns += 0.003 * (observed_ns - self.offset_ns)
        seconds, rest_ns = divmod(now_ns + int(self.offset_ns), 1_000_000_000)
        return seconds % 2**32 * 1_000_000_000 + rest_ns


def wander(bench, after_s=0.0):
    bench.pose_stamp = MavrosClock(bench.now + round(1e9 * after_s))
    return bench


@pytest.mark.table("simulated", [True, False])
def test_poses_count_by_their_arrival_and_it_says_what_wanders(simulated):
    bench = Bench(PublisherParameters(time_is_simulated=simulated))
    bench.commands = True
    wander(bench.fly()).run(30.0)
    said = [log.text for log in bench.of(Log) if log.is_warning]
    assert sum("the stamps of MAVROS's poses wander" in text for text in said) == 1
    assert len(said) <= 2  # and perhaps the first jump
    remedy = "timesync_mode PASSTHROUGH" if simulated else "mavros/timesync_status"
    assert any(remedy in text for text in said)
    assert len(bench.of(AnnounceReady)) <= 4
    assert bench.of(AnnounceReady)[-1] == AnnounceReady(True)
    bench.run(1.0)
    assert {action.linear for action in bench.of(SendVelocity)} == {(1.0, 0.0, 0.0)}


def test_it_takes_off_by_them():
    bench = wander(Bench(), 0.2)
    bench.run(1.0)
    bench.set("OFFBOARD").run(0.5)
    bench.pose = Pose((1.0, 2.0, 2.0))
    bench.run(5.0)
    assert bench.publisher.phase is Phase.FLYING


def test_without_poses_it_says_so_as_ever():
    bench = wander(Bench().fly())
    bench.run(5.0)
    bench.poses = False
    bench.run(2.0)
    assert any("MAVROS has sent no pose for" in log.text for log in bench.of(Log))


def test_a_flight_controller_that_starts_anew_twice_in_a_minute_is_believed():
    """Its clock begins at 0 again, and ROS's goes on."""
    bench = Bench()
    for starts_ns in (30_000 * MS, 70_000 * MS):
        bench.state, bench.landed = FcuState(True, True, "OFFBOARD", 4), AIR
        bench.pose = Pose((1.0, 2.0, 2.0))
        bench.run((starts_ns - bench.now) * 1e-9)
        bench.pose_stamp = lambda now, starts_ns=starts_ns: now - starts_ns + 1000 * MS
        bench.run(5.0)
        assert [log.text for log in bench.of(Log) if "clock" in log.text][:1] == [
            "the clock jumped back: starting again."
        ]
        assert not any("wander" in log.text for log in bench.of(Log))


def test_after_a_reset_the_stamps_count_again():
    bench = wander(Bench().fly())
    bench.run(5.0)
    bench.now, bench.clock_ahead, bench.pose_stamp = 1000 * MS, 700 * MS, lambda now: now
    bench.run(5.0)
    assert any("0.7 s behind" in log.text for log in bench.of(Log))  # arrivals would lag by nothing
