"""The file of settings of an exploration: what it may say, and that the shipped one says the defaults."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml

from flights.errors import FlightError, FlightsError
from simulation_tools.errors import SimulationToolsError

exploration_settings = pytest.importorskip(
    "flights_ros.launch.exploration_settings", reason="needs the workspace's environment"
)
SHIPPED = Path(__file__).resolve().parents[2] / "config/exploring.yaml"


def written(tmp_path, text):
    path = tmp_path / "mine.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_shipped_file_holds_the_defaults_of_the_arguments_that_were():
    assert exploration_settings.read_file(SHIPPED) == {}
    assert yaml.safe_load(SHIPPED.read_text(encoding="utf-8")) == {
        "gazebo": {"static_models": False, "lockstep_timeout": 10.0},
        "gridslam": {"loop_closure": True},
    }


def test_the_swaps_of_a_file_reach_the_flight(tmp_path):
    shown = SHIPPED.read_text(encoding="utf-8").replace("# experiment:", "experiment:")
    shown = shown.replace("#   swaps: 1", "  swaps: 5")
    assert exploration_settings.read_file(written(tmp_path, shown)) == {"swaps": 5}


@pytest.mark.table(
    ("text", "sentence"),
    [
        ("experimant: {swaps: 5}", "There is no parameter experimant; did you mean experiment?"),
        ("experiment: {swap: 5}", "experiment: There is no parameter swap; did you mean swaps?"),
        ("experiment: {time: 5}", "experiment: There is no parameter time;"),  # has an argument
        ("experiment:", "experiment holds no names with values;"),
        ("gazebo: {static_models: some}", "'some' is no static_models; give true or false."),
        ("gridslam: {loop_closure: 2}", "'2' is no loop_closure; give true or false."),
        ("gazebo: {lockstep_timeout: 0}", "lockstep_timeout must be a number from 0.001"),
        ("a: [", "line 1, column 5 is not YAML"),
    ],
)
def test_what_has_no_effect_is_refused_in_one_sentence(tmp_path, text, sentence):
    with pytest.raises((FlightsError, SimulationToolsError)) as refused:
        exploration_settings.read_file(written(tmp_path, text))
    assert sentence in str(refused.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(FlightError, match="settings:=FILE"):
        exploration_settings.read_file(tmp_path / "none.yaml")
