"""The mixer: closed forms and bounds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.px4.control.mixer import QUAD_WIDE, Mixer, mixing_matrix


def test_the_mixer_makes_pure_torques_on_the_geometry_it_was_made_for():
    columns = mixing_matrix(QUAD_WIDE)
    effect = np.array([(-y, x, 0.05 * turn, 1.0) for x, y, turn in QUAD_WIDE]).T
    produced = effect @ columns
    assert produced == pytest.approx(np.diag(np.diag(produced)), abs=1e-12)
    assert np.linalg.norm(columns[:, :2], axis=0).max() == pytest.approx(math.sqrt(2.0))
    assert np.abs(columns[:, 2]).max() == pytest.approx(1.0)
    assert columns[:, 3] == pytest.approx(np.ones(4))


def test_what_fits_is_mixed_exactly():
    mixer = Mixer()
    out = mixer.mix(np.array([0.1, -0.05, 0.02]), 0.5)
    assert out == pytest.approx(mixing_matrix(QUAD_WIDE) @ [0.1, -0.05, 0.02, 0.5])
    assert not mixer.saturation.any()


@given(st.tuples(*[st.floats(-1, 1)] * 3), st.floats(0, 1))
def test_commands_stay_within_bounds_and_thrust_is_never_raised(torques, thrust):
    out = Mixer().mix(np.array(torques), thrust)
    assert ((out >= 0.0) & (out <= 1.0)).all()
    # Clipping at zero adds what desaturation could not take away; the mean bounds it.
    unclipped = np.clip(mixing_matrix(QUAD_WIDE) @ [*torques, thrust], 0.0, 1.0)
    assert out.mean() <= max(thrust, unclipped.mean()) + 1e-9


def test_at_full_thrust_thrust_gives_way_to_roll():
    out = Mixer().mix(np.array([0.2, 0.0, 0.0]), 1.0)
    columns = mixing_matrix(QUAD_WIDE)
    assert out - out.mean() == pytest.approx(0.2 * (columns[:, 0] - columns[:, 0].mean()), abs=1e-9)
    assert out.max() == pytest.approx(1.0)


def test_idle_rotors_report_which_way_they_cannot_go():
    mixer = Mixer()
    mixer.mix(np.array([0.0, 0.0, 0.0]), 0.0)
    assert mixer.saturation.all()
