"""What the report says follows from the numbers: a statement is borne out by some and not by others."""

from __future__ import annotations

import numpy as np
import pytest

from flights.worlds.scenario import LIDARS
from master_thesis.experiment_1.claim_metrics import claim_metrics as flight_metrics
from master_thesis.experiment_2.claim_metrics import angle_deg
from master_thesis.experiment_2.claim_metrics import claim_metrics as trial_metrics
from master_thesis.experiment_2.variations import Flown
from master_thesis.experiments_3_4.report.claim_metrics import hold_metrics, room_metrics
from master_thesis.experiments_3_4.report.maps import Maps
from master_thesis.measurements.claim_metrics import build_metrics, launch_metrics
from master_thesis.report import thesis
from master_thesis.report.claims import judged
from master_thesis.report.content import listed, number, spread


def found(findings, words):
    """Return the one finding whose claim has these words."""
    (finding,) = (each for each in findings if words in each.claim)
    return finding


# -- experiment 1 -------------------------------------------------------------------------------------------


def flights(**changed_ms):
    """Flights with the thesis's own times; NAME_ALGORITHM=ms for others."""
    made = {}
    for algorithm, times in thesis.TABLE_8_1_MS.items():
        for name, time_ms in times.items():
            time_ms = changed_ms.get(f"{name}_{algorithm}", time_ms or 0.01)
            made[name, algorithm] = [
                {
                    "computation_ms": time_ms,
                    "computation_p99_ms": 1.2 * time_ms,
                    "directions": 1.0 if (name, algorithm) == ("empty", "improved") else 4320.0,
                    "collision": False,
                    "reached_goal": True,
                }
            ]
    return made


def of_flights(made):
    return judged("experiment_1", flight_metrics(list(thesis.SCENARIO_FIGURES), made))


def of_room(seen):
    return judged("experiment_3", room_metrics(seen))


def of_hold(*seen):
    return judged("experiment_4", hold_metrics(*seen))


def of_builds(seconds):
    return judged("measurement_1", build_metrics(seconds, rounds=2))


def of_launches(seconds):
    return judged("measurement_2", launch_metrics(seconds, launches=2))


def test_a_verdict_from_one_flight_says_so():
    lone = flights()
    several = {key: flown * 3 for key, flown in lone.items()}
    several_but_one = {**several, ("forest", "original"): lone["forest", "original"]}
    assert {each.basis for each in of_flights(lone)} == {"one flight of each"}
    assert {each.basis for each in of_flights(several)} == {""}
    assert {each.basis for each in of_flights(several_but_one)} == {"one flight of each"}
    seen = maps("hold", urg=BENT, ust=BENT)
    again = Maps("hold", *({n: 2 * list(m) for n, m in each.items()} for each in (seen.open, seen.closed)))
    for judge in (of_room, of_hold):
        assert {each.basis for each in judge(seen)} == {"one flight of each"}
        assert {each.basis for each in judge(again)} == {""}


def test_the_thesis_agrees_with_itself():
    assert [each.claim for each in of_flights(flights()) if not each.agrees] == []
    assert all(each.why == "" for each in of_flights(flights()))


@pytest.mark.parametrize(
    ("words", "changed_ms"),
    [
        ("huge reduction", {"hallway_improved": 8.0}),
        ("quite stable", {"sparse_original": 9.0}),
        ("saves a little time", {"hallway_original": 12.0}),
        ("more cluttered", {"empty_improved": 2.0}),
        ("in the order of their times", {"hallway_improved": 4.0}),
        ("fast enough", {"forest_original": 21.0}),
    ],
)
def test_other_times_do_not_bear_it_out(words, changed_ms):
    finding = found(of_flights(flights(**changed_ms)), words)
    assert not finding.agrees
    assert finding.why


def test_a_collision_is_not_passed_over():
    made = flights()
    made["forest", "improved"][0]["collision"] = True
    finding = found(of_flights(made), "no longer cause collisions")
    assert not finding.agrees
    assert "1 collision in 4 flights" in finding.ours


# -- experiment 2 -------------------------------------------------------------------------------------------


def set_of(scenario, algorithm, touched, of=20):
    merits = [
        {"collision": n < touched, "left": n >= touched, "left_after_s": 2.0, "min_clearance_m": 0.2}
        for n in range(of)
    ]
    path = np.zeros((2, 2))
    return [Flown(scenario, algorithm, merit, False, path, None) for merit in merits]


def of_sets(touched_by_original, touched_by_improved=0):
    scenario = "wall_three_columns"
    sets = {
        (scenario, "original"): set_of(scenario, "original", touched_by_original),
        (scenario, "improved"): set_of(scenario, "improved", touched_by_improved),
    }
    return judged("experiment_2", trial_metrics({}, sets))


def test_whether_the_original_crashes_is_counted():
    assert found(of_sets(20), "would have caused").agrees
    few = found(of_sets(3), "would have caused")
    assert not few.agrees
    assert "3 of 20" in few.ours


def test_one_touch_of_the_improved_is_too_many():
    assert found(of_sets(20), "safe escape").agrees
    assert not found(of_sets(20, 1), "safe escape").agrees


@pytest.mark.parametrize(
    ("first", "second", "apart"), [((1, 0), (2, 0), 0), ((1, 0), (0, -1), 90), ((-1, 0.1), (-1, -0.1), 11.42)]
)
def test_angles_between_arrows(first, second, apart):
    assert angle_deg(first, second) == pytest.approx(apart, abs=0.01)


