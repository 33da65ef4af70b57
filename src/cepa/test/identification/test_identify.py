"""The identified response against UAVs whose response is known, integrated here in plain steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa.identification.identify import identify, predicted_velocities
from cepa.identification.recording import IdentificationError, Recording

STEP_S = 0.0025
SCAN_S = 0.025


def steps(rng, seconds=40.0, speed=2.0, climb=0.0):
    """Return commands (n, 4) at 40 Hz: another velocity every second or two, sometimes none."""
    rows, until, command = [], 0.0, np.zeros(3)
    for t in np.arange(0.0, seconds, SCAN_S):
        if t >= until:
            until = t + rng.uniform(0.7, 2.0)
            angle = rng.uniform(-math.pi, math.pi)
            horizontal = speed * rng.choice([0.0, 0.5, 1.0])
            vertical = climb * rng.uniform(-1, 1)
            command = np.array([horizontal * math.cos(angle), horizontal * math.sin(angle), vertical])
        rows.append((t, *command))
    return np.array(rows)


def flown(commands, p=1.5, i=0.0, lag=0.12, delay=0.0, climb_lag=0.3, noise=0.0, rng=None):
    """Return what a UAV of a known response measures of its velocity at each command's time.

    Here horizontal vectors are complex numbers.
    """
    rows = []
    velocity, acceleration, integral, climb = 0j, 0j, 0j, 0.0
    late = round(delay / STEP_S)
    per_command = round(SCAN_S / STEP_S)
    held = [row for row in commands.tolist() for _ in range(per_command)]
    for k in range(len(held)):
        if k % per_command == 0:
            rows.append((k // per_command * SCAN_S, velocity.real, velocity.imag, climb))
        _, x, y, z = held[max(k - late, 0)]
        error = complex(x, y) - velocity
        wanted = p * error + integral
        integral = integral + i * error * STEP_S
        acceleration = acceleration + (wanted - acceleration) * STEP_S / lag
        velocity = velocity + acceleration * STEP_S
        climb += (z - climb) * STEP_S / climb_lag
    rows = np.array(rows)
    rows[:, 1:] += (rng or np.random.default_rng(0)).normal(0.0, noise, (len(rows), 3)) if noise else 0.0
    return rows


@pytest.mark.table(("p", "i", "lag"), [(1.5, 0.0, 0.12), (2.2, 0.4, 0.2), (0.9, 0.1, 0.35)])
def test_a_known_response_is_recovered(p, i, lag):
    rng = np.random.default_rng(1)
    commands = steps(rng)
    found = identify(Recording(commands, flown(commands, p, i, lag)))
    assert found.model.p == pytest.approx(p, rel=0.03)
    assert found.model.i == pytest.approx(i, abs=0.03)
    assert found.model.lag_s == pytest.approx(lag, rel=0.06, abs=0.01)
    assert found.model.delay_s < 0.012
    assert found.model.error_m_s2 == 0.0  # nothing strays by more than the margin
    assert found.explained > 0.97


def test_noise_and_lost_messages_do_not_spoil_it():
    rng = np.random.default_rng(2)
    commands = steps(rng)
    measured = flown(commands, 1.5, 0.2, 0.15, noise=0.05, rng=rng)
    kept = [rng.uniform(size=len(rows)) > 0.2 for rows in (commands, measured)]
    found = identify(Recording(commands[kept[0]], measured[kept[1]]))
    assert found.model.p == pytest.approx(1.5, rel=0.08)
    assert found.model.lag_s + found.model.delay_s == pytest.approx(0.15, abs=0.03)
    assert found.model.error_m_s2 < 0.5


def test_a_pure_delay_is_told_apart_from_the_lag():
    commands = steps(np.random.default_rng(3))
    model = identify(Recording(commands, flown(commands, 1.5, 0.0, 0.1, delay=0.15))).model
    assert (model.p, model.lag_s, model.delay_s) == pytest.approx((1.5, 0.1, 0.15), rel=0.06, abs=0.01)


def test_what_the_model_leaves_out_becomes_its_error():
    # Given a UAV that a steady acceleration of 0.5 m/s2 disturbs, in one half of the flight
    commands = steps(np.random.default_rng(4), 60.0)
    disturbed = commands.copy()
    disturbed[len(commands) // 2 :, 1] += 0.5 / 1.5
    # When its response is identified from what was asked for
    found = identify(Recording(commands, flown(disturbed)))
    # Then the stated error is about that, less what the margin covers
    assert 0.2 < found.model.error_m_s2 <= 0.6
    assert found.model.error_m_s2 <= found.error_max_m_s2


def test_the_climb_has_a_lag_of_its_own():
    commands = steps(np.random.default_rng(5), climb=0.8)
    assert identify(Recording(commands, flown(commands, climb_lag=0.4))).climb_lag_s == pytest.approx(
        0.4, rel=0.05
    )
    level = steps(np.random.default_rng(5))
    assert identify(Recording(level, flown(level))).climb_lag_s is None


def test_the_greatest_acceleration_is_the_flown_one():
    # An error of e accelerates by p e at most, and no command differs from the velocity by more than 4 m/s
    commands = steps(np.random.default_rng(6))
    assert 1.5 < identify(Recording(commands, flown(commands))).model.acceleration_max_m_s2 < 1.5 * 4.0


def test_a_gap_parts_the_recording():
    # Given a flight whose odometry was gone for 20 s, in which somebody else flew
    commands = steps(np.random.default_rng(7), 80.0)
    measured = flown(commands)
    measured = measured[(measured[:, 0] < 30.0) | (measured[:, 0] > 50.0)]
    found = identify(Recording(commands, measured))
    assert [round(piece.times_s[0]) for piece in found.pieces] == [0, 50]
    assert found.model.p == pytest.approx(1.5, rel=0.05)


def test_the_predicted_velocities_are_those_of_the_model():
    commands = steps(np.random.default_rng(8), 20.0)
    found = identify(Recording(commands, flown(commands)))
    (piece,) = found.pieces
    predicted = predicted_velocities(piece, found.model)
    assert np.abs(predicted - piece.velocities[:, :2]).max() < 0.1


@pytest.mark.table(
    ("change", "sentence"),
    [
        (lambda c, v: (c[:2], v), "never last"),
        (lambda c, v: (c[:0].reshape(0, 4), v), "0 commands"),
        (lambda c, v: (c * [1.0, 0.1, 0.1, 0.1], v), "jumps 0 times"),
        (lambda c, v: (c, np.concatenate((v[:, :1], v[::-1, 1:]), axis=1)), "check the topics"),
        (lambda c, v: (c, v * [1.0, 0.0, 0.0, 0.0]), "check the topics"),
        (lambda c, v: (c, np.where(v == v[5], np.nan, v)), "finite"),
    ],
)
def test_a_recording_that_does_not_tell_is_refused(change, sentence):
    commands = steps(np.random.default_rng(9), 30.0)
    with pytest.raises(IdentificationError, match=sentence):
        identify(Recording(*change(commands, flown(commands))))
