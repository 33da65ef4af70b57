"""Cells that were looked at without information gain."""

import numpy as np

from exploration.next_view.views.no_gain import CellsWithoutGain


def test_a_cell_is_left_after_views_that_count_one_unless_it_has_changed():
    """Beside a slow reference: one cell after the other, of cells that were looked at up to three times."""
    rng, no_gain, reference = np.random.default_rng(1), CellsWithoutGain(), {}
    for _ in range(3):
        cells = np.unique(rng.integers(-4, 5, (150, 3)), axis=0)
        counts, views = rng.integers(1, 30, len(cells)), rng.choice([0.25, 0.5, 1.0], len(cells))
        no_gain.note(cells, counts, views)
        for cell, count, view in zip(cells.tolist(), counts.tolist(), views.tolist()):
            before, tries = reference.get(tuple(cell), (count, 0.0))
            reference[tuple(cell)] = count, (tries if count >= 0.8 * before else 0.0) + view
    asked, counts = rng.integers(-6, 7, (500, 3)), rng.integers(1, 30, 500)
    expected = []
    for cell, count in zip(asked.tolist(), counts.tolist()):
        before, tries = reference.get(tuple(cell), (0, 0.0))
        expected.append(tries >= 1.0 and count >= 0.8 * before)
    assert 10 < sum(expected) < 490
    assert no_gain.is_left(asked, counts).tolist() == expected
    assert not CellsWithoutGain().is_left(asked, counts).any()
    assert no_gain.is_left(np.zeros((0, 3), np.int64), np.zeros(0, np.int64)).shape == (0,)