@pytest.mark.parametrize(("low_share", "agrees"), [(0.9, True), (0.31, False)])
def test_the_figure_loses_its_shape_when_it_grows(low_share, agrees):
    sweep = [
        {"k_filter": 0.5, "intruding_share": low_share},
        {"k_filter": 2.0, "intruding_share": 0.3},
        {"k_filter": 100.0, "intruding_share": 0.3},
    ]
    finding = judged("experiment_2", trial_metrics({"columns": {"sweep": sweep}}, {}))[0]
    assert finding.agrees is agrees
    assert ("Effects begin near K = 0.5" in finding.ours) is agrees


# -- experiments 3 and 4 ------------------------------------------------------------------------------------

TRUE, BENT = {"ate_rmse_m": 0.02, "map_error_p95_m": 0.05}, {"ate_rmse_m": 0.2, "map_error_p95_m": 0.3}


def figures(**changed):
    return {
        **TRUE,
        "ate_online_rmse_m": 0.03,
        "map_error_mean_m": 0.02,
        "map_error_max_m": 0.15,
        "half_way_error_max_m": 0.2,
        "wall_seen_share": 0.9,
        "wall_straightness_rms_m": 0.015,
        "wall_turned_max_rad": 0.01,
        "end_error_m": 0.02,
        "closures": 2,
        **changed,
    }


def maps(world, closed=None, **by_lidar):
    """Maps true to the world but for what is said: of NAME without loop closure, and with it in `closed`."""
    closed = closed or {}
    return Maps(
        world,
        {lidar: [figures(**by_lidar.get(lidar, {}))] for lidar in LIDARS},
        {lidar: [figures(**closed.get(lidar, {}))] for lidar in LIDARS},
    )


def test_as_the_thesis_saw_the_hold():
    seen = maps(
        "hold",
        closed={"urg": BENT},
        urg=BENT,
        ust=BENT,
        tim={"wall_straightness_rms_m": 0.05},
    )
    assert [each.claim for each in of_hold(seen) if not each.agrees] == []


def test_the_tim_may_bulge_with_the_range_of_the_text_only():
    seen, bent = maps("hold", urg=BENT, ust=BENT), [figures(wall_straightness_rms_m=0.05)]
    finding = found(of_hold(seen, bent), "bulges inwards")
    assert finding.agrees
    assert "nothing bulges" in finding.why
    straight = found(of_hold(seen, [figures()]), "bulges inwards")
    assert not straight.agrees


@pytest.mark.parametrize(
    ("words", "seen"),
    [
        ("huge impact", maps("hold")),
        ("pretty much equal", maps("hold", utm=BENT)),
        ("indistinguishable", maps("hold", puck={"map_error_p95_m": 0.12})),
        ("bulges inwards", maps("hold")),
        ("fixed by the loop closure", maps("hold")),
        ("fixed by the loop closure", maps("hold", ust=BENT, closed={"ust": BENT})),
        ("could not correct it", maps("hold")),
        ("could not correct it", maps("hold", urg=BENT)),
    ],
)
def test_other_maps_of_the_hold_do_not_bear_it_out(words, seen):
    finding = found(of_hold(seen), words)
    assert not finding.agrees
    assert finding.why


def test_as_the_thesis_saw_the_room():
    seen = maps("room", urg={"wall_seen_share": 0.8}, tim={"half_way_error_max_m": 0.5})
    assert [each.claim for each in of_room(seen) if not each.agrees] == []
    other = of_room(maps("room", m8=BENT, ust={"wall_seen_share": 0.5}))
    assert [each.agrees for each in other] == [False, False, False]
    assert all(each.why for each in other)


def test_loop_closure_is_shown_where_it_matters():
    seen = maps("hold", urg=BENT)
    assert seen.closure_matters("urg")
    assert not seen.closure_matters("m8")
    assert seen.lidars == ("urg", "ust", "tim", "utm", "puck", "m8")


# -- measurements -------------------------------------------------------------------------------------------


def test_build_times_are_alike_within_a_factor_of_two():
    near = {"one file": 4.0, "many files": 12.0, "from nothing": 20.0}
    assert all(each.agrees for each in of_builds(near))
    far = of_builds({"one file": 1.0, "many files": 40.0, "from nothing": 30.0})
    assert not far[0].agrees
    assert "one file 5.0 times as fast" in far[0].why
    assert "many files 2.7 times as long" in far[0].why
    assert not far[1].agrees


def test_launch_times_beside_the_thesis():
    theirs = {what: time._asdict() for what, time in thesis.TABLE_8_4.items()}
    assert all(each.agrees for each in of_launches(theirs))
    ours = {what: {"startup_s": 3.0, "shutdown_s": 1.0} for what in theirs}
    differ = of_launches(ours)
    assert [each.agrees for each in differ] == [False, False, False]
    assert "Gazebo with PX4 5.5 times as fast" in differ[0].why


def test_numbers_as_they_are_written():
    assert number(None, 2) == "-"
    assert number(1.005e-3, 4) == "0.0010"
    assert spread([1.0, 3.0], 1) == "2.0 ± 1.0"
    assert spread([2.0], 1) == "2.0"
    assert spread([None], 1) == "-"
    assert listed(["a"]) == "a"
    assert listed(["a", "b", "c"]) == "a, b and c"
