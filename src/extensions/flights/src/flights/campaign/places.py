"""Where trials are flown: worlds drawn at random, and the experiments' own."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cepa import KeepOutBox
from flights.campaign.axes import (
    BARRIERS,
    DEAD_ENDS,
    DEEP_DEAD_END,
    DOORS,
    FOREST,
    HALLWAY,
    HOLD,
    MANHOLES,
    MIXED_FOREST,
    OFFICE,
    SPACED_FOREST,
    THICK_FOREST,
    Settings,
)
from flights.mapping.mapping_flight import PACKAGE
from flights.mapping.mapping_flight import SCENARIOS as MAPPING_SCENARIOS
from flights.worlds.drawn.barriers import barriers_sdf
from flights.worlds.drawn.dead_ends import dead_ends_sdf, deep_dead_end_sdf
from flights.worlds.drawn.doors import doors_sdf
from flights.worlds.drawn.forests import (
    HALF_WIDTH_M,
    MIXED_SPACINGS_M,
    SPACING_M,
    THICK_HEIGHT_M,
    forest_sdf,
    plant,
    plant_thick,
)
from flights.worlds.drawn.hallway import hallway_sdf
from flights.worlds.drawn.kept_out import KEEP_OUT, draw_boxes
from flights.worlds.drawn.manholes import manholes_sdf
from flights.worlds.drawn.materials import CLEAR_M
from flights.worlds.drawn.movers import (
    ABREAST,
    CROSSING,
    HEAD_ON,
    SINKING,
    SMALL_UAV,
    abreast_sdf,
    meeting_sdf,
    sinking_sdf,
    small_uav_sdf,
)
from flights.worlds.drawn.office import office_sdf
from flights.worlds.drawn.overhead import OBSTACLES, overhead_sdf
from flights.worlds.drawn.traps import BUG_TRAP, trap_sdf
from flights.worlds.experiments_3_4 import hold_with_beams

STUCK_S, ASTRAY_S, DEEP_ASTRAY_S = 12.0, 40.0, 90.0
"""A flight that comes no nearer to the goal for so long is stuck; in a place where the way leads back; where
it leads back for 20 m.
"""


@dataclass(frozen=True)
class Place:
    """A world, as SDF text or as a file.

    distance_m: how far ahead along x the goal lies; 0 if none. stuck_s: a flight that comes no nearer to the
    goal for so long is stuck. keep_out: boxes that the UAV is to stay out of.
    """

    world: str | Path
    distance_m: float
    stuck_s: float = STUCK_S
    keep_out: tuple[KeepOutBox, ...] = ()

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
        return Place(forest_sdf(plant(rng, SPACING_M, distance_m, trees)), distance_m)
    if world == MIXED_FOREST:
        return Place(forest_sdf(plant(rng, rng.uniform(*MIXED_SPACINGS_M), distance_m)), distance_m)
    if world == SPACED_FOREST:
        return Place(forest_sdf(plant(rng, SPACING_M, distance_m)), distance_m)
    if world == KEEP_OUT:
        boxes = draw_boxes(rng, distance_m)
        return Place(forest_sdf(plant(rng, SPACING_M, distance_m)), distance_m, keep_out=boxes)
    if world == THICK_FOREST:
        return Place(forest_sdf(plant_thick(rng, distance_m), THICK_HEIGHT_M), distance_m)
    if world == HALLWAY:
        return Place(hallway_sdf(rng, settings["width_m"], distance_m), distance_m)
    if world == DEAD_ENDS:
        return Place(dead_ends_sdf(rng, distance_m), distance_m, ASTRAY_S)
    if world == DEEP_DEAD_END:
        return Place(deep_dead_end_sdf(rng, settings["depth_m"]), distance_m, DEEP_ASTRAY_S)
    if world == MANHOLES:
        passage = manholes_sdf(rng, distance_m, settings["height_m"], settings["behind"])
        return Place(passage, distance_m, ASTRAY_S)
    if world == BUG_TRAP:
        return Place(trap_sdf(rng, settings["trap"], distance_m), distance_m, ASTRAY_S)
    if world == DOORS:
        return Place(doors_sdf(rng, settings["door_m"], distance_m), distance_m, ASTRAY_S)
    if world in BARRIERS:
        return Place(barriers_sdf(rng, world, distance_m), distance_m, ASTRAY_S)
    if world == OFFICE:
        return Place(office_sdf(rng, distance_m), distance_m, ASTRAY_S)
    if world in (CROSSING, HEAD_ON):
        speeds = settings["speed_m_s"], settings["mover_speed_m_s"]
        return Place(meeting_sdf(rng, world, distance_m, *speeds), distance_m)
    if world == ABREAST:
        return Place(abreast_sdf(rng, distance_m, settings["speed_m_s"]), distance_m, ASTRAY_S)
    if world in (SINKING, SMALL_UAV):
        sdf = sinking_sdf if world == SINKING else small_uav_sdf
        flight = distance_m, settings["speed_m_s"], settings["height_m"]
        return Place(sdf(rng, *flight), distance_m, ASTRAY_S)
    if world in OBSTACLES:
        return Place(overhead_sdf(rng, world, distance_m, settings["height_m"]), distance_m)
    if world == HOLD:
        return Place(hold_with_beams(settings["beam_width_m"], settings["beam_spacing_m"]), distance_m)
    file = MAPPING_SCENARIOS[world].world if world in MAPPING_SCENARIOS else world
    return Place(PACKAGE / "worlds" / f"{file}.world", distance_m)
