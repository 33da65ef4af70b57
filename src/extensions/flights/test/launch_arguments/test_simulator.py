"""What the simulator would refuse seconds after the start is refused before it."""

from __future__ import annotations

import pytest

from flights.errors import FlightsError
from flights.launch_arguments import simulator


@pytest.fixture
def arducopter(tmp_path):
    program = tmp_path / "arducopter"
    program.write_text("#!/bin/sh\n")
    program.chmod(0o755)
    return str(program)


@pytest.mark.parametrize("autopilot", ["px4", "ardupilot"])
def test_lockstep_with_a_foreign_flight_controller_is_refused(autopilot, arducopter):
    asked = {"autopilot": autopilot, "ardupilot": arducopter}
    simulator.check({**asked, "lockstep": "false"})
    simulator.check({**asked, "autopilot": "standin", "lockstep": "true"})
    with pytest.raises(FlightsError, match=f"lockstep:=true needs autopilot:=standin; with {autopilot}"):
        simulator.check({**asked, "lockstep": "true"})


def test_a_battery_of_the_simulator_is_refused_with_a_foreign_flight_controller(arducopter):
    asked = {"ardupilot": arducopter, "battery": "0.3"}
    simulator.check({**asked, "autopilot": "standin"})
    simulator.check({"autopilot": "px4", "battery": "0.3"})  # real.launch has its own sentence
    for autopilot in ("px4", "ardupilot"):
        with pytest.raises(FlightsError, match=f"battery:=0.3 is of no use with autopilot:={autopilot}"):
            simulator.check({**asked, "autopilot": autopilot})
