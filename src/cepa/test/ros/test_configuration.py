"""The parameters stand in three places: dataclass, cfg and YAML. They agree."""

import ast
import dataclasses
from pathlib import Path

import pytest
import yaml

from cepa import ALGORITHMS, SLOW_DETOURS, STEADY_SIDE, CepaParameters

PACKAGE = Path(__file__).resolve().parents[2]


def as_config(parameters):
    config = {"algorithm": "improved", **dataclasses.asdict(parameters)}
    config["speed_fractions"] = list(parameters.speed_fractions)
    return config


def fractions(text):
    return [float(word) for word in text.split()]


def cfg_entries():
    """The arguments of every gen.add(...): name -> (type, sentence, default, min, max)."""
    calls = [
        node
        for node in ast.walk(ast.parse((PACKAGE / "cfg/Cepa.cfg").read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "add"
    ]
    entries = {}
    for call in calls:
        name, kind, _, sentence, *rest = call.args
        entries[name.value] = (kind.id, sentence.value, *(ast.literal_eval(value) for value in rest))
    return entries


def test_dynamic_reconfigure_has_every_parameter_and_its_default():
    entries = cfg_entries()
    defaults = as_config(CepaParameters())
    assert set(entries) == set(defaults)
    for name, (_, _, default, *_) in entries.items():
        assert (fractions(default) if name == "speed_fractions" else default) == defaults[name], name


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(CepaParameters)])
def test_every_parameter_has_a_sentence_and_numbers_have_limits(name):
    kind, sentence, default, *limits = cfg_entries()[name]
    assert sentence.endswith(".")
    if kind in ("double_t", "int_t"):
        least, most = limits
        assert least <= default <= most
        assert least < most


def test_the_yaml_file_explains_every_default_and_has_slower_detours():
    path = PACKAGE / "config/cepa.yaml"
    config = yaml.safe_load(path.read_text())
    config["speed_fractions"] = fractions(config["speed_fractions"])
    assert config == as_config(CepaParameters(speed_fractions=SLOW_DETOURS, k_previous=STEADY_SIDE))
    assert config["algorithm"] in ALGORITHMS
    lines = [line for line in path.read_text().splitlines() if line.split("#")[0].strip()]
    assert all("Default" in line or "default" in line for line in lines), lines


def test_the_response_by_ardupilot_replaces_parameters_that_exist():
    replaced = yaml.safe_load((PACKAGE / "config/ardupilot.yaml").read_text())
    assert all(name.startswith("response_") for name in replaced)
    found = dataclasses.replace(CepaParameters(), **replaced)
    assert found.response_delay > CepaParameters().response_delay
