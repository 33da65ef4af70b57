"""The coverage record: what photographs showed from where the camera really was."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np

from inspection_tools.errors import SurveyError
from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.poses import Taken
from inspection_tools.survey.showing import Showing
from inspection_tools.survey.surface.of_mesh import patches_of_mesh
from inspection_tools.survey.surface.patches import Patches
from inspection_tools.survey.surface.reading import Surface, read_surface
from inspection_tools.survey.surface_record import SurfaceRecord, write_surface_record
from inspection_tools.survey.views.candidates import Candidates, lattice


@dataclass(frozen=True)
class Coverage:
    """What was shown: (n,) per patch. reachable: (n,) what a UAV could have shown at all."""

    patches: Patches
    shown: np.ndarray
    reachable: np.ndarray

    def share(self, part: int | None = None) -> float | None:
        """Return the share, 0..1, of what is reachable: of all or of one thing; None: nothing of it is."""
        counts = self.reachable if part is None else self.reachable & (self.patches.parts == part)
        area_m2 = self.patches.areas_m2[counts].sum()
        return float(self.patches.areas_m2[counts & self.shown].sum() / area_m2) if area_m2 > 0.0 else None


def judge(
    mesh_file: Path,
    taken: Sequence[Taken],
    camera: SurveyCamera,
    asked: SurveyParameters,
    home_m: Sequence[float] | None = None,
) -> Coverage:
    """Return the coverage of a mesh or an SDF world, in patches of half the planner's side.

    Reachable is what the planner could show from somewhere: a patch of it, and so the small ones in it.

    Raises:
        SurveyError: the file cannot be used, or the UAV fits nowhere in it.
    """
    return judge_each(mesh_file, (taken,), camera, asked, home_m)[0]


def judge_each(
    mesh_file: Path,
    several: Sequence[Sequence[Taken]],
    camera: SurveyCamera,
    asked: SurveyParameters,
    home_m: Sequence[float] | None = None,
) -> list[Coverage]:
    """Return the coverage of several sets of photographs, as `judge` does of one."""
    return judge_on(read_surface(mesh_file, asked, home_m), several, camera, asked)


def judge_on(
    surface: Surface, several: Sequence[Sequence[Taken]], camera: SurveyCamera, asked: SurveyParameters
) -> list[Coverage]:
    """Return the coverage of several sets of photographs on a surface that is read already.

    Reachable is what photographs from the best places would show, without what a plan keeps in reserve.
    """
    p = fine_patches(surface, asked)
    places_m = lattice(surface.room, asked.lattice_m)
    candidates = Candidates(surface.patches, places_m, camera, replace(asked, finer=0.0), surface.ranges_m)
    whole = surface.patches.numbers(p.points_m, p.normals, p.parts)
    reachable = (whole >= 0) & candidates.reachable[np.maximum(whole, 0)]
    showing = Showing(surface.mesh, p, camera, asked)
    return [Coverage(p, showing.by(taken), reachable) for taken in several]


def fine_patches(surface: Surface, asked: SurveyParameters) -> Patches:
    """Return the patches for which coverage is judged: of half the planner's side."""
    finer = replace(asked, patch=0.5 * asked.patch)
    return patches_of_mesh(surface.mesh, surface.room, surface.samples, surface.near, finer)


def write_coverage(
    path: Path, coverage: Coverage, source: str, poses: str, photographs: int, asked: SurveyParameters
) -> dict:
    """Write the record as JSON and return it. `open`: reachable patches that no photograph shows.

    All patches go into a file of the same name with the suffix .npz: see `survey.surface_record`.

    Raises:
        SurveyError: the file cannot be written.
    """
    p, shown, reachable = coverage.patches, coverage.shown, coverage.reachable
    things = {
        name: {
            "reachable_m2": round(float(p.areas_m2[reachable & (p.parts == number)].sum()), 3),
            "share": _rounded(coverage.share(number)),
        }
        for number, name in enumerate(p.names)
    }
    missing = np.flatnonzero(reachable & ~shown)
    record = {
        "surface": source,
        "poses": poses,
        "photographs": photographs,
        "resolution_mm_per_px": asked.resolution,
        "incidence_deg": asked.incidence,
        "surface_m2": round(float(p.areas_m2.sum()), 3),
        "shown_m2": round(float(p.areas_m2[shown].sum()), 3),
        "reachable_m2": round(float(p.areas_m2[reachable].sum()), 3),
        "share_of_reachable": _rounded(coverage.share()),
        "classes": things,
        "open": [
            [*np.round(point, 3).tolist(), round(area, 5)]
            for point, area in zip(p.points_m[missing], p.areas_m2[missing].tolist())
        ],
    }
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_text(json.dumps(record, allow_nan=False), encoding="utf-8")
        os.replace(partial, path)
    except OSError as error:
        partial.unlink(missing_ok=True)
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None
    whole = SurfaceRecord(
        p.points_m, p.normals, p.areas_m2, p.parts, p.names, shown, reachable, p.grid.side_m
    )
    write_surface_record(path.with_suffix(".npz"), whole)
    return record


def _rounded(share: float | None) -> float | None:
    return None if share is None else round(share, 5)
