"""Limits of path_planner, from a file."""

from pathlib import Path

import pytest

from exploration.planning import KeepOutBox, Limits, read_limits
from flight_basics.errors import ParameterError


def test_the_page_shows_a_file_that_can_be_read(tmp_path):
    page = Path(__file__).resolve().parents[2] / "doc" / "path_planner.md"
    path = tmp_path / "limits.yaml"
    path.write_text(page.read_text().split("```yaml\n")[1].split("```")[0])
    assert read_limits(path) == Limits((KeepOutBox((10, -2, 6), (14, 2, 9), "hatch"),), 8.0)


def test_a_file_that_makes_no_sense_is_refused_as_a_parameter_is(tmp_path):
    path = tmp_path / "limits.yaml"
    path.write_text("{floor: 1}")
    with pytest.raises(ParameterError, match=r"limits\.yaml, line 1: .*'floor'"):
        read_limits(path)
