"""What the photographs of a flown plan do not show, and a plan of more photographs that show it.

The UAV is never quite where a plan wants it, so the edges of photographs miss a few strips.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from flight_basics.errors import SurveyError
from inspection.camera.photograph_pose import PhotographPose
from inspection.survey.coverage import fine_patches
from inspection.survey.plan import SurveyPlan
from inspection.survey.showing import Showing
from inspection.survey.surface.of_mesh import sides_in_air
from inspection.survey.surface.reading import Surface
from inspection.survey.tour.flown import flown
from inspection.survey.views.candidates import Candidates, lattice
from inspection.survey.views.cover import Cover

POINTING_DEG = 2.0
"""The edge of a picture counts as so much narrower: 0.15 m at 4.5 m."""
LEAST_M2 = 0.05
"""A photograph that shows less of what is open is not worth its flight."""
MORE = 0.005
"""The planned shares are so much greater than those asked: the judge counts a little more as reachable."""
AWAY_M = 0.6
"""No photograph is planned so near to one that could not be taken."""
TRIES = 100
ROUNDS = 2
"""So often at most, more photographs are planned."""


class Supplement:
    """Follows what the photographs of one plan show, and plans more.

    Args:
        plan: that is flown. surface: of its mesh.

    Attributes:
        points: those at which coverage is judged. shown: (n,) that a photograph shows.
    """

    def __init__(self, plan: SurveyPlan, surface: Surface) -> None:
        self._plan, self._surface = plan, surface
        self.points = sides_in_air(surface.mesh, surface.room, surface.samples, surface.near)
        self.shown = np.zeros(len(self.points), bool)
        self._showing = Showing(surface.mesh, self.points, plan.camera, plan.asked)

    def add(self, taken: PhotographPose) -> None:
        """Take a photograph, from where it was taken."""
        self._showing.add(taken, self.shown)

    def plan_more(self, left_out_m: Sequence[Sequence[float]], rng: np.random.Generator) -> SurveyPlan | None:
        """Return a plan that shows with all before what the first one asks for; None: none shows more.

        left_out_m: places (x, y, z) of photographs that could not be taken.

        Raises:
            SurveyError: there is no way to a photograph, or not on one battery; or a place is none.
        """
        for place_m in left_out_m:
            if len(place_m) != 3 or not np.isfinite(np.asarray(place_m, float)).all():
                given = np.asarray(place_m, float).tolist()
                raise SurveyError(f"The place {given} of a photograph left out is not three finite numbers.")
        room, asked = self._surface.room, self._plan.asked
        careful = replace(
            asked,
            pointing_error=max(asked.pointing_error, POINTING_DEG),
            share=min(1.0, asked.share + MORE),
            class_share=min(1.0, asked.class_share + MORE) if asked.class_share else 0.0,
        )
        places_m = _away_from(left_out_m, lattice(room, asked.lattice_m))
        if self.shown.all() or not len(places_m):
            return None
        names = self._surface.mesh.names
        open_ = fine_patches(self.points.only(~self.shown), names, asked)
        candidates = Candidates(
            open_, places_m, self._plan.camera, careful, self._surface.ranges_m,
            self._plan.flying.shooting_speed,
        )  # fmt: skip
        shown = self.points.only(self.shown)
        shown_m2 = np.bincount(shown.parts, shown.areas_m2, len(names))
        cover = Cover(candidates.comfortable(room), careful, shown_m2)
        before = cover.share
        if before >= asked.share and (cover.class_shares() >= asked.class_share).all():
            return None
        cover.fill(least_m2=LEAST_M2)
        if not cover.shots:
            return None
        flights, figures = flown(room, cover.views, self._plan.flying, rng, TRIES)
        shares = {"share_before": before, "share": cover.share}
        return replace(self._plan, flights=flights, figures={**figures, **shares}, shares={}, leftovers=())


def _away_from(left_out_m: Sequence[Sequence[float]], places_m: np.ndarray) -> np.ndarray:
    kept = np.ones(len(places_m), bool)
    for away_m in left_out_m:
        kept &= np.linalg.norm(places_m - away_m, axis=1) >= AWAY_M
    return places_m[kept]
