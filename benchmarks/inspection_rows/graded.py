"""Grades of a corroded box of six plates, by its photographs, beside the grades of its true rust."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Sequence

import numpy as np
import yaml

from benchmarks.inspection_rows.found import shoot
from benchmarks.inspection_rows.hold import ASKED
from benchmarks.inspection_rows.parts import only
from benchmarks.inspection_rows.rusted import STEP_M, by_cells, is_rusted
from flights.worlds.defects import COATINGS
from flights.worlds.writer import Box, Colour, Part, Prop, Surroundings, write_world
from inspection.findings.merging import Finding
from inspection.findings.parameters import FindingParameters
from inspection.findings.search import find
from inspection.report.grades import AreaGrade, GradeRules, areas_graded
from inspection.ship.ship import Ship
from inspection.ship.ship_file import parse_ship
from inspection.survey.coverage import coverages_on
from inspection.survey.planner import SurveyPlanner
from inspection.survey.surface.edges import edge_places
from inspection.survey.surface.reading import read_surface
from simulation_tools.camera.defects import decals_of, read_defects
from simulation_tools.camera.surfaces import surfaces_of
from simulation_tools.sdf.parser import load_world

SEEDS = (61, 62)
MOST, BRIEF_MOST = 1000, 2
"""Photographs."""
SIZE_M = np.array((7.0, 6.0, 4.0))
"""Of the space, from its middle on the floor."""
FLOOR = "ground_plane"
PLATES = {
    "aft": (0, -1), "forward": (0, 1), "starboard": (1, -1), "port": (1, 1), FLOOR: (2, -1), "deck": (2, 1)
}  # fmt: skip
"""Axis and side of each."""
SHARES = (0.005, 0.01, 0.08, 0.12, 0.3, 0.4)
"""Of a plate that is rusted, about: the grades' limits are 0.03 and 0.2. They are dealt out by the seed."""
LONG_M = (0.1, 0.8)


def grade(seed: int, most: int) -> dict:
    """Photograph the box, and grade its plates by what is found and by the truth."""
    rng = np.random.default_rng(seed)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        world, marks = folder / "corroded.world", folder / "corroded.defects.yaml"
        world.write_text(_world(), encoding="utf-8")
        marks.write_text(yaml.safe_dump(_corrosion(rng), default_flow_style=None), encoding="utf-8")
        asked = replace(ASKED, share=0.9, class_share=0.9)
        surface = read_surface(world, asked, (0.0, 0.0, 1.5))
        planner = SurveyPlanner(
            surface.room, surface.patches, surface.ranges_m, asked=asked, source=str(world)
        )
        plan = next(planner.improve(seed, 0.0, bound=False)).plan
        part = only(plan, plan.views[:most])
        taken = shoot(world, part, folder / "photographs", marks, seed, rng)
        found = find([folder / "photographs"], surface.mesh, FindingParameters())
        (coverage,) = coverages_on(surface, (taken,), part.camera, asked)
        record = coverage.record()
        edges_m = edge_places(surface.mesh.triangles_m, surface.mesh.part)
        whole = replace(record, shown=record.reachable)  # the truth counts what was not seen, too
        told, true = (
            {each.name: each for each in areas_graded(_ship(), shown, edges_m, findings, GradeRules())}
            for shown, findings in ((record, found), (whole, _true_findings(world, marks)))
        )
    return {
        "photographs": len(taken),
        "areas": {name: _row(told[name], true[name]) for name in told if true[name].grade is not None},
    }


def summary(boxes: Sequence[dict]) -> dict:
    """Return what all boxes together have."""
    plates = [plate for box in boxes for plate in box["areas"].values()]
    return {
        "photographs": sum(box["photographs"] for box in boxes),
        "plates": len(plates),
        "right": sum(plate["told"][0] == plate["true"][0] for plate in plates),
        "told_as_other": sum(plate["other"] == plate["true"][0] for plate in plates),
        "off_share": max((abs(plate["told"][1] - plate["true"][1]) for plate in plates), default=None),
    }


def _row(told: AreaGrade, true: AreaGrade) -> dict:
    return {
        "told": [told.grade, round(told.rust_share, 4), round(told.edge_share, 4)],
        "true": [true.grade, round(true.rust_share, 4), round(true.edge_share, 4)],
        "other": told.other_grade,
        "seen": round(told.seen, 3),
    }


