"""A campaign before it flies: its file and the mistakes in it, places, the search of parameters."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import pytest

from flights.campaign.axes import FLIGHT_WORLDS, KINDS, MAPPING_WORLDS, axes_of
from flights.campaign.command import main
from flights.campaign.folder import columns_of
from flights.campaign.reading import SHIPPED, campaign_of, read_campaign
from flights.campaign.trial import lidar_data
from flights.campaign.tuning import objective, tune
from flights.errors import CampaignError

ROOT = Path(__file__).resolve().parents[5]
FOREST = {"world": "random_forest"}
BY_100 = {"from": 1, "to": 100, "steps": 100}


# -- the page -----------------------------------------------------------------------------------------------


@pytest.mark.table("kind", KINDS)
def test_the_page_names_every_axis_world_and_column(kind):
    page = (ROOT / "src/extensions/flights/doc/campaigns.md").read_text()
    on_page = re.findall(r"`([a-z0-9_.]+)`", page)
    begun = tuple(name.removesuffix("...") for name in on_page if name.endswith("_..."))  # `ate_...`
    world = {"flight": "random_forest", "mapping": "beamed_hold"}[kind]
    campaign = campaign_of({"kind": kind, "trials": {"world": world}}, "none")
    axes = [name for name in axes_of(kind) if not name.startswith(("cepa.", "slam."))]
    needed = [*axes, *FLIGHT_WORLDS, *MAPPING_WORLDS, *columns_of(campaign)]
    assert [name for name in needed if name not in on_page and not name.startswith(begun)] == []


# -- the file -----------------------------------------------------------------------------------------------


@pytest.mark.table("path", sorted(SHIPPED.glob("*.yaml")))
def test_every_shipped_campaign_is_read_and_its_smallest_is_small(path):
    whole, smallest = read_campaign(path), read_campaign(path, smallest=True)
    assert whole.name == path.stem
    assert 1 <= len(smallest) <= 12 < len(whole)
    assert read_campaign(Path(path.stem)) == whole


@pytest.mark.table(
    ("content", "sentence"),
    [
        ([1], r"a campaign must be a mapping of names to values, not \[1\]"),
        ({"trails": FOREST}, "a campaign knows no 'trails'; did you mean trials?"),
        ({}, "trials must be a mapping of names to values, not None"),
        ({"trials": {}}, "trials needs a world"),
        ({"kind": "walk", "trials": FOREST}, "there is no kind 'walk'; choose from flight, mapping"),
        ({"trials": {"world": "jungle"}}, "There is no world 'jungle'; choose from random_forest"),
        (
            {"trials": {**FOREST, "algorithm": ["improved", "magic"]}},
            "no algorithm 'magic'; choose from",
        ),
        ({"trials": {**FOREST, "lidar": "vlp"}}, "There is no lidar 'vlp'; choose from urg"),
        ({"trials": {**FOREST, "speed_m_s": "fast"}}, "speed_m_s is 'fast'; it must be a finite number"),
        ({"trials": {**FOREST, "speed_m_s": [1, 900]}}, "speed_m_s must be from 0.2 to 8, not 900"),
        ({"trials": {**FOREST, "speed_m_s": [2, 2.0]}}, "speed_m_s names a value twice"),
        ({"trials": {**FOREST, "speed_m_s": []}}, "speed_m_s has an empty list of values"),
        ({"trials": {**FOREST, "speed": 2}}, "trials knows no 'speed'; did you mean speed_m_s?"),
        ({"trials": {**FOREST, "speed_m_s": {"from": 1, "to": 2}}}, "takes a value, a list, or of numbers"),
        (
            {"trials": {**FOREST, "width_m": 2}},
            "width_m is of the world random_hallway only",
        ),
        (
            {"trials": {**FOREST, "cepa.r_upper": 2}},
            "knows no 'cepa.r_upper'; did you mean cepa.r_ub?",
        ),
        ({"trials": {**FOREST, "cepa.r_ub": [1, 0.3]}}, "do not go together: r_lb must be less than r_ub"),
        ({"trials": {**FOREST, "cepa.levelling": 1}}, "cepa.levelling is 1; it must be true or false"),
        ({"trials": {**FOREST, "slam.particles": 3}}, "trials knows no 'slam.particles'"),
        ({"kind": "mapping", "trials": {"world": "room", "slam.particles": 2.5}}, "must be a whole number"),
        (
            {"kind": "mapping", "trials": {"world": "forest"}},
            "There is no world 'forest'; choose from",
        ),
        ({"trials": {**FOREST, **{f"cepa.k{i}": BY_100 for i in (1, 2, 3)}}}, "has 1000000 combinations"),
        ({"trials": FOREST, "seeds": 0}, "seeds must be from 1 to"),
        ({"trials": FOREST, "seed": True}, "seed is True; it must be a whole number"),
        ({"trials": FOREST, "seeds": 10**400}, "seeds is 1000.+; it must be a whole number"),
        ({"trials": []}, "trials is an empty list"),
        ({"trials": [FOREST, {**FOREST, "cepa.k4": 0}]}, "Only some blocks of trials name cepa.k4"),
        ({"trials": {**FOREST, "times": 0}}, "times must be from 1 to"),
        ({"trials": FOREST, "smallest": {"seed": 3}}, "smallest knows no 'seed'; did you mean seeds?"),
        (
            {"trials": FOREST, "tune": {"stuck_cost": 5, "parameters": {"r_ub": {"from": 1, "to": 2}}}},
            "stuck_cost must be from 10 to",
        ),
        ({"trials": FOREST, "tune": {}}, "parameters of tune must be a mapping"),
        ({"trials": FOREST, "tune": {"parameters": {"r_ub": 1}}}, "range of r_ub must be a mapping"),
        ({"trials": FOREST, "tune": {"parameters": {"r_ub": {"from": 2, "to": 1}}}}, "r_ub must rise"),
        ({"trials": FOREST, "tune": {"parameters": {"magic": {"from": 0, "to": 1}}}}, "knows no 'magic'"),
    ],
)
def test_every_mistake_is_told_in_a_sentence(content, sentence):
    with pytest.raises(CampaignError, match=sentence) as told:
        campaign_of(content, "wrong")
    assert "\n" not in str(told.value)


def test_the_command_tells_mistakes_and_where(tmp_path, capsys):
    path = tmp_path / "wrong.yaml"
    path.write_text("kind: flight\ntrials: {world: [random_forest")
    assert main([str(path)]) == 1
    assert main(["nowhere"]) == 1
    path.write_text("trials: {world: moon}")
    assert main(["tune", str(path)]) == 1
    damaged, unknown, wrong = capsys.readouterr().err.splitlines()
    assert f"{path} cannot be read: line 3, column 1 is not YAML" in damaged
    assert "There is no campaign file nowhere; give a YAML file, or one of avoidance, " in unknown
    assert wrong.startswith(f"campaign: {path}: There is no world 'moon'")


def test_the_trials_are_the_product_and_a_seed_more_changes_none():
    content = {"trials": {**FOREST, "speed_m_s": {"from": 1, "to": 3, "steps": 3}, "cepa.k4": [0, 1]}}
    some, more = (campaign_of({**content, "seeds": seeds}, "x") for seeds in (2, 5))
    assert (len(some), len(more)) == (12, 30)
    assert more.cases[:12] == some.cases
    flown = [(case.settings["speed_m_s"], case.settings["cepa.k4"]) for case in some.cases[:6]]
    assert flown == [(1.0, 0.0), (1.0, 1.0), (2.0, 0.0), (2.0, 1.0), (3.0, 0.0), (3.0, 1.0)]
    assert more.digest == some.digest
    assert campaign_of({**content, "seed": 2}, "x").digest != some.digest


def test_places_and_noise_differ_between_seeds_and_nowhere_else():
    campaign = campaign_of({"seeds": 50, "trials": {**FOREST, "speed_m_s": [1, 2]}}, "x")
    cases = campaign.cases
    for of in ("place_seed", "noise_seed"):
        seeds = [getattr(case, of) for case in cases]
        assert seeds[::2] == seeds[1::2]
        assert len(set(seeds)) == 50
    assert cases[0].place_seed != cases[0].noise_seed


def test_blocks_share_what_both_name_and_may_have_more_seeds():
    fast, often = {**FOREST, "speed_m_s": [2, 4]}, {**FOREST, "speed_m_s": 2, "times": 3}
    campaign = campaign_of({"seeds": 2, "trials": [fast, often]}, "x")
    flown = [(case.index, case.replicate, case.settings["speed_m_s"]) for case in campaign.cases]
    assert flown == [(0, 0, 2), (1, 0, 4), (2, 1, 2), (3, 1, 4)] + [(2 * r, r, 2) for r in range(2, 6)]
    assert len(campaign) == 8
    assert campaign.varied == ("speed_m_s",)


# -- trials -----------------------------------------------------------------------------------------------


def test_the_lidars_data_are_the_thesiss():
    """Tables 8.2 and D.1."""
    m8, urg = lidar_data("m8"), lidar_data("urg", 4.0)
    assert dataclasses.astuple(m8) == (150.0, 30.0, 0.8, 15.0)
    assert dataclasses.astuple(urg) == (4.0, 10.0, 0.16, 2.5)


# -- the search of parameters -------------------------------------------------------------------------------

TUNING = {
    "seeds": 1,
    "trials": {**FOREST, "distance_m": 6.5, "density_per_m2": 0.16, "cepa.k4": 0.5},
    "tune": {
        "trials": 3,
        "collision_cost": 19,
        "parameters": {"r_ub": {"from": 0.8, "to": 2}, "k3": {"from": 0.1, "to": 3, "log": True}},
    },
}


def test_the_objective_weighs_time_collisions_and_stuck_flights():
    import pandas as pd

    trials = pd.DataFrame(
        {
            "collision": [False, False, True, False],
            "stuck": [False, False, False, True],
            "time_over_straight": [1.0, 2.0, 0.3, 9.9],
        }
    )
    tuning = campaign_of(TUNING, "x").tuning
    assert objective(trials, tuning) == pytest.approx((1.0 + 2.0 + 19.0 + 10.0) / 4)


def test_a_late_arrival_is_better_than_none():
    import pandas as pd

    ways = {"late": (False, False, 9.9), "stuck": (False, True, 2.0), "touched": (True, False, 0.3)}
    flown = {name: dict(zip(("collision", "stuck", "time_over_straight"), way)) for name, way in ways.items()}
    tuning = campaign_of({**TUNING, "tune": {"parameters": TUNING["tune"]["parameters"]}}, "x").tuning
    costs = {name: objective(pd.DataFrame([row]), tuning) for name, row in flown.items()}
    assert costs["late"] < costs["stuck"] < costs["touched"]


@pytest.mark.table(
    ("axes", "sentence"),
    [
        ({"algorithm": "vfh_plus"}, "Only improved and original"),
        ({"algorithm": ["improved", "original"]}, "One algorithm can be tuned at a time"),
        ({"cepa.r_ub": 1.0}, "cepa.r_ub is searched or varied already"),
    ],
)
def test_what_cannot_be_tuned_is_refused(axes, sentence, tmp_path):
    campaign = campaign_of({**TUNING, "trials": {**TUNING["trials"], **axes}}, "x")
    with pytest.raises(CampaignError, match=sentence):
        tune(campaign, tmp_path, workers=None)


def test_only_campaigns_import_what_they_need_besides():
    """Nodes must start fast."""
    heavy = ("import dask", "from distributed", "import pandas", "import optuna")
    for path in ROOT.glob("src/**/*.py"):
        if path.parent.name != "campaign" and "test" not in path.parts and path.name != "dask_workers.py":
            assert not [line for line in path.read_text().splitlines() if line.strip().startswith(heavy)], (
                path
            )
