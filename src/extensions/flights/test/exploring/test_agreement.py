"""Success needs a map that agrees with itself."""

import math

import numpy as np
import pytest

from flights.exploring.agreement import home_height_off_m, with_agreement
from flights.exploring.summary import rows_of
from gridslam.evaluation.volume.doubled_surfaces import DOUBLED_MAX

FLIGHT_S = 60.0
FLOWN = {"success": True, "failure": "", "exploration": {"end": "explored"}}


@pytest.mark.table("share", [0.0, DOUBLED_MAX])
def test_a_map_that_agrees_with_itself_leaves_the_success(share):
    judged = with_agreement(FLOWN, share)
    told = {"end": "explored", "doubled_share": share, "home_height_off_m": None}
    assert judged == {**FLOWN, "exploration": told}


def test_a_map_that_lies_doubled_is_no_success_and_the_result_says_why():
    judged = with_agreement(FLOWN, 0.23)
    assert not judged["success"]
    assert judged["failure"].startswith("The map does not agree with itself: 23 %")
    assert judged["exploration"]["doubled_share"] == 0.23


def test_a_failure_of_before_stays_and_no_surface_is_no_share():
    failed = {**FLOWN, "success": False, "failure": "The UAV touched a wall."}
    assert with_agreement(failed, 0.23)["failure"] == "The UAV touched a wall."
    nothing = with_agreement(FLOWN, math.nan)
    assert nothing["exploration"]["doubled_share"] is None
    assert nothing["success"]


def test_the_headline_tells_both_and_neither_of_an_older_result():
    told = {"end": "explored", "reason": "", "unknown": [], "time_99_s": None, "known_m3": 18.0}
    told |= {"is_home": True, "home_s": 30.0, "views": 3, "swaps": 0}
    assert not {"height", "floors doubled"} & set(rows_of(told))
    rows = rows_of({**told, "height_uncertain_m": 0.041, "doubled_share": 0.058})
    assert "0.04 m" in rows["height"]
    assert rows_of({**told, "home_height_off_m": 5.26})["height at home"].startswith("off by 5.26 m")
    assert rows["floors doubled"].startswith("6 %")


def flown(ends_m, begins_at_0_m=True):
    """Odometry of a flight of 60 s up to 10 m, at 10 Hz, that lands at (x, y, z).

    It stands at (0, 0, 0.12) for 3 s at both ends. Its first pose tells 0, before the first range came.
    """
    t = np.arange(0.0, FLIGHT_S, 0.1)
    up = np.clip(np.minimum(t - 3.0, FLIGHT_S - 3.0 - t), 0.0, 10.0)
    way = np.clip((t - 3.0) / (FLIGHT_S - 6.0), 0.0, 1.0)[:, None]
    places = (1.0 - way) * (0.0, 0.0, 0.12) + way * ends_m
    places[:, 2] += up
    if begins_at_0_m:
        places[:5, 2] = 0.0
    return np.column_stack((t, places))


def test_a_uav_that_lands_where_it_took_off_stands_as_high_as_at_the_start():
    assert home_height_off_m(flown((0.0, 0.0, 0.12))) == pytest.approx(0.0, abs=0.01)
    assert home_height_off_m(flown((0.0, 0.0, -5.14))) == pytest.approx(5.26, abs=0.01)
    assert home_height_off_m(flown((0.3, 0.4, 5.12))) == pytest.approx(4.5, abs=0.01)  # beside it, on a slope
    assert home_height_off_m(flown((0.3, 0.4, 0.52))) == 0.0


def test_a_uav_that_lands_elsewhere_and_an_odometry_that_tells_too_little_say_nothing_of_it():
    assert math.isnan(home_height_off_m(flown((0.8, 0.8, 5.0))))
    assert math.isnan(home_height_off_m(flown((0.0, 0.0, 5.0))[:20]))
    assert math.isnan(home_height_off_m(np.empty((0, 4))))


def test_a_height_that_was_wrong_is_no_success_and_the_result_says_why():
    judged = with_agreement(FLOWN, 0.03, 5.26)
    assert not judged["success"]
    assert "stands 5.3 m higher or lower than at the start" in judged["failure"]
    assert judged["exploration"]["home_height_off_m"] == 5.26
    assert with_agreement(FLOWN, 0.03, 0.3)["success"]
    unsure = {**FLOWN, "exploration": {"end": "explored", "height_uncertain_m": 1.3}}
    assert "its standard deviation reached 1.3 m" in with_agreement(unsure, 0.0)["failure"]
    known = {**FLOWN, "exploration": {"end": "explored", "height_uncertain_m": 0.3}}
    assert with_agreement(known, 0.0)["success"]
