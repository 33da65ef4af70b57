"""What a lidar that nods cannot do is refused in one sentence, before anything starts."""

from __future__ import annotations

import re

import pytest

from flights.errors import FlightsError
from flights.launch_arguments import nodding
from simulation_tools.errors import SimulationToolsError

ASKED = {
    "nod": "true",
    "volume": "true",
    "lidar": "ust",
    "level_lidar": "false",
    "lockstep": "false",
    "nod_amplitude": "0.7",
    "nod_period": "4.0",
    "nod_sweeps": "2",
}


def test_the_defaults_and_a_flight_that_does_not_nod_pass():
    nodding.check(ASKED)
    nodding.check({**ASKED, "nod_amplitude": "0"})
    nodding.check({"nod": "false", "lidar": "puck"})


@pytest.mark.table(
    ("asked", "sentence"),
    [
        ({"volume": "false"}, "add volume:=true to nod:=true."),
        ({"lidar": "puck"}, "lidar:=puck need not nod, because it has a cloud; leave out nod:=true."),
        ({"level_lidar": "true"}, "leave out level_lidar:=true."),
        ({"lockstep": "true"}, "leave out lockstep:=true."),
        ({"nod_amplitude": "wide"}, "nod_amplitude"),
        ({"nod_amplitude": "nan"}, "nod_amplitude"),
        ({"nod_amplitude": "1.2"}, "the gimbal turns by 0.8 rad at most."),
        ({"nod_period": "0"}, "The period_s of a nod must be greater than 0"),
        ({"nod_period": "0.2"}, "give a longer period."),
        ({"nod_sweeps": "0"}, "'0' is no nod_sweeps; give a whole number from 1 to 100."),
    ],
)
def test_what_cannot_be_flown_is_refused(asked, sentence):
    with pytest.raises((FlightsError, SimulationToolsError), match=re.escape(sentence)):
        nodding.check({**ASKED, **asked})


def test_an_exploration_may_nod_in_lockstep_but_not_with_a_cloud():
    nodding.check_lidar({**ASKED, "lockstep": "true"})
    with pytest.raises(FlightsError, match="lidar:=m8 need not nod"):
        nodding.check_lidar({**ASKED, "lidar": "m8"})
