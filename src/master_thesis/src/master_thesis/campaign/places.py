"""Where trials are flown: worlds drawn at random, and the experiments' own."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from master_thesis.campaign.axes import DRAWN_DISTANCE_M, FOREST, HALLWAY, HOLD, MIXED_FOREST, Settings
from master_thesis.experiments_3_4.mapping_flight import PACKAGE
from master_thesis.experiments_3_4.mapping_flight import SCENARIOS as MAPPING_SCENARIOS
from master_thesis.worlds.experiments_3_4 import hold_with_beams
from master_thesis.worlds.writer import Box, Colour, Cylinder, Part, Prop, Surroundings, write_world

HALF_WIDTH_M = 10.0
CLEAR_M = 3.0
"""No obstacle's middle is nearer to start or goal."""
SPACING_M = 2.0
"""Least distance between trunks' middles in a forest of a given density."""
MIXED_SPACINGS_M = (2.0, 4.0)
"""Bounds of the least distance that is drawn for each mixed forest: 0.16 to 0.04 trees per m2."""
RADII_M = (0.12, 0.30)
DARTS = 3000
_BARK = Colour(0.55, 0.40, 0.27)
_STEEL = Colour(0.45, 0.50, 0.56)
_PLASTER = Colour(0.88, 0.86, 0.80)
_GRASS = Surroundings(Colour(0.80, 0.87, 0.72))
_LINOLEUM = Surroundings(Colour(0.90, 0.89, 0.86))
_CABINET_X_M, _CABINET_Y_M, _CABINET_GAP_M = 0.9, 0.4, 3.0
_WALL_M = 0.2


@dataclass(frozen=True)
class Place:
    """A world, as SDF text or as a file. distance_m: how far ahead along x the goal lies; 0 if none."""

    world: str | Path
    distance_m: float

    def world_file(self, folder: Path) -> Path:
        """Return the world's file; a text is written into the folder."""
        if isinstance(self.world, Path):
            return self.world
        path = Path(folder) / "drawn.world"
        path.write_text(self.world, encoding="utf-8")
        return path


def place_of(settings: Settings, seed: int) -> Place:
    """Return the place of a trial's settings; seed: of what is drawn at random."""
    world, distance_m = settings["world"], settings.get("distance_m", 0.0)
    rng = np.random.default_rng(np.random.SeedSequence(seed))
    if world == FOREST:
        area_m2 = (distance_m - 2 * CLEAR_M) * 2 * HALF_WIDTH_M
        trees = round(settings["density_per_m2"] * area_m2)
        return Place(forest_sdf(plant(rng, SPACING_M, trees, distance_m)), distance_m)
    if world == MIXED_FOREST:
        spacing_m = rng.uniform(*MIXED_SPACINGS_M)
        return Place(forest_sdf(plant(rng, spacing_m, distance_m=distance_m)), distance_m)
    if world == HALLWAY:
        return Place(hallway_sdf(rng, settings["width_m"], distance_m), distance_m)
    if world == HOLD:
        return Place(hold_with_beams(settings["beam_width_m"], settings["beam_spacing_m"]), distance_m)
    file = MAPPING_SCENARIOS[world].world if world in MAPPING_SCENARIOS else world
    return Place(PACKAGE / "worlds" / f"{file}.world", distance_m)


def plant(
    rng: np.random.Generator, spacing_m: float, most: int | None = None, distance_m: float = DRAWN_DISTANCE_M
) -> np.ndarray:
    """Return trunks (n, 3: x, y, radius in m): as many as their spacing leaves room for (darts), or fewer.

    With the same generator a denser forest is a sparser one with more trunks in it.
    """
    trunks = np.empty((0, 3))
    for _ in range(DARTS):
        if len(trunks) == most:
            break
        x, y = rng.uniform(CLEAR_M, distance_m - CLEAR_M), rng.uniform(-HALF_WIDTH_M, HALF_WIDTH_M)
        radius = rng.uniform(*RADII_M)
        gaps = np.hypot(*(trunks[:, :2] - (x, y)).T)
        if gaps.min(initial=math.inf) >= spacing_m:
            trunks = np.vstack((trunks, (x, y, radius)))
    return trunks


def forest_sdf(trunks: np.ndarray) -> str:
    """Return the world file's text of trunks (n, 3: x, y, radius in m)."""
    props = tuple(
        Prop(f"tree_{i}", x, y, (Part("trunk", Cylinder(radius, 4.0), _BARK),))
        for i, (x, y, radius) in enumerate(trunks.tolist())
    )
    return write_world("random_forest", "A forest drawn at random.", _GRASS, props)


def hallway_sdf(rng: np.random.Generator, width_m: float, distance_m: float) -> str:
    """Return a straight hallway along x, this wide between its walls, with cabinets along them.

    A cabinet takes 0.4 m of the width; the next one, on either side, is 3 m or more farther on.
    """
    length, middle = distance_m + 6.0, distance_m / 2
    offset = (width_m + _WALL_M) / 2
    wall = (Part("wall", Box(length, _WALL_M, 4.0), _PLASTER),)
    end = (Part("wall", Box(_WALL_M, width_m, 4.0), _PLASTER),)
    props = [Prop("left", middle, offset, wall), Prop("right", middle, -offset, wall)]
    props += [Prop("behind", -3.0, 0.0, end), Prop("ahead", distance_m + 3.0, 0.0, end)]
    cabinet = (Part("cabinet", Box(_CABINET_X_M, _CABINET_Y_M, 4.0), _STEEL),)
    x = CLEAR_M + rng.uniform(0.0, _CABINET_GAP_M)
    while x < distance_m - CLEAR_M:
        side = 1.0 if rng.random() < 0.5 else -1.0
        props.append(Prop(f"cabinet_{len(props)}", x, side * (width_m - _CABINET_Y_M) / 2, cabinet))
        x += _CABINET_GAP_M + rng.uniform(0.0, _CABINET_GAP_M)
    comment = f"A hallway {width_m:g} m wide, its cabinets drawn at random."
    return write_world("random_hallway", comment, _LINOLEUM, tuple(props))
