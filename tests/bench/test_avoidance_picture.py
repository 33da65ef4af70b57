"""The picture of bench avoidance shows all that it says."""

from __future__ import annotations

import io

import matplotlib.image
import pytest

from benchmarks.avoidance_rows import picture


@pytest.mark.parametrize("algorithms", [("dynamic",), ("dynamic", "improved")])
def test_the_legend_is_whole_however_few_the_algorithms(algorithms):
    values = {"reached": 0.8, "contacts": 2, "flights": 20}
    png = picture.png({("ros", 4.0, name): values for name in algorithms})
    image = matplotlib.image.imread(io.BytesIO(png))
    for edge in (image[:, 0], image[:, -1], image[-1]):
        assert (edge == 1.0).all(), "something is cut off"
