"""A launch file that checks itself is checked once, not again by each file that it includes."""

from __future__ import annotations

from pathlib import Path

import pytest

from simulation_tools.launch_check.launch_files import has_own_check

OURS = Path(__file__).resolve().parents[4] / "src/master_thesis/launch"
ITSELF = '<launch><param name="flight_check" command="check"/></launch>'
NOT = '<launch><param name="flight_check" value="1"/><group><param name="x" command="y"/></group></launch>'


def test_our_flights_check_themselves_and_the_simulators_file_does_not():
    assert has_own_check(OURS / "experiment_1.launch")
    assert not has_own_check(OURS.parents[1] / "simulation_tools/launch/sitl.launch")


@pytest.fixture
def launch_check(monkeypatch, tmp_path):
    """The module, with one package `flights` in this folder."""
    module = pytest.importorskip(
        "simulation_tools_ros.launch_check", reason="the workspace is not built, or not sourced"
    )
    (tmp_path / "launch").mkdir()
    (tmp_path / "launch/itself.launch").write_text(ITSELF)
    (tmp_path / "launch/not.launch").write_text(NOT)
    (tmp_path / "launch/broken.launch").write_text("<launch>")

    def find(package):
        if package != "flights":
            raise LookupError(package)
        return str(tmp_path)

    monkeypatch.setattr(module, "find_package", find)
    monkeypatch.chdir(tmp_path / "launch")
    return module


@pytest.mark.ros
@pytest.mark.parametrize(
    ("words", "is_checked"),
    [
        ("flights itself.launch", True),
        ("-p 11411 --screen flights itself.launch seed:=3 world:=a.launch", True),
        ("itself.launch", True),
        ("flights not.launch", False),
        ("flights broken.launch", False),
        ("flights absent.launch", False),
        ("absent absent.launch", False),
        ("absent.launch", False),
        ("itself.launch not.launch", False),
        ("flights", False),
        ("", False),
    ],
)
def test_a_roslaunch_is_checked_by_its_file_only_if_that_is_clear(launch_check, words, is_checked):
    program = ["/usr/bin/python3", "/usr/bin/roslaunch"]
    assert launch_check.is_checked_by_its_file([*program, *words.split()]) is is_checked
