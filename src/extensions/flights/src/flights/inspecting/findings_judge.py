"""Judges findings by the defects that a world really has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from inspection.camera.photograph_pose import PhotographPose
from inspection.camera.survey_camera import SurveyCamera
from inspection.findings.merging import Finding
from inspection.findings.placing import MeshSurface
from inspection.survey.parameters import SurveyParameters
from inspection.survey.showing import Showing
from inspection.survey.surface.mesh_file import Mesh
from inspection.survey.surface.patches import Patches
from simulation_tools.camera.defects import Defect

NEAR_M = 0.15
"""A finding belongs to a defect of its kind if it is nearer to it than this."""
WIDE_M = 0.001
"""Cracks from this width are to be found."""
ALONG = np.linspace(-0.45, 0.45, 9)
"""Places along a defect, as shares of its length, of which half must be photographed."""


@dataclass(frozen=True)
class Count:
    """How many defects were photographed, and how many of them were found."""

    shown: int
    found: int

    @property
    def share(self) -> float | None:
        """Of those photographed, 0..1; None: there was none."""
        return self.found / self.shown if self.shown else None


@dataclass(frozen=True)
class JudgedFindings:
    """Findings beside the truth.

    rust, cracks, wide_cracks: wide ones have 1 mm or more. false: findings near no defect of their kind.
    off_m: of each true finding: from a crack to its line, from rust to its middle. area_m2: photographed.
    """

    rust: Count
    cracks: Count
    wide_cracks: Count
    false: tuple[Finding, ...]
    off_m: tuple[float, ...]
    area_m2: float

    @property
    def false_per_100_m2(self) -> float:
        """False alarms per 100 m2 of photographed surface."""
        return 100.0 * len(self.false) / max(self.area_m2, 1e-9)


def judge_findings(
    findings: Sequence[Finding],
    defects: Sequence[Defect],
    taken: Sequence[PhotographPose],
    camera: SurveyCamera,
    asked: SurveyParameters,
    mesh: Mesh,
    patches: Patches,
) -> JudgedFindings:
    """Judge findings. taken: where the photographs were truly taken. patches: of the mesh.

    A defect is photographed if half of it lies in one photograph, at the asked resolution and incidence.
    """
    area_m2 = float(patches.areas_m2[Showing(mesh, patches, camera, asked).by(taken)].sum())
    surface = MeshSurface(mesh.triangles_m)
    return count_found(findings, defects, taken, camera, asked, surface, area_m2)


def count_found(
    findings: Sequence[Finding],
    defects: Sequence[Defect],
    taken: Sequence[PhotographPose],
    camera: SurveyCamera,
    asked: SurveyParameters,
    surface: MeshSurface,
    area_m2: float,
) -> JudgedFindings:
    """Judge findings, where one knows the area that the photographs show, m2."""
    counts, used, off_m = {}, set(), []
    for kind, least_m in (("rust", 0.0), ("crack", 0.0), ("crack", WIDE_M)):
        own = [each for each in defects if each.kind == kind and each.width_m >= least_m]
        told = [k for k, each in enumerate(findings) if each.kind == kind]
        shown = found = 0
        for defect in own:
            near = [(k, _apart_m(findings[k], defect)) for k in told]
            near = [(k, apart_m) for k, apart_m in near if apart_m < NEAR_M]
            if any(shows(each, defect, camera, asked, surface) for each in taken):
                shown, found = shown + 1, found + bool(near)
            if not least_m:
                off_m += [apart_m for k, apart_m in near if k not in used]
                used |= {k for k, _ in near}
        counts[kind, least_m] = Count(shown, found)
    false = tuple(each for k, each in enumerate(findings) if k not in used)
    return JudgedFindings(
        counts["rust", 0.0], counts["crack", 0.0], counts["crack", WIDE_M], false, tuple(off_m), area_m2
    )


def _apart_m(finding: Finding, defect: Defect) -> float:
    """Distance of a finding from a crack's straight line, or from the middle of rust."""
    off = np.array(finding.position_m) - defect.position_m
    if defect.kind == "crack":
        half = 0.5 * defect.length_m
        off = off - np.clip(off @ defect.along, -half, half) * np.array(defect.along)
    return float(np.linalg.norm(off))


def shows(
    taken: PhotographPose, defect: Defect, camera: SurveyCamera, asked: SurveyParameters, surface: MeshSurface
) -> bool:
    """Return whether half of a defect lies in a photograph as it is asked."""
    points = np.array(defect.position_m) + np.outer(ALONG * defect.length_m, defect.along)
    _, inside = camera.drawn((points - taken.place_m) @ taken.axes)
    rays = points - taken.place_m
    far = np.linalg.norm(rays, axis=1)
    rays /= far[:, None]
    steep = -(rays @ np.array(defect.normal))
    fine = 1e3 * far / camera.focal_px <= asked.resolution * np.maximum(steep, 1e-9)
    good = inside & fine & (steep >= np.cos(np.radians(asked.incidence)))
    if good.mean() < 0.5:
        return False
    hits, _ = surface.hits(taken.place_m, rays)
    good &= np.linalg.norm(hits - points, axis=1) < 0.02
    return bool(good.mean() >= 0.5)


def disturbed(
    taken: PhotographPose, rng: np.random.Generator, off_m: float, off_deg: float
) -> PhotographPose:
    """Return where a camera would seem to be whose pose is off by such medians: each axis is normal."""
    # The median length of a vector of three standard normal numbers is 1.538.
    turn = Rotation.from_rotvec(np.radians(off_deg) / 1.538 * rng.standard_normal(3)).as_matrix()
    return PhotographPose(
        taken.place_m + off_m / 1.538 * rng.standard_normal(3), turn @ taken.axes, taken.blur_px
    )
