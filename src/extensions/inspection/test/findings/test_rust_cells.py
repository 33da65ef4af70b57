"""Given cells of red things, their features are those by hand, and the weights tell leather from rust."""

import numpy as np
import pytest
from drawn_kinds import leather, on_grey

from inspection.findings.parameters import FindingParameters
from inspection.findings.picture import rust_texture
from inspection.findings.picture.candidates import BLOCK_PX, candidates_in, linear_light, red_blocks
from inspection.findings.picture.rust_cells import (
    DARK,
    FEATURES,
    OWN,
    Weights,
    learnt_weights,
    likely_cells,
    red_cells,
)
from inspection.findings.picture.rust_texture import CELLS, LEAST_LIKELY

BROWN = (150, 85, 50)


def cells_of(picture):
    return red_cells(picture, red_blocks(picture, FindingParameters()), BLOCK_PX, linear_light())


def test_an_even_surface_has_the_shares_of_its_colour_and_varies_nowhere():
    cells = cells_of(np.full((160, 240, 3), BROWN, np.uint8))
    assert (cells.red.shape, cells.red.all(), cells.side_px) == ((20, 30), True, 8)
    r, g, b = linear_light()[list(BROWN)]
    total = r + g + b + DARK
    own = (r / total, b / total, (g - b) / (r - b), np.log(total), np.log(DARK), np.log(DARK**2), 0.0)
    inside = cells.features.reshape(20, 30, FEATURES)[8, 10]
    np.testing.assert_allclose(inside[:OWN], own, atol=1e-3)
    np.testing.assert_allclose(inside[OWN : 2 * OWN], own, atol=1e-3)
    np.testing.assert_allclose(inside[2 * OWN :], (0.0, 0.0, 0.0, 0.0, 1.0), atol=2e-3)


def test_means_around_a_cell_are_those_of_its_red_cells():
    rng = np.random.default_rng(1)
    picture = np.full((160, 160, 3), 120, np.uint8)
    picture[:, 80:] = (
        rng.integers(60, 180, (20, 10, 1)).repeat(8, axis=0).repeat(8, axis=1) * np.array(BROWN) // 150
    )
    red = np.arange(40) >= np.full((40, 1), 20)  # blocks of 4 px
    cells = red_cells(picture, red, BLOCK_PX, linear_light())
    features = np.full((20, 20, FEATURES), np.nan)
    features[cells.red] = cells.features
    around = features[7:14, 10:14, :OWN].reshape(-1, OWN)  # 3 cells to the left of it are not red
    assert cells.red[7:14, 10:14].all()
    assert not cells.red[7:14, 7:10].any()
    np.testing.assert_allclose(features[10, 10, OWN : 2 * OWN], around.mean(axis=0), rtol=1e-3)
    np.testing.assert_allclose(
        features[10, 10, 2 * OWN : -1], around[:, :4].std(axis=0), rtol=0.02, atol=1e-3
    )
    assert features[10, 10, -1] == pytest.approx(4 / 7, rel=1e-3)


def test_probabilities_are_those_by_hand():
    weights = Weights(
        np.ones(2), np.array((2.0, 4.0)), np.array([[1.0], [0.0], [0.5]]), np.array([3.0, -1.0])
    )
    (probability,) = weights.probabilities(np.array([[2.0, 9.0]]))  # tanh((2 - 1) / 2 + 0.5)
    assert probability == pytest.approx(1.0 / (1.0 + np.exp(1.0 - 3.0 * np.tanh(1.0))))


@pytest.mark.table(("kind", "is_rust"), [(leather, False), (on_grey, True)])
def test_the_weights_of_the_package_tell_them_apart(kind, is_rust):
    likely = likely_cells(cells_of(kind(1)), learnt_weights(), LEAST_LIKELY)
    assert (likely.sum() > 3 * CELLS) == is_rust


def test_leather_has_the_texture_of_rust_and_the_network_refuses_it(monkeypatch):
    def has_rust():
        found = candidates_in(leather(1), FindingParameters().for_pictures())
        return any(each.kind in ("rust", "red") for each in found)

    assert not has_rust()
    monkeypatch.setattr(rust_texture, "_likely", lambda picture, red, linear: red)
    assert has_rust()
