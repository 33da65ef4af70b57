"""Writes the worlds of the experiments, and those of inspections, by their names."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path
from typing import Callable, Mapping

import numpy as np

from flights.errors import ScenarioError
from flights.worlds import experiment_1, experiments_3_4
from flights.worlds.ballast_tank import BallastTankParameters, ballast_tank
from flights.worlds.hold_3d import Hold3DParameters, hold_3d, hold_3d_cargo

SEED = 8  # of the sparse field and the forest; flights have their own seeds
MAKERS: dict[str, Callable[[np.random.Generator], str]] = {
    **experiment_1.MAKERS,
    **experiments_3_4.MAKERS,
    "hold_3d": lambda rng: hold_3d(),
    "hold_3d_cargo": lambda rng: hold_3d_cargo(),
    "ballast_tank": lambda rng: ballast_tank(),
}
_SIZED: dict[str, tuple[Callable, type]] = {
    "hold_3d": (hold_3d, Hold3DParameters),
    "ballast_tank": (ballast_tank, BallastTankParameters),
}


def make(name: str, sizes: Mapping[str, float] | None = None) -> str:
    """Return the SDF text of one world. Every call returns the same text.

    Args:
        name: of the world.
        sizes: values of the world's parameters, where they differ from the defaults.

    Raises:
        ScenarioError: there is no world of this name, or the world has no such parameter or refuses it.
    """
    if name not in MAKERS:
        raise ScenarioError(f"There is no world '{name}'; choose one of {', '.join(MAKERS)}.")
    if not sizes:
        return MAKERS[name](np.random.default_rng(SEED))
    if name not in _SIZED:
        raise ScenarioError(f"The world '{name}' has no parameters. {' and '.join(_SIZED)} have some.")
    draw, parameters = _SIZED[name]
    known = [field.name for field in fields(parameters)]
    unknown = ", ".join(sorted(sizes.keys() - set(known)))
    if unknown:
        raise ScenarioError(f"The world '{name}' has no parameter {unknown}. It has {', '.join(known)}.")
    return draw(parameters(**sizes))


def write_all(folder: Path) -> list[Path]:
    """Write every world as FOLDER/NAME.world and return the paths."""
    return [write_one(folder, name) for name in MAKERS]


def write_one(folder: Path, name: str, sizes: Mapping[str, float] | None = None) -> Path:
    """Write a world as FOLDER/NAME.world and return the path; raises as `make`."""
    text, path = make(name, sizes), Path(folder) / f"{name}.world"
    path.write_text(text, encoding="utf-8")
    return path
