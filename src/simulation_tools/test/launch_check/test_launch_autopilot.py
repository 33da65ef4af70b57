"""What the simulator would refuse of its flight controller seconds after the start is refused before it."""

from __future__ import annotations

import re

import pytest

from simulation_tools.errors import SimulationToolsError
from simulation_tools.launch_check.launch_autopilot import check_autopilot, check_program_is_used


@pytest.fixture
def program(tmp_path):
    one = tmp_path / "arducopter"
    one.write_text("#!/bin/sh\n")
    one.chmod(0o755)
    return str(one)


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ({"autopilot": "px5"}, 'There is no autopilot "px5"'),
        ({"lockstep": "true"}, "lockstep:=true needs autopilot:=standin; with ardupilot leave it out"),
        ({"autopilot": "px4", "lockstep": "true"}, "lockstep:=true needs autopilot:=standin; with px4"),
        ({"ardupilot": "./arducopter"}, "ardupilot:=./arducopter is not an absolute path"),
        ({"ardupilot": "~/arducopter"}, "for example ardupilot:=$HOME/arducopter."),
        ({"ardupilot": " "}, "autopilot:=ardupilot needs the place of ArduPilot's program"),
        ({"ardupilot_parameters": "my.parm"}, "for example ardupilot_parameters:=$PWD/my.parm."),
        ({"ardupilot_parameters": "/no.parm"}, "ArduPilot's file of parameters /no.parm is not there."),
        ({"battery": "0.3"}, "battery:=0.3 is of no use with autopilot:=ardupilot: ArduPilot simulates one"),
        ({"autopilot": "px4", "battery": "0.3"}, "SIM_BAT_DRAIN and SIM_BAT_MIN_PCT"),
    ],
)
def test_a_flight_controller_that_cannot_fly_so_is_refused(program, words, sentence):
    with pytest.raises(SimulationToolsError, match=re.escape(sentence)):
        check_autopilot({"autopilot": "ardupilot", "ardupilot": program, **words})


@pytest.mark.parametrize(
    "words",
    [
        {"battery": "endless", "lockstep": "false", "ardupilot_parameters": " "},
        {"autopilot": "px4", "ardupilot": " ", "battery": " "},
        {"autopilot": "standin", "ardupilot": "~/not looked at", "lockstep": "true", "battery": "0.3"},
    ],
)
def test_others_pass(program, words):
    check_autopilot({"autopilot": "ardupilot", "ardupilot": program, **words})


def test_a_program_that_nobody_would_start_is_refused():
    check_program_is_used("ardupilot", {"ardupilot": "/a"})
    check_program_is_used("standin", {"ardupilot": " "})
    with pytest.raises(SimulationToolsError, match="add autopilot:=ardupilot, or leave ardupilot out"):
        check_program_is_used("standin", {"ardupilot": "/a"})
