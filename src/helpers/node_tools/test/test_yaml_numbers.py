"""What is told of numbers that YAML reads as text."""

from __future__ import annotations

import pytest
import yaml

pytestmark = pytest.mark.ros

parameters = pytest.importorskip(
    "node_tools.parameters", reason="needs the workspace's environment: source devel/setup.bash"
)


@pytest.mark.table("written", ["1e9", "1.0e9", "1e+9", "-2.5E3", "3e-4", "7.e2"])
def test_an_exponent_that_yaml_reads_as_text_is_told_with_what_to_write(written):
    values = yaml.safe_load(f"gain: {written}")
    assert isinstance(values["gain"], str)
    sentence = parameters.exponents_as_text(values)
    assert sentence.startswith(f"YAML reads {written} as text: write gain: ")
    advised = yaml.safe_load(sentence.split("write ")[1].split(",")[0])
    assert advised == {"gain": float(written)}


def test_other_texts_and_numbers_are_no_matter():
    assert parameters.exponents_as_text({"a": "best", "b": 1.0e9, "c": "e9", "d": "1e", "e": "0x1e9"}) == ""
