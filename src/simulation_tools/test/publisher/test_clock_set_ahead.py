"""ROS's clock is set ahead in flight: the UAV neither stops nor lands for it."""

from __future__ import annotations

import pytest

from simulation_tools.publisher import (
    AnnounceReady,
    Log,
    Phase,
    PublisherParameters,
    RequestMode,
    SendVelocity,
)

from .conftest import Bench

STEPS_S = [1.9, 600.0, 31_536_000.0]


@pytest.fixture(params=[True, False], ids=["vision", "GNSS"])
def flying(request):
    bench = Bench(PublisherParameters(needs_vision=request.param))
    bench.vision = bench.commands = True
    return bench.fly()


def assert_flies_on(bench):
    bench.run(4.0)
    assert bench.publisher.phase is Phase.FLYING
    assert not bench.of(RequestMode)
    assert bench.of(SendVelocity)[-1].linear == (1.0, 0.0, 0.0)


@pytest.mark.parametrize("step_s", STEPS_S)
@pytest.mark.parametrize("first", ["tell_clock", "tell_pose", "tell_state"])
def test_it_flies_on_whatever_comes_first(flying, step_s, first):
    flying.run(1.0)
    flying.actions = []
    flying.now += round(1e9 * step_s)
    getattr(flying, first)()
    if step_s > 2.0:
        assert not flying.of(AnnounceReady)
    assert_flies_on(flying)


def test_poses_that_keep_the_clock_of_before_are_no_silence(flying):
    """MAVROS learns of another clock of its computer after some seconds only."""
    step_ns = 600_000_000_000
    flying.run(1.0)
    flying.now += step_ns
    flying.pose_stamp = lambda now: now - step_ns
    flying.run(5.0)
    assert flying.publisher.phase is Phase.FLYING
    assert not [log for log in flying.of(Log) if "has sent no pose" in log.text]
    flying.pose_stamp = lambda now: now
    assert_flies_on(flying)


def test_what_is_silent_from_then_on_is_noticed_as_ever(flying):
    flying.run(1.0)
    flying.now += 600_000_000_000
    flying.poses = False
    flying.run(2.0)
    assert any("MAVROS has sent no pose for" in log.text for log in flying.of(Log))
