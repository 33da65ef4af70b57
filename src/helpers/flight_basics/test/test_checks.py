"""Limits stand in the fields of a dataclass; each value beyond them is refused in one sentence."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import pytest

from flight_basics.checks import check_limits, check_parameters, limited
from flight_basics.errors import ParameterError


@dataclass(frozen=True)
class Parameters:
    near: float = limited(1.0, 0.0, "far")
    far: float = limited(5.0, 1.0, 10.0)
    times: int = limited(3, 1, 5)
    is_on: bool = False
    rest: float | None = limited(None, 2.0, 3.0)
    free: float = 7.0
    time: float = limited(math.inf, above=0.0, most=math.inf)
    called_m: float = limited(1.0, 0.0, 2.0, named="called")

    def __post_init__(self) -> None:
        check_parameters(self)


@pytest.mark.table(
    "given",
    [
        {},
        {"near": 0.0, "far": 1},
        {"near": 5.0},
        {"times": 5},
        {"is_on": True},
        {"rest": 2.5},
        {"free": -1e9},
        {"time": 0.1},
    ],
)
def test_what_is_within_the_limits_is_taken(given):
    assert vars(Parameters(**given)).items() >= given.items()


@pytest.mark.table(
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
        ({"time": 0.0}, "time is 0.0; it must be greater than 0."),
        ({"rest": 1.0}, "rest is 1.0; it must be a number from 2 to 3."),
        ({"far": None}, "far is None; it must be a number from 1 to 10."),
        ({"called_m": 3.0}, "called is 3.0; it must be a number from 0 to 2."),
    ],
)
def test_what_is_beyond_them_is_refused_in_one_sentence(given, said):
    with pytest.raises(ParameterError, match=f"^{re.escape(said)}$"):
        Parameters(**given)


# -- limits of one side, each in a sentence of its own, with a package's own error --------------------------


class OwnError(Exception):
    """Of some package."""


@dataclass(frozen=True)
class OneSided:
    gain: float = limited(1.0, above=0.0)
    share: float = limited(0.5, 0.0, 1.0)
    part: float = limited(0.5, 0.0, below=1.0)
    height: float = limited(2.0, live=(-10.0, 10.0))
    reach: float = limited(9.0, 1.0, math.inf)
    times: int = limited(3, 1, 5)
    is_on: bool = False
    rest: float | None = limited(None, above=2.0)
    name: str = "any"

    def __post_init__(self) -> None:
        check_limits(self, OwnError, "The tool's {}")


@pytest.mark.table(
    "given",
    [
        {},
        {"gain": 1e-300, "share": 0, "part": 0.0, "times": 1},
        {"gain": 1e300, "share": 1, "part": 0.999, "times": 5},
        {"height": -1e9},  # beyond what a window of dynamic_reconfigure shows
        {"reach": math.inf},
        {"rest": 2.1},
        {"times": 4.0},  # as a YAML file may hold it
        {"name": 3},  # without limits
    ],
)
def test_what_keeps_limits_of_one_side_is_taken(given):
    assert vars(OneSided(**given)).items() >= given.items()


@pytest.mark.table(
    ("given", "must_be"),
    [
        ({"gain": 0.0}, "greater than 0, not 0.0"),
        ({"gain": math.nan}, "a finite number, not nan"),
        ({"gain": math.inf}, "a finite number, not inf"),
        ({"gain": True}, "a finite number, not True"),
        ({"gain": "1"}, "a finite number, not '1'"),
        ({"height": None}, "a finite number, not None"),
        ({"height": 10**400}, f"a finite number, not {10**400}"),
        ({"reach": 10**400}, f"a finite number, not {10**400}"),  # not even where inf is allowed
        ({"share": -0.1}, "between 0 and 1, not -0.1"),
        ({"share": 1.1}, "between 0 and 1, not 1.1"),
        ({"part": 1.0}, "less than 1, not 1.0"),
        ({"part": -1}, "at least 0, not -1"),
        ({"times": 0}, "at least 1, not 0"),
        ({"times": 6}, "at most 5, not 6"),
        ({"times": 2.5}, "a whole number, not 2.5"),
        ({"reach": -math.inf}, "between 1 and inf, not -inf"),
        ({"is_on": 1}, "true or false, not 1"),
        ({"rest": 2.0}, "greater than 2, not 2.0"),
    ],
)
def test_the_sentence_tells_the_side_that_is_passed(given, must_be):
    said = f"The tool's {next(iter(given))} must be {must_be}."
    with pytest.raises(OwnError, match=f"^{re.escape(said)}$"):
        OneSided(**given)