def _world() -> str:
    grey = Colour(*COATINGS["shell"])
    props = []
    for name, (axis, side) in PLATES.items():
        if name == FLOOR:
            continue  # each world has it
        size_m, centre_m = SIZE_M.copy(), 0.5 * SIZE_M * (0.0, 0.0, 1.0)
        size_m[axis] = 0.2
        centre_m[axis] += side * 0.5 * (SIZE_M[axis] + 0.2)
        x, y, z = centre_m.tolist()
        props.append(Prop(name, x, y, (Part(name, Box(*size_m.tolist()), grey, (0.0, 0.0, z)),)))
    return write_world("corroded", "A box of six plates.", Surroundings(grey), tuple(props))


def _corrosion(rng: np.random.Generator) -> dict:
    """Return the content of a file of defects: rust spots, until each plate has its share."""
    defects, shares = [], dict(zip(PLATES, rng.permutation(SHARES)))
    for name, (axis, side) in PLATES.items():
        across = [k for k in range(3) if k != axis]
        left_m2 = shares[name] * float(np.prod(SIZE_M[across]))
        while left_m2 > 0.0:
            length_m = float(np.exp(rng.uniform(*np.log(LONG_M))))
            width_m = length_m * rng.uniform(0.4, 1.0)
            place_m, along, normal = np.zeros(3), np.zeros(3), np.zeros(3)
            place_m[across] = rng.uniform(-0.5, 0.5, 2) * SIZE_M[across]
            place_m[axis], normal[axis] = 0.5 * side * SIZE_M[axis], -side
            place_m[2] += 0.5 * SIZE_M[2]
            angle = rng.uniform(0.0, np.pi)
            along[across] = np.cos(angle), np.sin(angle)
            vectors = {"position_m": place_m, "normal": normal, "along": along}
            defects.append(
                {
                    "kind": "rust",
                    **{key: [round(float(x), 5) for x in vector] for key, vector in vectors.items()},
                    "length_m": round(length_m, 4),
                    "width_m": round(width_m, 4),
                    "seed": int(rng.integers(1 << 31)),
                }
            )
            left_m2 -= 0.25 * np.pi * length_m * width_m
    return {
        "world": "corroded.world",
        "coatings": {name: [*COATINGS["shell"]] for name in PLATES},
        "defects": defects,
    }


def _true_findings(world: Path, marks: Path) -> list[Finding]:
    """Return a finding for each cell of the plates that is rusted, of its true area."""
    given = read_defects(marks)
    surfaces = surfaces_of(load_world(str(world)), given.coatings)
    decals, found = decals_of(given.defects, surfaces), list[Finding]()
    for name, (axis, side) in PLATES.items():
        points_m = _places_on(axis, side)
        normal = np.zeros(3)
        normal[axis] = -side
        on = np.abs(surfaces.normals @ points_m[0] - surfaces.offsets_m) < 1e-3
        (face,) = np.flatnonzero(on & (surfaces.normals @ normal > 0.99))
        axes = np.column_stack((surfaces.u_axes[face], surfaces.v_axes[face]))
        rows = range(decals.first[face], decals.first[face + 1])
        rusted_m = points_m[is_rusted(points_m @ axes, decals, rows)]
        found += by_cells(rusted_m, normal, name, len(found) + 1)
    return found


def _places_on(axis: int, side: int) -> np.ndarray:
    """Return places (n, 3) all over a plate."""
    across = [k for k in range(3) if k != axis]
    low_m = np.array((-0.5, -0.5, 0.0)) * SIZE_M
    a, b = (low_m[k] + np.arange(STEP_M / 2, SIZE_M[k], STEP_M) for k in across)
    points_m = np.full((a.size * b.size, 3), low_m[axis] + (side > 0) * SIZE_M[axis])
    points_m[:, across] = np.stack(np.meshgrid(a, b), -1).reshape(-1, 2)
    return points_m


def _ship() -> Ship:
    content = {"ap": [0.0, 0.0, 0.0], "frames": [{"from": 0, "to": 1, "spacing": 1000}]}
    return parse_ship({**content, "areas": [{"name": name, "parts": [name]} for name in PLATES]})
