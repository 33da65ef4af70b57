"""The coverage record: what photographs showed from where the camera really was."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.files.whole import write_whole
from inspection.photographs.listing import LeftOut
from inspection.photographs.searched import digest_of
from inspection.survey.parameters import SurveyParameters
from inspection.survey.showing import Showing
from inspection.survey.surface.mesh_file import reference_of
from inspection.survey.surface.of_mesh import sides_in_air
from inspection.survey.surface.patches import Patches, grouped
from inspection.survey.surface.reading import Surface, read_surface
from inspection.survey.surface.samples import SurfacePoints
from inspection.survey.surface_record import SurfaceRecord, surface_record_bytes
from inspection.survey.views.candidates import Candidates, lattice

FINER = 0.5
"""Side of the patches in which coverage is told, as a share of the planner's."""


@dataclass(frozen=True)
class Coverage:
    """What was shown, at points spread evenly over the surface.

    points: (n,) of them. shown: (n,) by some photograph. reachable: (n,) what a UAV could have shown at all,
    and what was shown. patches: of the points, for a record. mesh_m2: of the whole mesh, in this room or not,
    with both sides of its sheets.
    """

    points: SurfacePoints
    shown: np.ndarray
    reachable: np.ndarray
    patches: Patches
    mesh_m2: float = 0.0

    @property
    def shown_m2(self) -> float:
        """Area that was shown."""
        return float(self.points.areas_m2[self.shown].sum())

    @property
    def reachable_m2(self) -> float:
        """Area that a UAV could have shown."""
        return float(self.points.areas_m2[self.reachable].sum())

    def share(self, part: int | None = None) -> float | None:
        """Return the share, 0..1, of what is reachable: of all or of one thing; None: nothing of it is."""
        counts = self.reachable if part is None else self.reachable & (self.points.parts == part)
        area_m2 = self.points.areas_m2[counts].sum()
        return float(self.points.areas_m2[counts & self.shown].sum() / area_m2) if area_m2 > 0.0 else None

    def record(self) -> SurfaceRecord:
        """Return the surface in patches, each with the shares of it that were shown and are reachable."""
        p = self.patches
        of = p.numbers(self.points.points_m, self.points.normals, self.points.parts)
        shown, reachable = (
            np.bincount(of, self.points.areas_m2 * each, len(p)) / p.areas_m2
            for each in (self.shown, self.reachable)
        )
        return SurfaceRecord(
            p.points_m, p.normals, p.areas_m2, p.parts, p.names, shown, reachable, p.grid.side_m
        )


@dataclass(frozen=True)
class OnDrawing:
    """What photographs show of a drawing, beside the map on which they were planned.

    source: file of the drawing. is_mapped: (n,) points of its coverage that the map has, too: a surface that
    faces the same way lies near them.
    """

    source: str
    coverage: Coverage
    is_mapped: np.ndarray

    @classmethod
    def beside(cls, mapped: Coverage, source: str, coverage: Coverage) -> OnDrawing:
        """mapped: on the map. coverage: on the drawing in the file `source`, by the same photographs."""
        points = coverage.points
        return cls(source, coverage, mapped.record().patches_at(points.points_m, points.normals) >= 0)

    def record(self) -> dict[str, Any]:
        """Return it for coverage.json, as `DrawnRecord` reads it."""
        coverage, lacking = self.coverage, self.coverage.reachable & ~self.is_mapped
        of_part = {
            name: self.lacking_m2(lacking & (coverage.points.parts == number))
            for number, name in enumerate(coverage.patches.names)
        }
        return {
            "surface": self.source,
            **_areas(coverage),
            "not_mapped_m2": self.lacking_m2(lacking),
            "classes": {
                name: {**told, "not_mapped_m2": of_part[name]} for name, told in _things(coverage).items()
            },
        }

    def lacking_m2(self, those: np.ndarray) -> float:
        """Return the area of some of the points (n,)."""
        return round(float(self.coverage.points.areas_m2[those].sum()), 3)


def coverage_of_file(
    mesh_file: Path,
    taken: Sequence[PhotographPose],
    camera: SurveyCamera,
    asked: SurveyParameters,
    home_m: Sequence[float] | None = None,
) -> Coverage:
    """Return the coverage of a mesh or an SDF world.

    Reachable is what the planner could show from somewhere: a patch of it, and so all points in it.

    Raises:
        SurveyError: the file cannot be used, or the UAV fits nowhere in it.
    """
    return coverages_of_file(mesh_file, (taken,), camera, asked, home_m)[0]


