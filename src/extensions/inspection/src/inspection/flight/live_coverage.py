"""What the photographs of a survey show so far, patch by patch, for a live picture."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from inspection.camera.photograph_pose import PhotographPose
from inspection.photographs.record import PhotographError, PhotographRecord
from inspection.survey.plan import SurveyPlan
from inspection.survey.showing import Showing
from inspection.survey.surface.reading import read_surface

OFF_SURFACE_M = 0.02
"""A patch is drawn so far before the surface, so that the map's voxels do not hide it."""
FILLED = 0.92
"""Of a patch's side that is drawn."""


@dataclass(frozen=True)
class CoverageSoFar:
    """Shares of a surface in m2. planned_m2: that all photographs of the plan show, or those taken do."""

    shown_m2: float
    planned_m2: float


class LiveCoverage:
    """Follows one survey.

    Args:
        plan: that is flown; its mesh is read. photographs: only the first so many are flown; 0: all.

    Attributes:
        mesh: of the surface. shown: (n,) patches that a photograph has shown. planned: (n,) that those of the
        plan show.

    Raises:
        SurveyError: the mesh cannot be used.
    """

    def __init__(self, plan: SurveyPlan, photographs: int = 0) -> None:
        surface = read_surface(Path(plan.source), plan.asked, plan.home_m)
        self.mesh, self.patches = surface.mesh, surface.patches
        self._showing = Showing(self.mesh, self.patches, plan.camera, plan.asked)
        self.planned = self._showing.by(
            [PhotographPose.of_view(v) for v in plan.views[: photographs or None]]
        )
        self.shown = np.zeros(len(self.patches), bool)

    def add(self, record: PhotographRecord, picture: Path | None = None) -> None:
        """Take a photograph that was stored. picture: its file; None: all of it counts as well exposed.

        Raises:
            PhotographError: the picture cannot be read.
        """
        try:
            self.shown |= self._showing.by([replace(record.pose, path=picture)])
        except (OSError, ValueError, SyntaxError) as error:
            raise PhotographError(f"{picture}: cannot be read ({error}).") from None

    @property
    def so_far(self) -> CoverageSoFar:
        """The areas."""
        areas_m2 = self.patches.areas_m2
        planned = self.planned | self.shown
        return CoverageSoFar(float(areas_m2[self.shown].sum()), float(areas_m2[planned].sum()))

    def squares_m(self) -> np.ndarray:
        """Return (n, 4, 3) corners of a square for each patch, as large as it is, just before the surface."""
        p = self.patches
        half = 0.5 * FILLED * np.sqrt(np.minimum(p.areas_m2, p.grid.side_m**2))
        axis = np.eye(3)[np.argmin(np.abs(p.normals), axis=1)]
        aside = np.cross(p.normals, axis)
        aside *= (half / np.linalg.norm(aside, axis=1))[:, None]
        up = np.cross(p.normals, aside)
        middle = p.points_m + OFF_SURFACE_M * p.normals
        return np.stack(
            (middle - aside - up, middle + aside - up, middle + aside + up, middle - aside + up), 1
        )
