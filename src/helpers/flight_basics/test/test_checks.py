"""Limits stand in the fields of a dataclass; each value beyond them is refused in one sentence."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import pytest

from flight_basics.checks import check_parameters, limited
from flight_basics.errors import ParameterError


@dataclass(frozen=True)
class Parameters:
    near: float = limited(1.0, 0.0, "far")
    far: float = limited(5.0, 1.0, 10.0)
    times: int = limited(3, 1, 5)
    is_on: bool = False
    rest: float | None = limited(None, 2.0, 3.0)
    free: float = 7.0

    def __post_init__(self) -> None:
        check_parameters(self)


@pytest.mark.parametrize(
    "given",
    [
        {},
        {"near": 0.0, "far": 1},
        {"near": 5.0},
        {"times": 5},
        {"is_on": True},
        {"rest": 2.5},
        {"free": -1e9},
    ],
)
def test_what_is_within_the_limits_is_taken(given):
    assert vars(Parameters(**given)).items() >= given.items()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"near": -0.1}, "near is -0.1; it must be a number from 0 to 5."),
        ({"near": 2.0, "far": 1.5}, "near is 2.0; it must be a number from 0 to 1.5."),
        ({"far": "5"}, "far is '5'; it must be a number from 1 to 10."),
        ({"far": math.nan}, "far is nan; it must be a number from 1 to 10."),
        ({"times": 6}, "times is 6; it must be a whole number from 1 to 5."),
        ({"times": 2.0}, "times is 2.0; it must be a whole number from 1 to 5."),
        ({"times": True}, "times is True; it must be a whole number from 1 to 5."),
        ({"is_on": 1}, "is_on is 1; it must be true or false."),
        ({"rest": 1.0}, "rest is 1.0; it must be a number from 2 to 3."),
        ({"far": None}, "far is None; it must be a number from 1 to 10."),
    ],
)
def test_what_is_beyond_them_is_refused_in_one_sentence(given, said):
    with pytest.raises(ParameterError, match=f"^{re.escape(said)}$"):
        Parameters(**given)
