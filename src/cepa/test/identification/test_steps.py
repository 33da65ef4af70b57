"""The steps that identify_response flies."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.identification.identify import identify
from cepa.identification.recording import Recording
from cepa.identification.response_report import draw, report
from cepa.identification.steps import StepFlight, StepParameters

STEP_S = 0.01


def flown(speed, box, p=1.5, lag=0.12, wind=0.0):
    """Fly the steps with a UAV of a known response; return (t, command, velocity, place) of each instant."""
    flight = StepFlight((3.0, -2.0), 0.7, StepParameters(speed_m_s=speed, box_m=box))
    place, velocity, acceleration = np.array([3.0, -2.0]), np.zeros(2), np.zeros(2)
    rows = []
    for k in range(20000):
        command = flight.velocity(k * STEP_S, tuple(place))
        if command is None:
            return rows
        rows.append((k * STEP_S, command, velocity.copy(), place.copy()))
        acceleration = acceleration + (p * (command - velocity) - acceleration) * STEP_S / lag
        velocity = velocity + (acceleration + wind) * STEP_S
        place = place + velocity * STEP_S
    raise AssertionError("the steps never end")


@pytest.mark.table(("speed", "box"), [(2.0, 15.0), (4.0, 15.0), (2.0, 6.0)])
def test_the_box_is_not_left_and_it_ends_at_rest(speed, box):
    rows = flown(speed, box)
    places = np.array([place for *_, place in rows])
    assert np.abs(places - (3.0, -2.0)).max() < 0.5 * box
    assert np.hypot(*rows[-1][2]) < 0.4
    assert rows[-1][0] < 60.0


def test_it_steps_in_four_directions_of_the_heading():
    angles = {round(math.atan2(c[1], c[0]) - 0.7, 3) % 6.283 for _, c, _, _ in flown(2.0, 15.0) if c.any()}
    assert sorted(angles) == pytest.approx([0.0, 1.571, 3.142, 4.712], abs=0.002)


def test_the_steps_tell_the_response(tmp_path):
    rows = flown(2.0, 15.0)
    tables = (np.array([(t, *row[which], 0.0) for t, *row in rows]) for which in (0, 1))
    found = identify(Recording(*tables))
    assert found.model.p == pytest.approx(1.5, rel=0.03)
    assert found.model.lag_s + found.model.delay_s == pytest.approx(0.12, abs=0.015)
    lines = dict(line.split("#")[0].split(": ") for line in report(found).splitlines() if line[0] != "#")
    assert float(lines["response_p"]) == pytest.approx(found.model.p, abs=0.001)
    assert len(lines) == 7
    draw(found, tmp_path / "response.png")
    assert (tmp_path / "response.png").stat().st_size > 10_000
