"""The real MAVROS flies Experiment 4 with the PX4 stand-in, for longer than it takes to believe clocks."""

from __future__ import annotations

import pytest
from launched_flight import READY_PATIENCE_S, Flight

pytestmark = [pytest.mark.ros, pytest.mark.flight, pytest.mark.timeout(420)]

LONG_ENOUGH_S = 70.0
"""MAVROS compares clocks from its 500th exchange on, ten a second. 20 s more show what it makes of them."""
MISSION_PATIENCE_S = 200.0


@pytest.mark.parametrize("gnss", ["true", pytest.param("false", marks=pytest.mark.long)])
def test_a_flight_of_70_s_arrives(processes, tmp_path, gnss):
    for package in ("mavros",) if gnss == "true" else ("mavros", "mavros_extras"):
        if processes.run("rospack", "find", package, timeout_s=200.0).returncode != 0:
            pytest.skip(f"the real {package} is not installed (flights/doc/from_source.md)")
    flight = Flight(processes, tmp_path, "experiment_4.launch", mavros="real", gnss=gnss, headless="true")
    flight.wait_until_said("A mission of 5 waypoints begins.", READY_PATIENCE_S)
    flight.end_without_pictures(MISSION_PATIENCE_S)
    assert flight.result["success"], flight.result["failure"]
    assert flight.result["flight_time_s"] > LONG_ENOUGH_S
    # MAVROS saw no jump of the clocks, nor did a node see one in its stamps
    assert "jump" not in flight.said
