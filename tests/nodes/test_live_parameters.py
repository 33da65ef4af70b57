"""The live parameters that catkin generates, and the shipped configuration, against the library's."""

import dataclasses
import importlib
from pathlib import Path

import pytest
import yaml

from exploration.planning import PlannerParameters
from flight_basics.errors import ParameterError
from inspection_tools import (
    MedianFilterParameters,
    PaddingParameters,
    PositionControllerParameters,
    YawRegulatorParameters,
)

ROOT = Path(__file__).resolve().parents[2]
CONFIGS = {
    "lidar_median_filter": ("inspection_tools.cfg.LidarMedianFilterConfig", MedianFilterParameters),
    "lidar_padding": ("inspection_tools.cfg.LidarPaddingConfig", PaddingParameters),
    "path_planner": ("exploration.cfg.PathPlannerConfig", PlannerParameters),
    "position_controller": ("inspection_tools.cfg.PositionControllerConfig", PositionControllerParameters),
    "yaw_regulator": ("inspection_tools.cfg.YawRegulatorConfig", YawRegulatorParameters),
}
BEYOND = 1e-3  # a step past a limit
COUPLED = {
    "speed_on",
    "speed_off",
    "max_acceleration",
    "braking_deceleration",
}  # limited by each other as well


def live(config):
    pytest.importorskip("inspection_tools.cfg", reason="the workspace is not built, or not sourced")
    return importlib.import_module(config)


def parameters(group):
    """Yield the parameters of a group and of the groups in it."""
    yield from group["parameters"]
    for inner in group["groups"]:
        yield from parameters(inner)


@pytest.mark.ros
@pytest.mark.parametrize("node", CONFIGS)
def test_live_parameters_are_the_librarys(node):
    config, parameter_class = CONFIGS[node]
    described = live(config)
    defaults = {field.name: field.default for field in dataclasses.fields(parameter_class)}
    assert described.defaults == defaults
    entries = list(parameters(described.config_description))
    assert {entry["name"] for entry in entries} == defaults.keys()
    for entry in entries:
        assert entry["description"].endswith("."), entry["name"]


@pytest.mark.ros
@pytest.mark.parametrize("node", [name for name in CONFIGS if name != "lidar_padding"])
def test_live_limits_are_the_librarys(node):
    config, parameter_class = CONFIGS[node]
    described = live(config)
    for name, default in described.defaults.items():
        step = 1 if isinstance(default, int) else BEYOND
        for value, beyond in ((described.min[name], -step), (described.max[name], step)):
            with pytest.raises(ParameterError, match=name):
                parameter_class(**{name: value + beyond})
            if name not in COUPLED:
                assert getattr(parameter_class(**{name: value}), name) == value


def test_shipped_configuration_is_valid_and_says_the_defaults():
    shipped = yaml.safe_load((ROOT / "src/inspection_tools/config/tools.yaml").read_text())
    assert shipped.keys() == CONFIGS.keys() - {"path_planner"}  # which has a launch file of its own
    for node, values in shipped.items():
        parameter_class = CONFIGS[node][1]
        assert parameter_class(**values) == parameter_class()


def test_the_planners_launch_file_says_the_defaults():
    text = (ROOT / "src/extensions/exploration/launch/path_planner.launch").read_text()
    defaults = PlannerParameters()
    assert f'name="radius" default="{defaults.radius}"' in text
    assert f'name="margin" default="{defaults.margin}"' in text


def test_each_cfg_file_says_what_its_dataclass_says(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "scripts"))
    from live_parameters import config_files, written

    texts = {path: (path.read_text(encoding="utf-8"), of) for path, of in config_files().items()}
    assert len(texts) > 6
    wrong = [path.name for path, (text, of) in texts.items() if written(text, of) != text]
    assert not wrong, "run scripts/live_parameters.py"
