import dataclasses

import numpy as np
import pytest

from cepa import CepaError, CepaParameters, ParameterError


def test_defaults_are_those_that_were_tuned():
    p = CepaParameters()
    assert (p.r_lb, p.r_ub, p.time_horizon, p.body_radius) == (0.5, 1.2, 1.5, 0.35)
    assert (p.k_filter, p.emergency_lookahead, p.speed_fractions) == (50.0, 1.2, (1.0, 0.75, 0.5, 0.25))
    assert not p.unseen_is_free


def test_parameters_cannot_be_changed_in_place():
    with pytest.raises(dataclasses.FrozenInstanceError):
        CepaParameters().r_lb = 0.4


def test_speed_fractions_are_sorted_and_unique():
    assert CepaParameters(speed_fractions=[0.5, 1, 0.5]).speed_fractions == (1.0, 0.5)


def test_numbers_of_numpy_are_numbers():
    p = CepaParameters(r_lb=np.float32(0.5), k3=np.float64(0.25), dropout_beams=np.int64(3))
    assert p == CepaParameters(r_lb=0.5, k3=0.25, dropout_beams=3)
    assert (type(p.r_lb), type(p.k3), type(p.dropout_beams)) == (float, float, int)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"r_lb": 1.2}, "r_lb must be less than r_ub, but 1.2 >= 1.2."),
        ({"r_lb": 0.0}, "r_lb must be greater than 0, not 0.0."),
        ({"r_lb": float("nan")}, "r_lb must be a finite number, not nan."),
        ({"r_ub": 10**400}, f"r_ub must be a finite number, not {10**400}."),
        ({"speed_fractions": [10**400]}, f"speed_fractions must be numbers, not {[10**400]}."),
        ({"r_ub": "wide"}, "r_ub must be a finite number, not 'wide'."),
        ({"k_filter": -1.0}, "k_filter must be greater than 0, not -1.0."),
        ({"k3": -0.1}, "k3 must be at least 0, not -0.1."),
        ({"body_radius": 0.5}, "body_radius must be less than r_lb"),
        ({"v_min": 2.0, "v_max": 1.0}, "v_min must be at most v_max"),
        ({"speed_fractions": ()}, "speed_fractions must be one or more numbers in (0, 1]"),
        ({"speed_fractions": (1.0, 1.5)}, "speed_fractions must be one or more numbers in (0, 1]"),
        ({"speed_fractions": ("fast",)}, "speed_fractions must be numbers"),
        ({"reference_speed_min": 0.0}, "reference_speed_min must be greater than 0"),
        ({"dropout_beams": 1.5}, "dropout_beams must be a whole number, not 1.5."),
        ({"emergency_cancellation": 1.0}, "emergency_cancellation must be less than 1, not 1.0."),
        ({"unseen_is_free": "no"}, "unseen_is_free must be true or false, not 'no'."),
    ],
)
def test_what_makes_no_sense_is_refused_in_a_sentence(change, sentence):
    with pytest.raises(ParameterError) as refusal:
        CepaParameters(**change)
    assert sentence in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert isinstance(refusal.value, CepaError)
