"""Campaigns flown: the same table whoever flies them and whatever happens; a smallest run of each."""

from __future__ import annotations

import ast
import contextlib
import json
import re
import signal
import sys
from pathlib import Path

import pandas as pd
import pytest
import yaml

from cepa import CepaParameters
from flights.campaign import command
from flights.campaign.command import main
from flights.campaign.folder import CampaignFolder
from flights.campaign.reading import campaign_of
from flights.campaign.trial import run_case
from flights.campaign.tuning import HISTORY, TUNED, tune
from flights.errors import CampaignError, TrialsError
from flights.trials import run
from flights.trials.workers import INTERRUPTED, ThisProcess

pytestmark = [pytest.mark.flight, pytest.mark.timeout(900)]

ROOT = Path(__file__).resolve().parents[5]
RUN_CASE = "flights.campaign.folder.run_case"
FOREST = {"world": "random_forest", "density_per_m2": 0.16}
SHORT = {"seeds": 1, "trials": {**FOREST, "distance_m": 8, "speed_m_s": 4, "algorithm": ["none", "improved"]}}
TUNING = {
    "seeds": 1,
    "trials": {**FOREST, "distance_m": 6.5, "cepa.k4": 0.5},
    "tune": {
        "trials": 2,
        "parameters": {"r_ub": {"from": 0.8, "to": 2}, "k3": {"from": 0.1, "to": 3, "log": True}},
    },
}


MAPPING = {
    "kind": "mapping",
    "seeds": 1,
    "trials": {"world": ["room", "beamed_hold"], "lidar": "urg", "duration_s": 3, "slam.particles": 3},
}


class Interrupted(ThisProcess):
    """Runs trials until Ctrl-C comes. after: so many trials. backwards: the last one first."""

    def __init__(self, after, backwards=False):
        self.after, self.backwards, self.killed = after, backwards, False

    def results(self, run, tasks):
        for task in tasks[::-1] if self.backwards else tasks:
            if self.after == 0:
                raise KeyboardInterrupt
            yield task, run(task)
            self.after -= 1

    def kill(self):
        self.killed = True


def fly(content, path, workers):
    with CampaignFolder(path, campaign_of(content, "short")) as folder:
        return folder.fly(workers, quiet=True)


def finished_lines(folder) -> int:
    """Return how many trials are on the disk."""
    path = folder / "trials.jsonl"
    return path.read_bytes().count(b"\n") if path.exists() else 0


def rows_of(folder) -> list[dict]:
    """Return the trials of a campaign's folder as pandas finds them; None where nothing stands."""
    table = pd.read_csv(folder / "trials.csv").astype(object)
    return table.where(table.notna(), None).to_dict("records")


@pytest.fixture(scope="module")
def fly_once():
    """Fly each case once in this module."""
    known = {}

    def fly(case):
        if repr(case) not in known:
            known[repr(case)] = run_case(case)
        return known[repr(case)]

    return fly


@pytest.fixture(scope="module")
def flown(tmp_path_factory, fly_once):
    """The short campaign's folder, flown to its end by this process, without Dask."""
    path = tmp_path_factory.mktemp("flown")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RUN_CASE, fly_once)
        fly(SHORT, path, ThisProcess())
    return path


@pytest.fixture(scope="module")
def table(flown):
    """The short campaign's table, every bit of it."""
    return (flown / "trials.csv").read_bytes()


@pytest.fixture
def flown_once(fly_once, monkeypatch):
    """No case is flown twice: these tests ask what is made of flights."""
    monkeypatch.setattr(RUN_CASE, fly_once)


def test_the_table_tells_what_was_flown(flown):
    rows = rows_of(flown)
    assert [row["index"] for row in rows] == [0, 1]
    assert [row["algorithm"] for row in rows] == ["none", "improved"]
    blind, careful = rows
    assert blind["collision"]  # this forest has a trunk in the way
    assert blind["min_clearance_m"] < 0.01
    assert blind["path_length_m"] < 4.0
    assert careful["reached"]
    assert careful["min_clearance_m"] > 0.1
    assert 8.0 - 0.3 < careful["path_length_m"] < 10.0
    assert careful["time_over_straight"] == pytest.approx(careful["flight_time_s"] * 4.0 / 8.0)
    assert careful["mass_kg"] == pytest.approx(1.5 + 0.13)  # the thesis's Iris and the UST


