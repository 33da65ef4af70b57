"""A small learnt detector: a network of one hidden layer judges cells of a picture by colour and texture.

It is the worked example of a detector of one's own. `benchmarks.findings_rows.learn` trains it.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import NamedTuple
from zipfile import BadZipFile

import numpy as np
from scipy import ndimage

from flight_basics.errors import SurveyError
from inspection.findings.picture.candidates import Candidate
from inspection.findings.picture.kernels import block_light, block_texture

CELL_PX, COPY_PIXELS = 8, 5e5
"""Side of a cell in the copy that is judged; pixels of the copy at most."""
DARK = 0.01
"""Light that is added before logarithms are taken, of white."""
FEATURES = 12
NEAR_CELLS = 3
"""Cells along the sides of the square whose mean features count beside a cell's own."""
ALSO_CORNERS = np.ones((3, 3), bool)


class Network(NamedTuple):
    """Weights. mean, deviation: (FEATURES,) of the features. hidden: (FEATURES + 1, n). out: (n + 1,).

    The last row of hidden and the last value of out are added. least: probability of a cell of the kind.
    cells: fewer that touch are no mark.
    """

    mean: np.ndarray
    deviation: np.ndarray
    hidden: np.ndarray
    out: np.ndarray
    least: float = 0.5
    cells: int = 12

    def probabilities(self, features: np.ndarray) -> np.ndarray:
        """Return (...,): how probably a cell is of the kind. features: (..., FEATURES)."""
        scaled = (features - self.mean) / self.deviation
        inner = np.tanh(scaled @ self.hidden[:-1] + self.hidden[-1])
        sums: np.ndarray = inner @ self.out[:-1] + self.out[-1]
        return 1.0 / (1.0 + np.exp(-np.clip(sums, -50.0, 50.0)))

    def marks(self, picture: np.ndarray, kind: str) -> list[Candidate]:
        """Return a candidate for each group of cells of the kind. picture: uint8 (height, width, 3), sRGB."""
        features, times = features_of(picture)
        if not features.size:
            return []
        numbers, count = ndimage.label(self.probabilities(features) >= self.least, ALSO_CORNERS)
        side, found = CELL_PX * times, []
        for number in range(1, count + 1):
            y, x = np.nonzero(numbers == number)
            if len(x) >= self.cells:
                found.append(Candidate(kind, (np.column_stack((x, y)) + 0.5) * side - 0.5, len(x) * side**2))
        return found

    def save(self, path: Path) -> None:
        """Write the weights to a file NAME.npz."""
        np.savez(path, **self._asdict())

    @classmethod
    def load(cls, path: Path) -> Network:
        """Read the weights; raises SurveyError if the file holds none."""
        try:
            with np.load(path) as stored:
                network = cls(**{name: stored[name] for name in cls._fields})
            network.probabilities(np.zeros((1, FEATURES)))
        except (OSError, ValueError, KeyError, EOFError, BadZipFile) as error:
            raise SurveyError(f"{path} holds no weights of a detector ({error}). Train it again.") from None
        return network._replace(least=float(network.least), cells=int(network.cells))


def features_of(picture: np.ndarray) -> tuple[np.ndarray, int]:
    """Return (rows, columns, FEATURES), and how many pixels are one of the copy. picture: uint8, sRGB.

    Of each cell: shares of red and blue in the light, hue, logarithms of light, texture and edges; and their
    means around it.
    """
    times = max(1, round(math.sqrt(picture.shape[0] * picture.shape[1] / COPY_PIXELS)))
    value = np.arange(256, dtype=np.float32) / 255.0
    linear = np.where(value <= 0.04045, value / 12.92, ((value + 0.055) / 1.055) ** 2.4).astype(np.float32)
    light = block_light(picture, linear, times).mean(axis=2)
    texture, edges, _ = block_texture(np.log(light + np.float32(DARK)), CELL_PX)
    r, g, b = np.moveaxis(block_light(picture, linear, CELL_PX * times), 2, 0)
    total = r + g + b + np.float32(DARK)
    hue = np.clip((g - b) / np.maximum(r - b, 1e-2), -2.0, 3.0)
    own = np.stack(
        (r / total, b / total, hue, np.log(total), np.log(texture + DARK), np.log(edges + DARK**2)), axis=2
    )
    around = ndimage.uniform_filter(own, (NEAR_CELLS, NEAR_CELLS, 0))
    return np.concatenate((own, around), axis=2), times
