"""Heightmaps: pictures as terrain, as Gazebo reads them."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from simulation_tools.errors import SimulationToolsError
from simulation_tools.sdf.elements import Heightmap

MAX_SIDE = 1025


class MeshError(SimulationToolsError):
    """A mesh file, or the picture of a heightmap, cannot be used."""


def heights_of(terrain: Heightmap) -> np.ndarray:
    """Return the heights above the terrain's foot in metres, (side, side), the picture's top row first.

    Raises MeshError when the picture cannot be read, or its sides are not 2^n + 1 as Gazebo wants them.
    """
    brightness = _brightness(terrain.path)
    return brightness * (terrain.size_m[2] / max(float(brightness.max()), 1e-12))


@lru_cache(maxsize=8)
def _brightness(path: str) -> np.ndarray:
    from PIL import Image  # comes with matplotlib; most worlds hold no heightmap

    try:
        with Image.open(path) as picture:
            side, height = picture.size
            if side == height and 3 <= side <= MAX_SIDE and not (side - 1) & (side - 2):
                wide = picture.mode.startswith("I") or picture.mode == "F"
                return np.asarray(picture if wide else picture.convert("L"), float)
    except Exception as error:  # the reader raises many kinds of errors
        sentence = f"{path}: The heightmap cannot be read: {str(error) or type(error).__name__}."
        raise MeshError(sentence) from None
    raise MeshError(
        f"{path}: A heightmap must be a square of 2^n + 1 pixels, up to {MAX_SIDE}, not {side} x {height}."
    )