def test_an_interrupted_campaign_goes_on_and_its_order_changes_nothing(table, tmp_path):
    """Not even that a flight came after another's contact in its process."""
    interrupted = Interrupted(1, backwards=True)
    with pytest.raises(KeyboardInterrupt):
        fly(SHORT, tmp_path, interrupted)
    assert interrupted.killed
    assert len(rows_of(tmp_path)) == 1
    with CampaignFolder(tmp_path, campaign_of(SHORT, "short")) as folder:
        assert folder.missing == [0]
    fly(SHORT, tmp_path, ThisProcess())
    assert (tmp_path / "trials.csv").read_bytes() == table


UNFLYABLE = {"kind": "mapping", "trials": {"world": "room", "cepa.r_lb": 1.0}}  # r_ub is 0.9 m indoors


def test_a_campaign_with_failures_counts_them_and_tries_them_again(tmp_path, capsys):
    file, out = tmp_path / "bad.yaml", tmp_path / "out"
    file.write_text(yaml.safe_dump({**UNFLYABLE, "seeds": 2}))
    for _ in range(2):
        assert main([str(file), "--workers", "1", "--out", str(out)]) == 1
        assert "campaign: 2 of 2 trials failed, see the column error of trials.csv" in capsys.readouterr().err
        assert [row["error"][:28] for row in rows_of(out)] == ["r_lb must be less than r_ub,"] * 2
        assert finished_lines(out) == 0
    assert pd.read_csv(out / "summary.csv")["errors"].tolist() == [2]


def test_a_table_that_mixes_versions_of_the_code_says_so(flown, tmp_path):
    here, other = map(json.loads, (flown / "trials.jsonl").read_text().splitlines())
    other["commit"] = "abc+changes.1"
    (tmp_path / "trials.jsonl").write_text("".join(json.dumps(row) + "\n" for row in (here, other)))
    mixed = fly(SHORT, tmp_path, ThisProcess())
    assert mixed.trials["commit"].tolist() == [here["commit"], "abc+changes.1"]
    assert mixed.mixture == (
        f"Different versions of the code computed these 2 trials: 1 by {here['commit']}, 1 by abc+changes.1."
    )


def test_a_damaged_folder_is_refused_with_a_sentence(tmp_path):
    campaign = campaign_of({"trials": FOREST}, "x")
    (tmp_path / "campaign.json").write_text("{}")
    with pytest.raises(CampaignError, match=r"campaign\.json, line 1: .*'digest'"):
        CampaignFolder(tmp_path, campaign)
    with pytest.raises(TrialsError, match="cannot be used: Not a directory"):
        CampaignFolder(tmp_path / "campaign.json/folder", campaign)


def test_a_folder_knows_whose_trials_it_holds(flown):
    with CampaignFolder(flown, campaign_of({**SHORT, "seeds": 3}, "longer")) as folder:
        assert folder.missing == [2, 3, 4, 5]
        with pytest.raises(TrialsError, match="Another process writes trials into"):
            CampaignFolder(flown, campaign_of(SHORT, "short"))
    changed = {**SHORT, "trials": {**SHORT["trials"], "speed_m_s": 3}}
    with pytest.raises(CampaignError, match="holds trials of another campaign, or of this file before"):
        CampaignFolder(flown, campaign_of(changed, "short"))


@pytest.fixture
def begun(flown_once, tmp_path):
    """The folder of a search that was interrupted when it had tried the shipped parameters."""
    with pytest.raises(KeyboardInterrupt):
        tune(campaign_of(TUNING, "tuning"), tmp_path / "begun", Interrupted(1), quiet=True)
    return tmp_path / "begun"


def test_an_interrupted_search_repeats_itself_with_cepas_parameters(begun, tmp_path):
    whole, file = tmp_path / "whole", tmp_path / "tuning.yaml"
    file.write_text(yaml.safe_dump(TUNING, sort_keys=False))
    assert main(["tune", str(file), "--workers", "1", "--out", str(whole)]) == 0
    tune(campaign_of(TUNING, "tuning"), begun, Interrupted(1), quiet=True)
    for name in (HISTORY, TUNED):
        assert (begun / name).read_bytes() == (whole / name).read_bytes()
    shipped, tried = (whole / HISTORY).read_text().splitlines()[1:]
    assert shipped.startswith("0,1.2,0.5,")
    assert not tried.startswith("1,1.2,0.5,")
    check_loadable(yaml.safe_load((whole / TUNED).read_text()))


def test_a_search_by_several_versions_of_the_code_says_so(begun, monkeypatch):
    monkeypatch.setattr(run, "version", lambda: "abc")
    told = tune(campaign_of(TUNING, "tuning"), begun, ThisProcess(), quiet=True)
    assert told.endswith(
        "Different versions of the code flew these sets, see the column commits of tuning.csv."
    )


