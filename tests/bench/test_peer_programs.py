"""Peers that no registry has: they fly by the path that the caller gives; who fails has a sentence."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest

from benchmarks import campaign, sim
from benchmarks.peers import gazebo_flight, px4_flight, turns
from benchmarks.peers.environments import PeerError
from benchmarks.peers.programs import PROGRAMS
from benchmarks.shared.speed import Speed
from benchmarks.simulator import forest

GZSERVER = """#!{python}
import sys, time
steps, world = int(sys.argv[sys.argv.index("--iters") + 1]), open(sys.argv[-1]).read()
assert "<real_time_update_rate>0<" in world and "model://lidar_ust" in world
{does}
"""
WORKS = "end = time.process_time() + 0.02 + 2e-4 * steps\nwhile time.process_time() < end: pass"


@pytest.fixture
def gzserver(tmp_path):
    """Return what writes a program that takes the place of gzserver."""

    def write(does: str) -> Path:
        program = tmp_path / "gzserver"
        program.write_text(GZSERVER.format(python=sys.executable, does=does))
        program.chmod(0o755)
        return program

    return write


def test_gazebo_simulates_our_forest_and_its_start_does_not_count(gzserver):
    speed = gazebo_flight.fly(gzserver(WORKS), simulated_s=4.0)
    # 1000 steps of 0.2 ms; the start, which is the interpreter's here, is more than that
    assert speed.simulated_s == 4.0
    assert speed.process_s == pytest.approx(0.2, rel=0.3)


@pytest.mark.parametrize(
    ("does", "sentence"),
    [
        ("sys.exit('no world')", r"^gazebo does not run: no world\.$"),
        ("sys.exit(5)", r"^gazebo does not run: it ended with code 5 and said nothing\.$"),
    ],
)
def test_a_gazebo_that_fails_is_told_in_one_sentence(gzserver, does, sentence):
    with pytest.raises(PeerError, match=sentence):
        gazebo_flight.fly(gzserver(does))


def test_gazebo_loads_a_world_that_it_does_not_slow_down():
    world = ElementTree.fromstring(gazebo_flight.unpaced(gazebo_flight.WORLD.read_text())).find("world")
    assert world.findtext("physics/real_time_update_rate") == "0"
    assert world.findtext("physics/max_step_size") == str(gazebo_flight.STEP_S)
    assert "model://lidar_ust" in [each.text for each in world.iterfind("include/uri")]


@pytest.mark.parametrize(("name", "module"), [("px4", px4_flight), ("gazebo", gazebo_flight)])
def test_a_path_without_the_program_is_told_in_one_sentence(tmp_path, name, module):
    with pytest.raises(PeerError, match=rf"^{name} is not there: .*{tmp_path}.*; give .*\.$"):
        module.fly(tmp_path)


@pytest.fixture
def programs(monkeypatch):
    """Fly nothing: ours is 40 times as fast as time, PX4 10 times; Gazebo fails."""
    flights = {"px4": Speed(30.0, 3.0, 3.0, 6.0)}

    def fly(name):
        if name not in flights:
            raise PeerError(f"{name} does not run: no display.")
        return flights[name]

    for name in PROGRAMS:
        flown = replace(PROGRAMS[name], fly=lambda path, name=name: fly(name))
        monkeypatch.setitem(turns.PROGRAMS, name, flown)
    monkeypatch.setattr(forest, "fly", lambda seed: Speed(20.0, 0.5, 0.5, 1.0))


def test_sim_flies_programs_beside_ours_and_tells_who_failed(programs, tmp_path, capsys):
    sim.main(["--results", str(tmp_path), "--parts", "inprocess", "--px4", "/px4", "--gazebo", "/gz"])
    said = capsys.readouterr().out
    row = next(line for line in said.splitlines() if line.startswith("| PX4"))
    assert [cell.strip() for cell in row.split("|")[2:7]] == ["10.0", "10.0", "5.0", "4.00", "4.00"]
    assert "Left out: gazebo does not run: no display." in said.splitlines()
    peers = json.loads((tmp_path / "benchmarks.json").read_text())["sim"]["peers"]
    assert peers["px4"]["ours_by_it"] == 4.0
    assert peers["gazebo"] == {"left_out": "gazebo does not run: no display."}


def test_a_campaign_prints_its_row_with_its_peers(programs, tmp_path, capsys, monkeypatch):
    # Given 4 trials that fly 20 s each and take 1 s of a core each
    monkeypatch.setattr(
        campaign, "timed", lambda number, workers: campaign.Timed(1.0, 4.0 / workers, 4.0, 4.0, 80.0, b"")
    )
    campaign.main(["--results", str(tmp_path), "--trials", "4", "--px4", "/px4", "--gazebo", "/gz"])
    said = capsys.readouterr().out.splitlines()
    rows = {line.split("|")[1].split()[0]: line for line in said if line.startswith(("| ours", "| PX4"))}
    # Then ours simulates 20 s in a second of a core, which is one trial, and PX4 10 s, half of one
    assert [cell.strip() for cell in rows["ours:"].split("|")[2:4]] == ["20.00", "1.00"]
    assert [cell.strip() for cell in rows["PX4"].split("|")[2:4]] == ["10.00", "0.50"]
    assert "Left out: gazebo does not run: no display." in said
    written = json.loads((tmp_path / "benchmarks.json").read_text())["campaign"]
    assert written["peers"]["px4"] == {"flown_s_per_core_s": 10.0, "trials_per_core_s": 0.5}
    assert written["flown_s_per_core_s"] == 20.0


def test_a_campaign_without_peers_says_how_to_ask_for_them(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(
        campaign, "timed", lambda number, workers: campaign.Timed(1.0, 4.0, 4.0, 4.0, 80.0, b"")
    )
    campaign.main(["--results", str(tmp_path), "--trials", "4"])
    assert "--peers pyflyt crazyflow --px4 PATH --gazebo PATH" in capsys.readouterr().out
