"""The parameters of loop closure are checked alone and together."""

import math

import pytest

from gridslam.errors import ParameterError
from gridslam.loop_closure import LoopClosureParameters


@pytest.mark.parametrize(
    "wrong",
    [
        {"score_min": 1.2},
        {"search_every_m": 0.0},
        {"drift_share": -0.1},
        {"stretch_m": 30.0},
        {"stretch_m": 10.0},  # maps of 10 m before and after meet at a separation of 20 m
        {"window_min_m": 9.0},
        {"rival_distance_m": 0.01},
        {"blur_m": math.nan},
        {"blur_m": 10**400},
        {"places_max": True},
        {"search_agreed_m": 20.0},
    ],
)
def test_parameters_that_make_no_sense_are_refused_with_a_sentence(wrong):
    with pytest.raises(ParameterError, match=f"^.*{next(iter(wrong))}.*\\.$"):
        LoopClosureParameters(**wrong)
