"""Coating grades of areas and the rust on plates, as IMO MSC.1/Circ.1330 4.1.3 and IACS UR Z10 ask for."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np
from scipy.spatial import cKDTree

from flight_basics.checks import check_parameters, limited
from inspection.findings.findings_file import DISMISSED
from inspection.findings.kinds import FINDING_KINDS, kind_of
from inspection.findings.merging import Finding
from inspection.ship.ship import Plate, Ship
from inspection.survey.surface.edges import STEP_M
from inspection.survey.surface_record import SurfaceRecord

GOOD, FAIR, POOR = GRADES = ("GOOD", "FAIR", "POOR")
ELSEWHERE = "Elsewhere"
NEAR_M = 0.2
RUST_M = 0.05
"""An edge so near to a place of rust is rusted there."""


@dataclass(frozen=True)
class GradeRules:
    """Limits of the grades, as shares 0..1.

    Raises:
        ParameterError: a value out of range.
    """

    good_area: float = limited(0.03, 0.0, 1.0)
    """Below this rusted share of the area it is GOOD."""
    poor_area: float = limited(0.20, 0.0, 1.0)
    """Above this rusted share of the area it is POOR."""
    good_edges: float = limited(0.20, 0.0, 1.0)
    """Below this rusted share of edges and welds it is GOOD."""
    poor_edges: float = limited(0.50, 0.0, 1.0)
    """Above this rusted share of edges and welds it is POOR."""
    pitting: float = limited(0.15, 0.0, 1.0)
    """Rusted share of a plate from which thickness measurements are proposed."""
    least_seen: float = limited(0.5, 0.0, 1.0)
    """Seen share of an area that a grade needs."""
    error: float = limited(0.15, 0.0, 1.0)
    """Photographs tell a share wrong by so much of it. Where that may change the grade, both are told."""

    def __post_init__(self) -> None:
        check_parameters(self)

    def grade(self, area_share: float, edge_share: float) -> str:
        """Return the lower of the grades by the area and by edges and welds."""
        area = GOOD if area_share < self.good_area else FAIR if area_share <= self.poor_area else POOR
        edges = GOOD if edge_share < self.good_edges else FAIR if edge_share <= self.poor_edges else POOR
        return max(area, edges, key=GRADES.index)

    def other_grade(self, area_share: float, edge_share: float) -> str | None:
        """Return the grade that shares which are wrong by `error` would give; None: the same."""
        grade = self.grade(area_share, edge_share)
        others = (self.grade(area_share * by, edge_share * by) for by in (1.0 + self.error, 1.0 - self.error))
        return next((other for other in others if other != grade), None)


@dataclass(frozen=True)
class AreaGrade:
    """What is known of an area. Shares are of what was seen.

    numbers: of findings of each of the `FINDING_KINDS`.
    grade: None: too little of it was seen. other_grade: it may be this one, too; None: it is sure.
    """

    name: str
    area_m2: float
    seen_m2: float
    rust_m2: float
    edges_m: float
    rusted_edges_m: float
    numbers: tuple[int, ...]
    grade: str | None = None
    other_grade: str | None = None

    @property
    def seen(self) -> float:
        """Share of the area that was seen."""
        return self.seen_m2 / self.area_m2 if self.area_m2 > 0.0 else 0.0

    @property
    def rust_share(self) -> float:
        """Share of what was seen that is rusted."""
        return min(self.rust_m2 / self.seen_m2, 1.0) if self.seen_m2 > 0.0 else 0.0

    @property
    def edge_share(self) -> float:
        """Share of the edges and welds that were seen that is rusted."""
        return self.rusted_edges_m / self.edges_m if self.edges_m > 0.0 else 0.0


@dataclass(frozen=True)
class PlateState:
    """What was seen of a plate, with the numbers of its findings."""

    plate: Plate
    area_m2: float
    seen_m2: float
    rust_m2: float
    findings: tuple[int, ...]

    @property
    def rust_share(self) -> float:
        """Share of what was seen that is rusted: the pitting intensity is at most this."""
        return min(self.rust_m2 / self.seen_m2, 1.0) if self.seen_m2 > 0.0 else 0.0


class Standing:
    """The findings that stand, those not dismissed, by place; rust is what counts for the grade."""

    def __init__(self, findings: Sequence[Finding]) -> None:
        self.all = [each for each in findings if each.status != DISMISSED]
        self.points_m = np.array([each.position_m for each in self.all]).reshape(-1, 3)
        self.normals = np.array([each.normal for each in self.all]).reshape(-1, 3)
        self.kinds = [kind_of(each.kind) for each in self.all]
        self.rust_m2 = np.array(
            [each.area_m2 if kind.counts_for_coating else 0.0 for each, kind in zip(self.all, self.kinds)]
        )

    def near_rust(self, places_m: np.ndarray) -> np.ndarray:
        """Return which places (k, 3) lie at a place of rust.

        Where a finding tells no places, those within half its length do.
        """
        rusted = np.zeros(len(places_m), bool)
        rust = [each for each, kind in zip(self.all, self.kinds) if kind.counts_for_coating]
        for each in (each for each in rust if not each.places_m):
            apart_m = np.linalg.norm(places_m - np.array(each.position_m), axis=1)
            rusted |= apart_m <= 0.5 * each.length_m
        told_m = [place_m for each in rust for place_m in each.places_m]
        if told_m and len(places_m):
            rusted |= cKDTree(np.array(told_m)).query(places_m)[0] <= RUST_M
        return rusted


def areas_graded(
    ship: Ship, surface: SurfaceRecord, edges_m: np.ndarray, findings: Sequence[Finding], rules: GradeRules
) -> list[AreaGrade]:
    """Return a grade for each area of the ship, and for the surface that lies in none of them.

    edges_m: (k, 3) places on edges and welds, STEP_M apart.
    """
    stand = Standing(findings)
    names = [surface.names[part] for part in surface.parts]
    of_patch = ship.areas_of(surface.points_m, names, surface.normals)
    on = surface.patches_at(stand.points_m, stand.normals, NEAR_M)
    of_finding = np.where(
        on >= 0, of_patch[on], ship.areas_of(stand.points_m, [None] * len(stand.all), stand.normals)
    )
    beside = surface.patches_at(edges_m, None, NEAR_M)
    edges_m, beside = edges_m[beside >= 0], beside[beside >= 0]
    seen_edge, of_edge = surface.is_shown[beside], of_patch[beside]
    rusted = seen_edge & stand.near_rust(edges_m)
    graded = []
    for number, name in [*enumerate(area.name for area in ship.areas), (-1, ELSEWHERE)]:
        patches, marks, lines = of_patch == number, of_finding == number, of_edge == number
        area_m2, seen_m2 = (float(each[patches].sum()) for each in (surface.areas_m2, surface.shown_m2))
        if area_m2 == 0.0:
            continue
        each = AreaGrade(
            name if ship.areas else "Whole space",
            area_m2,
            seen_m2,
            float(stand.rust_m2[marks].sum()),
            STEP_M * float((lines & seen_edge).sum()),
            STEP_M * float((lines & rusted).sum()),
            tuple(sum(stand.kinds[k] == kind for k in np.flatnonzero(marks)) for kind in FINDING_KINDS),
        )
        if each.seen >= rules.least_seen:
            shares = each.rust_share, each.edge_share
            each = replace(each, grade=rules.grade(*shares), other_grade=rules.other_grade(*shares))
        graded.append(each)
    return graded


def plates_seen(ship: Ship, surface: SurfaceRecord, findings: Sequence[Finding]) -> list[PlateState]:
    """Return each plate of the ship that has a surface or a finding."""
    stand = Standing(findings)
    of_patch = ship.plates_of(surface.points_m, surface.normals)
    of_finding = ship.plates_of(stand.points_m, stand.normals)
    states = []
    for number, plate in enumerate(ship.plates()):
        patches, marks = of_patch == number, of_finding == number
        area_m2, seen_m2 = (float(each[patches].sum()) for each in (surface.areas_m2, surface.shown_m2))
        if area_m2 > 0.0 or marks.any():
            ids = tuple(stand.all[k].id for k in np.flatnonzero(marks))
            states.append(PlateState(plate, area_m2, seen_m2, float(stand.rust_m2[marks].sum()), ids))
    return states