def coverages_of_file(
    mesh_file: Path,
    several: Sequence[Sequence[PhotographPose]],
    camera: SurveyCamera,
    asked: SurveyParameters,
    home_m: Sequence[float] | None = None,
) -> list[Coverage]:
    """Return the coverage of several sets of photographs, as `coverage_of_file` does of one."""
    return coverages_on(read_surface(mesh_file, asked, home_m), several, camera, asked)


def coverages_on(
    surface: Surface,
    several: Sequence[Sequence[PhotographPose]],
    camera: SurveyCamera,
    asked: SurveyParameters,
) -> list[Coverage]:
    """Return the coverage of several sets of photographs on a surface that is read already.

    Reachable is what photographs from the best places would show, without what a plan keeps in reserve.
    """
    points = sides_in_air(surface.mesh, surface.room, surface.samples, surface.near)
    places_m = lattice(surface.room, asked.lattice_m)
    candidates = Candidates(surface.patches, places_m, camera, replace(asked, finer=0.0), surface.ranges_m)
    whole = surface.patches.numbers(points.points_m, points.normals, points.parts)
    reachable = (whole >= 0) & candidates.reachable[np.maximum(whole, 0)]
    showing = Showing(surface.mesh, points, camera, asked)
    patches = fine_patches(points, surface.mesh.names, asked)
    several_shown = [showing.by(taken) for taken in several]
    mesh_m2 = surface.mesh.area_m2
    return [Coverage(points, shown, reachable | shown, patches, mesh_m2) for shown in several_shown]


def fine_patches(points: SurfacePoints, names: tuple[str, ...], asked: SurveyParameters) -> Patches:
    """Return the patches in which coverage is told: of half the planner's side."""
    return grouped(points, names, FINER * asked.patch)


def write_coverage(
    path: Path,
    coverage: Coverage,
    source: str,
    poses: str,
    taken: Sequence[PhotographPose],
    asked: SurveyParameters,
    left_out: Sequence[LeftOut] = (),
    drawing: OnDrawing | None = None,
) -> dict:
    """Write the record as JSON and return it. `open`: patches within reach that no photograph shows whole.

    All patches go into a file of the same name with the suffix .npz: see `survey.surface_record`. `record` is
    its digest: two files of two runs do not pass for one.

    taken: the photographs that count. left_out: those that do not. drawing: known besides a map.

    Raises:
        SurveyError: the files cannot be written; those from before stay.
    """
    whole = surface_record_bytes(coverage.record())
    record = _record_of(coverage, source, poses, taken, asked)
    record["drawing"] = None if drawing is None else drawing.record()
    record["left_out"] = [{"photograph": each.name, "why": each.why} for each in left_out]
    record["record"] = hashlib.sha256(whole).hexdigest()
    try:
        write_whole({path.with_suffix(".npz"): whole, path: json.dumps(record, allow_nan=False).encode()})
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None
    return record


def _record_of(
    coverage: Coverage, source: str, poses: str, taken: Sequence[PhotographPose], asked: SurveyParameters
) -> dict[str, Any]:
    points, names = coverage.points, coverage.patches.names
    missing = coverage.reachable & ~coverage.shown
    opened = fine_patches(points.only(missing), names, asked) if missing.any() else None
    return {
        "surface": source,
        "of": reference_of(names),
        "poses": poses,
        "photographs": len(taken),
        "counted": [each.name for each in taken if each.name],
        "rests_on": {each.name: digest_of(each.path) for each in taken if each.path is not None},
        "resolution_mm_per_px": asked.resolution,
        "incidence_deg": asked.incidence,
        "mesh_m2": round(coverage.mesh_m2, 3),
        **_areas(coverage),
        "classes": _things(coverage),
        "open": []
        if opened is None
        else [
            [*np.round(point, 3).tolist(), round(area, 5)]
            for point, area in zip(opened.points_m, opened.areas_m2.tolist())
        ],
    }


def _areas(coverage: Coverage) -> dict[str, float | None]:
    return {
        "surface_m2": round(float(coverage.points.areas_m2.sum()), 3),
        "shown_m2": round(coverage.shown_m2, 3),
        "reachable_m2": round(coverage.reachable_m2, 3),
        "share_of_reachable": _rounded(coverage.share()),
    }


def _things(coverage: Coverage) -> dict[str, dict[str, float | None]]:
    """Return what is within reach of each thing, and which share of that is shown."""
    points = coverage.points
    reachable_m2 = np.bincount(
        points.parts, points.areas_m2 * coverage.reachable, len(coverage.patches.names)
    )
    return {
        name: {
            "reachable_m2": round(float(reachable_m2[number]), 3),
            "share": _rounded(coverage.share(number)),
        }
        for number, name in enumerate(coverage.patches.names)
    }


def _rounded(share: float | None) -> float | None:
    return None if share is None else round(share, 5)
