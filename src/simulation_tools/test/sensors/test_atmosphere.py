"""The standard atmosphere against the tables of ISO 2533."""

from __future__ import annotations

import pytest

from simulation_tools.sensors.atmosphere import pressure_pa, temperature_k


@pytest.mark.table(
    ("altitude_m", "pressure", "temperature"),
    [
        (0.0, 101325.0, 288.15),
        (500.0, 95461.0, 284.90),
        (1000.0, 89875.0, 281.65),
        (5000.0, 54020.0, 255.65),
        (11000.0, 22632.0, 216.65),
    ],
)
def test_pressure_and_temperature_are_the_tables(altitude_m, pressure, temperature):
    # The tables are by geopotential altitude, to 1 Pa.
    assert pressure_pa(altitude_m) == pytest.approx(pressure, abs=1.5)
    assert temperature_k(altitude_m) == pytest.approx(temperature, abs=0.01)
