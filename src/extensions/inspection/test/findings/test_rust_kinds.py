"""Given drawn things of many kinds, rust is told on each coating, and red or brown things are not."""

import pytest
from drawn_kinds import NO_RUST, RUST, car_paint, containers, gold, leaves, skin

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in

PARAMETERS = FindingParameters().for_pictures()
TAKEN_FOR_RUST = (car_paint, gold, skin, leaves, containers)
"""The page says so: shine, smooth gradients of yellow and brown, and patches of many colours."""


def rust_in(picture):
    return [each.kind for each in candidates_in(picture, PARAMETERS) if each.kind in ("rust", "red")]


@pytest.mark.parametrize("kind", [each for each in NO_RUST if each not in TAKEN_FOR_RUST])
def test_no_rust(kind):
    assert rust_in(kind(0)) == []


@pytest.mark.parametrize("kind", RUST)
def test_rust(kind):
    assert rust_in(kind(0))
