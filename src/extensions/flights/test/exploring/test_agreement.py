"""Success needs a map that agrees with itself."""

import math

import pytest

from flights.exploring.agreement import with_agreement
from flights.exploring.summary import rows_of
from gridslam.evaluation.volume.doubled_surfaces import DOUBLED_MAX

FLOWN = {"success": True, "failure": "", "exploration": {"end": "explored"}}


@pytest.mark.parametrize("share", [0.0, DOUBLED_MAX])
def test_a_map_that_agrees_with_itself_leaves_the_success(share):
    judged = with_agreement(FLOWN, share)
    assert judged == {**FLOWN, "exploration": {"end": "explored", "doubled_share": share}}


def test_a_map_that_lies_doubled_is_no_success_and_the_result_says_why():
    judged = with_agreement(FLOWN, 0.23)
    assert not judged["success"]
    assert judged["failure"].startswith("The map does not agree with itself: 23 %")
    assert judged["exploration"]["doubled_share"] == 0.23


def test_a_failure_of_before_stays_and_no_surface_is_no_share():
    failed = {**FLOWN, "success": False, "failure": "The UAV touched a wall."}
    assert with_agreement(failed, 0.23)["failure"] == "The UAV touched a wall."
    nothing = with_agreement(FLOWN, math.nan)
    assert nothing["exploration"] == {"end": "explored", "doubled_share": None}
    assert nothing["success"]


def test_the_headline_tells_both_and_neither_of_an_older_result():
    told = {"end": "explored", "reason": "", "unknown": [], "time_99_s": None, "known_m3": 18.0}
    told |= {"is_home": True, "home_s": 30.0, "views": 3, "swaps": 0}
    assert not {"height", "floors doubled"} & set(rows_of(told))
    rows = rows_of({**told, "height_uncertain_m": 0.041, "doubled_share": 0.058})
    assert "0.04 m" in rows["height"]
    assert rows["floors doubled"].startswith("6 %")
