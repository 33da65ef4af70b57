"""Given drawn things of many kinds, rust is told on each coating, and red or brown things are not."""

import pytest
from drawn_kinds import NO_RUST, RUST, gold, leaves, skin

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture.candidates import candidates_in

PARAMETERS = FindingParameters().for_pictures()
TAKEN_FOR_RUST = (gold, leaves)
"""The page says so."""


def rust_in(picture):
    return [each.kind for each in candidates_in(picture, PARAMETERS) if each.kind in ("rust", "red")]


@pytest.mark.table("kind", [each for each in NO_RUST if each not in TAKEN_FOR_RUST])
def test_no_rust(kind):
    assert rust_in(kind(0)) == []


def test_what_differs_from_a_coating_that_fills_the_picture_needs_texture_too():
    """A cheek is all of one colour, and its redder patches are smooth."""
    assert rust_in(skin(1)) == []


@pytest.mark.table("kind", RUST)
def test_rust(kind):
    assert rust_in(kind(0))
