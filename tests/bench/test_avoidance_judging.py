"""How `bench avoidance` counts and judges flights."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.avoidance_rows import judging, mixed_forests, real_time, rows
from flights.campaign.reading import read_campaign


# Garwood's limits for 0, 1 and 10 events at 95 % as every table of them has it
@pytest.mark.parametrize(("events", "low", "high"), [(0, 0.0, 3.689), (1, 0.0253, 5.572), (10, 4.795, 18.39)])
def test_the_confidence_interval_is_garwoods(events, low, high):
    assert mixed_forests.rate_interval(events, 1.0) == pytest.approx((low, high), abs=5e-3)
    assert mixed_forests.rate_interval(events, 4.0)[1] == pytest.approx(high / 4.0, abs=2e-3)


def flight(end, path_length_m, flight_time_s=13.0, **more):
    """A flight of 26 m at 2 m/s, as a row of the campaign's table."""
    return {
        "replicate": 0,
        "algorithm": "improved",
        "speed_m_s": 2.0,
        "cepa.velocity_aware_emergency": False,
        "cepa.levelling": False,
        "reached": end == "goal",
        "collision": end == "collision",
        "stuck": end == "stuck",
        "path_length_m": path_length_m,
        "flight_time_s": flight_time_s,
        "time_over_straight": flight_time_s / 13.0,
        "min_clearance_m": 0.5,
        "emergencies": 0,
        **more,
    }


def test_flights_are_counted_by_what_flew_where_every_speed_did():
    campaign = read_campaign(Path("avoidance"), seeds=1)
    rows = [
        flight("goal", 26.0),
        flight("goal", 26.0, replicate=3),
        flight("goal", 26.0, speed_m_s=4.0),
        flight("stuck", 9.0, **{"cepa.levelling": True}),
        flight("collision", 4.0, algorithm="original"),
    ]
    sets = mixed_forests.sets(campaign, pd.DataFrame(rows))
    assert {name: len(flights) for name, flights in sets.items()} == {
        "improved_at_2_m_s": 2,
        "improved.all": 2,
        "improved.2_m_s": 1,
        "improved.4_m_s": 1,
        "improved_levelling.all": 1,
        "improved_levelling.2_m_s": 1,
        "original.all": 1,
        "original.2_m_s": 1,
    }
    assert mixed_forests.failures(pd.DataFrame(rows)).splitlines() == [
        "forest   0, improved_levelling, 2 m/s: stuck after 13.0 s",
        "forest   0, original, 2 m/s: collision after 13.0 s",
    ]


def test_collisions_count_by_what_was_flown():
    rows = [flight("goal", 30.0), flight("goal", 26.0, 26.0), flight("collision", 4.0)]
    metrics = mixed_forests.metrics(pd.DataFrame(rows))
    assert metrics["collisions_per_km"] == pytest.approx(1 / 0.06)
    assert metrics["reached"] == pytest.approx(2 / 3)
    assert metrics["stuck"] == 0.0
    assert metrics["time_to_goal_s"]["mean"] == pytest.approx(19.5)
    assert metrics["time_over_straight"] == pytest.approx(1.5)  # of 1 and 2: 26 m at 2 m/s take 13 s


# Clopper's and Pearson's limits: closed form for no event and for every event
@pytest.mark.parametrize(
    ("events", "low", "high"), [(0, 0.0, 1 - 0.025 ** (1 / 50)), (50, 0.025 ** (1 / 50), 1.0)]
)
def test_the_interval_of_a_share_is_clopper_and_pearsons(events, low, high):
    assert judging.share_interval(events, 50) == pytest.approx((low, high))


ROW = rows.Row("thick", "thick forests", (rows.Goal((2.0,), 0.75, 0.05, 1.4, no_slower=True),), p99_ms=2.0)


def row_flights(end="goal", flight_time_s=16.0, computation_ms=1.0, **more):
    """Four flights of the judged algorithm, of which the last ends so; three of improved."""
    common = {"world": "thick_forest", "flight_time_s": flight_time_s}
    common["time_over_straight"] = flight_time_s / 13.0
    flights = [flight("goal", 26.0, **common, replicate=i, algorithm="dynamic") for i in range(3)]
    flights.append(flight(end, 26.0, **common, replicate=3, algorithm="dynamic", **more))
    flights += [flight("goal", 26.0, 17.0, world="thick_forest", replicate=i) for i in range(3)]
    flown = pd.DataFrame(flights)
    flown["index"] = np.arange(len(flown))
    return flown, {i: [computation_ms] * 9 for i in range(4)}


