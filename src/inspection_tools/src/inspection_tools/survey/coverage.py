"""The coverage record: what photographs showed from where the camera really was.

It does not use the planner's geometry. Embree casts rays through pixels of each photograph. The footprint
of a pixel comes from where its neighbours' rays meet the plane of the triangle that was hit.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Sequence

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from inspection_tools.errors import SurveyError
from inspection_tools.survey.camera import SurveyCamera
from inspection_tools.survey.parameters import SurveyParameters
from inspection_tools.survey.poses import Taken
from inspection_tools.survey.surface.mesh_file import Mesh
from inspection_tools.survey.surface.of_mesh import patches_of_mesh
from inspection_tools.survey.surface.patches import Patches
from inspection_tools.survey.surface.reading import Surface, read_surface
from inspection_tools.survey.surface.samples import normals_of
from inspection_tools.survey.surface_record import SurfaceRecord, write_surface_record
from inspection_tools.survey.views.candidates import Candidates, lattice

RAYS_PER_PATCH = 4
"""Rays along the side of a patch that is as far away as the resolution allows."""


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
    places_m = lattice(surface.room, asked.spacing)
    candidates = Candidates(surface.patches, places_m, camera, replace(asked, finer=0.0), surface.ranges_m)
    whole = surface.patches.numbers(p.points_m, p.normals, p.parts)
    reachable = (whole >= 0) & candidates.reachable[np.maximum(whole, 0)]
    return [Coverage(p, shown_by(taken, surface.mesh, p, camera, asked), reachable) for taken in several]


def fine_patches(surface: Surface, asked: SurveyParameters) -> Patches:
    """Return the patches for which coverage is judged: of half the planner's side."""
    finer = replace(asked, patch=0.5 * asked.patch)
    return patches_of_mesh(surface.mesh, surface.room, surface.samples, surface.near, finer)


def shown_by(
    taken: Sequence[Taken], mesh: Mesh, patches: Patches, camera: SurveyCamera, asked: SurveyParameters
) -> np.ndarray:
    """Return which patches (n,) some photograph shows at the asked resolution and incidence."""
    scene = EmbreeScene()
    TriangleMesh(scene, np.ascontiguousarray(mesh.triangles_m, dtype=np.float32))
    normals, _ = normals_of(mesh.triangles_m)
    step_px = max(1, int(1e3 * patches.grid.side_m / (RAYS_PER_PATCH * asked.resolution)))
    pixels = _pixels(camera, step_px)
    shown = np.zeros(len(patches), bool)
    for each in taken:
        rays = pixels @ each.axes.T
        lengths = np.linalg.norm(rays, axis=1)
        origins = np.broadcast_to(each.place_m.astype(np.float32), rays.shape)
        hits = scene.run(
            np.ascontiguousarray(origins), (rays / lengths[:, None]).astype(np.float32), output=True
        )
        hit = np.flatnonzero(hits["primID"] >= 0)
        triangles = hits["primID"][hit]
        towards = normals[triangles]
        towards = towards * -np.sign((towards * rays[hit]).sum(axis=1))[:, None]
        cosine = -(towards * rays[hit]).sum(axis=1) / lengths[hit]
        depth_m = hits["tfar"][hit] / lengths[hit]
        footprint_m = _footprints_m(rays[hit], towards, depth_m, each.axes, camera.focal_px)
        fine = 1e3 * each.widths_m(footprint_m, depth_m, lengths[hit]) <= asked.resolution
        fine &= cosine >= np.cos(np.radians(asked.incidence))
        places_m = each.place_m + depth_m[fine, None] * rays[hit[fine]]
        found = patches.numbers(places_m, towards[fine], mesh.part[triangles[fine]])
        shown[found[found >= 0]] = True
    return shown


def _pixels(camera: SurveyCamera, step_px: int) -> np.ndarray:
    """Return (k, 3) the lines of sight of every such pixel, at depth 1 in the optical frame."""
    right, down = np.meshgrid(
        np.arange(step_px // 2, camera.width, step_px), np.arange(step_px // 2, camera.height, step_px)
    )
    places = (np.column_stack((right.ravel(), down.ravel())) - camera.centre_px) / camera.focal_px
    return np.column_stack((places, np.ones(len(places))))


def _footprints_m(
    rays: np.ndarray, normals: np.ndarray, depth_m: np.ndarray, axes: np.ndarray, focal_px: float
) -> np.ndarray:
    """Return (k,) how much surface a pixel covers in its worst direction, by its neighbours' rays."""
    reach = (rays * normals).sum(axis=1) * depth_m
    points = rays * depth_m[:, None]
    edges = []
    for axis in (0, 1):
        beside = rays + 1e-3 * axes[:, axis] / focal_px
        edges.append(1e3 * (beside * (reach / (beside * normals).sum(axis=1))[:, None] - points))
    spread = np.stack(edges, axis=2)
    return np.linalg.svd(spread, compute_uv=False)[:, 0]


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
    try:
        path.write_text(json.dumps(record), encoding="utf-8")
    except OSError as error:
        raise SurveyError(f"{path} cannot be written: {error.strerror}.") from None
    whole = SurfaceRecord(
        p.points_m, p.normals, p.areas_m2, p.parts, p.names, shown, reachable, p.grid.side_m
    )
    write_surface_record(path.with_suffix(".npz"), whole)
    return record


def _rounded(share: float | None) -> float | None:
    return None if share is None else round(share, 5)
