"""A campaign's rates, means and pictures, on tables worked out by hand."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from flights.campaign.axes import STEERING
from flights.campaign.pictures import COLOURS, MARKERS, pictures
from flights.campaign.reading import campaign_of
from flights.campaign.statistics import bootstrap, summary, wilson


# Newcombe (1998), table I, method 3
@pytest.mark.table(
    ("events", "trials", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_the_interval_of_a_rate_is_wilsons(events, trials, low, high):
    assert wilson(events, trials) == pytest.approx((low, high), abs=6e-5)


def test_nothing_tried_is_nothing_known():
    assert wilson(0, 0) == (0.0, 1.0)
    for values in ([], [2.0]):
        assert np.isnan(bootstrap(np.array(values), np.random.default_rng(1))).all()


def test_the_interval_of_a_mean_is_the_normal_one_for_many_values():
    values = np.random.default_rng(1).normal(3.0, 2.0, 900)
    low, high = bootstrap(values, np.random.default_rng(2))
    half = 1.96 * values.std() / 30.0
    assert (low, high) == pytest.approx((values.mean() - half, values.mean() + half), abs=0.1 * half)
    assert bootstrap(values, np.random.default_rng(2)) == (low, high)


def flights():
    """Two algorithms: one that arrives in 10 and 14 s, one that hits something, gets stuck, or fails."""
    content = {"seeds": 3, "trials": {"world": "random_forest", "algorithm": ["improved", "none"]}}
    ends = ["goal", "collision", "goal", "stuck", "goal", "error"]
    rows = [
        {
            "index": index,
            "algorithm": ("improved", "none")[index % 2],
            "reached": end == "goal",
            "collision": end == "collision",
            "stuck": end == "stuck",
            "flight_time_s": time_s,
            "time_over_straight": time_s / 10.0,
            "path_length_m": 20.0,
            "min_clearance_m": 0.5,
            "emergencies": 0,
            "error": "It failed." if end == "error" else None,
            "commit": "abc",
        }
        for index, (end, time_s) in enumerate(zip(ends, (10.0, 3.0, 14.0, 60.0, 12.0, np.nan)))
    ]
    return campaign_of(content, "x"), pd.DataFrame(rows)


def test_a_summary_counts_what_it_should():
    campaign, trials = flights()
    improved, none = summary(campaign, trials).to_dict("records")
    assert (improved["algorithm"], improved["trials"], improved["errors"]) == ("improved", 3, 0)
    assert (improved["collision_rate"], improved["reached_rate"]) == (0.0, 1.0)
    assert improved["flight_time_s_mean"] == pytest.approx(12.0)
    assert 10.0 <= improved["flight_time_s_mean_low"] < 12.0 < improved["flight_time_s_mean_high"] <= 14.0
    assert (none["trials"], none["errors"]) == (3, 1)
    assert (none["collision_rate"], none["stuck_rate"]) == (0.5, 0.5)
    assert (none["collision_rate_low"], none["collision_rate_high"]) == wilson(1, 2)
    assert np.isnan(none["flight_time_s_mean"])  # a collision's few seconds are no speed
    assert none["min_clearance_m_mean"] == 0.5


def test_a_summary_names_every_version_of_the_code():
    campaign, trials = flights()
    trials.loc[4, "commit"] = "def"
    assert summary(campaign, trials)["commits"].tolist() == ["abc def", "abc"]


def test_a_campaign_without_anything_that_varies_has_one_line():
    _, trials = flights()
    (line,) = summary(campaign_of({"trials": {"world": "random_forest"}}, "x"), trials).to_dict("records")
    assert (line["trials"], line["errors"]) == (6, 1)
    assert line["collision_rate"] == pytest.approx(0.2)


def test_every_algorithm_has_a_colour_and_a_marker_of_its_own():
    assert set(COLOURS) == set(MARKERS) == set(STEERING)
    assert len(set(COLOURS.values())) == len(set(MARKERS.values())) == len(STEERING)


@pytest.mark.table(
    ("axes", "names"),
    [
        ({"algorithm": ["improved", "none"]}, set()),
        ({"algorithm": ["improved", "none"], "density_per_m2": [0.1, 0.16]}, {"flights.png"}),
        ({"speed_m_s": [1, 2], "cepa.k4": [0, 1]}, {"flights.png", "trade_off.png"}),
        ({"cepa.levelling": [False, True]}, {"trade_off.png"}),
    ],
)
def test_the_pictures_are_those_that_the_axes_call_for(axes, names):
    campaign = campaign_of({"seeds": 2, "trials": {"world": "random_forest", **axes}}, "x")
    _, some = flights()
    rows = []
    for index in range(len(campaign)):
        row = some.iloc[index % 5].to_dict()
        rows.append({**row, **campaign.case(index).settings, "index": index})
    drawn = pictures(campaign, pd.DataFrame(rows))
    assert set(drawn) == names
    assert all(content.startswith(b"\x89PNG") for content in drawn.values())


def test_a_world_without_an_axis_has_no_curve_over_it():
    moving = {"world": "crossing", "mover_speed_m_s": [1, 2]}
    campaign = campaign_of({"seeds": 1, "trials": [{"world": "dead_ends"}, moving]}, "x")
    _, some = flights()
    rows = [{**some.iloc[0].to_dict(), **settings} for settings in campaign.combinations]
    assert set(pictures(campaign, pd.DataFrame(rows))) == {"flights.png"}


def test_without_any_flight_nothing_is_drawn():
    campaign, trials = flights()
    assert pictures(campaign, trials.assign(error="It failed.")) == {}
