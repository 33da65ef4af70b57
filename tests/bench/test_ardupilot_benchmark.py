"""The benchmark `ardupilot` without ArduPilot, and with it where there is one."""

from __future__ import annotations

import os
import time
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from benchmarks import ardupilot
from benchmarks.simulator.real_ardupilot import RealArduPilot
from benchmarks.simulator.reference_quad import standing, stepped
from benchmarks.simulator.step_response import COLUMNS, Pilot
from simulation_tools.ardupilot_sitl.program import ENVIRONMENT
from simulation_tools.px4.setpoint import Setpoint
from simulation_tools.simulation import Simulation


def test_without_ardupilot_it_is_skipped_with_a_sentence(tmp_path, monkeypatch, capsys):
    monkeypatch.delenv(ENVIRONMENT, raising=False)
    assert ardupilot.main(["--results", str(tmp_path)]) == 0
    assert capsys.readouterr().out.count("Skipped: ArduPilot is not here;") == 1
    assert not list(tmp_path.iterdir())


def test_a_program_that_is_not_there_ends_it_in_one_sentence(tmp_path, capsys):
    assert ardupilot.main(["--ardupilot", "/no/arducopter", "--results", str(tmp_path)]) == 1
    assert "/no/arducopter is not there" in capsys.readouterr().err


def test_a_px4_that_is_not_there_ends_it_in_one_sentence(tmp_path, capsys):
    with pytest.raises(SystemExit):
        ardupilot.main(["--ardupilot", "/no/arducopter", "--px4", "/no/px4", "--results", str(tmp_path)])
    assert "there is no /no/px4/bin/px4" in capsys.readouterr().err


def test_a_hover_spreads_about_its_own_mean():
    turns = np.linspace(0.0, 2.0 * np.pi, 1000, endpoint=False)
    rows = np.zeros((1000, len(COLUMNS)))
    rows[:, COLUMNS.index("north_m")] = 5.0 + 0.02 * np.sin(turns)
    found = ardupilot.hover_cm([{"hover": rows}])
    assert found["north"] == pytest.approx(100.0 * 0.02 / 2.0**0.5)
    assert found["east"] == 0.0


@pytest.mark.skipif(
    not os.access(os.environ.get(ENVIRONMENT, ""), os.X_OK),
    reason=f"{ENVIRONMENT} does not name ArduPilot's program (simulation_tools/doc/ardupilot.md)",
)
def test_real_ardupilot_takes_off_and_follows_a_velocity():
    given = RealArduPilot(os.environ[ENVIRONMENT], 1, True, {}, lambda state: ())
    simulation = Simulation(replace(standing(1), model="iris"), given)
    try:
        while not given.is_ready():
            time.sleep(0.02)
        pilot = Pilot(given, partial(stepped, simulation))
        given.take_off(3.0, pilot, 120.0)
        pilot.stream(Setpoint(velocity=(2.0, 0.0, 0.0), yaw=0.0))
        pilot.fly(4.0)
        rows = pilot.fly(2.0)
        assert rows[:, COLUMNS.index("v_north")] == pytest.approx(2.0, abs=0.2)
        assert -rows[-1, COLUMNS.index("down_m")] == pytest.approx(3.0, abs=0.5)
    finally:
        simulation.close()