def tuning_of(**ranges):
    parameters = {name: {"from": low, "to": high} for name, (low, high) in ranges.items()}
    return campaign_of({**TUNING, "tune": {"trials": 2, "parameters": parameters}}, "tuning")


@pytest.mark.usefixtures("flown_once")
def test_shipped_parameters_outside_of_the_ranges_are_said_and_not_flown(tmp_path):
    # r_lb 0.5 m becomes 0.34 m, body_radius stays 0.35 m: an emergency would start after the collision
    told = tune(tuning_of(r_lb=(0.3, 0.34), body_radius=(0.15, 0.36)), tmp_path, ThisProcess(), quiet=True)
    shipped, best, _ = told.splitlines()
    assert shipped.startswith("shipped: not flown. ")
    assert "body_radius must be less than r_lb" in shipped
    assert best.startswith("best, set 1")
    assert "shipped not flown" in (tmp_path / TUNED).read_text()
    assert (tmp_path / HISTORY).read_text().splitlines()[0].endswith(",refused")


def test_ranges_in_which_no_parameters_go_together_are_one_sentence(tmp_path):
    with pytest.raises(CampaignError, match=r"None of the 2 sets could be flown: .*body_radius"):
        tune(tuning_of(r_lb=(0.2, 0.3)), tmp_path, ThisProcess(), quiet=True)
    assert not (tmp_path / TUNED).exists()
    assert len((tmp_path / HISTORY).read_text().splitlines()) == 3


def check_loadable(values):
    """`dynparam load` knows each name, its type and bounds as Cepa.cfg has them; CEPA takes them all."""
    known = {}
    for node in ast.walk(ast.parse((ROOT / "src/cepa/cfg/Cepa.cfg").read_text())):
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "add":
            name, kind, _, _, *rest = node.args
            known[name.value] = kind.id, [ast.literal_eval(value) for value in rest]
    assert set(values) == set(known)
    for name, value in values.items():
        kind, (_, *bounds) = known[name]
        assert type(value) is {"str_t": str, "double_t": float, "int_t": int, "bool_t": bool}[kind], name
        assert not bounds or bounds[0] <= value <= bounds[1], name
    algorithm, fractions = values.pop("algorithm"), values.pop("speed_fractions")
    assert algorithm == "improved"
    flown = CepaParameters(**values, speed_fractions=[float(word) for word in fractions.split()])
    assert flown.k4 == 0.5  # which the campaign sets


@pytest.mark.long
def test_maps_of_the_experiments_worlds_and_of_drawn_ones_are_compared(tmp_path):
    file, out = tmp_path / "maps.yaml", tmp_path / "out"
    file.write_text(yaml.safe_dump(MAPPING))
    assert main([str(file), "--workers", "1", "--out", str(out)]) == 0
    rows = rows_of(out)
    assert [row["world"] for row in rows] == ["room", "beamed_hold"]
    assert all(0.0 < row["ate_rmse_m"] < 0.5 for row in rows)
    assert len((out / "summary.csv").read_text().splitlines()) == 3
    assert (out / "slam_lidars.png").exists()


def test_ctrl_c_keeps_what_is_finished_and_a_second_call_ends_the_same(
    flown_once, table, tmp_path, monkeypatch, capsys
):
    file, out = tmp_path / "short.yaml", tmp_path / "out"
    file.write_text(yaml.safe_dump(SHORT))
    monkeypatch.setattr(sys, "unraisablehook", sys.unraisablehook)  # `interrupted` replaces it
    interrupted = contextlib.nullcontext(Interrupted(1))
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_DFL)  # as the executable begins
    with monkeypatch.context() as patch:
        patch.setattr(command, "open_workers", lambda *_: interrupted)
        assert main([str(file), "--out", str(out)]) == INTERRUPTED
    for number in (signal.SIGINT, signal.SIGTERM):
        assert signal.getsignal(number) is signal.default_int_handler
    assert "interrupted; call again" in capsys.readouterr().err
    assert len(rows_of(out)) == 1
    assert main([str(file), "--workers", "1", "--out", str(out)]) == 0
    assert (out / "trials.csv").read_bytes() == table


def test_a_scheduler_that_is_not_there_is_told_in_a_sentence(tmp_path, capsys):
    file = tmp_path / "short.yaml"
    file.write_text(yaml.safe_dump(SHORT))
    assert main([str(file), "--scheduler", str(tmp_path / "none.json"), "--out", str(tmp_path)]) == 1
    told = capsys.readouterr().err
    assert re.search(r"There is no scheduler file .*none\.json; give tcp://host:port", told)
