"""Writes the worlds of the experiments by their names."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from master_thesis.errors import ScenarioError
from master_thesis.worlds import experiment_1, experiments_3_4

SEED = 8  # of the sparse field and the forest; flights have their own seeds
MAKERS = {**experiment_1.MAKERS, **experiments_3_4.MAKERS}


def make(name: str) -> str:
    """Return the SDF text of one world. Every call returns the same text.

    Raises:
        ScenarioError: there is no world of this name.
    """
    if name not in MAKERS:
        raise ScenarioError(f"There is no world '{name}'; choose one of {', '.join(MAKERS)}.")
    return MAKERS[name](np.random.default_rng(SEED))


def write_all(folder: Path) -> list[Path]:
    """Write every world as FOLDER/NAME.world and return the paths."""
    paths = [Path(folder) / f"{name}.world" for name in MAKERS]
    for path in paths:
        path.write_text(make(path.stem), encoding="utf-8")
    return paths