def test_a_row_counts_by_place_speed_and_algorithm():
    flown, computation_ms = row_flights("collision")
    sets = judging.sets(ROW, flown)
    assert {name: len(flights) for name, flights in sets.items()} == {
        ("thick_forest", 2.0, "dynamic"): 4,
        ("thick_forest", 2.0, "improved"): 3,
    }
    metrics = judging.metrics(sets["thick_forest", 2.0, "dynamic"], computation_ms)
    assert (metrics["flights"], metrics["contacts"], metrics["reached"]) == (4, 1, 0.75)
    assert metrics["time_ratio"] == pytest.approx(16.0 / 13.0)
    assert metrics["computation_ms"] == {"p50": 1.0, "p99": 1.0}
    assert judging.key("thick_forest", 2.0, "dynamic") == "avoidance.thick_forest.2_m_s.dynamic"


@pytest.mark.parametrize(
    ("flown", "missed"),
    [
        ({}, []),
        ({"end": "collision"}, ["no contact"]),
        ({"min_clearance_m": 0.049}, ["clearance at least 0.05 m"]),
        ({"flight_time_s": 18.0}, ["time / improved's at most 1"]),
        ({"flight_time_s": 19.0}, ["time / straight at most 1.4", "time / improved's at most 1"]),
        ({"computation_ms": 2.1}, ["p99 of computation at most 2 ms"]),
    ],
)
def test_a_goal_is_met_or_missed(flown, missed):
    found = judging.verdicts(ROW, *row_flights(**flown))
    assert [verdict.goal for verdict in found if not verdict.met] == missed
    assert len(found) == 6
    assert judging.verdicts_table(found).count("missed") == len(missed)


def test_a_comparison_with_nothing_is_missed():
    flown, computation_ms = row_flights()
    found = judging.verdicts(ROW, flown[flown["algorithm"] == "dynamic"], computation_ms)
    assert [verdict.goal for verdict in found if not verdict.met] == ["time / improved's at most 1"]


def test_each_worse_condition_is_a_place_and_judged_alone():
    row = rows.Row(
        "adverse", "", (rows.Goal((2.0,)),), worse={"urg": ("lidar", "urg"), "wind": ("wind_m_s", 5.0)}
    )
    common = {"world": "spaced_forest", "algorithm": "dynamic"}
    flown = pd.DataFrame(
        [
            flight("goal", 26.0, **common, lidar="urg", wind_m_s=0.0),
            flight("collision", 26.0, **common, lidar="ust", wind_m_s=5.0),
        ]
    )
    flown["index"] = [0, 1]
    assert [place for place, _, _ in judging.sets(row, flown)] == ["urg", "wind"]
    found = judging.verdicts(row, flown, {})
    assert [(verdict.name, verdict.met) for verdict in found] == [("urg", True), ("wind", False)]


def test_no_two_rows_have_a_place_in_common():
    """Their keys would be the same."""
    places = []
    for row in rows.ROWS:
        if row is rows.REAL_TIME:
            continue
        settings = pd.DataFrame(read_campaign(Path(row.campaign)).combinations)
        places += list(dict.fromkeys(row.places(settings)))
    assert len(places) == len(set(places))
    assert {"thick_forest", "without_window", "wind", "crossing", "cables"} <= set(places)


@pytest.mark.parametrize(
    ("result", "end"),
    [
        ({}, "reached"),
        ({"collision": True}, "collision"),
        ({"reached_goal": False, "collision": True}, "collision"),
        ({"reached_goal": False}, "stuck"),
    ],
)
def test_a_flight_through_the_graph_is_judged_as_one_without(tmp_path, result, end):
    content = {
        "reached_goal": True,
        "collision": False,
        "flight_time_s": 13.0,
        "path_length_m": 30.0,
        "min_clearance_m": 0.3,
        "emergencies": 0,
        "real_time_factor": 1.0,
        "times_s": {"flying": 8.0},
    }
    (tmp_path / "result.json").write_text(json.dumps({**content, **result}))
    lines = [f"{t},{ms}" for t, ms in [(7.0, 99.0), *((8.0 + i, i) for i in range(20))]]
    (tmp_path / "decisions.csv").write_text("\n".join(["t_s,computation_ms", *lines]))
    found = real_time.outcome_of(tmp_path / "result.json", straight_s=6.5)
    assert [name for name in ("reached", "collision", "stuck") if found[name]] == [end]
    assert found["computation_ms"] == [5.0, 15.0]  # of 0 to 19; what was before the goal does not count
    if end == "reached":
        assert found["time_over_straight"] == 2.0
