"""When a node counts as at work."""

import pytest

working = pytest.importorskip("node_tools.lockstep.working", reason="needs the workspace's environment")


def test_a_process_works_while_its_cpu_time_goes_on():
    cpu_s = [1.0]
    meter = working.WorkMeter(lambda: cpu_s[0])
    assert not meter.has_worked()
    cpu_s[0] += 0.2
    assert meter.has_worked()
    # When it hangs, then only what its other threads need goes on
    cpu_s[0] += 0.001
    assert not meter.has_worked()
